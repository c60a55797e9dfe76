"""Full certificates of censuses, checked by SymPy and plain integers."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import mpmath as mp
import pytest
import sympy as sp

from rpr_solver import EXAMPLES, Census, InputError, Manipulator, census, restrict_census
from tests.support.families import family

V = sp.Symbol("v")
GENERIC = Manipulator(9, 4, 11, 14, 15, 13)


def full_of(found: Census) -> dict[str, list[dict[str, dict[str, str]]]]:
    return found.certificate["full"]


def test_each_real_root_has_its_event() -> None:
    found = census(GENERIC, digits=15, certificate="full")
    full = full_of(found)
    with mp.workdps(40):
        angles = [mp.radians(mp.mpf(event["theta1_deg"]["centre"])) for event in full["events"]]
        tangents = [sp.Rational(str(mp.tan(angle))) for angle in angles]
    for system, degree in zip(full["systems"], (32, 18), strict=True):
        assert "omega" not in system["polynomial"]
        p = sp.Poly([int(c) for c in reversed(system["polynomial"]["coefficients"])], V)
        assert p.degree() == system["polynomial"]["degree"] == degree
        prime = int(system["squarefree"]["prime"])
        modulo = sp.Poly(p, V, modulus=prime)
        assert sp.isprime(prime)
        assert sp.gcd(modulo, modulo.diff()).degree() == 0
        if degree == 18:  # the other one takes seconds
            assert p.count_roots() == len(system["real_roots"])
        for root in system["real_roots"]:
            low, high = (sp.Rational(root[end]) for end in ("lower", "upper"))
            assert p.eval(low) * p.eval(high) < 0
            assert sum(bool(low < v < high) for v in tangents) == 1
    assert len(full["events"]) == sum(len(system["real_roots"]) for system in full["systems"])


def test_a_range_has_the_events_of_all_lengths_and_its_own_samples() -> None:
    found = census(GENERIC, digits=15, start=3, stop=6, certificate="full")
    full = full_of(found)
    lengths = [Fraction(event["l1"]["centre"]) for event in full["events"]]
    assert lengths == sorted(lengths)
    inside = [x for x in lengths if 3 < x < 6]
    assert [float(x) for x in inside] == pytest.approx(
        [float(t.length) for t in found.transitions], rel=1e-14
    )
    assert 0 < len(inside) < len(lengths)
    ends = [Fraction(3), *inside, Fraction(6)]
    samples = [Fraction(sample) for sample in full["samples"]]
    assert all(low < x < high for (low, high), x in zip(pairwise(ends), samples, strict=True))


def test_the_rest_of_the_document_is_as_usual() -> None:
    short, full = (census(EXAMPLES["zein-flat"], digits=15, certificate=name) for name in ("short", "full"))
    assert restrict_census(full.to_json(), 0, None) == short.to_json()
    assert full_of(full)["systems"][0]["squarefree"] is None
    del full.certificate["full"]
    assert full == short
    with pytest.raises(InputError, match="certificate"):
        census(EXAMPLES["zein-flat"], certificate="long")


def test_events_that_are_not_isolated_have_no_eliminants() -> None:
    found = census(family("congruent, mirrored"), digits=15, certificate="full")
    full = full_of(found)
    assert not full["systems"]
    assert len(full["samples"]) == len(found.counts)
    assert len(full["events"]) == sum(len(transition.events) for transition in found.transitions)


def test_a_pose_that_solves_two_systems_is_one_event() -> None:
    """The node at L3 = 4 is a critical pose, and a double root of the eliminant of swallowtails."""
    found = census(family("folded flat platform"), digits=15, fixed_leg=3, start="3.32", certificate="full")
    boxes = [tuple(side["centre"] for side in list(event.values())[1:]) for event in full_of(found)["events"]]
    assert boxes.count(("4", "0", "-90")) == 1
    assert len(set(boxes)) == len(boxes)
