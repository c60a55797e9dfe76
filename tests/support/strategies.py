"""Random manipulators, generic and special."""

from fractions import Fraction

from hypothesis import assume
from hypothesis import strategies as st

from rpr_solver import InputError, Manipulator


def rationals(low: int, high: int, denominators: tuple[int, ...]) -> st.SearchStrategy[Fraction]:
    """Fractions in [low, high] with one of the denominators."""
    return st.sampled_from(denominators).flatmap(
        lambda d: st.integers(low * d, high * d).map(lambda n: Fraction(n, d))
    )


@st.composite
def manipulators(draw: st.DrawFn, size: int = 40, denominators: tuple[int, ...] = (1, 10, 7)) -> Manipulator:
    """Any valid manipulator; small sizes bring many coincidences."""
    values = [draw(rationals(low, size, denominators)) for low in (-size, -size, -size, 0, 0, 0)]
    try:
        return Manipulator(*values, orientation=draw(st.sampled_from(["ccw", "cw"])))
    except InputError:
        assume(False)
        raise


def lengths(size: int = 60, denominators: tuple[int, ...] = (1, 10, 7)) -> st.SearchStrategy[Fraction]:
    """Positive leg lengths."""
    return rationals(0, size, denominators).filter(bool)
