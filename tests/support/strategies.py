"""Random manipulators, generic and special."""

from collections import Counter
from collections.abc import Callable
from fractions import Fraction
from typing import TypeVar

from hypothesis import assume, settings
from hypothesis import strategies as st

from rpr_solver import InputError, Manipulator, SolverError

Answer = TypeVar("Answer")


def rationals(low: int, high: int, denominators: tuple[int, ...]) -> st.SearchStrategy[Fraction]:
    """Fractions in [low, high] with one of the denominators."""
    return st.sampled_from(denominators).flatmap(
        lambda d: st.integers(low * d, high * d).map(lambda n: Fraction(n, d))
    )


@st.composite
def manipulators(draw: st.DrawFn, size: int = 40, denominators: tuple[int, ...] = (1, 10, 7)) -> Manipulator:
    """Any valid manipulator whose legs share no joints; small sizes make coincidences frequent."""
    values = [draw(rationals(low, size, denominators)) for low in (-size, -size, -size, 0, 0, 0)]
    try:
        manipulator = Manipulator(*values, orientation=draw(st.sampled_from(["ccw", "cw"])))
        manipulator.geometry.apart_from_shared()
        return manipulator
    except InputError:
        assume(False)
        raise


def lengths(size: int = 60, denominators: tuple[int, ...] = (1, 10, 7)) -> st.SearchStrategy[Fraction]:
    """Positive leg lengths."""
    return rationals(0, size, denominators).filter(bool)


def examples(count: int) -> settings:
    """Settings for `count` random examples, scaled by the profile."""
    return settings(max_examples=max(1, count * settings().max_examples // 100))


def unless_refused(solve: Callable[[], Answer], answers: Counter[str]) -> Answer:
    """Returns the answer; an unsupported case is counted, and replaced by another one."""
    try:
        answer = solve()
    except SolverError as error:
        answers["refused"] += 1
        assume("not supported" not in str(error))
        raise
    answers["given"] += 1
    return answer
