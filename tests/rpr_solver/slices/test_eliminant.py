"""The eliminant against Res_t(J, E) itself: the whole of it, at every parameter, and within its bound."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from fractions import Fraction
from itertools import product
from math import gcd

import pytest
from flint import arb, arb_mat, ctx, fmpz, fmpz_mpoly_ctx, fmpz_poly
from hypothesis import assume, given
from hypothesis import strategies as st

from rpr_solver import (
    EXAMPLES,
    Eliminant,
    Manipulator,
    SolverError,
    cusp_table,
    eliminate,
    solve_slice,
)
from rpr_solver.contract import FEW_SLICES
from rpr_solver.exact.biform import BiForm
from rpr_solver.exact.modular import sylvester
from rpr_solver.exact.quadratic import QuadraticPoly, omega_ball
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.eliminant import KeptEliminants, _Sampling
from tests.support.sampling import sample
from tests.support.shared import eliminant_of, plain_leg
from tests.support.strategies import examples, manipulators

BITS = 4096


def manipulator(*values: int | str, orientation: str = "ccw") -> Manipulator:
    return Manipulator(*map(Fraction, values), orientation=orientation)


IRRATIONAL = manipulator(7, 3, 5, 4, 5, 6, orientation="cw")
LARGE = manipulator(3 * 10**12 + 1, "-2.71828182845", 10**11 + 7, 10**12, 10**12 + 9, 17)
"""A sharp platform with numbers of 12 and more digits."""


def exact_resultant(slice_map: SliceMap, length: Fraction) -> tuple[fmpz_poly, fmpz_poly]:
    """Res_t(J, E) at one L by FLINT's own multivariate resultant, as A + omega B."""
    ring = fmpz_mpoly_ctx.get(("t", "u", "w"), "lex")

    def polynomial(form: BiForm) -> object:
        terms: dict[tuple[int, ...], int] = {}
        for i, row in enumerate(form.at(length)):
            for w, part in enumerate((row.a, row.b)):
                for k, c in enumerate(part.coeffs()):
                    terms[i, k, w] = terms.get((i, k, w), 0) + c
        return ring.from_dict({key: c for key, c in terms.items() if c})

    resultant = polynomial(slice_map.singular).resultant(polynomial(slice_map.coalescence), "t")  # type: ignore[attr-defined]
    parts: tuple[dict[int, int], dict[int, int]] = ({}, {})
    for (_, k, w), c in resultant.to_dict().items():
        part = parts[0 if slice_map.radicand == 1 else w % 2]
        part[k] = part.get(k, 0) + c * slice_map.radicand ** (w // 2)
    a, b = (fmpz_poly([part.get(k, 0) for k in range(max(part, default=0) + 1)]) for part in parts)
    return a, b


@pytest.mark.parametrize(("name", "fixed_leg"), sample(product(EXAMPLES, (1, 2, 3)), 5))
def test_the_resultant_is_the_known_factors_times_q(name: str, fixed_leg: int) -> None:
    eliminant = eliminant_of(EXAMPLES[name], fixed_leg)
    slice_map = eliminant.slice_map
    for length in (Fraction(7, 3) * slice_map.scale, Fraction(20) * slice_map.scale):
        a, b = exact_resultant(slice_map, length)
        known = slice_map.f.collinear.a**2 * fmpz_poly([1, 0, 1]) ** 9 * slice_map.f.closed(length).a
        quotient_a, quotient_b = a / known, b / known
        assert quotient_a * known == a
        assert quotient_b * known == b
        q = eliminant.at(length)
        assert q.degree == 24
        q_a, q_b = q.a, q.b
        # equal up to a rational constant
        assert q_a * quotient_b == q_b * quotient_a
        lead = next(p for p in (q_a, q_b) if p).leading_coefficient()
        other = next(p for p in (quotient_a, quotient_b) if p).leading_coefficient()
        assert (q_a * other, q_b * other) == (quotient_a * lead, quotient_b * lead)


# the identity in u and L at once


def constant(eliminant: Eliminant, u: int, length: int) -> fmpz:
    """c in Res_t(J, E) = c w² (u²+1)⁹ q Q at integers, with Sylvester's determinant in balls."""
    slice_map = eliminant.slice_map
    with ctx.workprec(BITS):
        omega = omega_ball(slice_map.radicand, BITS)
        j, e = (
            [row(arb(u), omega) for row in form.at(Fraction(length))]
            for form in (slice_map.singular, slice_map.coalescence)
        )
        whole = arb_mat(sylvester(j, e, arb(0))).det()
        a, b = (
            sum(part[k, i] * fmpz(u) ** k * fmpz(length) ** i for k in range(25) for i in range(11))
            for part in (eliminant.a, eliminant.b)
        )
        known = (
            slice_map.f.collinear.a(u) ** 2 * fmpz(u * u + 1) ** 9 * slice_map.f.closed(Fraction(length)).a(u)
        )
        value = whole / (known * (a + omega * b))
    integer = value.unique_fmpz()
    assert value.is_finite()
    assert integer is not None
    return integer


def constant_everywhere(eliminant: Eliminant) -> fmpz:
    places = [(-5, 13), (11, 2), (4, 1009)]
    first, *others = (constant(eliminant, u, length) for u, length in places)
    assert others == [first, first]
    assert first != 0
    return first


SMALL_MANIPULATORS = manipulators(size=6, denominators=(1, 2))


@given(SMALL_MANIPULATORS, st.sampled_from([1, 2, 3]))
@examples(4)
def test_the_cofactor_is_one_integer_for_all_u_and_l(m: Manipulator, leg: int) -> None:
    eliminant = eliminant_of(m, leg)
    assume(any(eliminant.a.entries()) or any(eliminant.b.entries()))
    constant_everywhere(eliminant)


@given(st.lists(st.integers(-60, 60), min_size=8, max_size=8), st.sampled_from([1, 2, 3]), st.integers(1, 6))
@examples(12)
def test_the_sides_divide_the_resultant(numbers: list[int], unit: int, length: int) -> None:
    """The content, for legs that belong to no manipulator: the quotient by all known factors is integral."""
    m, n, ax, ay, *other = numbers
    f, g = (plain_leg(*(x * unit for x in own)) for own in ((m, n, ax, ay), other))
    sides = f.platform2**2 * g.platform2 * ((f.ax - g.ax) ** 2 + (f.ay - g.ay) ** 2)
    assume(sides and f.base2)
    a, _ = exact_resultant(SliceMap(1, Fraction(1), 1, 1, f, g), Fraction(length * unit))
    known = f.collinear.a**2 * fmpz_poly([1, 0, 1]) ** 9 * f.closed(Fraction(length * unit)).a
    assert (a * 2**8) % (known * sides * unit**26) == 0


@pytest.mark.parametrize("along", [[7, 1, 5], [3, -2, 0]])
def test_factors_that_do_not_divide_are_noticed(along: list[int]) -> None:
    sampling = replace(_Sampling.of(SliceMap.of(EXAMPLES["zein-flat"])), along=QuadraticPoly.rational(along))
    with pytest.raises(SolverError, match="known factors"):
        sampling.whole()


# one slice


@given(st.fractions(min_value=Fraction(1, 50), max_value=90, max_denominator=50))
@examples(20)
def test_one_slice_is_the_primitive_value_at_its_length(length: Fraction) -> None:
    eliminant = eliminant_of(IRRATIONAL)
    q = eliminant.at(length)
    parts = [
        [sum(Fraction(int(part[k, i])) * length**i for i in range(11)) for k in range(25)]
        for part in (eliminant.a, eliminant.b)
    ]
    own = [Fraction(int(x)) for p in (q.a, q.b) for x in (p[k] for k in range(25))]
    ratio = next(x / y for x, y in zip(parts[0] + parts[1], own, strict=True) if y)
    assert parts[0] + parts[1] == [ratio * x for x in own]
    assert ratio > 0
    assert gcd(*map(int, own)) == 1
    assert q.radicand == eliminant.slice_map.radicand != 1


# in a cache


@pytest.mark.parametrize(
    ("m", "leg"), [(EXAMPLES["zein-flat"], 3), (IRRATIONAL, 2), (LARGE, 1)], ids=["flat", "small", "large"]
)
def test_a_cached_eliminant_reads_back(m: Manipulator, leg: int) -> None:
    eliminant = eliminant_of(m, leg)
    again = Eliminant.from_json(json.loads(json.dumps(eliminant.to_json())))
    assert (again.a, again.b) == (eliminant.a, eliminant.b)
    assert again.slice_map.fixed_leg == leg


def test_an_eliminant_of_another_version_is_not_taken() -> None:
    stored = eliminant_of(EXAMPLES["zein-flat"]).to_json()
    with pytest.raises(ValueError, match="version"):
        Eliminant.from_json({**stored, "solver_version": "0"})


@pytest.mark.parametrize(("name", "leg"), sample(product(EXAMPLES, (1, 2, 3)), 0, 16))
def test_the_first_slices_are_those_of_the_whole(name: str, leg: int) -> None:
    few, whole = eliminate(EXAMPLES[name], leg), eliminant_of(EXAMPLES[name], leg).expect(FEW_SLICES + 1)
    for length in (Fraction(27), Fraction(1499, 97), Fraction(1, 10**9)):
        assert few.at(length) == whole.at(length)
    assert few.coefficients.known is None


@pytest.mark.parametrize("leg", [1, 2, 3])
def test_a_slice_alone_of_forms_without_the_highest_power_of_a_length(leg: int) -> None:
    """Found by the long run: base and platform of these are flat and similar."""
    m, length = Manipulator(-1, 1, 0, 2, 4, 2), Fraction(4337, 100)
    few, whole = eliminate(m, leg), eliminate(m, leg).expect(FEW_SLICES + 1)
    assert few.at(length) == whole.at(length)
    assert few.coefficients.known is None
    assert solve_slice(few, length, 20).to_json() == solve_slice(whole, length, 20).to_json()


FIRST = EXAMPLES["innocenti"]


@pytest.fixture
def eliminated(monkeypatch: pytest.MonkeyPatch) -> list[tuple[Manipulator, int]]:
    """What is eliminated, in order."""
    done: list[tuple[Manipulator, int]] = []

    def noted(manipulator: Manipulator, fixed_leg: int) -> Eliminant:
        done.append((manipulator, fixed_leg))
        return eliminate(manipulator, fixed_leg)

    monkeypatch.setattr("rpr_solver.slices.eliminant.eliminate", noted)
    return done


def test_a_loop_of_single_slices_eliminates_once(eliminated: list[object]) -> None:
    other = replace(FIRST, d1=FIRST.d1 + Fraction(1, 977))
    lengths = ["14.98", "27", "28.1", "34"]
    looped = [table for length in lengths for table in cusp_table(other, length, digits=15)]
    assert len(eliminated) == 1
    fresh = eliminate(other)
    assert looped == [solve_slice(fresh, length, 15) for length in lengths]


def test_geometry_orientation_and_leg_have_their_own(eliminated: list[object]) -> None:
    store = KeptEliminants()
    mirror = replace(FIRST, orientation="cw")
    for _ in range(2):
        for manipulator, leg in ((FIRST, 1), (FIRST, 2), (mirror, 1)):
            found = store.eliminant(manipulator, leg)
            assert (found.manipulator, found.slice_map.fixed_leg) == (manipulator, leg)
    assert len(eliminated) == len(store) == 3


def test_the_last_used_are_kept_within_the_bound(eliminated: list[object]) -> None:
    one = KeptEliminants()
    one.eliminant(FIRST, 1)
    store = KeptEliminants(most_bytes=int(2.5 * one._bytes))
    for leg in (1, 2, 1, 3, 1):
        store.eliminant(FIRST, leg)
        assert store._bytes <= store.most_bytes
    assert eliminated == [(FIRST, leg) for leg in (1, 1, 2, 3)]
    small = KeptEliminants(most_bytes=100)
    assert small.eliminant(FIRST, 1).a == eliminate(FIRST).a
    assert len(small) == 0


def test_threads_get_the_same() -> None:
    store = KeptEliminants()
    expected = {leg: eliminant_of(FIRST, leg).a for leg in (1, 2, 3)}
    with ThreadPoolExecutor(6) as pool:
        found = list(pool.map(lambda n: store.eliminant(FIRST, n % 3 + 1), range(60)))
    assert all(e.a == expected[n % 3 + 1] for n, e in enumerate(found))
    assert len(store) == 3
