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

from rpr_solver.curves.neighbourhood import (
    ALONG_L,
    ORDER,
    Expansion,
    Frame,
    Neighbourhood,
    Place,
    Two,
    at_parameter,
    value,
    values,
)
from rpr_solver.exact.real_roots import ball_of

_BOUND_BITS = 64
_NEWTON_STEPS = 4
_TRIALS = 3


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

    def place_at(self, length: arb) -> Place:
        """The box of the slice of one length, with L as parameter."""
        x, y = self._box(self.frame.of_length(length))
        return self.frame.outside(x, y)

    def end(self) -> tuple[Place, arb]:
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

    def advance(self, axis: int) -> arb:
        """The approximate extent of the tube in another coordinate."""
        return abs(self.slopes[axis] * self.reach).mid()

    def _last(self) -> arb:
        r: arb = (self.reach * 0.999).mid()
        return r if self.forwards else -r

    def _box(self, r: arb) -> Two:
        middle = _on_parabola(self.slopes, self.bends, r)
        p, q = (arb(m.mid(), m.rad() + radius) for m, radius in zip(middle, self.radii, strict=True))
        return _contracted(self.nonlinear, r, (p, q))


def build(around: Neighbourhood, axis: int, forwards: bool, reach: arb, between: Two | None) -> Tube | None:
    """A tube with one coordinate as parameter, of the given reach or less.

    With ``between`` the curve in the tube stays strictly between two lengths. None if no tube can be built at
    this precision.
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
    planes = None if between is None else [around.frame.of_length(length) for length in between]
    with ctx.workprec(_BOUND_BITS):
        bounds = _Bounds.of(nonlinear, slopes, bends)
        least = max(abs(r).abs_upper(), arb(2) ** -(around.bits // 3))
        reach = reach.mid()
        while reach > least:
            radii = bounds.radii(reach, off)
            if radii is not None:
                tube = Tube(around.frame, axis, forwards, nonlinear, slopes, bends, reach, radii)
                if planes is None or tube.stays_between(r, *planes):
                    return tube
            reach /= 2
    return None


def _by_power(form: Expansion, axis: int) -> Expansion:
    """An expansion by powers of z as one by powers of the chosen parameter."""
    if axis == ALONG_L:
        return form
    size, powers = range(ORDER + 1), range(len(form))
    if axis == 0:
        return [arb_mat([[form[k][i, j] for k in powers] for j in size]) for i in size]
    return [arb_mat([[form[k][i, j] for k in powers] for i in size]) for j in size]


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
    """Absolute values of the coefficients, to bound all terms in a tube by sums."""

    sizes: tuple[Expansion, Expansion]
    slopes: Two
    bends: Two
    errors: tuple[Two, ...]
    """The residues of the terms in r and r² on the parabola."""

    @classmethod
    def of(cls, nonlinear: tuple[Expansion, Expansion], slopes: Two, bends: Two) -> _Bounds:
        first, second = ([_sizes(m) for m in n] for n in nonlinear)
        errors = tuple(
            (abs(n[1][0, 0] + slope), abs(_second_order(n, *slopes) + bend))
            for n, slope, bend in zip(nonlinear, slopes, bends, strict=True)
        )
        return cls((first, second), _absolute(slopes), _absolute(bends), errors)

    def radii(self, reach: arb, off: Two) -> Two | None:
        """Radii of p and q, greater than ``off``, that pass Krawczyk's test; None if no trial passes."""
        p, q = _on_parabola(self.slopes, self.bends, reach)
        sizes = [at_parameter(size, reach) for size in self.sizes]
        least = []
        for size, at_reach, (error, second_error), beside in zip(
            self.sizes, sizes, self.errors, off, strict=True
        ):
            cancelled = reach * (size[1][0, 0] + reach * _second_order(size, *self.slopes))
            residue = value(at_reach, p, q) - cancelled + reach * (error + reach * second_error)
            least.append((residue + beside).abs_upper())
        wide = [2 * x for x in least]
        for _ in range(_TRIALS):
            first, second = values(sizes, p + wide[0], q + wide[1])
            a, b, c, d = first[1, 0], first[0, 1], second[1, 0], second[0, 1]
            if (
                least[0] + a * wide[0] + b * wide[1] < wide[0]
                and least[1] + c * wide[0] + d * wide[1] < wide[1]
            ):
                return wide[0], wide[1]
            # 3/2 times the radii that would just pass if the derivatives did not change
            det = (1 - a) * (1 - d) - b * c
            if not (a < 1 and det > 0):
                return None
            factor = arb(3) / (2 * det)
            wide = [
                (factor * ((1 - d) * least[0] + b * least[1])).abs_upper(),
                (factor * (c * least[0] + (1 - a) * least[1])).abs_upper(),
            ]
        return None


def _sizes(m: arb_mat) -> arb_mat:
    return arb_mat(m.nrows(), m.ncols(), [x.abs_upper() for x in m.entries()])


def _absolute(pair: Two) -> Two:
    return pair[0].abs_upper(), pair[1].abs_upper()


def _contracted(nonlinear: tuple[Expansion, Expansion], r: arb, box: Two) -> Two:
    """The part of a box that can contain zeros, by interval Newton steps."""
    forms = [at_parameter(n, r) for n in nonlinear]
    for _ in range(_NEWTON_STEPS):
        p, q = box
        mid_p, mid_q = p.mid(), q.mid()
        first, second = (value(form, mid_p, mid_q) for form in forms)
        a, b = values(forms, p, q)
        jacobian = arb_mat([[1 + a[1, 0], a[0, 1]], [b[1, 0], 1 + b[0, 1]]])
        try:
            move = jacobian.solve(arb_mat([[mid_p + first], [mid_q + second]]))
        except ZeroDivisionError:
            break
        new = mid_p - move[0, 0], mid_q - move[1, 0]
        if not all(w.is_finite() for w in new):
            break
        box = p.intersection(new[0]), q.intersection(new[1])
        if not 2 * box[0].rad().max(box[1].rad()) < p.rad().max(q.rad()):
            break
    return box
