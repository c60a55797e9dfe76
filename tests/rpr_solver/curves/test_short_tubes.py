"""Tubes of few digits pass Krawczyk's test as they are printed, and others do not."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import pytest
from flint import arb

from rpr_solver import EXAMPLES
from rpr_solver.curves.destinations import Tracker
from rpr_solver.curves.short_tubes import ProvedTube, shortened
from tests.support.shared import eliminant_of

LOW, HIGH = Fraction(34), Fraction("34.6")


@pytest.fixture(scope="module")
def chain() -> list[tuple[ProvedTube, Tracker]]:
    tracker = Tracker(eliminant_of(EXAMPLES["zein-flat"]), 30)
    scale = tracker.eliminant.slice_map.scale
    follower = tracker.follower((LOW, 0), upwards=True)
    tubes: list[ProvedTube] = []
    while follower.walk(LOW * scale, HIGH * scale, 0) is None:
        assert follower.tube
        before = tubes[-1] if tubes else None
        start = None if tubes else tracker.place((LOW, 0), follower.bits)
        tube = shortened(follower.tube, tracker.forms, follower.bits, before, start)
        assert tube
        tubes.append(tube)
    return [(tube, tracker) for tube in tubes]


def test_the_printed_numbers_are_proved_and_short(chain: list[tuple[ProvedTube, Tracker]]) -> None:
    for proved, tracker in chain:
        tube = proved.tube
        assert proved.passes()
        for narrow in (Fraction(1, 50), Fraction(1, 10**6)):
            p, q = tube.radii
            assert not ProvedTube(replace(tube, radii=(p * narrow, q * narrow)), tracker.forms, 128).passes()
        other = replace(tube, slopes=(tube.slopes[0] + 1, tube.slopes[1]))
        assert not ProvedTube(other, tracker.forms, 128).passes()
        assert len(str(tube.to_json(1))) < 400


def test_they_hold_what_the_chain_joins(chain: list[tuple[ProvedTube, Tracker]]) -> None:
    tracker = chain[0][1]
    assert chain[0][0].contains(*tracker.place((LOW, 0), 128))
    assert not chain[0][0].contains(*tracker.place((LOW, 1), 128))
    for (before, _), (tube, _) in pairwise(chain):
        middle = tube.middle()
        assert middle is not None
        assert before.contains(*middle)
        place, length = middle
        assert not before.contains(place, length * arb(2))


@pytest.mark.parametrize(
    ("length", "text"),
    [(Fraction(27), "27"), (Fraction("-0.000123"), "-0.000123"), (Fraction("3e-61"), "3e-61")],
)
def test_numbers_are_exact_decimals(
    chain: list[tuple[ProvedTube, Tracker]], length: Fraction, text: str
) -> None:
    tube = replace(chain[0][0].tube, bends=(length, Fraction(0)))
    assert tube.to_json(1)["bends"] == [text, "0"]
