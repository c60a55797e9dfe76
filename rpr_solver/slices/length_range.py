"""Ranges of lengths of the fixed leg."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from rpr_solver.errors import FieldProblem, InputError
from rpr_solver.exact.rationals import Exact, exact_or_none, exact_str, parse_all, parse_exact


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
