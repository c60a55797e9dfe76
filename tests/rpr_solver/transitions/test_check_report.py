"""Reports of checks: intervals that cut the range, verdicts, and cusps on the right side of a limit."""

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, JointPoint, Requirement, check
from rpr_solver.transitions.check_report import CheckedInterval, CheckReport, _merged, _side
from tests.support.shared import census_of
from tests.support.strategies import examples, rationals

FLAT = EXAMPLES["zein-flat"]
CUSP = JointPoint(1, ("1", "2", "3", "4"))


def report(counts: Sequence[int], most: int | None = None, least: int | None = None) -> CheckReport:
    """Of the lengths from 1, with so many cusps from each integer to the next."""
    intervals = tuple(
        CheckedInterval(str(n), str(n + 1), count, Fraction(2 * n + 1, 2), (CUSP,) * count)
        for n, count in enumerate(counts, 1)
    )
    requirement = Requirement(start=1, stop=len(counts) + 1, max_cusps=most, min_cusps=least)
    return CheckReport(FLAT, requirement, 15, intervals)


class TestVerdict:
    @given(
        st.lists(st.integers(0, 9), min_size=1),
        st.one_of(st.none(), st.integers(4, 9)),
        st.integers(0, 4),
    )
    @examples(60)
    def test_a_requirement_fails_where_there_are_too_many_or_too_few(
        self, counts: list[int], most: int | None, least: int
    ) -> None:
        answer = report(counts, most, least)
        bad = [n for n, x in enumerate(counts, 1) if x < least or (most is not None and x > most)]
        assert [int(x.start) for x in answer.violations] == bad
        assert answer.passed == (not bad)

    def test_the_document_has_all_intervals_and_examples_of_violations(self) -> None:
        answer = report([2, 1, 3], most=1)
        document = answer.to_json()
        assert list(document)[2:] == [
            "requirement", "passed", "max_cusps_found", "min_cusps_found", "intervals", "violations",
            "degenerate", "digits", "solver_version",
        ]  # fmt: skip
        assert (document["passed"], document["max_cusps_found"], document["min_cusps_found"]) == (False, 3, 1)
        assert document["intervals"][1] == {"from": "2", "to": "3", "count": 1}
        assert document["violations"] == [
            {"from": "1", "to": "2", "count": 2, "example": {"l1": "1.5", "cusps": [CUSP.to_json()] * 2}},
            {"from": "3", "to": "4", "count": 3, "example": {"l1": "3.5", "cusps": [CUSP.to_json()] * 3}},
        ]


class TestIntervals:
    @given(st.lists(st.integers(0, 2), min_size=1))
    @examples(40)
    def test_neighbours_of_equal_count_become_one(self, counts: list[int]) -> None:
        merged = list(_merged(list(report(counts, most=9).intervals)))
        assert all(a.stop == b.start and a.count != b.count for a, b in pairwise(merged))
        spread = [x.count for x in merged for _ in range(int(x.start), int(x.stop or 0))]
        assert spread == counts
        assert all(Fraction(x.start) < x.example < Fraction(x.stop or 0) for x in merged)

    @pytest.mark.parametrize(
        ("start", "stop"), [(30, 40), ("31.8633", "31.86335"), (Fraction(100, 3), None), (0, "20.5")]
    )
    def test_without_limits_they_are_those_of_the_census(self, start: Any, stop: Any) -> None:
        requirement = Requirement(start=start, stop=stop, min_cusps=0)
        answer = check(FLAT, requirement, digits=15)
        table = census_of(FLAT, digits=30)
        low, high = requirement.start, requirement.stop
        cuts = [x for x in table.transitions if low < Fraction(x.length) and x.count_before != x.count_after]
        cuts = [x for x in cuts if high is None or Fraction(x.length) < high]
        assert len(answer.intervals) == len(cuts) + 1
        for (a, b), cut in zip(pairwise(answer.intervals), cuts, strict=True):
            assert abs(Fraction(b.start) - Fraction(cut.length)) <= Fraction(cut.length) / 10**14
            assert (a.count, b.count) == (cut.count_before, cut.count_after)
            assert a.stop == b.start
        first, last = answer.intervals[0], answer.intervals[-1]
        assert (Fraction(first.start), last.stop and Fraction(last.stop)) == (low, high)
        assert all(len(x.cusps) == x.count for x in answer.intervals)


class TestSide:
    @given(
        rationals(1, 30, (1, 7, 10**16)),
        st.one_of(st.none(), rationals(1, 30, (1, 7, 10**16))),
        st.one_of(st.none(), rationals(1, 30, (1, 7, 10**16))),
    )
    @examples(120)
    def test_a_decided_side_is_right_for_every_number_that_rounds_so(
        self, x: Fraction, low: Fraction | None, high: Fraction | None
    ) -> None:
        assume(low is None or high is None or low < high)
        text = f"{float(x):.14e}"  # 15 digits
        side = _side(text, (low, high), 15)
        unit = Fraction(10) ** int(text.partition("e")[2]) / 10**14
        values = [Fraction(text) + sign * unit / 2 for sign in (-1, 1)]
        sides = {(low is None or y > low) and (high is None or y < high) for y in values}
        assert side is None or sides == {side}

    def test_only_a_limit_within_the_last_digit_is_not_decided(self) -> None:
        for bounds in ((Fraction("12.5"), None), (None, Fraction("12.5"))):
            assert _side("12.5000000000000", bounds, 15) is None
            assert _side("12.5000000000001", bounds, 15) is None
            assert _side("12.5000000000003", bounds, 15) == (bounds[0] is not None)
            assert _side("12.4999999999997", bounds, 15) == (bounds[1] is not None)
        assert _side("12.5", (None, None), 15) is True
