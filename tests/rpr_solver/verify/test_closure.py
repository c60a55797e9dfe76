"""The sixth-degree form of the verifier against the solver's, and its roots of every multiplicity."""

from __future__ import annotations

from fractions import Fraction

from rpr_solver import EXAMPLES, poses
from rpr_solver.verify.closure import Closure
from tests.support.families import family
from tests.support.verified import geometry_of


def closure_of(name: str, *lengths: int) -> Closure:
    manipulator = EXAMPLES[name] if name in EXAMPLES else family(name)
    first, second, third = (Fraction(length) ** 2 for length in lengths)
    return Closure.of(geometry_of(manipulator), (first, second, third))


def test_the_polynomial_of_the_solver() -> None:
    mine = closure_of("zein-flat", 20, 20, 20).sextic
    theirs = poses(EXAMPLES["zein-flat"], 20, 20, 20, digits=15).polynomial
    assert [a * theirs.a[0] for a, _ in mine] == [mine[0][0] * a for a in theirs.a]
    assert not any(b for _, b in mine)


def test_multiplicities_and_a_root_at_180_degrees() -> None:
    assert {k: len(p) - 1 for k, p in closure_of("both flat", 3, 10, 13).parts.items()} == {1: 2, 4: 1}
    turned = closure_of("congruent", 5, 5, 5)
    assert sum(k * (len(p) - 1) for k, p in turned.parts.items()) == 6
