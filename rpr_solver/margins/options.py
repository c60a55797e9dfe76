"""Reading the changes of lengths that a margin is about."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from types import MappingProxyType
from typing import TypedDict

from rpr_solver.contract import LENGTHS, Progress
from rpr_solver.errors import InputError
from rpr_solver.exact.numerals import check_doubles
from rpr_solver.exact.rationals import Exact, parse_all, parse_not_negative, parse_positive
from rpr_solver.model.manipulator import Manipulator

PROVED, REFUTED, OPEN = "proved", "refuted", "open"
"""The verdicts on a tolerance."""
TOO_WIDE = "within the tolerance there are geometries that are flat, or no manipulators"

_MARGINS = "margins"

MayGoOn = Callable[[], bool]
"""Asked now and then; False ends a search."""


class SearchOptions(TypedDict, total=False):
    """How long to search, and whom to tell."""

    most_boxes: int
    may_go_on: MayGoOn
    progress: Progress


def changes(
    weights: Mapping[str, Exact] | None, tolerance: Exact | Mapping[str, Exact] | None
) -> tuple[Fraction, ...]:
    """What radii multiply, for each of LENGTHS.

    Args:
        weights: by names; those that are missing are 1.
        tolerance: of all lengths, times the weights, or by names, those that are missing being 0; or None.

    Raises:
        InputError: naming ``weights``, ``tolerance`` or a member of them.
    """
    by_name = _numbers(weights or {}, "weights", Fraction(1))
    if tolerance is None:
        return by_name
    if isinstance(tolerance, Mapping):
        if weights:
            raise InputError.of("weights", "are those of a tolerance of all lengths; here each has its own")
        return _numbers(tolerance, "tolerance", Fraction(0))
    common = parse_positive(tolerance, "tolerance", "a tolerance must be > 0")
    check_doubles({"tolerance": common}, _MARGINS)
    return tuple(common * w for w in by_name)


def check_margins(manipulator: Manipulator, lengths: Mapping[str, Fraction] = MappingProxyType({})) -> None:
    """Checks that margins of a geometry, in slices of some lengths by their names, can be computed.

    Raises:
        InputError: naming each length that doubles do not hold.
    """
    bounds = zip(LENGTHS, manipulator.bounds(), strict=True)
    own = {f"geometry.{name}": high if high > 0 else low for name, (low, high) in bounds}
    check_doubles({**own, **lengths}, _MARGINS)


def degenerate_throughout(kinds: Iterable[str]) -> str | None:
    """Why nothing can be proved where poses of these kinds are degenerate in all slices; None if none are."""
    names = sorted(set(kinds))
    return f"degenerate throughout: {', '.join(names)}" if names else None


def _numbers(given: Mapping[str, Exact], field: str, default: Fraction) -> tuple[Fraction, ...]:
    if not isinstance(given, Mapping) or (unknown := [name for name in given if name not in LENGTHS]):
        name = field if not isinstance(given, Mapping) else f"{field}.{unknown[0]}"
        raise InputError.of(name, f"unknown; give numbers for {', '.join(LENGTHS)}")
    values = parse_all({f"{field}.{name}": x for name, x in given.items()}, parse_not_negative)
    check_doubles(values, _MARGINS)
    numbers = tuple(values.get(f"{field}.{name}", default) for name in LENGTHS)
    if not any(numbers):
        raise InputError.of(field, "are all 0, so that nothing changes; give one > 0")
    return numbers
