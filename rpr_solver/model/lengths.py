"""What is asked for by lengths of legs: slices, ranges of slices, joint limits, and limits of a motion."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any, TypeAlias

from rpr_solver.contract import LEAST_SAMPLES, MOST_SAMPLES, check_integer, check_leg
from rpr_solver.errors import FieldProblem, InputError, shown
from rpr_solver.exact.rationals import (
    Exact,
    exact_or_none,
    exact_str,
    one_or_more,
    parse_all,
    parse_exact,
    parse_positive,
)

Bounds: TypeAlias = tuple[Fraction | None, Fraction | None]
"""A least and a greatest length; None is an open end."""
ExactBounds: TypeAlias = tuple[Exact | None, Exact | None]
ExactLimits: TypeAlias = Mapping[int, ExactBounds] | Mapping[str, ExactBounds]
"""The bounds by the legs' numbers or names: ``{"l2": (5, "20.5"), "l3": (None, 30)}``."""

_LEGS = {"l1": 1, "l2": 2, "l3": 3}
_positive = partial(parse_positive, expected="a slice needs a leg length > 0 (at 0 its angle is undefined)")


def slice_length(length: Exact, fixed_leg: int) -> Fraction:
    """The length of a slice's fixed leg, in the user's unit.

    Raises:
        InputError: naming the leg: the length is not an exact number, or not positive.
    """
    return _positive(length, f"l{fixed_leg}")


def slice_lengths(lengths: Exact | Iterable[Exact], fixed_leg: int) -> list[Fraction]:
    """As :func:`slice_length`, for one length or several.

    Raises:
        InputError: naming the leg and the place of each length at fault.
    """
    return list(parse_all(one_or_more(lengths, f"l{fixed_leg}"), _positive).values())


@dataclass(frozen=True)
class LengthRange:
    """The lengths of the fixed leg from ``start`` to ``stop``, in the user's unit; 0 and None are open ends.

    >>> LengthRange.of(20, "61/2")
    LengthRange(start=Fraction(20, 1), stop=Fraction(61, 2))
    """

    start: Fraction = Fraction(0)
    stop: Fraction | None = None

    @classmethod
    def of(
        cls, start: Exact | None, stop: Exact | None, names: tuple[str, str] = ("start", "stop")
    ) -> LengthRange:
        """Reads the ends of a range; None is an open end.

        Raises:
            InputError: an end is negative or not an exact number, or the range is empty; ``names`` are the
                fields of the ends.
        """
        pairs = zip(names, (start, stop), strict=True)
        ends = parse_all({name: end for name, end in pairs if end is not None}, parse_exact)
        low, high = ends.get(names[0], Fraction(0)), ends.get(names[1])
        problems = []
        if low < 0:
            problems.append(FieldProblem(names[0], f"is {exact_str(low)}; a length is at least 0"))
        if high is not None and high <= low:
            problems.append(FieldProblem(names[1], f"is {exact_str(high)}; it must exceed {exact_str(low)}"))
        if problems:
            raise InputError(problems)
        return cls(low, high)

    def __contains__(self, length: Fraction) -> bool:
        return self.start <= length and (self.stop is None or length <= self.stop)

    def __str__(self) -> str:
        return f"from {exact_str(self.start)}{'' if self.stop is None else f' to {exact_str(self.stop)}'}"

    def to_json(self) -> dict[str, str | None]:
        """The contract's object; the range of all lengths is ``{"from": "0", "to": null}``."""
        return {"from": exact_str(self.start), "to": exact_or_none(self.stop)}


def intervals_json(
    ends: Sequence[str | None], counts: Sequence[int], aspects: Sequence[int | None] = ()
) -> list[dict[str, Any]]:
    """The contract's intervals: numbers of cusps, and of aspects, with the ends between which they hold."""
    known = [{"aspects": number} for number in aspects] or [{}] * len(counts)
    return [
        {"from": start, "to": stop, "count": count, **more}
        for start, stop, count, more in zip(ends, ends[1:], counts, known, strict=False)
    ]


def leg_of(key: Any, field: str) -> int:
    """The number of a leg given by its name, such as ``"l2"``, or by its number.

    Raises:
        InputError: naming ``field``.
    """
    return _LEGS[key] if isinstance(key, str) and key in _LEGS else check_leg(key, field)


def read_limits(
    limits: ExactLimits, field: str, fixed_leg: int | None = None, held: int | None = None
) -> dict[int, Bounds]:
    """The bounds by the legs' numbers.

    ``fixed_leg`` is a leg that may have none, ``held`` one whose bounds may be one length, which it keeps.

    Raises:
        InputError: naming every part of ``field`` at fault, such as ``limits.l2.max``.

    >>> read_limits({"l2": (5, None)}, "limits")
    {2: (Fraction(5, 1), None)}
    """
    if not isinstance(limits, Mapping):
        legs = "the legs, such as l2" if fixed_leg is None else "the free legs, such as l2 and l3"
        raise InputError.of(field, f"is {shown(limits)}; its keys are {legs}")

    def read(bounds: ExactBounds, key: Any) -> tuple[int, Bounds]:
        leg = leg_of(key, field)
        return leg, _bounds(bounds, f"{field}.l{leg}", is_fixed=leg == fixed_leg, may_hold=leg == held)

    given: Mapping[Any, ExactBounds] = limits
    return dict(parse_all(given, read).values())


