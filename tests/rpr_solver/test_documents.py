"""Cuts from documents: what is cut out is what would have been answered, or there is no answer.

Documents are made from exact numbers, with any number of digits, so that the right cut is known beforehand.
"""

import csv
import io
from collections.abc import Sequence
from decimal import ROUND_HALF_UP, Context, Decimal
from fractions import Fraction
from itertools import pairwise
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rpr_solver import (
    EXAMPLES,
    InputError,
    LengthRange,
    census,
    census_csv,
    curves_csv,
    restrict_census,
    shorten_slice,
    solve_slice,
    table_csv,
)
from tests.support.shared import census_of, curves_of, eliminant_of
from tests.support.strategies import examples, rationals

FLAT = EXAMPLES["zein-flat"]
NUMBERS = st.fractions(min_value=Fraction(1, 1000), max_value=1000, max_denominator=10**9)
ANGLES = st.fractions(min_value=-180, max_value=180, max_denominator=10**6)  # none needs an exponent
POINTS = st.lists(st.tuples(ANGLES, ANGLES, NUMBERS, NUMBERS), max_size=3)
Point = tuple[Fraction, Fraction, Fraction, Fraction]


def decimal(x: Fraction, digits: int) -> str:
    """Rounded by Python's own arithmetic."""
    if x == 0:
        return "0"
    rounded = Context(prec=digits, rounding=ROUND_HALF_UP).divide(
        Decimal(x.numerator), Decimal(x.denominator)
    )
    places = max(digits - 1 - rounded.adjusted(), 0)
    return f"{rounded:.{places}f}"


def angle(x: Fraction, digits: int) -> str:
    return decimal(x, digits).removeprefix("-" if decimal(x, digits).startswith("-180") else "")


def points_json(points: Sequence[Point], digits: int, **more: str) -> list[dict[str, str]]:
    return [
        {**more, "alpha_deg": angle(a, digits), "theta1_deg": angle(b, digits),
         "l2": decimal(c, digits), "l3": decimal(d, digits)}
        for a, b, c, d in points
    ]  # fmt: skip


def slice_of(cusps: Sequence[Point], degenerate: Sequence[Point], digits: int) -> dict[str, Any]:
    return {
        "l1": "61/3",
        "count": len(cusps),
        "cusps": points_json(cusps, digits),
        "degenerate_points": [
            *points_json(degenerate, digits, kind="lips"), {"kind": "curve", "equation": "alpha = 180"}
        ],
        "certificate": {"method": "exact"},
    }  # fmt: skip


class TestFewerDigits:
    @given(POINTS, POINTS, st.integers(15, 39))
    @examples(60)
    def test_a_slice_is_rounded_as_if_it_had_been_computed_so(
        self, cusps: list[Point], degenerate: list[Point], digits: int
    ) -> None:
        short = shorten_slice(slice_of(cusps, degenerate, 40), 40, digits)
        assume(short is not None)  # what ends in …5 exactly is a tie
        assert short == slice_of(cusps, degenerate, digits)

    def test_a_tie_gives_none(self) -> None:
        tie = "1.00000000000000500000"
        for name in ("cusps", "degenerate_points"):
            for member in ("alpha_deg", "l3"):
                document = {name: [{"alpha_deg": "1.5", "l3": "2", member: tie}]}
                assert shorten_slice(document, 21, 15) is None
                assert shorten_slice(document, 21, 18) is not None

    def test_what_rounds_to_minus_180_degrees_is_180(self) -> None:
        document = {"cusps": [{"alpha_deg": "-179.99999999999999999", "l2": "-179.99999999999999999"}]}
        assert shorten_slice(document, 20, 15) == {
            "cusps": [{"alpha_deg": "180.000000000000", "l2": "-180.000000000000"}]
        }

    @pytest.mark.parametrize("length", [3, "34.5"])
    def test_a_solved_slice_becomes_the_one_of_fewer_digits(self, length: int | str) -> None:
        many, few = (solve_slice(eliminant_of(FLAT), length, digits).to_json() for digits in (60, 20))
        assert shorten_slice(many, 60, 20) == few
        assert len(many["cusps"][0]["l2"]) > 60


