"""What is degenerate in a range of slices, and in a part of it."""

from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import Degeneracy, LengthRange, PoseKind
from tests.support.strategies import examples

ENDS = st.one_of(st.none(), st.integers(1, 12))


@given(st.integers(0, 10), ENDS, st.integers(0, 10), ENDS)
@examples(60)
def test_a_part_is_the_intersection(low: int, high: int | None, start: int, stop: int | None) -> None:
    if (high is not None and high <= low) or (stop is not None and stop <= start):
        return
    whole = Degeneracy(1, PoseKind.CURVE, str(low), None if high is None else str(high))
    part = whole.within(LengthRange(Fraction(start), None if stop is None else Fraction(stop)))
    inside = [
        x
        for x in (Fraction(2 * n + 1, 2) for n in range(14))
        if low < x and start < x and (high is None or x < high) and (stop is None or x < stop)
    ]
    assert (part is not None) == bool(inside)
    if part is not None:
        assert Fraction(part.start) == max(low, start)
        assert (part.stop and int(part.stop)) == min((x for x in (high, stop) if x), default=None)


def test_a_single_length_is_inside_or_not() -> None:
    at_five = Degeneracy(1, PoseKind.CURVE, "5", "5", equation="alpha = 0 deg")
    assert at_five.within(LengthRange(Fraction(4), Fraction(6))) == at_five
    assert at_five.within(LengthRange(Fraction(6), None)) is None
    assert Degeneracy.from_json(at_five.to_json(), 1) == at_five
