"""Windows that are ignored since they are narrow: in checks, censuses and margins."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import pairwise

import pytest

from rpr_solver import (
    EXAMPLES,
    Manipulator,
    Requirement,
    census,
    census_csv,
    check,
    margin,
    restrict_census,
    verify_document,
)
from rpr_solver.contract import LENGTHS
from rpr_solver.errors import InputError
from rpr_solver.exact.rationals import exact_str
from tests.support.pictures import random_robot
from tests.support.sampling import seeds

INNOCENTI = EXAMPLES["innocenti"]
SHARED = Manipulator(a2x=3, a3x=0, a3y=4, d1=0, d2=6, d3=6)


def test_a_check_passes_with_windows_that_are_narrow_and_lists_them() -> None:
    strict = Requirement(start=10, stop=15, max_cusps=6)
    assert not check(INNOCENTI, strict)
    report = check(INNOCENTI, strict.ignoring(Fraction(1, 1000)))
    assert report
    assert report.violations == ()
    [first, second] = report.ignored_windows
    assert (first.counts, second.counts) == ((8,), (8,))
    assert Fraction(first.width) == pytest.approx(Fraction(first.stop) - Fraction(first.start), rel=1e-5)
    assert second.width == "8.59206e-9"
    document = report.to_json()
    assert (document["max_cusps_found"], len(document["intervals"])) == (6, 5)
    between = check(INNOCENTI, strict.ignoring(Fraction(1, 10**6)))
    assert not between
    assert [x.count for x in between.violations] == [8]
    assert between.ignored_windows == (second,)
    assert verify_document(document).verdict == verify_document(between.to_json()).verdict == "verified"


def test_neighbouring_intervals_are_one_window() -> None:
    # 8, 10 and 8 cusps from 27.23 to 28.26, where the 10 are in a window of 0.0125
    wish = Requirement(start="28", stop="29", max_cusps=6)
    width = Fraction(check(INNOCENTI, wish).violations[-1].stop or 0) - 28
    assert len(check(INNOCENTI, wish).violations) == 3
    assert not check(INNOCENTI, wish.ignoring(width - Fraction(1, 10**9)))
    [window] = check(INNOCENTI, wish.ignoring(width + Fraction(1, 10**9))).ignored_windows
    assert window.counts == (8, 10, 8)
    assert window.start == "28"


def test_a_window_is_not_narrower_than_itself() -> None:
    wish = Requirement(start=12, stop=13, max_cusps=0)
    assert not check(INNOCENTI, wish.ignoring(Fraction(1)))
    [window] = check(INNOCENTI, wish.ignoring(Fraction(1000001, 1000000))).ignored_windows
    assert window.width == "1.00000"
    open_end = Requirement(start=12, max_cusps=0)
    assert not check(INNOCENTI, open_end.ignoring(Fraction(10**9)))


def test_machines_whose_legs_share_joints_have_one_window_without_cusps() -> None:
    wish = Requirement(start=1, stop=2, min_cusps=1)
    assert not check(SHARED, wish.ignoring(Fraction(1)))
    assert check(SHARED, wish.ignoring(Fraction(2)))
    assert list(census(SHARED, start=1, stop=2, ignore_windows=2).ignored_windows) == [0]


def test_a_census_marks_each_interval_that_is_narrower() -> None:
    table = census(INNOCENTI, start=10, stop=20, digits=15, ignore_windows="0.001")
    assert table.counts == (6, 8, 6, 8, 6)
    assert list(table.ignored_windows) == [1, 3]
    assert set(table.kept_counts) == {6}
    document = table.to_json()
    plain = census(INNOCENTI, start=10, stop=20, digits=15).to_json()
    assert {name: document[name] for name in plain} == plain
    assert [window["width"] for window in document["ignored_windows"]] == ["0.00000337782", "8.59206e-9"]
    assert [line.rpartition(",")[2] for line in census_csv(document).split()[1:]] == [
        *("", "0.00000337782", "", "8.59206e-9", ""),
    ]
    part = restrict_census(document, 11, 20)
    assert part is not None
    assert "ignored_windows" not in part
    assert verify_document(document).verdict == "verified"


def test_what_is_no_width_is_named() -> None:
    with pytest.raises(InputError, match=r"requirement\.ignore_windows"):
        Requirement(max_cusps=3, ignore_windows=-1)
    with pytest.raises(InputError, match="ignore_windows"):
        census(INNOCENTI, ignore_windows="-0.1")
    again = Requirement(max_cusps=3, ignore_windows="1/3")
    assert Requirement.from_json(again.to_json()) == again


def test_a_forged_window_is_refused() -> None:
    document = check(INNOCENTI, Requirement(start=10, stop=15, max_cusps=6, ignore_windows="0.001")).to_json()
    wider = {**document["ignored_windows"][0], "width": "0.00000337783"}
    fewer = {**document, "ignored_windows": document["ignored_windows"][1:]}
    narrower = {**document["requirement"], "ignore_windows": "0.000001"}
    for forged in (
        {**document, "ignored_windows": [wider, *document["ignored_windows"][1:]]},
        fewer,
        {**document, "requirement": narrower},
    ):
        assert verify_document(forged).verdict == "refused"
    with pytest.raises(InputError, match="ignored_windows"):
        verify_document({name: x for name, x in document.items() if name != "ignored_windows"})


@pytest.mark.parametrize("some", seeds(2, number=40, at_once=8))
def test_a_looser_threshold_never_loses_a_yes(some: range) -> None:
    for rng in map(random.Random, some):
        manipulator = random_robot(rng)
        table = census(manipulator, digits=15)
        lengths = [Fraction(t.length) for t in table.transitions]
        widths = sorted(b - a for a, b in pairwise(lengths))
        limits = [Fraction(0), *(w * f for w in widths[:6] for f in (Fraction(99, 100), Fraction(101, 100)))]
        most = rng.choice(table.counts)
        wish = Requirement(start=lengths[0] / 2, stop=lengths[-1] * 2, max_cusps=most)
        answers = [check(manipulator, wish.ignoring(w)) for w in limits]
        assert [bool(x) for x in answers] == sorted(bool(x) for x in answers)
        for low, high in pairwise(answers):
            assert set(low.ignored_windows) <= set(high.ignored_windows)


@pytest.mark.parametrize("tolerance", ["0.0001", "0.01"])
def test_a_margin_is_that_of_the_requirement_without_narrow_windows(tolerance: str) -> None:
    wish = Requirement(start=10, stop=15, max_cusps=6)
    strict = margin(INNOCENTI, requirement=wish, tolerance=tolerance)
    assert strict.reason == "the manipulator does not satisfy the requirement"
    found = margin(INNOCENTI, requirement=wish.ignoring(Fraction(1, 1000)), tolerance=tolerance)
    assert found.verdict == ("proved" if tolerance == "0.0001" else "open")
    assert found.asked["requirement"]["ignore_windows"] == "0.001"


def test_geometries_within_a_margin_have_narrow_windows_alone() -> None:
    wish = Requirement(start=10, stop=15, max_cusps=6, ignore_windows="0.001")
    rng = random.Random(7)
    for _ in range(6):
        own = dict(zip(LENGTHS, INNOCENTI.lengths, strict=True))
        moved = {g: x + Fraction(rng.choice((-1, 1)), 10**4) for g, x in own.items()}
        assert check(Manipulator(**{**INNOCENTI.to_dict(), **moved}), wish)


def test_a_window_that_grows_too_wide_is_a_counterexample() -> None:
    wish = Requirement(start=21, stop=26, max_cusps=6, ignore_windows="0.1")
    found = margin(INNOCENTI, requirement=wish)
    assert found.proved is not None
    assert found.counterexample is not None
    assert margin(INNOCENTI, requirement=wish.ignoring(Fraction(0))).proved <= found.proved  # type: ignore[operator]
    refuting = check(found.counterexample.manipulator, wish)
    assert not refuting
    assert exact_str(refuting.violations[0].example) == exact_str(found.counterexample.found.length or 0)
