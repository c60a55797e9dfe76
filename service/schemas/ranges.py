"""Ranges of a leg's length with open ends, as they are posted and as they are written on the command line."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

from rpr_solver import exact_str
from rpr_solver.errors import InputError
from rpr_solver.transitions.length_range import check_range
from service.schemas.limits import Limits
from service.schemas.numbers import MISSING, Collector, check_keys, kind_of, number

_ENDS = ("from", "to")


@dataclass(frozen=True)
class LengthRange:
    """The lengths between two ends; without an upper end all from the lower one on.

    Raises:
        InputError: there is no length between the ends.
    """

    start: Fraction = Fraction(0)
    stop: Fraction | None = None
    field: str = "range"

    def __post_init__(self) -> None:
        check_range(self.start, self.stop, self.field)

    def check_inside(self, lengths: Iterable[Fraction], field: str) -> None:
        """Refuse lengths that are no leg lengths, or outside.

        Raises:
            InputError: naming the first one at fault.
        """
        for x in lengths:
            if x <= 0:
                raise InputError.of(field, f"is {exact_str(x)}; a leg length must be > 0")
            if x < self.start or (self.stop is not None and x > self.stop):
                end = "" if self.stop is None else f" to {exact_str(self.stop)}"
                raise InputError.of(
                    field, f"is {exact_str(x)}, outside the range from {exact_str(self.start)}{end}"
                )


def read_range(value: object, limits: Limits) -> LengthRange:
    """Read `{"from": …, "to": …}`; an end that is missing or null is open, and so is a missing range."""
    if value is MISSING or value is None:
        return LengthRange()
    if not isinstance(value, dict):
        raise InputError.of("range", f'is {kind_of(value)}; give an object with "from" and "to"')
    collect = Collector()
    collect(lambda: check_keys(value, _ENDS, "range."))
    ends: list[Fraction | None] = []
    for name in _ENDS:
        end = value.get(name)
        ends.append(None if end is None else collect(lambda e=end, n=name: number(e, f"range.{n}", limits)))  # type: ignore[misc]
    collect.finish()
    start, stop = ends
    return LengthRange(start or Fraction(0), stop)


def parse_open_range(text: str, option: str, limits: Limits) -> tuple[Fraction | None, Fraction | None]:
    """Read `A:B`, either of which may be missing.

    >>> [str(x) for x in parse_open_range("10:61/2", "--l1-range", Limits())]
    ['10', '61/2']
    >>> parse_open_range(":", "--l1-range", Limits())
    (None, None)
    """
    parts = text.split(":")
    if len(parts) != 2:
        raise InputError.of(option, f"{text[:60]!r} is not A:B, for example 10:20, 10: or :20")
    first, second = (number(part, option, limits) if part.strip() else None for part in parts)
    return first, second


def parse_length_range(text: str, option: str, limits: Limits) -> LengthRange:
    """Read `A:B` as a range of lengths."""
    start, stop = parse_open_range(text, option, limits)
    return LengthRange(start or Fraction(0), stop, option)