def census_json(
    events: Sequence[tuple[Fraction, Point]], digits: int, start: Fraction, stop: Fraction | None
) -> dict[str, Any]:
    """The census of a manipulator with one lips at each of these lengths, two cusps more after each."""
    counts = [2 * n for n in range(len(events) + 1)]
    inside = [
        (n, x, point)
        for n, (x, point) in enumerate(events)
        if start < x and (stop is None or x < stop)
    ]  # fmt: skip
    first = sum(x <= start for x, _ in events)
    span = LengthRange(start, stop).to_json()
    ends = [span["from"], *(decimal(x, digits) for _, x, _ in inside), span["to"]]
    return {
        "fixed_leg": 1,
        "digits": digits,
        "range": span,
        "transitions": [
            {
                "l1": decimal(x, digits),
                "kind": "lips",
                "count_before": counts[n],
                "count_after": counts[n + 1],
                "events": points_json([point], digits, kind="lips"),
            }
            for n, x, point in inside
        ],
        "intervals": [
            {"from": a, "to": b, "count": counts[first + k]} for k, (a, b) in enumerate(pairwise(ends))
        ],
        "degenerate": degenerate_json([x for x, _ in events], digits, start, stop),
        "certificate": {"method": "events"},
    }


def degenerate_json(
    ends: Sequence[Fraction], digits: int, start: Fraction, stop: Fraction | None
) -> list[dict[str, Any]]:
    """A curve at all lengths, one at the second event alone, and nodes between the first and the last."""
    span = LengthRange(start, stop).to_json()
    found: list[dict[str, Any]] = [{"kind": "curve", **span, "equation": "alpha = 0 deg"}]
    if len(ends) > 1:
        low, at, high = ends[0], ends[1], ends[-1]
        if start < at and (stop is None or at < stop):
            found.append({"kind": "curve", "from": decimal(at, digits), "to": decimal(at, digits)})
        if start < high and (stop is None or low < stop):
            first = span["from"] if low < start else decimal(low, digits)
            last = span["to"] if stop is not None and high > stop else decimal(high, digits)
            found.append({"kind": "node", "from": first, "to": last, "count": 2})
    return found


class TestPartOfARange:
    @given(
        st.dictionaries(NUMBERS, st.tuples(ANGLES, ANGLES, NUMBERS, NUMBERS), max_size=3),
        rationals(0, 900, (1, 7)),
        st.one_of(st.none(), rationals(1, 1000, (1, 7))),
        st.integers(15, 30),
    )
    @examples(60)
    def test_it_is_as_if_it_had_been_computed_so(
        self, by_length: dict[Fraction, Point], start: Fraction, stop: Fraction | None, digits: int
    ) -> None:
        events = sorted(by_length.items())
        assume(stop is None or start < stop)
        assume(not by_length.keys() & {start, stop})
        whole = census_json(events, 30, Fraction(0), None)
        part = restrict_census(whole, start, stop, digits)
        assume(part is not None)  # a tie
        assert part == census_json(events, digits, start, stop)

    @pytest.mark.parametrize("end", ["12.5", Fraction(25, 2) + Fraction(1, 10**18)])
    def test_an_end_within_the_last_digit_of_a_transition_is_not_decided(self, end: Fraction | str) -> None:
        point = (Fraction(1), Fraction(2), Fraction(3), Fraction(4))
        document = census_json([(Fraction(25, 2), point)], 20, Fraction(0), None)
        assert restrict_census(document, end, None) is None
        assert restrict_census(document, 1, end) is None
        beside = Fraction(25, 2) + Fraction(1, 10**17)
        below, above = restrict_census(document, 1, beside), restrict_census(document, beside, 20)
        assert below is not None
        assert above is not None
        assert [x["count"] for x in below["intervals"]] == [0, 2]
        assert [x["count"] for x in above["intervals"]] == [2]

    def test_a_tie_gives_none(self) -> None:
        tie = Fraction("1.000000000000005")
        point = (Fraction(1), Fraction(2), Fraction(3), Fraction(4))
        of_length, of_event = (
            census_json([event], 20, Fraction(0), None)
            for event in ((tie, point), (Fraction(2), (*point[:3], tie)))
        )
        for document in (of_length, of_event):
            assert restrict_census(document, None, None, 15) is None
            assert restrict_census(document, None, None, 17) is not None
        assert restrict_census(of_length, 5, None, 15) is not None  # it is outside

    @pytest.mark.parametrize(
        ("arguments", "fields"),
        [
            ((-1, None), ["start"]),
            ((3, 2), ["stop"]),
            ((None, None, 14), ["digits"]),
            ((0.5, "x"), ["start", "stop"]),
        ],
    )
    def test_what_is_wrong_is_named(self, arguments: tuple[Any, ...], fields: list[str]) -> None:
        with pytest.raises(InputError) as caught:
            restrict_census(census_json([], 20, Fraction(0), None), *arguments)
        assert [p.field for p in caught.value.problems] == fields

    def test_a_computed_census_becomes_that_of_its_part(self) -> None:
        part = restrict_census(census_of(FLAT, digits=30).to_json(), 30, "35.5", 15)
        own = census(FLAT, start=30, stop="35.5", digits=15).to_json()
        assert part is not None
        names = ("range", "transitions", "intervals", "degenerate", "digits", "fixed_leg", "geometry_hash")
        assert {name: part[name] for name in names} == {name: own[name] for name in names}


