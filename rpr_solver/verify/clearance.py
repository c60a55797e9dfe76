"""The clearance of a path: J has no zero within a distance of its arcs, by intervals on boxes and pieces.

A box of (α, θ) is done if J has its sign on all of it, or if it is farther than the clearance from the hulls
of all pieces; else the box is quartered, and the pieces near it that are wider than its parts are halved.
How far a fold is away in leg lengths follows from the least singular value of their derivative on boxes
round each piece, ring by ring (mathematics.md#paths-without-a-singularity).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from itertools import pairwise, product
from math import comb, isqrt

from rpr_solver.verify.arcs import Forms, Piece, directions, in_radians
from rpr_solver.verify.claims import Claim, ClaimStatus, Finding, OpenError, judged, worked
from rpr_solver.verify.core.intervals import Interval, pi
from rpr_solver.verify.core.krawczyk import value
from rpr_solver.verify.core.reader import Record, spend, spend_exact
from rpr_solver.verify.core.system import Graded

_WIDEST = 45
_FARTHEST = 255
"""In degrees: more than half a turn both ways. J has both signs in each slice, as it has no constant term."""
_FINEST = 2000
_RADIAN = 57
"""In degrees: what a change of the length by as much as itself counts, when pieces are halved."""
_BITS = 96
_RINGS, _FINEST_RING = 12, 128
Control = str | tuple[Fraction, Fraction, Fraction]


def clearance_claims(clearance: Record, pieces: Sequence[Piece], sign: int) -> Iterator[Claim]:
    """The claims of how wide a path with this sign of J is."""
    claim = "no singular pose of the slice is nearer to the arcs"
    least = clearance["proved"]
    yield worked("/clearance/proved", claim, partial(_clear, pieces, sign, least))
    if (asked := clearance["asked"]) != "best":
        claim = "the path has the clearance that was asked for"
        yield judged("/clearance/asked", claim, asked <= least, "as it is")


def shape_claims(
    clearance: Record, pieces: Sequence[Piece], arcs: Sequence[Sequence[Control]], content: Callable[[], int]
) -> Iterator[Claim]:
    """The claims of how much a path is bent, and how far folds are away in leg lengths.

    ``arcs`` are the control points in the document; ``content`` is what divides the determinant of the slopes
    of the squared free legs, besides L, so that J / L is left.
    """
    if (radius := clearance["radius"]) is not None:
        claim = "the radius of curvature is nowhere less"
        yield worked("/clearance/radius", claim, partial(_is_round, pieces, arcs, radius))
    claim = "no fold is met while the free legs change by less than this"

    def carry() -> Finding:
        radius = min(clearance["proved"], Fraction(_FARTHEST))
        return _Rings(pieces, content(), radius).carry(clearance["legs"])

    yield worked("/clearance/legs", claim, carry)


@dataclass(frozen=True)
class Square:
    """A box: its middle and its half width in units of 2^−bits degrees."""

    alpha: int
    theta: int
    half: int

    @property
    def quarters(self) -> list[Square]:
        half = (self.half + 1) // 2
        steps = (-half, half)
        return [Square(self.alpha + x, self.theta + y, half) for x in steps for y in steps]

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
    if least >= _FARTHEST:
        return ClaimStatus.REFUSED, "no pose is so far from all poses where J has another sign"
    bits = pieces[0].hull[0].bits
    reach = Interval.of(least, bits).upper
    half = _WIDEST << (bits - 1)
    low, high = (
        [side(getattr(p.hull[n], end) for p in pieces) for n in (0, 1)]
        for side, end in ((min, "lower"), (max, "upper"))
    )
    counts = [(high[n] - low[n] + 2 * reach) // (2 * half) + 1 for n in (0, 1)]
    queue = deque(
        (Square(low[0] - reach + (2 * i + 1) * half, low[1] - reach + (2 * k + 1) * half, half), pieces)
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
        signs = {length: singular_on(near[0].forms, square, length).sign for length in lengths}
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


def singular_on(forms: Forms, square: Square, length: Interval) -> Interval:
    """J / L on a box."""
    bits, half, radicand = length.bits, square.half, forms.surface.ring.radicand
    middles = [Interval(x, x, bits) for x in (square.alpha, square.theta)]
    wide = [Interval(x - half, x + half, bits) for x in (square.alpha, square.theta)]
    reach = in_radians(Interval(-half, half, bits))
    here = directions((wide[0], wide[1], length), radicand)
    at_middle = directions((middles[0], middles[1], length), radicand)
    total = value(at_middle, forms.functions[0], length)
    for p in forms.slopes[0][:2]:
        total += value(here, p, length) * reach
    return total


def waves_of(p: Graded, radicand: int, length: Interval) -> dict[tuple[int, int], list[Interval]]:
    """A polynomial of a slice as Σ c(p, q) e^(i (p α + q θ)): the real and the imaginary part of each c."""
    bits, omega = length.bits, Interval.of(radicand, length.bits).root()
    parts: dict[tuple[int, int], list[Interval]] = {}
    power = Interval.of(1, bits)
    for row in p:
        for (i, j, k, m), (a, b) in row.items():
            spend(40, bits)
            size = (Interval.of(a, bits) + omega.scaled(b)) * power
            for n, x in _waves(i, j).items():
                for o, y in _waves(k, m).items():
                    re, im = x[0] * y[0] - x[1] * y[1], x[0] * y[1] + x[1] * y[0]
                    old = parts.setdefault((n, o), [Interval.of(0, bits)] * 2)
                    parts[n, o] = [
                        old[0] + size * Interval.of(re, bits),
                        old[1] + size * Interval.of(im, bits),
                    ]
        power *= length
    return parts


def steepest(forms: Forms, length: Interval) -> Interval:
    """A bound of the second derivatives of J / L in all directions of unit length, at any angles.

    They are at most Σ |c(p, q)| (p² + q²) by the waves of J.
    """
    total, waves = (
        Interval.of(0, length.bits),
        waves_of(forms.functions[0], forms.surface.ring.radicand, length),
    )
    for (p, q), (real, imaginary) in waves.items():
        spend(10, length.bits)
        total += (squared(real) + squared(imaginary)).root().scaled(p * p + q * q)
    return total


def squared(x: Interval) -> Interval:
    """The numbers from 0 to the greatest square."""
    top = max(abs(x.lower), abs(x.upper))
    return Interval(0, -(-top * top >> x.bits) + 1, x.bits)


def _waves(cos: int, sin: int) -> dict[int, tuple[Fraction, Fraction]]:
    """cosⁿ or cosⁿ sin as Σ c(p) e^(i p x): the real and the imaginary part of c(p)."""
    half = Fraction(1, 2)
    found = {0: (Fraction(1), Fraction(0))}
    factors = [{1: (half, Fraction(0)), -1: (half, Fraction(0))}] * cos
    factors += [{1: (Fraction(0), -half), -1: (Fraction(0), half)}] * sin
    for factor in factors:
        grown: dict[int, tuple[Fraction, Fraction]] = {}
        for p, (a, b) in found.items():
            for q, (c, d) in factor.items():
                x, y = grown.get(p + q, (Fraction(0), Fraction(0)))
                grown[p + q] = x + a * c - b * d, y + a * d + b * c
        found = grown
    return found


@dataclass(frozen=True)
class _Rings:
    """Boxes round the pieces of a path, with the least singular values of the legs' derivatives on them.

    Attributes:
        content: see :func:`clearance_claims`.
        radius: of a tube, in degrees.
    """

    pieces: Sequence[Piece]
    content: int
    radius: Fraction
    known: dict[tuple[int, tuple[int, ...], Interval], int] = field(default_factory=dict, repr=False)

    def carry(self, most: Fraction) -> Finding:
        """Whether legs that change by less than this, in the user's unit, carry each pose of the path.

        Raises:
            OpenError: it is not decided.
        """
        forms = self.pieces[0].forms
        degree = pi(_BITS).over(Interval.of(180, _BITS))
        needed = (Interval.of(most * forms.surface.unit, _BITS).over(degree)).upper
        stack = [(piece, 4) for piece in self.pieces]
        while stack:
            piece, parts = stack.pop()
            own = Interval.of(self.radius / parts, _BITS).upper
            if max(x.upper - x.lower for x in piece.hull[:2]) >> (piece.hull[0].bits - _BITS) > own:
                stack += [(half, parts) for half in piece.halves]
            elif not self._carries(piece, parts, needed):
                if parts >= _FINEST_RING:
                    raise OpenError("how far a fold is away in leg lengths is not decided")
                stack.append((piece, 2 * parts))
        return ClaimStatus.PROVED, "by the least singular values on boxes round the arcs"

    def _carries(self, piece: Piece, parts: int, needed: int) -> bool:
        """Whether the integral of the least rate over the distance from a piece, in degrees, is so much.

        The rate falls from ring to ring, so that a few rings may tell.
        """
        reach = Interval.of(self.radius, _BITS).lower
        size = Interval.of(2 * self.radius / parts, _BITS).upper
        hull = [x.at(_BITS) for x in piece.hull[:2]]
        length = piece.hull[2].at(_BITS)
        step = reach // _RINGS
        rings: list[list[tuple[int, ...]]] = [[] for _ in range(_RINGS)]
        for box in product(*(range((x.lower - reach) // size, (x.upper + reach) // size + 1) for x in hull)):
            away = _hypot(*(_gap(n * size, size, x) for n, x in zip(box, hull, strict=True)))
            if (number := away // (step + 1)) < _RINGS:
                rings[number].append(box)
        spend(4 * sum(map(len, rings)))
        total, rates = 0, list[int]()
        for left, ring in zip(reversed(range(_RINGS)), rings, strict=True):
            rates = [min([*rates, *(self._rate(size, box, length) for box in ring)])]
            total += rates[0] * step
            if total >> _BITS >= needed:
                return True
            if (total + rates[0] * step * left) >> _BITS < needed:
                return False
        return False

    def _rate(self, size: int, box: tuple[int, ...], length: Interval) -> int:
        """A lower bound of the least singular value on a box, in scaled lengths for a radian."""
        key = size, box, length
        if key not in self.known:
            half = size // 2 + 1
            square = Square(box[0] * size + size // 2, box[1] * size + size // 2, half)
            self.known[key] = _least_rate(self.pieces[0].forms, square, length)
        return self.known[key] * self.content


def _gap(low: int, size: int, x: Interval) -> int:
    """The distance of an interval of this size from another one."""
    return max(0, x.lower - (low + size), low - x.upper)


def _hypot(x: int, y: int) -> int:
    """The length of a vector, rounded down."""
    return isqrt(x * x + y * y)


def _least_rate(forms: Forms, square: Square, length: Interval) -> int:
    """A bound of L |J / L| / (2 √((f_α² + f_θ²) g + (g_α² + g_θ²) f)) on a box; 0 if J may vanish.

    This is the determinant of the derivatives of the lengths, but for the content, over the root of the sum
    of their squares, which is at least the greatest singular value.
    """
    bits = length.bits
    j = singular_on(forms, square, length)
    if not j.sign:
        return 0
    wide = [Interval(x - square.half, x + square.half, bits) for x in (square.alpha, square.theta)]
    here = directions((wide[0], wide[1], length), forms.surface.ring.radicand)
    values = [value(here, p, length) for p in forms.functions[1:]]
    slopes = [[value(here, p, length) for p in row[:2]] for row in forms.slopes[1:]]
    spend(20, bits)
    sizes = [squared(row[0]) + squared(row[1]) for row in slopes]
    below = (sizes[0] * values[1] + sizes[1] * values[0]).root()
    above = Interval(max(j.lower, -j.upper), max(j.lower, -j.upper), bits) * length
    return (above.lower << bits) // (2 * below.upper)


def _is_round(pieces: Sequence[Piece], arcs: Sequence[Sequence[Control]], least: Fraction) -> Finding:
    """Whether arcs meet without corners, and are nowhere bent more than circles of a radius in degrees."""
    for arc, following in pairwise(arcs):
        points = arc[-2], arc[-1], following[1]
        if any(isinstance(p, str) for p in points):
            raise OpenError("a corner at a pose of the path is not excluded")
        (a, b), (c, d) = (
            tuple(y - x for x, y in zip(p[:2], q[:2], strict=True))  # type: ignore[operator]
            for p, q in pairwise(points)
        )
        spend_exact(8, a, b, c, d)
        if a * d != b * c or a * c + b * d <= 0:
            return ClaimStatus.REFUSED, "it has a corner"
    queue = deque(pieces)
    while queue:
        piece = queue.popleft()
        spend(8 * len(piece.controls) ** 2, piece.hull[0].bits)
        first = [
            [y - x for x, y in pairwise(column)] for column in list(zip(*piece.controls, strict=True))[:2]
        ]
        degree = len(first[0])
        second = [[(y - x).scaled(degree - 1) for x, y in pairwise(row)] for row in first]
        if degree == 1:
            continue
        # the derivatives are degree times these, so the radius is |first|³ degree / |first × second|
        speed = [x + y for x, y in zip(*(_product(row, row) for row in first), strict=True)]
        cross = [
            x - y for x, y in zip(_product(first[0], second[1]), _product(first[1], second[0]), strict=True)
        ]
        bent, slow = max(x.greatest for x in cross), Fraction(min(x.lower for x in speed), 1 << speed[0].bits)
        if slow > 0 and (bent * least) ** 2 <= slow**3 * degree**2:
            continue
        straightest = min(Fraction(max(x.lower, -x.upper, 0), 1 << x.bits) for x in cross)
        fast = max(x.greatest for x in speed)
        if (
            min(cross, key=lambda x: x.lower).sign == max(cross, key=lambda x: x.upper).sign != 0
            and (straightest * least) ** 2 > fast**3 * degree**2
        ):
            return ClaimStatus.REFUSED, "it is bent more somewhere"
        queue += piece.halves
    return ClaimStatus.PROVED, "by control points of pieces"


def _product(p: Sequence[Interval], q: Sequence[Interval]) -> list[Interval]:
    """The control points of the product of two polynomials with these control points."""
    m, n = len(p) - 1, len(q) - 1
    found = []
    for k in range(m + n + 1):
        terms = [
            (p[i] * q[k - i]).scaled(comb(m, i) * comb(n, k - i)) for i in range(max(0, k - n), min(m, k) + 1)
        ]
        low, high = (sum(getattr(x, end) for x in terms) for end in ("lower", "upper"))
        whole = comb(m + n, k)
        found.append(Interval(low // whole, -(-high // whole), p[0].bits))
    return found
