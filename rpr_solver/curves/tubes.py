"""Tubes that contain a single curve J = E = 0.

One of the coordinates x, y, z, in which the curve is not too steep, is its parameter r; p and q are the other
two. The inverse of the Jacobian matrix times (J, E) is G = (p, q) + N(p, q, r). A parabola (p̂(r), q̂(r))
approximates the curve to second order, and if for all |r| ≤ h

    |G(p̂(r), q̂(r), r)| + |N′| ρ < ρ,        N′ = ∂N/∂(p, q) over the tube of radii ρ round the parabola,

then for each r the tube contains exactly one zero of J = E = 0 (Krawczyk's test, mathematics.md#tubes).
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from flint import arb, arb_mat, ctx

from rpr_solver.boxes.krawczyk import Slopes, contracting_radii
from rpr_solver.boxes.newton import narrowed, newton_image
from rpr_solver.boxes.systems import Box
from rpr_solver.curves.neighbourhood import (
    ALONG_L,
    ORDER,
    Expansion,
    Frame,
    Neighbourhood,
    PoseBox,
    Two,
    at_parameter,
    value_of_each,
    values,
)
from rpr_solver.exact.real_roots import ball_of

_BOUND_BITS = 64
"""The precision of bounds over a tube, which need few digits."""
_SLIM = arb(2) ** -20
"""The radius of a tube round a curve that its parabola meets exactly, as a share of the reach."""
_MOST_HALVINGS = 8
"""By how many powers of 2 a reach falls at most from one trial to the next."""
_EITHER_SIGN = arb(0, 1)
"""The interval from −1 to 1."""


@dataclass(frozen=True)
class Tube:
    """For |r| ≤ reach, all points within ``radii`` of the parabola in p and in q."""

    frame: Frame
    axis: int
    forwards: bool
    nonlinear: tuple[Expansion, Expansion]
    slopes: Two
    bends: Two
    reach: arb
    radii: Two

    def meets(self, low: Fraction, high: Fraction) -> Fraction | None:
        """The length, of two, that the tube contains and leads to, with L as parameter; else None."""
        if self.axis != ALONG_L:
            return None
        length = high if self.forwards else low
        return length if abs(self.frame.of_length(ball_of(length))) <= self.reach else None

    def box_at(self, length: arb) -> PoseBox:
        """The box of the slice of one length, with L as parameter."""
        x, y = self._box(self.frame.of_length(length))
        return self.frame.outside(x, y)

    def end(self) -> tuple[PoseBox, arb]:
        """A small box round the curve near the end of the tube, and its lengths."""
        r = self._last()
        box = list(self._box(r))
        box.insert(self.axis, r)
        x, y, z = box
        return self.frame.outside(x, y), self.frame.length * (1 + z)

    def stays_between(self, start: arb, low: arb, high: arb) -> bool:
        """Whether z stays strictly between two values from a start to the tube's end."""
        slope, bend = self.slopes[1], self.bends[1]
        extremes = [start, self._last()]
        if not bend.is_zero():
            turn = -slope / (2 * bend)
            extremes += [] if abs(turn) > self.reach else [turn]
        heights = [r * (slope + r * bend) for r in extremes]
        radius = self.radii[1]
        return all(low < height - radius and height + radius < high for height in heights)

    def _last(self) -> arb:
        r: arb = (self.reach * 0.999).mid()
        return r if self.forwards else -r

    def _box(self, r: arb) -> Two:
        middle = _on_parabola(self.slopes, self.bends, r)
        p, q = (arb(m.mid(), m.rad() + radius) for m, radius in zip(middle, self.radii, strict=True))
        return _contracted(self.nonlinear, r, (p, q))