def lines(text: str) -> list[dict[str, str]]:
    assert "\r" not in text
    return list(csv.DictReader(io.StringIO(text)))


class TestCsv:
    def test_a_table_has_a_line_for_each_cusp_and_for_each_slice_without(self) -> None:
        cusps = points_json([(Fraction(1), Fraction(2), Fraction(3), Fraction(4))] * 2, 15)
        detail = 'not decided, at "5",\nnor later'
        table = {
            "fixed_leg": 1,
            "slices": [
                {"l1": "3", "count": 2, "cusps": cusps, "certificate": {}},
                {"l1": "4", "count": 0, "cusps": []},
                {"l1": "5", "error": {"type": "solver-error", "detail": detail}},
            ],
        }
        columns = ["alpha_deg", "theta1_deg", "l2", "l3", "cusp", "error", "kind", "equation"]
        empty = dict.fromkeys(columns, "")
        assert lines(table_csv(table)) == [
            {**empty, "l1": "3", "count": "2", "cusp": "1", "kind": "cusp", **cusps[0]},
            {**empty, "l1": "3", "count": "2", "cusp": "2", "kind": "cusp", **cusps[1]},
            {**empty, "l1": "4", "count": "0"},
            {**empty, "l1": "5", "count": "", "error": detail},
        ]

    def test_a_table_has_a_line_for_each_degenerate_point_with_its_kind(self) -> None:
        item = slice_of([], [(Fraction(1), Fraction(2), Fraction(3), Fraction(4))], 15)
        lips, curve = lines(table_csv({"fixed_leg": 1, "slices": [item]}))
        assert (lips["kind"], lips["cusp"], lips["count"], lips["alpha_deg"]) == (
            "lips", "", "0", "1.00000000000000"
        )  # fmt: skip
        assert (curve["kind"], curve["equation"], curve["l2"]) == ("curve", "alpha = 180", "")

    def test_curves_have_a_line_for_each_point(self) -> None:
        curves = curves_of(FLAT, digits=15).sampled([3, "34.5"], eliminant=eliminant_of(FLAT))
        expected = [
            (curve.name, str(point.cusp), *point.point.coordinates)
            for curve in curves.curves
            for point in curve.points
        ]
        columns = ("curve", "cusp", "alpha_deg", "theta1_deg", "l2", "l3")
        rows = lines(curves_csv(curves.to_json()))
        assert [tuple(row[name] for name in columns) for row in rows] == expected
        assert {row["l1"] for row in rows} == {"3", "34.5"}

    def test_an_interval_of_a_census_has_the_transition_at_its_end(self) -> None:
        table = census_of(FLAT, digits=30)
        rows = lines(census_csv(table.to_json()))
        assert [int(row["count"]) for row in rows] == list(table.counts)
        kinds = [*(x.kind.value for x in table.transitions), ""]
        assert [row["transition_at_end"] for row in rows] == kinds
        assert [row["to"] for row in rows] == [*(x.length for x in table.transitions), ""]
