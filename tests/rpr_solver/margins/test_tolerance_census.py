"""Censuses of a tolerance: intervals of transitions, and what they mean for exact censuses nearby."""

import random
from collections.abc import Mapping
from fractions import Fraction
from functools import cache

import pytest

from rpr_solver import EXAMPLES, Manipulator, ToleranceCensus, census, tolerance_census
from rpr_solver.contract import LENGTHS
from rpr_solver.margins.bands import ORDER, OUTSIDE, SINGULAR, Span
from tests.support.sampling import long

INNOCENTI = EXAMPLES["innocenti"]


@cache
def table(
    name: str = "innocenti", tolerance: str = "0.001", start: int = 26, stop: int = 32, leg: int = 1
) -> ToleranceCensus:
    """The census of a tolerance, shared by the tests."""
    return tolerance_census(EXAMPLES[name], tolerance, fixed_leg=leg, start=start, stop=stop, digits=15)


def near(manipulator: Manipulator, tolerance: Mapping[str, Fraction], rng: random.Random) -> Manipulator:
    """A random geometry within a tolerance, often at a corner."""
    parts = {g: rng.choice((-1, 1, Fraction(rng.randrange(-99, 100), 100))) for g in LENGTHS}
    moved = {g: getattr(manipulator, g) + tolerance[g] * part for g, part in parts.items()}
    return Manipulator(**{**manipulator.to_dict(), **moved})


def assert_holds(answer: ToleranceCensus, other: Manipulator) -> None:
    """The exact census of another geometry is as proved."""
    document = answer.document
    leg = document["fixed_leg"]
    start, stop = document["range"]["from"], document["range"]["to"]
    found = census(other, fixed_leg=leg, start=start, stop=stop, digits=15)
    lengths = [Fraction(transition.length) for transition in found.transitions]
    ends = [Fraction(start), *lengths, Fraction(stop or 10**6)]
    for piece in answer.pieces:
        inside = [k for k, length in enumerate(lengths) if Span(length, length).meets(piece.span)]
        if piece.least is None or piece.most is None:
            continue
        if piece.least == piece.most:
            assert not inside
        for low, high, count in zip(ends, ends[1:], found.counts, strict=False):
            if low < (piece.span.stop or high) and high > piece.span.start:
                assert piece.least <= count <= piece.most
    if answer.complete:
        assert len(lengths) == len(answer.spans)
        for length, span in zip(lengths, answer.spans, strict=True):
            assert span is not None
            assert Span(length, length).meets(span)
        assert list(found.counts) == [item["count"] for item in document["intervals"]]


def test_every_transition_of_a_range_has_its_interval() -> None:
    answer = table()
    assert answer.complete
    for transition, span in zip(answer.document["transitions"], answer.spans, strict=True):
        assert span is not None
        assert span.start < Fraction(transition["l1"]) < span.stop < span.start + Fraction(1, 50)
    counts = [piece.least for piece in answer.pieces if piece.least == piece.most]
    assert counts == [6, 8, 8, 6, 8, 6, 4]
    assert answer.pieces[0].span.start == 26
    assert answer.pieces[-1].span.stop == 32


def test_exact_censuses_are_as_proved() -> None:
    rng = random.Random(1)
    for _ in range(3):
        answer = table()
        assert_holds(answer, near(INNOCENTI, answer.tolerance, rng))


@pytest.mark.parametrize(("leg", "start"), [long(3, 38), long(2, 20), long(3, 20)])
def test_other_legs(leg: int, start: int) -> None:
    answer = table("twelve-cusps", "0.0002", start, 40, leg)
    assert answer.complete
    rng = random.Random(leg)
    assert_holds(answer, near(EXAMPLES["twelve-cusps"], answer.tolerance, rng))


def test_transitions_that_may_change_places_leave_a_range_open() -> None:
    answer = table(start=9, stop=10)
    assert [reason for _, reason in answer.open] == [ORDER, ORDER]
    assert all(span is not None for span in answer.spans)
    [_, first, between, second, _] = answer.pieces
    assert (first.least, first.most, between.most, second.most) == (4, 8, 6, 8)
    assert_holds(answer, near(INNOCENTI, answer.tolerance, random.Random(7)))
    document = answer.to_json()
    assert document["complete"] is False
    assert document["open"][0]["from"] == document["transitions"][0]["from"]


def test_a_transition_beyond_the_end_may_come_in() -> None:
    answer = tolerance_census(INNOCENTI, "0.002", start="30.5", stop="30.738", digits=15)
    [only] = answer.open
    assert only.reason == OUTSIDE
    assert Fraction("30.734") < only.span.start < only.span.stop == Fraction("30.738")
    assert (answer.pieces[-1].least, answer.pieces[-1].most) == (6, 8)


@pytest.mark.long
def test_single_lengths_may_change() -> None:
    answer = tolerance_census(INNOCENTI, {"a3x": "0.001"}, start=28, stop="28.2", digits=15)
    assert answer.complete
    assert answer.tolerance["d1"] == 0
    assert_holds(answer, near(INNOCENTI, answer.tolerance, random.Random(3)))


@pytest.mark.parametrize(
    ("manipulator", "words"),
    [
        (Manipulator(30, 0, 40, 15, 25, 20), "degenerate throughout: node"),
        (Manipulator(30, 0, 40, 30, 50, 40), "degenerate throughout: curve"),
        (EXAMPLES["zein-flat"], "flat"),
    ],
)
def test_special_families_are_open_throughout_and_it_is_said_why(
    manipulator: Manipulator, words: str
) -> None:
    answer = tolerance_census(manipulator, "0.001", start=10, stop=20, digits=15)
    assert not answer.complete
    assert answer.boxes == 0
    [only] = answer.open
    assert words in only.reason
    assert (only.span.start, only.span.stop) == (10, 20)


def test_a_search_that_is_cut_short_leaves_the_range_open() -> None:
    answer = tolerance_census(INNOCENTI, "0.001", start=26, stop=32, digits=15, most_boxes=100)
    assert not answer.complete


def test_a_transition_that_is_not_located_leaves_the_others_proved() -> None:
    answer = tolerance_census(INNOCENTI, "0.003", start="10.5", stop=21, digits=15)
    first, second, *_, before, last = answer.spans
    assert first is second is None
    assert before is not None
    assert last is not None
    assert {reason for _, reason in answer.open} <= {SINGULAR, ORDER}
    assert answer.open[0].span.start > 10.8
    assert (answer.pieces[0].least, answer.pieces[0].most) == (6, 6)
    assert_holds(answer, near(INNOCENTI, answer.tolerance, random.Random(11)))


@pytest.mark.long
def test_the_whole_census_of_the_first_manipulator() -> None:
    answer = tolerance_census(INNOCENTI, "0.001", digits=15)
    assert len(answer.spans) == 22
    assert None not in answer.spans
    assert {reason for _, reason in answer.open} == {ORDER}
    rng = random.Random(5)
    for _ in range(20):
        assert_holds(answer, near(INNOCENTI, answer.tolerance, rng))
