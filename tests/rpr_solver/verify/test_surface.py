"""The equations with the length as an unknown agree with those of a slice."""

from __future__ import annotations

from fractions import Fraction

import pytest

from rpr_solver import EXAMPLES, census
from rpr_solver.verify.core.angles import radians
from rpr_solver.verify.core.boxes import Directions
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.system import System
from rpr_solver.verify.surface import Surface, value
from tests.support.verified import geometry_of

BITS = 200
GEOMETRY = geometry_of(EXAMPLES["innocenti"])


@pytest.mark.parametrize("fixed", [1, 3])
def test_at_one_length_it_is_the_slice(fixed: int) -> None:
    surface, system = Surface.of(GEOMETRY, fixed), System.of(GEOMETRY, fixed, Fraction(12))
    here = Directions.of(radians(Fraction(40), BITS), radians(Fraction(-75), BITS), surface.ring.radicand)
    length = Interval.of(12 * surface.unit, BITS)
    for leg, mine in zip(system.legs, surface.legs, strict=True):
        assert value(here, mine.squared, length).meets(here.value(leg.squared))
    singular, other = value(here, surface.singular, length), here.value(system.singular)
    ratio = float(singular.middle / other.middle)
    assert ratio == pytest.approx(round(ratio)) or 1 / ratio == pytest.approx(round(1 / ratio))


def test_events_are_zeros_of_the_systems_of_their_kinds() -> None:
    whole = census(EXAMPLES["zein-flat"], digits=15)
    surface = Surface.of(geometry_of(EXAMPLES["zein-flat"]), 1)
    for transition in whole.transitions[:3]:
        [event] = transition.events
        alpha, theta, *_ = (Fraction(x) for x in event.point.coordinates)
        _, triple = next(surface.systems(event.kind))
        box = triple.zero_near(alpha, theta, Fraction(transition.length) * surface.unit, 80)
        assert box is not None
        found = box[2].middle / surface.unit
        assert abs(found - Fraction(transition.length)) < Fraction(1, 10**13)
        if event.kind != "swallowtail":
            here = Directions.of(box[0], box[1], surface.ring.radicand)
            assert surface.hessian(here, box[2]).sign == (1 if event.kind == "lips" else -1)
