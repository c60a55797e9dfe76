"""One cusp curve: ends that survive their documents, ranges that it meets, and how it is shown."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import JointPoint, LengthKind, LengthRange, PoseKind, TransitionEvent
from rpr_solver.curves.cusp_curve import CurveEnd, CurvePoint, CuspCurve
from tests.support.strategies import examples, rationals

POINTS = st.lists(st.sampled_from(["0", "-12.5", "3.25", "1.00000e-12"]), min_size=4, max_size=4)
KINDS = st.sampled_from([*PoseKind, *LengthKind])
LENGTHS = rationals(1, 12, (1, 2))


@st.composite
def ends(draw: st.DrawFn, leg: int) -> CurveEnd:
    events = draw(st.lists(st.tuples(st.sampled_from(list(PoseKind)), POINTS), max_size=2))
    return CurveEnd(
        draw(st.sampled_from([None, "0", "26.7863808708888"])),
        draw(KINDS),
        draw(st.sampled_from([None, "C19"])),
        tuple(TransitionEvent(kind, JointPoint(leg, (a, b, c, d))) for kind, (a, b, c, d) in events),
    )


def curve(start: Fraction, stop: Fraction | None) -> CuspCurve:
    """From a decimal, or 0, to a decimal, or infinity."""
    first = CurveEnd(str(float(start)), PoseKind.SWALLOWTAIL)
    last = CurveEnd(None if stop is None else str(float(stop)), LengthKind.OPEN)
    return CuspCurve("C1", first, last, ())


@given(st.sampled_from([1, 2, 3]), st.data())
@examples(60)
def test_an_end_survives_its_document(leg: int, data: st.DataObject) -> None:
    end = data.draw(ends(leg))
    document = end.to_json(leg)
    assert list(document) == [f"l{leg}", "kind", "joins", "events"]
    again = CurveEnd.from_json(document, leg)
    assert again == end
    assert type(again.kind) is type(end.kind)


@pytest.mark.parametrize("kind", [*PoseKind, *LengthKind])
def test_every_kind_of_end_is_known_by_its_name(kind: PoseKind | LengthKind) -> None:
    document = {"l1": "5", "kind": str(kind), "joins": None, "events": []}
    assert CurveEnd.from_json(document, 1).kind is kind


def test_no_kind_of_length_has_the_name_of_a_kind_of_pose() -> None:
    assert not {x.value for x in PoseKind} & {x.value for x in LengthKind}


@given(LENGTHS, st.one_of(st.none(), LENGTHS), LENGTHS, st.one_of(st.none(), LENGTHS))
@examples(120)
def test_a_curve_meets_a_range_where_lengths_lie_in_both(
    start: Fraction, stop: Fraction | None, low: Fraction, high: Fraction | None
) -> None:
    """To touch in an end is not enough; steps of 1/4 come upon every overlap of halves."""
    if (stop is not None and stop <= start) or (high is not None and high <= low):
        return

    def inside(x: Fraction) -> bool:
        return start < x and (stop is None or x < stop) and low < x and (high is None or x < high)

    shared = any(inside(Fraction(n, 4)) for n in range(1, 100))
    assert curve(start, stop).meets(LengthRange(low, high)) == shared


@given(LENGTHS, st.one_of(st.none(), LENGTHS), st.integers(15, 40), st.fractions(-2, 2))
def test_a_curve_holds_lengths_between_its_ends_and_half_a_unit_beyond(
    start: Fraction, stop: Fraction | None, digits: int, units: Fraction
) -> None:
    unit = Fraction(10) ** (1 - digits)
    assert curve(start, stop).holds(start * (1 - units * unit), digits) == (
        units <= Fraction(1, 2) and (stop is None or start * (1 - units * unit) <= stop * (1 + unit / 2))
    )
    if stop is not None and start < stop:
        assert curve(start, stop).holds((start + stop) / 2, digits)
        assert curve(start, stop).holds(stop * (1 + units * unit), digits) == (units <= Fraction(1, 2))


def test_a_curve_from_0_to_infinity_meets_every_range() -> None:
    whole = CuspCurve("C1", CurveEnd("0", LengthKind.OPEN), CurveEnd(None, LengthKind.OPEN), ())
    for span in (
        LengthRange(),
        LengthRange(Fraction(10) ** 9),
        LengthRange(Fraction(0), Fraction(1, 10**9)),
    ):
        assert whole.meets(span)


def test_an_end_is_shown_with_its_kind_and_what_joins_it() -> None:
    assert repr(CurveEnd("26.7863808708888", PoseKind.LIPS)) == "<CurveEnd at 26.786380…: lips>"
    assert repr(CurveEnd(None, LengthKind.OPEN)) == "<CurveEnd without end: open>"
    joined = CurveEnd("3", PoseKind.BEAK_TO_BEAK, joins="C2")
    assert repr(joined) == "<CurveEnd at 3: beak-to-beak, joins C2>"


def test_a_curve_is_shown_with_its_ends_and_the_number_of_its_points() -> None:
    point = JointPoint(3, ("31.4509403281135", "-129", "25.5", "35.5"))
    on_curve = CurvePoint(Fraction(61, 3), 4, point)
    assert repr(on_curve) == (
        "<CurvePoint L3=61/3 cusp 4: alpha_deg=31.450940… theta3_deg=-129 l1=25.5 l2=35.5>"
    )
    born, dies = CurveEnd("0.829977410", PoseKind.SWALLOWTAIL), CurveEnd("7", LengthKind.SEVERAL)
    one = CuspCurve("C7", born, dies, (on_curve,))
    assert repr(one) == "<CuspCurve C7 from 0.82997741… (swallowtail) to 7 (several): 1 point>"
    open_one = CuspCurve("C7", born, CurveEnd(None, LengthKind.OPEN), ())
    assert repr(open_one) == "<CuspCurve C7 from 0.82997741… (swallowtail) to ∞ (open): 0 points>"
