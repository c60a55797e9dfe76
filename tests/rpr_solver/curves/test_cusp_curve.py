"""One cusp curve: ends that survive their documents, ranges that it meets, and how it is shown."""

from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import JointPoint, LengthKind, LengthRange, PoseKind, TransitionEvent
from rpr_solver.curves.cusp_curve import CurveEnd, CuspCurve
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
