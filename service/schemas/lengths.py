"""Which slices are asked for: one value, a list, or a range, all exact and bounded before they are made."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

from rpr_solver import exact_str, parse_exact
from rpr_solver.errors import InputError
from service.schemas.limits import LimitError


@dataclass(frozen=True)
class Range:
    """The values start, start + step, … up to stop, which is included when it is hit.

    Raises:
        InputError: the step is not positive, or the range is empty.
    """

    start: Fraction
    stop: Fraction
    step: Fraction
    field: str = "l1"

    def __post_init__(self) -> None:
        if self.step <= 0:
            raise InputError.of(f"{self.field}.step", f"is {exact_str(self.step)}; a step must be > 0")
        if self.stop < self.start:
            raise InputError.of(
                f"{self.field}.stop",
                f"is {exact_str(self.stop)}, less than start = {exact_str(self.start)}; the range is empty",
            )

    def __len__(self) -> int:
        return int((self.stop - self.start) // self.step) + 1

    def values(self, limit: int) -> list[Fraction]:
        """All values of the range.

        Raises:
            LimitError: there are more than `limit`.
        """
        # not len(): a huge range overflows it
        check_count(int((self.stop - self.start) // self.step) + 1, limit, self.field)
        return [self.start + i * self.step for i in range(len(self))]


def check_count(count: int, limit: int, field: str) -> None:
    """Refuse more slices than the limit.

    Raises:
        LimitError: naming the limit.
    """
    if count > limit:
        shown = str(count) if count < 10**20 else "more than 10^20"
        raise LimitError(field, "max_slices", limit, f"asks for {shown} slices")


def parse_range(text: str, field: str, max_digits: int) -> Range:
    """Read `START:STOP:STEP`.

    >>> [str(x) for x in parse_range("14:15:0.5", "l1", 400).values(10)]
    ['14', '29/2', '15']
    """
    parts = text.split(":")
    if len(parts) != 3:
        raise InputError.of(field, f"{text[:60]!r} is not START:STOP:STEP, for example 0.1:50.1:0.1")
    names = ("start", "stop", "step")
    start, stop, step = (
        parse_exact(part, f"{field}.{name}", max_digits=max_digits)
        for name, part in zip(names, parts, strict=True)
    )
    return Range(start, stop, step, field)


def distinct(values: Iterable[Fraction]) -> list[Fraction]:
    """Each value once, in the order of its first occurrence."""
    return list(dict.fromkeys(values))
