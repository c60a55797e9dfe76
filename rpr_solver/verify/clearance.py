"""The clearance of a path: J has no zero within a distance of its arcs, by intervals on boxes and pieces.

A box of (α, θ) is done if J has its sign on all of it, or if it is farther than the clearance from the hulls
of all pieces; else the box is quartered, and the pieces near it that are wider than its parts are halved.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial

from rpr_solver.verify.arcs import Forms, Piece, directions, in_radians
from rpr_solver.verify.claims import Claim, ClaimStatus, Finding, OpenError, judged, worked
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.krawczyk import value
from rpr_solver.verify.core.reader import Record, spend

_WIDEST = 45
_FINEST = 2000
_RADIAN = 57
"""In degrees: what a change of the length by as much as itself counts, when pieces are halved."""
_OPEN = {
    "bound": "no path between these poses has a greater clearance",
    "legs": "no fold is met while the free legs change by less than this",
    "radius": "the least radius of curvature",
}


def clearance_claims(clearance: Record, pieces: Sequence[Piece], sign: int) -> Iterator[Claim]:
    """The claims of the clearance of a path with this sign of J."""
    claim = "no singular pose of the slice is nearer to the arcs"
    least = clearance["proved"]
    yield worked("/clearance/proved", claim, partial(_clear, pieces, sign, least))
    asked, bound = clearance["asked"], clearance["bound"]
    right = asked == "best" or asked <= least
    yield judged("/clearance/asked", "the path has the clearance that was asked for", right, "as it is")
    if bound is not None and bound < least:
        yield Claim("/clearance/bound", _OPEN["bound"], ClaimStatus.REFUSED, "this path has a greater one")
        return
    for name, claim in _OPEN.items():
        if clearance[name] is not None:
            reason = "this is not found anew"
            yield Claim(f"/clearance/{name}", claim, ClaimStatus.NOT_CHECKED, reason)


@dataclass(frozen=True)
class _Square:
    """A box: its middle and its half width in units of 2^−bits degrees."""

    alpha: int
    theta: int
    half: int

    @property
    def quarters(self) -> list[_Square]:
        half = (self.half + 1) // 2
        steps = (-half, half)
        return [_Square(self.alpha + x, self.theta + y, half) for x in steps for y in steps]

    def is_near(self, piece: Piece, reach: int) -> bool:
        """Whether it may be so near to a piece."""
        gaps = [
            max(0, x.lower - (middle + self.half), middle - self.half - x.upper)
            for x, middle in zip(piece.hull, (self.alpha, self.theta), strict=False)
        ]
        return gaps[0] ** 2 + gaps[1] ** 2 <= reach**2

    def is_within(self, piece: Piece, reach: int) -> bool:
        """Whether all of it is so near to the first point of a piece."""
        ways = [
            max(middle + self.half - x.lower, x.upper - middle + self.half)
            for x, middle in zip(piece.controls[0], (self.alpha, self.theta), strict=False)
        ]
        return ways[0] ** 2 + ways[1] ** 2 < reach**2


def _clear(pieces: Sequence[Piece], sign: int, least: Fraction) -> Finding:
    bits = pieces[0].hull[0].bits
    reach = Interval.of(least, bits).upper
    half = _WIDEST << (bits - 1)
    low, high = (
        [side(getattr(p.hull[n], end) for p in pieces) for n in (0, 1)]
        for side, end in ((min, "lower"), (max, "upper"))
    )
    counts = [(high[n] - low[n] + 2 * reach) // (2 * half) + 1 for n in (0, 1)]
    queue = deque(
        (_Square(low[0] - reach + (2 * i + 1) * half, low[1] - reach + (2 * k + 1) * half, half), pieces)
        for i in range(counts[0])
        for k in range(counts[1])
    )
    # the widest boxes first, so that a pose with the other sign is found before a box is too small
    while queue:
        square, around = queue.popleft()
        spend(4 * len(around), bits)
        near = [piece for piece in around if square.is_near(piece, reach)]
        if not near:
            continue
        lengths = {piece.hull[2] for piece in near}
        signs = {length: _sign(near[0].forms, square, length) for length in lengths}
        if {*signs.values()} == {sign}:
            continue
        if any(signs[piece.hull[2]] == -sign and square.is_within(piece, reach) for piece in near):
            return ClaimStatus.REFUSED, "J has another sign at a pose that is nearer"
        if square.half * _FINEST < reach:
            raise OpenError("boxes are so small that it is not decided")
        parts = [part for piece in near for part in _parts(piece, square.half)]
        queue += [(quarter, parts) for quarter in square.quarters]
    return ClaimStatus.PROVED, "by the sign of J on boxes round the arcs"


def _parts(piece: Piece, most: int) -> Sequence[Piece]:
    """The halves of a piece that is wider than this, in its angles or its length, or the piece."""
    alpha, theta, length = (x.upper - x.lower for x in piece.hull)
    share = (length * _RADIAN << piece.hull[2].bits) // piece.hull[2].upper
    return piece.halves if max(alpha, theta, share) > most else (piece,)


def _sign(forms: Forms, square: _Square, length: Interval) -> int:
    """The sign of J on a box; 0 if it is not decided."""
    bits, half, radicand = length.bits, square.half, forms.surface.ring.radicand
    middles = [Interval(x, x, bits) for x in (square.alpha, square.theta)]
    wide = [Interval(x - half, x + half, bits) for x in (square.alpha, square.theta)]
    reach = in_radians(Interval(-half, half, bits))
    here = directions((wide[0], wide[1], length), radicand)
    at_middle = directions((middles[0], middles[1], length), radicand)
    total = value(at_middle, forms.functions[0], length)
    for p in forms.slopes[0][:2]:
        total += value(here, p, length) * reach
    return total.sign