def limits_json(limits: Mapping[int, Bounds]) -> dict[str, dict[str, str | None]]:
    """The contract's object, with numbers in canonical text."""
    return {
        f"l{leg}": {"min": exact_or_none(low), "max": exact_or_none(high)}
        for leg, (low, high) in sorted(limits.items())
    }


def _bounds(bounds: ExactBounds, field: str, *, is_fixed: bool, may_hold: bool) -> Bounds:
    if is_fixed:
        raise InputError.of(field, "is the fixed leg; its limits are the range")
    if isinstance(bounds, str | bytes) or not isinstance(bounds, Sequence) or len(bounds) != 2:
        raise InputError.of(field, f"is {shown(bounds)}; give (min, max)")
    names = f"{field}.min", f"{field}.max"
    given = {name: end for name, end in zip(names, bounds, strict=True) if end is not None}
    if may_hold and len(given) == len(names):
        low, high = parse_all(given, parse_exact).values()
        if low == high > 0:
            return low, high
    span = LengthRange.of(*bounds, names)
    return None if bounds[0] is None else span.start, span.stop


MotionQuestion: TypeAlias = Mapping[str, Exact | Mapping[str, Exact]]
"""``{"speed": 10, "acceleration": {"l2": 30, "l3": "20.5"}, "jerk": 100}``."""
Sampling: TypeAlias = Mapping[str, Exact]
"""``{"number": 101}``, ``{"step": "0.01"}`` or ``{"chord": "0.001"}``."""

_KINDS = ("speed", "acceleration", "jerk")
_NEEDED = _KINDS[:2]
ROWS = ("number", "step", "chord")
"""By what the samples of a path are chosen."""
OF_LIMITS = "motion"
"""The law of time that follows from limits."""


def sample_count(number: int, field: str = "samples") -> int:
    """Returns a number of samples.

    Raises:
        InputError: naming ``field``.
    """
    return check_integer(number, field, f"{LEAST_SAMPLES} to {MOST_SAMPLES}", LEAST_SAMPLES, MOST_SAMPLES)


def rows_of(sampling: Sampling) -> tuple[int | None, Fraction | None, Fraction | None]:
    """The number of samples, their step in time, or their chord.

    Raises:
        InputError: naming ``sampling`` or its part at fault.
    """
    if not isinstance(sampling, Mapping):
        raise InputError.of("sampling", f"is {shown(sampling)}; give one of {', '.join(ROWS)}")
    if unknown := [name for name in sampling if name not in ROWS]:
        raise InputError.of("sampling", f"has {shown(unknown[0])}; give one of {', '.join(ROWS)}")
    if len(sampling) != 1:
        first, *others = sampling or ("",)
        where = f"sampling.{others[0]}" if others else "sampling"
        what = f"is given beside {first}" if others else "has nothing"
        raise InputError.of(where, f"{what}; give one of {', '.join(ROWS)}")
    [(kind, value)] = sampling.items()
    if kind == "number":
        return sample_count(value, "sampling.number"), None, None  # type: ignore[arg-type]
    number = parse_positive(value, f"sampling.{kind}", f"a {kind} must be > 0")
    return (None, number, None) if kind == "step" else (None, None, number)


@dataclass(frozen=True)
class MotionLimits:
    """The greatest speed, acceleration and perhaps jerk of legs, by their numbers, in the user's units.

    >>> MotionLimits.of({"speed": 5, "acceleration": {"l2": "0.5"}}).to_json()["acceleration"]
    {'l2': '0.5'}
    """

    speed: Mapping[int, Fraction]
    acceleration: Mapping[int, Fraction]
    jerk: Mapping[int, Fraction] | None = None

    @classmethod
    def of(cls, motion: MotionQuestion) -> MotionLimits:
        """The limits; a number is that of all legs.

        Raises:
            InputError: naming ``motion`` or its part at fault.
        """
        expected = "give speed and acceleration, and perhaps jerk"
        if not isinstance(motion, Mapping) or not set(_NEEDED) <= set(motion) <= set(_KINDS):
            raise InputError.of("motion", f"is {shown(motion)}; {expected}")
        return cls(**{kind: _by_leg(limit, f"motion.{kind}") for kind, limit in motion.items()})

    def to_json(self) -> dict[str, dict[str, str]]:
        """The contract's object, with numbers in canonical text."""
        kinds = ((kind, getattr(self, kind)) for kind in _KINDS)
        return {
            kind: {f"l{leg}": exact_str(x) for leg, x in sorted(limits.items())}
            for kind, limits in kinds
            if limits is not None
        }

    def check(self, moving: Sequence[int]) -> None:
        """Checks that all legs that move have limits.

        Raises:
            InputError: naming the limit that is missing.
        """
        for kind in _KINDS:
            limits = getattr(self, kind)
            for leg in moving:
                if limits is not None and leg not in limits:
                    raise InputError.of(f"motion.{kind}.l{leg}", "is missing; this leg moves, too")


def _by_leg(limit: Exact | Mapping[str, Exact], field: str) -> dict[int, Fraction]:
    if not isinstance(limit, Mapping):
        return dict.fromkeys((1, 2, 3), parse_positive(limit, field, "a limit must be > 0"))
    if not limit:
        raise InputError.of(field, "has no limits; give them by leg, such as l2")
    return {
        leg_of(leg, field): parse_positive(x, f"{field}.{leg}", "a limit must be > 0")
        for leg, x in limit.items()
    }
