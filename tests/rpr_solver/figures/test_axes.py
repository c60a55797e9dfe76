"""Scales keep order and proportions; ticks are round and inside.

A frame places values, and its ticks lie in it.
"""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.figures.sheet import Frame, Scale, WidenedScale, angle_ticks, ticks
from rpr_solver.notebook.scene import Box, Text

RANGES = st.tuples(st.floats(-1e6, 1e6), st.floats(1e-6, 1e6)).map(lambda x: (x[0], x[0] + x[1]))


@given(RANGES, st.integers(2, 12))
def test_ticks_are_inside_and_evenly_spaced(span: tuple[float, float], most: int) -> None:
    low, high = span
    values = [value for value, _ in ticks(low, high, most)]
    assert len(values) <= most + 1
    assert all(low <= value <= high for value in values)
    steps = [b - a for a, b in pairwise(values)]
    assert all(step == pytest.approx(steps[0], rel=1e-3) for step in steps)


def test_ticks_read_as_numbers() -> None:
    for value, text in ticks(-1.2, 0.3, 8):
        assert float(text.replace("−", "-")) == value


@given(st.lists(st.floats(0.001, 100), min_size=1, max_size=25), st.floats(1, 30))
def test_every_interval_gets_its_least_width(widths: list[float], least: float) -> None:
    knots = [0.0]
    for width in widths:
        knots.append(knots[-1] + width)
    scale = WidenedScale.of(knots, 50, 750, least)
    places = scale.places
    assert (places[0], places[-1]) == (50, 750)
    room = min(least, 700 / len(widths))
    assert all(b - a >= room * (1 - 1e-9) for a, b in pairwise(places))
    assert [scale(knot) for knot in knots] == pytest.approx(places)


def test_a_widened_interval_is_known_as_such() -> None:
    scale = WidenedScale.of([0, 50, 50.001, 100], 0, 100, 10)
    assert [scale.is_widened(k) for k in range(3)] == [False, True, False]
    assert scale(50.0005) == pytest.approx(50, abs=0.01)


def test_linear_scale() -> None:
    scale = Scale(0, 5, 300, 100)
    assert (scale(0), scale(5), scale(2.5)) == (300, 100, 200)
    assert [text for _, text in angle_ticks(90)] == ["−180°", "−90°", "0°", "90°", "180°"]


def test_ticks_are_where_their_values_are() -> None:
    frame = Frame.of(Box(60, 20, 660, 420), Box(0, 0, 50, 30))
    texts = [shape for shape in frame.shapes("L2", "L3") if isinstance(shape, Text)]
    by_words = {text.words: text.at for text in texts if text.at[1] > 420}
    assert {"0", "10", "20", "30", "40", "50", "L2"} <= by_words.keys()
    assert by_words["20"][0] == frame.place((20, 0))[0] == 300
    assert [text.turn for text in texts if text.words == "L3"] == [-90]
