"""Sensitivities of transitions: identities, finite differences of exact censuses, what is singular."""

from fractions import Fraction
from itertools import product

import pytest

from rpr_solver import EXAMPLES, Manipulator, census, with_sensitivities
from rpr_solver.contract import LENGTHS
from tests.support.sampling import long, sample

INNOCENTI = EXAMPLES["innocenti"]


def events(
    manipulator: Manipulator, leg: int = 1, digits: int = 30, **span: object
) -> list[tuple[Fraction, dict]]:
    """The lengths of transitions with their events."""
    document = with_sensitivities(census(manipulator, fixed_leg=leg, digits=digits, **span).to_json())
    return [(Fraction(t[f"l{leg}"]), event) for t in document["transitions"] for event in t["events"]]


@pytest.mark.parametrize(("name", "leg"), sample(product(["innocenti", "twelve-cusps"], [1, 2, 3]), 0, 4))
def test_lengths_scale_together(name: str, leg: int) -> None:
    """Euler's identity: L* is homogeneous of degree 1 in the lengths."""
    manipulator = EXAMPLES[name]
    found = events(manipulator, leg)
    assert len(found) > 5
    for length, event in found:
        total = sum(getattr(manipulator, g) * Fraction(event["sensitivity"][g]) for g in LENGTHS)
        assert abs(total - length) < Fraction(1, 10**10)


@pytest.mark.parametrize(("leg", "lengths"), [(1, LENGTHS[::3]), long(2, LENGTHS)])
def test_differences_of_censuses_agree(leg: int, lengths: tuple[str, ...]) -> None:
    step = Fraction(1, 10**7)
    [nominal] = [events(INNOCENTI, leg, start=26, stop=Fraction("28.1"))]
    kinds = [event["kind"] for _, event in nominal]
    for g in lengths:
        changed = [
            census(
                Manipulator(**{**INNOCENTI.to_dict(), g: getattr(INNOCENTI, g) + side * step}),
                fixed_leg=leg,
                digits=30,
                start=26,
                stop=Fraction("28.1"),
            )
            for side in (-1, 1)
        ]
        below, above = (
            [Fraction(t.length) for t in table.transitions for _ in t.events] for table in changed
        )
        assert [e.kind for t in changed[0].transitions for e in t.events] == kinds
        for (_, event), low, high in zip(nominal, below, above, strict=True):
            assert float((high - low) / (2 * step)) == pytest.approx(
                float(event["sensitivity"][g]), rel=1e-6, abs=1e-8
            )


def test_poses_that_are_not_simple_are_singular() -> None:
    passing = Manipulator(-1, 2, 4, 3, 4, 5, "cw")
    found = [event for length, event in events(passing, digits=15) if length == 5]
    assert [event["kind"] for event in found] == ["quadruple"]
    assert found[0]["sensitivity"] is None
    assert found[0]["singular"] is True


def test_sides_of_a_flat_platform_have_no_sensitivity() -> None:
    for _, event in events(EXAMPLES["zein-flat"], digits=15, start=30, stop=32):
        assert [g for g, x in event["sensitivity"].items() if x is None] == ["d1", "d2", "d3"]
