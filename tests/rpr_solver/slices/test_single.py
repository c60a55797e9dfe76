"""A slice by itself beside the reference, to the byte."""

from __future__ import annotations

import sys
from fractions import Fraction

import pytest
from flint import arb, arb_poly, ctx
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, Manipulator, eliminate
from rpr_solver.slices import single
from rpr_solver.slices.reference import ReferenceSlice
from rpr_solver.slices.single import single_slice
from tests.support.families import family
from tests.support.shared import eliminant_of
from tests.support.strategies import examples, lengths, manipulators

EQUILATERAL = Manipulator(base={"equilateral": "5*sqrt(3)"}, platform={"sides": ["4", "sqrt(7)", "3"]})


def same(reference: ReferenceSlice) -> bool:
    """Whether it is decided; then it is what the reference says."""
    own = single_slice(reference)
    assert own is None or own.to_json() == reference.solve().to_json()
    return own is not None


@pytest.mark.parametrize("with_numpy", [True, False])
@pytest.mark.parametrize("digits", [15, 90, 1000])
@pytest.mark.parametrize("name", ["zein-flat", "sixteen-cusps", "innocenti"])
def test_examples(name: str, digits: int, with_numpy: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if not with_numpy:
        monkeypatch.delitem(sys.modules, "numpy", raising=False)
    assert same(ReferenceSlice(eliminant_of(EXAMPLES[name]), Fraction(349, 10), digits))


@given(manipulators(), lengths(), st.sampled_from([1, 2, 3]), st.sampled_from([15, 60]))
@examples(12)
def test_random_slices(m: Manipulator, length: Fraction, leg: int, digits: int) -> None:
    same(ReferenceSlice(eliminate(m, leg), length, digits))


@pytest.mark.parametrize("leg", [1, 2, 3])
def test_roots_in_another_unit_and_angles_from_other_axes(leg: int) -> None:
    assert EQUILATERAL.frame.rho > 1
    decided = [same(ReferenceSlice(eliminate(EQUILATERAL, leg), Fraction(k, 3), 40)) for k in range(5, 40, 7)]
    assert all(decided)


def test_a_slice_without_cusps() -> None:
    reference = ReferenceSlice(eliminant_of(EXAMPLES["zein-flat"]), Fraction(1, 10), 20)
    table = single_slice(reference)
    assert table is not None
    assert table.count == 0
    assert same(reference)


def test_a_slice_that_is_not_generic_is_left_to_the_reference() -> None:
    assert single_slice(ReferenceSlice(eliminate(family("congruent, mirrored")), Fraction(9), 20)) is None


def test_guesses_that_are_not_all_roots_prove_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """(x² − 2)(x² + 1): a guess too few, too many, one twice, one far from any root."""
    with ctx.workprec(200):
        p, root = arb_poly([-2, 0, -1, 0, 1]), 2**0.5
        for guesses in ([root], [-root, 0.0, root], [root, root], [-root, root + 1e-6]):
            monkeypatch.setattr("rpr_solver.slices.fast.real_eigenvalues", lambda _q, found=guesses: found)
            assert single._near_eigenvalues(p.coeffs()) is None
        monkeypatch.setattr("rpr_solver.slices.fast.real_eigenvalues", lambda _q: [-root, root])
        roots = single._near_eigenvalues(p.coeffs())
        assert roots is not None
        assert [x.x.contains(y) for x, y in zip(roots, (-arb(2).sqrt(), arb(2).sqrt()), strict=True)] == [
            True,
            True,
        ]
