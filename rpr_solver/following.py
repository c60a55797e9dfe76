"""A cusp followed by proof, along its curve J = E = 0 in (α, θ, L): through tubes that hold the curve alone.

About a point of the curve J and E are expanded exactly in x = tan(δα/2), y = tan(δθ/2), z = δL/L. One
of the three, in which the curve is not too steep, is taken as its parameter r; p and q are the other two.
Multiplied by the inverse of its Jacobian matrix, (J, E) becomes G = (p, q) + N(p, q, r). A parabola
(p̂(r), q̂(r)) follows the curve to second order, and where for all |r| ≤ h

    |G(p̂(r), q̂(r), r)| + |N′| ρ < ρ,        N′ = ∂N/∂(p, q) over the tube of radii ρ round the parabola,

each r has exactly one zero of J = E = 0 in the tube (Krawczyk's test). So the curve is followed through
swallowtails, lips and beaks as well, where it turns back in L.

All along it is a curve of cusps, but for these: a zero at which neither ∇f = 0 nor v·∇E = 0 nor ∇J = 0 is
a cusp, and poses with ∇f = 0 come in curves of their own, which a tube would hold beside the cusps'. E
may be taken along either leg; it is taken along the one with the larger gradient, for a cusp may pass a
pose at which the other gradient vanishes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from flint import arb, arb_mat, arb_poly, ctx, fmpz_poly

from rpr_solver.jets import LocalMap, Pose
from rpr_solver.poses import HalfTangent
from rpr_solver.roots import RealPolynomial, omega_ball
from rpr_solver.surface import BiForm, Leg, Pair, Surface

_ORDER = 6
_ALONG_L = 2
"""The coordinates x, y, z are numbered 0, 1, 2."""
_FIRST_BITS, _MAX_BITS = 128, 1 << 12
_BOUND_BITS = 64
_NEWTON_STEPS = 4
_TRIALS = 3
_FIRST_REACH = Fraction(1, 32)

Two = tuple[arb, arb]
Three = tuple[arb, arb, arb]
Expansion = list[arb_mat]
"""The coefficients of 1, r, r², …, each a matrix with powers of p down and of q across."""


class LostError(Exception):
    """No tube leads on at any precision tried."""


@dataclass(frozen=True)
class Place:
    """A box in (α, θ) of one slice."""

    alpha: HalfTangent
    theta: HalfTangent

    def apart(self, other: Place) -> bool:
        """Proof that two boxes do not meet."""
        pairs = ((self.alpha, other.alpha), (self.theta, other.theta))
        crossed = (a.numerator * b.denominator - b.numerator * a.denominator for a, b in pairs)
        return any(not x.contains(0) for x in crossed)


class CuspForms:
    """J, and E along either leg, as matrices of balls at any precision (scaled units)."""

    def __init__(self, surface: Surface) -> None:
        self.surface = surface
        along_g = replace(surface, f=surface.g, g=surface.f)
        self._singular = _raised(surface.singular)
        self._coalescence = surface.coalescence.coefficients, along_g.coalescence.coefficients
        self._known: dict[int, tuple[Expansion, tuple[Expansion, Expansion]]] = {}

    def at(self, bits: int) -> tuple[Expansion, tuple[Expansion, Expansion]]:
        """J, and E along leg f and along leg g, by powers of L: powers of t down and of u across."""
        if bits not in self._known:
            along_f, along_g = (self._balls(rows, bits) for rows in self._coalescence)
            self._known[bits] = self._balls(self._singular, bits), (along_f, along_g)
        return self._known[bits]

    def _balls(self, rows: Sequence[Sequence[Pair]], bits: int) -> Expansion:
        radicand = self.surface.radicand
        balls = [[RealPolynomial(*pair, radicand).ball(bits) for pair in row] for row in rows]
        return [
            arb_mat([[row[k][j] for j in range(_ORDER + 1)] for row in balls]) for k in range(len(rows[0]))
        ]

    def steeper(self, place: Place, length: arb, bits: int) -> int:
        """0 or 1: the leg, f or g, whose gradient is the larger by its size."""
        (cos_a, sin_a), (cos_t, sin_t) = (_middle(t).cos_sin() for t in (place.alpha, place.theta))
        pose = Pose(cos_a, sin_a, cos_t, sin_t, length, omega_ball(self.surface.radicand, bits))
        local = LocalMap.at(self.surface, pose, 1)
        steep = [
            (jet.alpha.value**2 + jet.theta.value**2) / _size(leg, self.surface.radicand)
            for jet, leg in ((local.f, self.surface.f), (local.g, self.surface.g))
        ]
        return 0 if steep[0].mid() >= steep[1].mid() else 1


def _size(leg: Leg, radicand: int) -> int:
    return leg.m**2 + leg.n**2 * radicand + leg.ax**2 + leg.ay**2


def _middle(t: HalfTangent) -> HalfTangent:
    return HalfTangent(t.numerator.mid(), t.denominator.mid())


def _raised(form: BiForm) -> list[list[Pair]]:
    """J, of degrees 4 and 4, times (1+t²)(1+u²), so that all forms have one size."""
    one = fmpz_poly([1, 0, 1])
    rows = [[(a * one, b * one) for a, b in row] for row in form.coefficients]
    empty = [(fmpz_poly([]), fmpz_poly([]))] * len(rows[0])
    low, high = [*rows, empty, empty], [empty, empty, *rows]
    return [
        [(a + c, b + d) for (a, b), (c, d) in zip(x, y, strict=True)] for x, y in zip(low, high, strict=True)
    ]


class Follower:
    """A cusp of a slice on its way up, or down, along its curve.

    ``start`` gives a box that holds the cusp, and no other zero, as small as a precision in bits allows.
    Lengths are scaled.
    """

    def __init__(
        self, forms: CuspForms, start: Callable[[int], Place], length: Fraction, *, upwards: bool
    ) -> None:
        self.forms = forms
        self._start, self._begin, self._upwards = start, length, upwards
        self._bits = _FIRST_BITS
        self._reach = arb(_FIRST_REACH.numerator) / _FIRST_REACH.denominator
        self._tube: _Tube | None = None

    def walk(self, low: Fraction, high: Fraction, tubes: int) -> tuple[Fraction, Place] | None:
        """Go on, above ``low`` and below ``high``, to the first of these two slices that the curve meets.

        Returns:
            The slice that was met and the box there; None when so many new tubes lead to neither.

        Raises:
            LostError: no tube leads on.
        """
        for _ in range(tubes + 1):
            if self._tube:
                with ctx.workprec(self._bits):
                    met = self._tube.meets(low, high)
                    if met is not None:
                        return met, self._tube.place_at(_ball(met))
            self._extend(low, high)
        return None

    def _extend(self, low: Fraction, high: Fraction) -> None:
        while self._bits <= _MAX_BITS:
            with ctx.workprec(self._bits):
                tube = self._next(_ball(low), _ball(high))
            if tube:
                self._tube, self._reach = tube, 2 * tube.reach
                return
            self._bits *= 2
        raise LostError

    def _next(self, low: arb, high: arb) -> _Tube | None:
        if self._tube is None:
            around = _Around.at(self.forms, self._start(self._bits), _ball(self._begin), self._bits)
            return around.tube(_ALONG_L, self._upwards, self._reach, None)
        tube = self._tube
        around = _Around.at(self.forms, *tube.end(), self._bits)
        heading = around.heading(tube.axis, tube.forwards)
        if heading is None:
            return None
        axis, forwards, upwards = heading
        if axis == _ALONG_L:
            return around.tube(axis, forwards, self._reach, None)
        across = around.tube(axis, forwards, self._reach, (low, high))
        if (across and across.reach * 4 > self._reach) or upwards is None:
            return across
        along = around.tube(_ALONG_L, upwards, self._reach, None)
        if across and along and along.advance(axis) < across.reach:
            return across
        return along or across


@dataclass(frozen=True)
class _Frame:
    """Where local coordinates begin: half angles as (sin, cos), exact and all but normed, and L."""

    alpha: Two
    theta: Two
    length: arb

    @classmethod
    def about(cls, place: Place, length: arb) -> _Frame:
        """With its origin in the middle of a box."""

        def origin(t: HalfTangent) -> Two:
            n, d = t.numerator.mid(), t.denominator.mid()
            norm = (n * n + d * d).sqrt()
            return (n / norm).mid(), (d / norm).mid()

        return cls(origin(place.alpha), origin(place.theta), length.mid())

    def inside(self, place: Place, length: arb) -> Three:
        """A box in local coordinates."""
        origins = (self.alpha, place.alpha), (self.theta, place.theta)
        x, y = (
            (t.numerator * c - t.denominator * s) / (t.numerator * s + t.denominator * c)
            for (s, c), t in origins
        )
        return x, y, self.of_length(length)

    def of_length(self, length: arb) -> arb:
        """z."""
        return (length - self.length) / self.length

    def outside(self, x: arb, y: arb) -> Place:
        """The box with these local coordinates."""
        alpha, theta = (HalfTangent(c * w + s, c - s * w) for (s, c), w in ((self.alpha, x), (self.theta, y)))
        return Place(alpha, theta)

    def expanded(self, form: Expansion) -> Expansion:
        """A form by powers of z, those of x down and of y across."""
        left, right = _moved(self.alpha).transpose(), _moved(self.theta)
        form = [c * self.length**k for k, c in enumerate(form)]
        c0, c1, *rest = form
        if rest:
            [c2] = rest
            coefficients = [c0 + c1 + c2, c1 + c2 * 2, c2]
        else:
            coefficients = [c0 + c1, c1, c1 * 0]
        return [left * c * right for c in coefficients]


def _moved(origin: Two) -> arb_mat:
    """Row i: the coefficients of (c x + s)ⁱ (c − s x)⁶⁻ⁱ, what tⁱ becomes about t = s/c."""
    s, c = origin
    ups, downs = [arb_poly([1])], [arb_poly([1])]
    for _ in range(_ORDER):
        ups.append(ups[-1] * arb_poly([s, c]))
        downs.append(downs[-1] * arb_poly([c, -s]))
    rows = (up * down for up, down in zip(ups, reversed(downs), strict=True))
    return arb_mat([[row[p] for p in range(_ORDER + 1)] for row in rows])


@dataclass(frozen=True)
class _Around:
    """The neighbourhood of a point of the curve: J and E in local coordinates, and a box for the point."""

    frame: _Frame
    forms: tuple[Expansion, Expansion]
    box: Three
    bits: int

    @classmethod
    def at(cls, forms: CuspForms, place: Place, length: arb, bits: int) -> _Around:
        """About the point of the curve that a box holds."""
        frame = _Frame.about(place, length)
        singular, coalescence = forms.at(bits)
        e = coalescence[forms.steeper(place, length, bits)]
        return cls(frame, (frame.expanded(singular), frame.expanded(e)), frame.inside(place, length), bits)

    def heading(self, axis: int, forwards: bool) -> tuple[int, bool, bool | None] | None:
        """The best parameter, and whether it and L grow on the way on which coordinate ``axis`` does so.

        None where the balls do not tell; in place of the last where they do not tell that.
        """
        tangent = self._tangent()
        best = max(range(3), key=lambda i: abs(tangent[i].mid()))
        if any(tangent[i].contains(0) or not tangent[i].is_finite() for i in (axis, best)):
            return None
        reverse = (tangent[axis] > 0) != forwards
        upwards = None if tangent[_ALONG_L].contains(0) else bool(tangent[_ALONG_L] > 0) != reverse
        return best, bool(tangent[best] > 0) != reverse, upwards

    def _tangent(self) -> Three:
        """∇J × ∇E."""
        (a, b, c), (d, e, f) = (self._gradient(form) for form in self.forms)
        return b * f - c * e, c * d - a * f, a * e - b * d

    def _gradient(self, form: Expansion) -> Three:
        x, y, z = self.box
        table = _values(_at(form, z), x, y)
        slope = _value(form[1] + form[2] * (2 * z), x, y)
        return table[1, 0], table[0, 1], slope

    def tube(self, axis: int, forwards: bool, reach: arb, between: Two | None) -> _Tube | None:
        """A tube with one coordinate as parameter, of the given reach or less.

        With ``between`` the way forwards through it stays strictly between two lengths. None where no tube
        can be built at this precision.
        """
        along = [_by_power(form, axis) for form in self.forms]
        first, second = along
        nonlinear = _preconditioned(first, second)
        others = [i for i in range(3) if i != axis]
        p, q, r = (self.box[i] for i in (*others, axis))
        if nonlinear is None or not all(w.is_finite() for w in (p, q, r)):
            return None
        if max(p.rad(), q.rad()) > arb(2) ** -(self.bits // 2):
            p, q = _contracted(nonlinear, r, (p, q))
        slopes, bends = _parabola(nonlinear)
        middle = _on_parabola(slopes, bends, r)
        off = abs(p - middle[0]).abs_upper(), abs(q - middle[1]).abs_upper()
        planes = None if between is None else [self.frame.of_length(length) for length in between]
        with ctx.workprec(_BOUND_BITS):
            bounds = _Bounds.of(nonlinear, slopes, bends)
            least = max(abs(r).abs_upper(), arb(2) ** -(self.bits // 3))
            reach = reach.mid()
            while reach > least:
                radii = bounds.radii(reach, off)
                if radii is not None:
                    tube = _Tube(self.frame, axis, forwards, nonlinear, slopes, bends, reach, radii)
                    if planes is None or tube.stays_between(r, *planes):
                        return tube
                reach /= 2
        return None


def _by_power(form: Expansion, axis: int) -> Expansion:
    """An expansion by powers of z as one by powers of the chosen parameter."""
    if axis == _ALONG_L:
        return form
    size, powers = range(_ORDER + 1), range(len(form))
    if axis == 0:
        return [arb_mat([[form[k][i, j] for k in powers] for j in size]) for i in size]
    return [arb_mat([[form[k][i, j] for k in powers] for i in size]) for j in size]


@dataclass(frozen=True)
class _Tube:
    """Where |r| ≤ reach: all within ``radii`` of the parabola, in p and in q."""

    frame: _Frame
    axis: int
    forwards: bool
    nonlinear: tuple[Expansion, Expansion]
    slopes: Two
    bends: Two
    reach: arb
    radii: Two

    def meets(self, low: Fraction, high: Fraction) -> Fraction | None:
        """Which of two lengths the tube leads to, with L as parameter."""
        if self.axis != _ALONG_L:
            return None
        length = high if self.forwards else low
        return length if abs(self.frame.of_length(_ball(length))) <= self.reach else None

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
        reached = [start, self._last()]
        if not bend.contains(0):
            turn = -slope / (2 * bend)
            reached += [turn] if abs(turn) <= self.reach else []
        values = [r * (slope + r * bend) for r in reached]
        radius = self.radii[1]
        return all(low < value - radius and value + radius < high for value in values)

    def advance(self, axis: int) -> arb:
        """How far the tube leads in another coordinate, nearly."""
        return abs(self.slopes[axis] * self.reach).mid()

    def _last(self) -> arb:
        r: arb = (self.reach * 0.999).mid()
        return r if self.forwards else -r

    def _box(self, r: arb) -> Two:
        middle = _on_parabola(self.slopes, self.bends, r)
        p, q = (arb(m.mid(), m.rad() + radius) for m, radius in zip(middle, self.radii, strict=True))
        return _contracted(self.nonlinear, r, (p, q))


def _preconditioned(j: Expansion, e: Expansion) -> tuple[Expansion, Expansion] | None:
    """N: (nearly) the inverse of the Jacobian matrix at the origin times (J, E), less (p, q)."""
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
    """What is left of the terms in r and r² on the parabola."""

    @classmethod
    def of(cls, nonlinear: tuple[Expansion, Expansion], slopes: Two, bends: Two) -> _Bounds:
        first, second = ([_sizes(m) for m in n] for n in nonlinear)
        errors = tuple(
            (abs(n[1][0, 0] + slope), abs(_second_order(n, *slopes) + bend))
            for n, slope, bend in zip(nonlinear, slopes, bends, strict=True)
        )
        return cls((first, second), _absolute(slopes), _absolute(bends), errors)

    def radii(self, reach: arb, off: Two) -> Two | None:
        """Radii of p and q, greater than ``off``, that pass Krawczyk's test; None if none were found."""
        p, q = _on_parabola(self.slopes, self.bends, reach)
        sizes = [_at(size, reach) for size in self.sizes]
        least = []
        for size, at_reach, (error, second_error), beside in zip(
            self.sizes, sizes, self.errors, off, strict=True
        ):
            cancelled = reach * (size[1][0, 0] + reach * _second_order(size, *self.slopes))
            residue = _value(at_reach, p, q) - cancelled + reach * (error + reach * second_error)
            least.append((residue + beside).abs_upper())
        wide = [2 * x for x in least]
        for _ in range(_TRIALS):
            first, second = (_values(size, p + wide[0], q + wide[1]) for size in sizes)
            a, b, c, d = first[1, 0], first[0, 1], second[1, 0], second[0, 1]
            if (
                least[0] + a * wide[0] + b * wide[1] < wide[0]
                and least[1] + c * wide[0] + d * wide[1] < wide[1]
            ):
                return wide[0], wide[1]
            # what would pass by half as much again, if the derivatives stayed as they are
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
    """The part of a box in which zeros can lie, by interval Newton steps."""
    forms = [_at(n, r) for n in nonlinear]
    for _ in range(_NEWTON_STEPS):
        p, q = box
        mid_p, mid_q = p.mid(), q.mid()
        first, second = (_value(form, mid_p, mid_q) for form in forms)
        a, b = (_values(form, p, q) for form in forms)
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


def _at(form: Expansion, r: arb) -> arb_mat:
    total = form[-1]
    for coefficient in reversed(form[:-1]):
        total = total * r + coefficient
    return total


def _value(form: arb_mat, p: arb, q: arb) -> arb:
    rows, columns = form.nrows(), form.ncols()
    product: Any = arb_mat(1, rows, _powers(p, rows)) * form * arb_mat(columns, 1, _powers(q, columns))
    value: arb = product[0, 0]
    return value


def _values(form: arb_mat, p: arb, q: arb) -> arb_mat:
    """[[value, ∂/∂q], [∂/∂p, ∂²/∂p∂q]]."""
    return _table(p, form.nrows()) * form * _table(q, form.ncols()).transpose()


def _table(x: arb, size: int) -> arb_mat:
    """1, x, x², … and, below, their derivatives."""
    powers = _powers(x, size)
    return arb_mat([powers, [arb(0), *((k + 1) * powers[k] for k in range(size - 1))]])


def _powers(x: arb, size: int) -> list[arb]:
    powers = [arb(1)]
    for _ in range(size - 1):
        powers.append(powers[-1] * x)
    return powers


def _ball(x: Fraction) -> arb:
    return arb(x.numerator) / x.denominator
