"""Claims about numbers of cusps, by slices that are counted anew: of an interval, and beside a cut."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction

from rpr_solver.verify.claims import Claim, ClaimStatus
from rpr_solver.verify.counts import simplest_between

Count = Callable[[Fraction], tuple[int, bool] | None]
"""The number of cusps of the slice of a length, and whether it is proved; None if it is open."""
Side = tuple[tuple[Fraction, Fraction] | None, Fraction, object]
"""An interval that ends at a cut, a length beside the cut, and the number that is claimed there."""


@dataclass(frozen=True)
class Recount:
    """A way to count, and its words.

    Attributes:
        count: the way.
        manner: how it counts.
        is_open: why an interval, and a cut, stays open where it gives no number.
    """

    count: Count
    manner: str
    is_open: tuple[str, str]

    def throughout(
        self, at: str, claim: str, expected: object, lengths: Sequence[Fraction]
    ) -> tuple[Claim, bool | None]:
        """That an interval has so many cusps, by slices at some lengths in it, one at least.

        Also whether all roots of the eliminants there are simple; None if nothing is known.
        """
        doubt = False
        for length in lengths:
            found = self.count(length)
            if found is None:
                return Claim(at, claim, ClaimStatus.NOT_CHECKED, self.is_open[0]), False
            number, proved = found
            if number != expected:
                reason = f"the slice at {length} has {number}"
                return Claim(at, claim, ClaimStatus.REFUSED, reason), None
            doubt = doubt or not proved
        if doubt:
            reason = "Q has multiple roots in these slices, and the cusps above them were searched for"
            return Claim(at, claim, ClaimStatus.CHECKED, reason), False
        slices = "two slices have" if len(lengths) > 1 else "a slice has"
        reason = f"{slices} as many, {self.manner}; that it is constant rests on completeness"
        return Claim(at, claim, ClaimStatus.PROVED, reason), True

    def beside(self, at: str, sides: Iterable[Side]) -> Claim:
        """That the number changes at a cut, by a slice on either side, where its interval has room."""
        claim, doubt = "the number of cusps changes here", False
        for bounds, length, expected in sides:
            if bounds is None:
                return no_room(at)
            low, high = bounds
            found = self.count(length if low < length < high else simplest_between(low, high))
            if found is None:
                return Claim(at, claim, ClaimStatus.NOT_CHECKED, self.is_open[1])
            number, proved = found
            if number != expected:
                return Claim(at, claim, ClaimStatus.REFUSED, f"{number} cusps are counted beside it")
            doubt = doubt or not proved
        reason = "the counts beside it, at most one unit of the last digit away, are these"
        return Claim(at, claim, ClaimStatus.CHECKED if doubt else ClaimStatus.PROVED, reason)


def no_room(at: str) -> Claim:
    """That nothing can be counted beside a cut."""
    reason = "its digits leave no room between it and its neighbour"
    return Claim(at, "the number of cusps changes here", ClaimStatus.NOT_CHECKED, reason)
