"""Joint limits: the least and the greatest lengths of legs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any, TypeAlias

from rpr_solver.contract import check_leg
from rpr_solver.errors import InputError, shown
from rpr_solver.exact.rationals import Exact, exact_or_none, parse_all
from rpr_solver.slices.length_range import LengthRange

Bounds: TypeAlias = tuple[Fraction | None, Fraction | None]
"""A least and a greatest length; None is an open end."""
ExactBounds: TypeAlias = tuple[Exact | None, Exact | None]
ExactLimits: TypeAlias = Mapping[int, ExactBounds] | Mapping[str, ExactBounds]
"""The bounds by the legs' numbers or names: ``{"l2": (5, "20.5"), "l3": (None, 30)}``."""

_LEGS = {"l1": 1, "l2": 2, "l3": 3}


def read_limits(limits: ExactLimits, field: str, fixed_leg: int | None = None) -> dict[int, Bounds]:
    """The bounds by the legs' numbers; ``fixed_leg`` is a leg that may have none.

    Raises:
        InputError: naming every part of ``field`` at fault, such as ``limits.l2.max``.

    >>> read_limits({"l2": (5, None)}, "limits")
    {2: (Fraction(5, 1), None)}
    """
    if not isinstance(limits, Mapping):
        legs = "the legs, such as l2" if fixed_leg is None else "the free legs, such as l2 and l3"
        raise InputError.of(field, f"is {shown(limits)}; its keys are {legs}")

    def read(bounds: ExactBounds, key: Any) -> tuple[int, Bounds]:
        leg = _LEGS[key] if isinstance(key, str) and key in _LEGS else check_leg(key, field)
        return leg, _bounds(bounds, f"{field}.l{leg}", is_fixed=leg == fixed_leg)

    given: Mapping[Any, ExactBounds] = limits
    return dict(parse_all(given, read).values())


def limits_json(limits: Mapping[int, Bounds]) -> dict[str, dict[str, str | None]]:
    """The contract's object, with numbers in canonical text."""
    return {
        f"l{leg}": {"min": exact_or_none(low), "max": exact_or_none(high)}
        for leg, (low, high) in sorted(limits.items())
    }


def _bounds(bounds: ExactBounds, field: str, *, is_fixed: bool) -> Bounds:
    if is_fixed:
        raise InputError.of(field, "is the fixed leg; its limits are the range")
    if isinstance(bounds, str | bytes) or not isinstance(bounds, Sequence) or len(bounds) != 2:
        raise InputError.of(field, f"is {shown(bounds)}; give (min, max)")
    span = LengthRange.of(*bounds, (f"{field}.min", f"{field}.max"))
    return None if bounds[0] is None else span.start, span.stop