def build(
    around: Neighbourhood,
    axis: int,
    forwards: bool,
    reach: arb,
    *,
    between: Two | None = None,
    worth: tuple[int, arb] | None = None,
) -> Tube | None:
    """A tube with one coordinate as parameter, of the given reach or less.

    With ``between`` the curve in the tube stays strictly between two lengths; with ``worth`` it advances at
    least this far in another coordinate. None if no such tube can be built at this precision.
    """
    first, second = (_by_power(form, axis) for form in around.forms)
    nonlinear = _preconditioned(first, second)
    others = [i for i in range(3) if i != axis]
    p, q, r = (around.box[i] for i in (*others, axis))
    if nonlinear is None or not all(w.is_finite() for w in (p, q, r)):
        return None
    if max(p.rad(), q.rad()) > arb(2) ** -(around.bits // 2):
        p, q = _contracted(nonlinear, r, (p, q))
    slopes, bends = _parabola(nonlinear)
    middle = _on_parabola(slopes, bends, r)
    off = abs(p - middle[0]).abs_upper(), abs(q - middle[1]).abs_upper()
    planes = None if between is None else tuple(map(around.frame.of_length, between))
    with ctx.workprec(_BOUND_BITS):
        bounds = _Bounds.of(nonlinear, slopes, bends)
        least = max(abs(r).abs_upper(), arb(2) ** -(around.bits // 3))
        if worth is not None:
            least = max(least, _reach_for(worth[1], slopes[others.index(worth[0])], reach))
        reach = reach.mid()
        # A tube is what a trial proves, whatever was tried before. The reach at least halves each time; below
        # the least one there is no tube at this precision.
        while reach > least:
            radii, steepness = bounds.radii(reach, off)
            if radii is not None:
                tube = Tube(around.frame, axis, forwards, nonlinear, slopes, bends, reach, radii)
                if planes is None or tube.stays_between(r, *planes):
                    return tube
            reach /= _shortening(steepness)
    return None


def _reach_for(advance: arb, slope: arb, reach: arb) -> arb:
    """The least reach in which a coordinate with a slope advances this far; all of it if it is constant."""
    return reach if slope.is_zero() else (advance / slope).abs_lower()


def _shortening(steepness: arb) -> int:
    """By what to divide a reach with this bound of the derivatives, which fall with it or with its square."""
    if not steepness.is_finite():
        return 1 << _MOST_HALVINGS
    halvings = min(int(steepness.upper().floor().unique_fmpz() or 0).bit_length() // 2, _MOST_HALVINGS)
    return 1 << max(1, halvings)


def _by_power(form: Expansion, axis: int) -> Expansion:
    """An expansion by powers of z as one by powers of the chosen parameter."""
    if axis == ALONG_L:
        return form
    layers = [m.tolist() for m in form]
    size = range(ORDER + 1)
    if axis == 0:
        return [arb_mat([[layer[i][j] for layer in layers] for j in size]) for i in size]
    return [arb_mat([[layer[i][j] for layer in layers] for i in size]) for j in size]


def _preconditioned(j: Expansion, e: Expansion) -> tuple[Expansion, Expansion] | None:
    """N: an approximate inverse of the Jacobian matrix at the origin times (J, E), minus (p, q)."""
    (a, b), (c, d) = ((m[0][1, 0].mid(), m[0][0, 1].mid()) for m in (j, e))
    det = a * d - b * c
    if det.contains(0):
        return None

    def combined(p: arb, q: arb) -> Expansion:
        p, q = (p / det).mid(), (q / det).mid()
        return [m * p + n * q for m, n in zip(j, e, strict=True)]

    first, second = combined(d, -b), combined(-c, a)
    first[0][1, 0] -= 1
    second[0][0, 1] -= 1
    return first, second


def _parabola(nonlinear: tuple[Expansion, Expansion]) -> tuple[Two, Two]:
    """Slopes and bends of p̂ and q̂, so that G vanishes to second order."""
    first, second = nonlinear
    slopes = (-first[1][0, 0]).mid(), (-second[1][0, 0]).mid()
    return slopes, ((-_second_order(first, *slopes)).mid(), (-_second_order(second, *slopes)).mid())


def _second_order(n: Expansion, p: arb, q: arb) -> arb:
    """The terms of order 2 at (p r, q r, r), without r²."""
    n0, n1, n2, *_ = n
    across = n1[1, 0] * p + n1[0, 1] * q
    return n2[0, 0] + across + n0[2, 0] * p * p + n0[1, 1] * p * q + n0[0, 2] * q * q


def _on_parabola(slopes: Two, bends: Two, r: arb) -> Two:
    return r * (slopes[0] + r * bends[0]), r * (slopes[1] + r * bends[1])


@dataclass(frozen=True)
class _Bounds:
    """Coefficients with either sign, [−c, c], to bound all terms in a tube by sums."""

    sizes: tuple[Expansion, Expansion]
    slopes: Two
    bends: Two
    cancelled: tuple[Two, ...]
    """The bounds of the terms in r and in r² on the parabola, which in fact cancel,"""
    errors: tuple[Two, ...]
    """and what is left of them."""

    @classmethod
    def of(cls, nonlinear: tuple[Expansion, Expansion], slopes: Two, bends: Two) -> _Bounds:
        steep = _absolute(slopes)
        first, second = ([m * _EITHER_SIGN for m in n] for n in nonlinear)
        cancelled = tuple(
            (size[1][0, 0].abs_upper(), _second_order(size, *steep).abs_upper()) for size in (first, second)
        )
        errors = tuple(
            (abs(n[1][0, 0] + slope), abs(_second_order(n, *slopes) + bend))
            for n, slope, bend in zip(nonlinear, slopes, bends, strict=True)
        )
        return cls((first, second), steep, _absolute(bends), cancelled, errors)

    def radii(self, reach: arb, off: Two) -> tuple[Two | None, arb]:
        """Radii of p and q, greater than ``off``, that pass Krawczyk's test; None if no trial passes.

        Also a sum of the bounds of the derivatives.
        """
        p, q = _on_parabola(self.slopes, self.bends, reach)
        sizes = [at_parameter(size, reach) for size in self.sizes]
        least = self._residues(sizes, (p, q), reach, off)
        # a curve that the parabola meets exactly, as a fixed pose, needs a positive radius all the same
        first, second = (2 * x if x > 0 else reach * _SLIM for x in least)
        return contracting_radii(
            least, (first, second), lambda radii: _steepness(sizes, p + radii[0], q + radii[1])
        )

    def _residues(self, sizes: list[arb_mat], most: Two, reach: arb, off: Two) -> Two:
        """Bounds of G + off, with the largest p and q on the parabola."""
        least = []
        for whole, (once, twice), (error, second_error), offset in zip(
            value_of_each(sizes, *most), self.cancelled, self.errors, off, strict=True
        ):
            residue = (
                whole.abs_upper() - reach * (once + reach * twice) + reach * (error + reach * second_error)
            )
            least.append((residue + offset).abs_upper())
        return least[0], least[1]


def _steepness(sizes: list[arb_mat], p: arb, q: arb) -> Slopes:
    """Bounds of the derivatives of N in p and q."""
    first, second = values(sizes, p, q)
    a, b, c, d = (x.abs_upper() for x in (first[1, 0], first[0, 1], second[1, 0], second[0, 1]))
    return (a, b), (c, d)


def _absolute(pair: Two) -> Two:
    return pair[0].abs_upper(), pair[1].abs_upper()


def _contracted(nonlinear: tuple[Expansion, Expansion], r: arb, box: Two) -> Two:
    """The part of a box that can contain zeros of G = (p, q) + N, by interval Newton steps."""
    forms = [at_parameter(n, r) for n in nonlinear]

    def step(point: Box, box: Box) -> Box | None:
        gaps = [x + table[0, 0] for x, table in zip(point, values(forms, *point), strict=True)]
        (a, b), (c, d) = ((table[1, 0], table[0, 1]) for table in values(forms, *box))
        return newton_image(point, gaps, [[1 + a, b], [c, 1 + d]])

    # more digits than a box has to have in build, so that the next tube begins with this one
    p, q = narrowed(step, list(box), ctx.prec * 2 // 3)
    return p, q
