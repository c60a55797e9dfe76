"""The full certificate of a margin: that all geometries within a radius have the number of cusps of one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from rpr_solver.verify.claims import ClaimStatus, Finding
from rpr_solver.verify.core.numbers import LENGTHS, Geometry
from rpr_solver.verify.core.reader import Record
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.cusps import Limits, Slice
from rpr_solver.verify.degeneracy import Bound
from rpr_solver.verify.exclusion import Region, Span, flaw

FULL = "/certificate/full"


@dataclass(frozen=True)
class Scope:
    """What is asked for: one slice, or the range of a requirement with its limits.

    Attributes:
        subject: the member of ``asked``.
        fixed: the fixed leg.
        start, stop: the range; both are the length of a slice, or of one in a window.
        limits: of the other legs.
        least, most: numbers of cusps that are admitted; None if any is.
    """

    subject: str
    fixed: int
    start: Fraction
    stop: Fraction | None
    limits: Limits
    least: int | None = None
    most: int | None = None

    def admits(self, number: int) -> bool:
        """Whether a number of cusps is admitted."""
        return (self.least is None or number >= self.least) and (self.most is None or number <= self.most)

    @property
    def is_bounded(self) -> bool:
        """Whether there is a least or a greatest number."""
        return self.least is not None or self.most is not None

    def counted(self, geometry: Geometry, length: Fraction) -> tuple[int, bool] | None:
        """The number of cusps of a slice within the limits, and whether it is proved; None if it is open."""
        return self.limits.counted(Slice(Surface(geometry, self.fixed).at(length)))


@dataclass(frozen=True)
class Proof:
    """The proof of a full certificate.

    Attributes:
        geometry: the given one.
        weights: what the radius multiplies, for each of LENGTHS.
        radius: of the geometries.
        scope: what is asked for.
        count: the number of cusps, if it is one.
        full: the member of the certificate.
    """

    geometry: Geometry
    weights: tuple[Fraction, ...]
    radius: Fraction
    scope: Scope
    count: int | None
    full: Record

    @cached_property
    def _spans(self) -> tuple[Span, ...]:
        lengths = (getattr(self.geometry, g) for g in LENGTHS)
        pairs = zip(lengths, self.weights, strict=True)
        return tuple((x - self.radius * w, x + self.radius * w) for x, w in pairs)

    @cached_property
    def _most(self) -> list[Fraction]:
        return [max(map(abs, span)) for span in self._spans]

    def finding(self, number: int | None = None) -> Finding:
        """Whether all geometries within the radius have the property, or as many cusps as given."""
        length, flaws = self._sample, self._flaw
        if flaws is not None:
            return ClaimStatus.REFUSED, flaws
        found = self._found
        wanted = self.count if number is None else number
        if wanted is None and found is not None:
            wanted = found[0]
        status, reason = compared(wanted or 0, found)
        if status is ClaimStatus.PROVED and not self.scope.admits(wanted or 0):
            return ClaimStatus.REFUSED, f"the slice at {length} has {wanted}, which is not admitted"
        if status is not ClaimStatus.PROVED:
            return status, f"in the slice at {length}: {reason}"
        parts = sum(cuts.count(".") for cuts in self.full["cuts"])
        reason = f"no cusp degenerates, in {parts} parts; the slice at {length} has {wanted}"
        return ClaimStatus.PROVED, reason

    @cached_property
    def _found(self) -> tuple[int, bool] | None:
        return self.scope.counted(self.geometry, self._sample)

    @cached_property
    def _sample(self) -> Fraction:
        """A length of the fixed leg for the given geometry, within the regions of the proof."""
        if self.scope.subject == "window":
            length: Fraction = self.full.get("length", Fraction(1))
            return length
        start, stop = self.scope.start, self.scope.stop
        return (start + (2 * start + 1 if stop is None else stop)) / 2

    @cached_property
    def _flaw(self) -> str | None:
        """Why the certificate is no proof; None if it is one."""
        named = {"window": {"length", "rates"}, "requirement": {"turn"}}.get(self.scope.subject, set())
        named = set() if named == {"turn"} and self.scope.stop is not None else named
        if set(self.full) != {"cuts", *named}:
            return f"it should have the members cuts, {', '.join(sorted(named))}"
        regions = list(self._regions())
        if len(regions) != len(self.full["cuts"]):
            return f"{len(regions)} regions are to be cut"
        for n, (region, cuts) in enumerate(zip(regions, self.full["cuts"], strict=True)):
            reason = region if isinstance(region, str) else flaw(region, cuts)
            if reason is not None:
                return f"{FULL}/cuts/{n}: {reason}"
        return None

    def _regions(self) -> Iterator[Region | str]:
        """What is to be proved, with the reason where it cannot be."""
        if self.scope.subject == "window":
            length, rates = self.full["length"], tuple(self.full["rates"][g] for g in LENGTHS)
            change = sum(abs(rate) * (b - a) / 2 for rate, (a, b) in zip(rates, self._spans, strict=True))
            yield self._region((length, length), rates) if change < length else "a length is not > 0"
            return
        start, stop = self.scope.start, self.scope.stop
        if stop is not None:
            yield self._region((start, stop))
            return
        turn: Fraction = self.full["turn"]
        bounds = [bound for both in self.scope.limits.of_legs.values() for bound in both]
        if turn <= sum(self._most) + max([bound for bound in bounds if bound is not None], default=0):
            yield "turn is not far beyond all lengths"
            return
        if start < turn:
            yield self._region((start, turn))
        # beyond, all legs are longer than any limit
        if not any(most is not None for _, most in self.scope.limits.of_legs.values()):
            yield self._region((Fraction(0), 1 / max(turn, start)), inverse=True)

    def _region(
        self,
        fixed: Span,
        rates: tuple[Fraction, ...] = (Fraction(0),) * len(LENGTHS),
        *,
        inverse: bool = False,
    ) -> Region:
        geometry, unit = self.geometry, Fraction(1)
        longest = max(*self._most, 0 if inverse else fixed[1], 1 / fixed[1] if inverse else 0)
        while unit < longest:
            unit *= 2
        while unit > 2 * longest:
            unit /= 2
        first, second = geometry.free_legs(self.scope.fixed)
        limits = (
            ()
            if inverse
            else tuple(
                Bound((first, second).index(leg), side, bound / unit)
                for leg, both in self.scope.limits.of_legs.items()
                for side, bound in zip((-1, 1), both, strict=True)
                if bound is not None
            )
        )
        flat = geometry.height_squared == 0
        return Region(
            self.scope.fixed,
            0 if flat else -1 if geometry.clockwise else 1,
            tuple((low / unit, high / unit) for low, high in self._spans),
            (fixed[0] * unit, fixed[1] * unit) if inverse else (fixed[0] / unit, fixed[1] / unit),
            inverse,
            rates,
            limits,
        )


def compared(number: int, found: tuple[int, bool] | None) -> Finding:
    """A number of cusps against what was counted."""
    if found is None:
        return ClaimStatus.NOT_CHECKED, "its cusps are not counted"
    if found[0] != number:
        return ClaimStatus.REFUSED, f"it has {found[0]}"
    if not found[1]:
        return ClaimStatus.CHECKED, "as many are found; that there are no others is not proved"
    return ClaimStatus.PROVED, "all its cusps are found anew"
