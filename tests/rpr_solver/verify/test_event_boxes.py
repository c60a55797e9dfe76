"""Boxes of events: one that holds its event, and others."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

from rpr_solver import EXAMPLES, census
from rpr_solver.verify.event_boxes import EventBox, proved_event
from rpr_solver.verify.manipulator import Geometry
from rpr_solver.verify.printed import Printed
from rpr_solver.verify.surface import CRITICAL, Surface

FOUND = census(EXAMPLES["zein-flat"], digits=15, start=38, certificate="full").to_json()
SURFACE = Surface.of(Geometry.of(FOUND), 1)
BOX = next(
    EventBox.of(event, 1, "")
    for event in FOUND["certificate"]["full"]["events"]
    if event["kind"] == "beak-to-beak"
)


def test_the_zero_of_a_box() -> None:
    found = proved_event(SURFACE, BOX)
    assert found is not None
    assert found.system == CRITICAL
    low, high = BOX.ends
    assert found.zero[2].inside(low * SURFACE.unit, high * SURFACE.unit)
    tangent = found.tangent(SURFACE)
    assert tangent is not None
    assert tangent.radius < Fraction(1, 10**30)


@pytest.mark.parametrize("name", ["length", "alpha", "theta"])
def test_a_box_beside_it_is_not_proved(name: str) -> None:
    centre, radius = getattr(BOX, name)
    assert proved_event(SURFACE, replace(BOX, **{name: (centre + 3 * radius, radius)})) is None
    assert proved_event(SURFACE, replace(BOX, **{name: (centre, Fraction(0))})) is None


def test_which_printed_event_it_may_be() -> None:
    texts = [f"{float(centre):.10f}" for centre, _ in (BOX.length, BOX.alpha, BOX.theta)]
    length, alpha, theta = (Printed.of(text, "") for text in texts)
    assert BOX.may_be("beak-to-beak", length, alpha, theta)
    assert not BOX.may_be("lips", length, alpha, theta)
    assert not BOX.may_be("beak-to-beak", alpha, alpha, theta)
    turned = Printed.of(f"{float(BOX.alpha[0]) - 360:.10f}", "")
    assert BOX.may_be("beak-to-beak", length, turned, theta)
