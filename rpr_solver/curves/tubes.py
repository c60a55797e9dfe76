"""Tubes that contain a single curve J = E = 0.

One of the coordinates x, y, z, in which the curve is not too steep, is its parameter r; p and q are the other
two. Polynomials (p̂, q̂)(r) follow the curve to a high order, and a matrix A(r) of polynomials is about the
inverse of the Jacobian matrix of (J, E) in (p, q) along them. With G(p, q, r) = A(r) (J, E) = (p, q) + N, if
for all |r| ≤ h

    |G(p̂(r), q̂(r), r)| + |N′| ρ < ρ,        N′ = ∂N/∂(p, q) over the tube of radii ρ round (p̂, q̂),

then for each r the tube contains exactly one zero of J = E = 0 (Krawczyk's test, mathematics.md#tubes). Since
A follows the curve too, a tube may be much longer than it is wide, and pass close beside another curve.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import exp

from flint import arb, arb_mat, arb_poly, ctx

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
    tables,
)
from rpr_solver.exact.real_roots import ball_of

_BOUND_BITS = 64
"""The precision of bounds over a tube, which need few digits."""
_LEAST_TERMS = 8
"""Coefficients of the polynomials that follow a curve, in the first trial."""
_WIDE = arb(1) / 2
"""How far the terms of these polynomials reach at most, in half tangents, where their rest is bounded."""
_WIDER = 4
"""How many times wider a tube may be than its first trial."""
_SLIM = arb(2) ** -20
"""The radius of a tube round a curve that is met exactly, as a share of the reach."""
_TRIALS, _CLOSE = 9, 1.3
"""Trials of a reach, and how close they come to the greatest. With fewer, tubes are shorter."""
_WORTH = {8: 4, 16: 10, 32: 40}
"""By number of terms: twice as many are taken if the reach is less than this part of what it might be."""
_LEAST_PIECE, _MOST_PIECES = arb(2) ** 80, 400
"""The least piece of a tube, as a share, in which it is seen how far it stays between lengths; how many."""

Polynomials = tuple[arb_poly, arb_poly]


@dataclass(frozen=True)
class Tube:
    """For |r| ≤ reach, all points within ``radii`` of the path in p and in q.

    ``most`` is the reach before it was cut.
    """

    frame: Frame
    axis: int
    forwards: bool
    forms: tuple[Expansion, Expansion]
    path: Polynomials
    most: arb
    radii: Two
    reach: arb

    @property
    def terms(self) -> int:
        """The number of coefficients of the path."""
        return max(x.length() for x in self.path)

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
        return self.frame.outside(x, y), self.frame.length_at(z)

    def advance(self, axis: int) -> arb:
        """How far the path leads in a coordinate, about."""
        if axis == self.axis:
            return self.reach
        others = [i for i in range(3) if i != self.axis]
        path = self.path[others.index(axis)]
        return abs(path(self._last()) - path(arb(0)))

    def _last(self) -> arb:
        r: arb = (self.reach * 0.999).mid()
        return r if self.forwards else -r

    def _box(self, r: arb) -> Two:
        middle = self.path[0](r), self.path[1](r)
        p, q = (arb(m.mid(), m.rad() + radius) for m, radius in zip(middle, self.radii, strict=True))
        return _contracted(self.forms, r, (p, q))


def build(
    around: Neighbourhood, axis: int, forwards: bool, *, between: Two | None = None, terms: int = 0
) -> Tube | None:
    """A tube with one coordinate as parameter, as long as it is worth its work.

    With ``between`` the curve in the tube stays strictly between two lengths. Fewer ``terms`` are not tried.
    None if no such tube can be built at this precision.
    """
    first, second = (_by_power(form, axis) for form in around.forms)
    forms = first, second
    p, q, r = (around.box[i] for i in (*(i for i in range(3) if i != axis), axis))
    if not all(w.is_finite() for w in (p, q, r)):
        return None
    if max(p.rad(), q.rad()) > arb(2) ** -(around.bits // 2):
        p, q = _contracted(forms, r, (p, q))
    least = max(abs(r).abs_upper(), arb(2) ** -(around.bits // 3))
    ready = _preconditioned(forms)
    if ready is None:
        return None
    system, best = _System.of(ready), None
    course = _Course.along(system, (arb_poly([]), arb_poly([])), 1, None)
    # Each course has twice the terms of the one before.
    while course is not None:
        if course.terms >= max(terms, _LEAST_TERMS):
            off = abs(p - course.path[0](r)).abs_upper(), abs(q - course.path[1](r)).abs_upper()
            with ctx.workprec(_BOUND_BITS):
                trials = _Trials.of(course, off)
                found = trials.longest(least)
            if found is None:
                break
            reach, radii = found
            if best is None or reach > best[0].reach:
                best = Tube(around.frame, axis, forwards, forms, course.path, reach, radii, reach), trials
            if course.terms not in _WORTH or reach * _WORTH[course.terms] > trials.most:
                break
        course = course.improved()
    if best is None or between is None:
        return best and best[0]
    low, high = map(around.frame.of_length, between)
    return _cut(*best, r, low, high)


def _cut(tube: Tube, trials: _Trials, start: arb, low: arb, high: arb) -> Tube | None:
    """The part of a tube in which z stays strictly between two values, from a start on."""
    tube = replace(tube, reach=_stays_until(tube.path[1], tube._last(), start, low, high, arb(0)))
    height = tube.path[1](start)
    room = min(height - low, high - height)
    # The radii are about as a power of the reach.
    for _ in range(_TRIALS):
        if not tube.reach > abs(start):
            return None
        with ctx.workprec(_BOUND_BITS):
            radii, _ = trials.radii(tube.reach)
        if radii is not None:
            until = _stays_until(tube.path[1], tube._last(), start, low, high, radii[1])
            if until >= abs(tube._last()):
                return replace(tube, radii=radii)
        share = 0.7 if radii is None else float((room / (8 * radii[1])).root(trials.course.terms).mid())
        tube = replace(tube, reach=(tube.reach * min(max(share, 1 / 16), 0.7)).mid())
    return None


def _stays_until(height: arb_poly, last: arb, start: arb, low: arb, high: arb, radius: arb) -> arb:
    """How far a path stays strictly between two heights, with a radius; 0 for nowhere."""
    r, step = start, (last - start).mid()
    least = abs(step) / _LEAST_PIECE
    # Invariant: the path stays between from the start to r. Pieces are halved down to the least.
    for _ in range(_MOST_PIECES):
        if not abs(step) > least:
            break
        end = last if abs(r + step) >= abs(last) else (r + step).mid()
        z = height(r.union(end))
        if not (low < z - radius and z + radius < high):
            step = (step / 2).mid()
        elif end is last:
            return abs(last)
        else:
            r, step = end, (step * 2).mid()
    return arb(0) if r is start else abs(r).mid()


def _by_power(form: Expansion, axis: int) -> Expansion:
    """An expansion by powers of z as one by powers of the chosen parameter."""
    if axis == ALONG_L:
        return form
    layers = [m.tolist() for m in form]
    size = range(ORDER + 1)
    if axis == 0:
        return [arb_mat([[layer[i][j] for layer in layers] for j in size]) for i in size]
    return [arb_mat([[layer[i][j] for layer in layers] for i in size]) for j in size]


def _preconditioned(forms: tuple[Expansion, Expansion]) -> tuple[Expansion, Expansion] | None:
    """About the inverse of the Jacobian matrix at the origin, times (J, E): what they share cancels."""
    (a, b), (c, d) = ((form[0][1, 0].mid(), form[0][0, 1].mid()) for form in forms)
    det = (a * d - b * c).mid()
    if not det or not det.is_finite():
        return None
    first, second = (
        [m * (x / det).mid() + n * (y / det).mid() for m, n in zip(*forms, strict=True)]
        for x, y in ((d, -b), (-c, a))
    )
    return first, second


@dataclass(frozen=True)
class _System:
    """J and E as matrices: powers of p down, J above E; across for each power of r all powers of q."""

    forms: tuple[Expansion, Expansion]
    coefficients: arb_mat
    slopes: arb_mat
    """Their derivatives in q."""

    @classmethod
    def of(cls, forms: tuple[Expansion, Expansion]) -> _System:
        """Both forms by powers of the parameter."""
        layers = [[m.tolist() for m in form] for form in forms]
        rows = [[c for layer in form for c in layer[i]] for form in layers for i in range(len(form[0]))]
        slopes = [
            [c for layer in form for c in (*(k * c for k, c in enumerate(layer[i][1:], 1)), arb(0))]
            for form in layers
            for i in range(len(form[0]))
        ]
        return cls(forms, arb_mat(rows), arb_mat(slopes))

    def basis(self, q: arb_poly, terms: int) -> list[list[arb]]:
        """The coefficients of rˡ q(r)ᵐ."""
        powers = [arb_poly([1])]
        for _ in range(self.forms[0][0].ncols() - 1):
            powers.append((powers[-1] * q).truncate(terms))
        rows = [_padded(power.coeffs(), terms) for power in powers]
        zeros = [arb(0)] * len(self.forms[0])
        return [(zeros[:k] + row)[:terms] for k in range(len(self.forms[0])) for row in rows]


def _padded(row: list[arb], terms: int) -> list[arb]:
    return row + [arb(0)] * (terms - len(row))


def _rows(coefficients: arb_mat, basis: list[list[arb]]) -> tuple[list[arb_poly], list[arb_poly]]:
    """Polynomials by powers of p: those of J, and those of E."""
    rows = [arb_poly(row) for row in (coefficients * arb_mat(basis)).tolist()]
    half = len(rows) // 2
    return rows[:half], rows[half:]


def _at(rows: Sequence[arb_poly], p: arb_poly, terms: int) -> arb_poly:
    """The sum of rows times powers of p."""
    total = rows[-1]
    for row in reversed(rows[:-1]):
        total = (total * p).truncate(terms) + row
    return total


def _mid(polynomial: arb_poly) -> arb_poly:
    return arb_poly([c.mid() for c in polynomial.coeffs()])


@dataclass(frozen=True)
class _Course:
    """Polynomials that follow a curve, with so many terms, and what is left of J and E along them.

    Attributes:
        path: p̂ and q̂.
        terms: their number of coefficients, n.
        inverse: A, by rows, with as many.
        reciprocal: of the determinant of the Jacobian matrix, with as many.
        rests: A (J, E) along the path, but for the terms of J and E from r²ⁿ on.
        changes: A times the Jacobian matrix, less the identity, but for the terms of the latter from rⁿ on.
    """

    system: _System
    path: Polynomials
    terms: int
    inverse: tuple[Polynomials, Polynomials]
    reciprocal: arb_poly
    rests: Polynomials
    changes: tuple[Polynomials, Polynomials]

    @classmethod
    def along(
        cls, system: _System, path: Polynomials, terms: int, reciprocal: arb_poly | None
    ) -> _Course | None:
        """Follows a path. ``reciprocal`` has half as many terms."""
        p, q = path
        basis = system.basis(q, 2 * terms)
        first, second = _rows(system.coefficients, basis)
        j, e = _at(first, p, 2 * terms), _at(second, p, 2 * terms)
        across = _rows(system.slopes, [row[:terms] for row in basis])
        (a, c), (b, d) = (
            [
                _at([k * row.truncate(terms) for k, row in enumerate(rows[1:], 1)], p, terms)
                for rows in (first, second)
            ],
            [_at(rows, p, terms) for rows in across],
        )
        det = _mid((a * d - b * c).truncate(terms))
        if reciprocal is None:
            if not det[0] or not det[0].is_finite():
                return None
            reciprocal = arb_poly([(1 / det[0]).mid()])
        else:
            reciprocal = _mid((reciprocal * (2 - (det * reciprocal).truncate(terms))).truncate(terms))
        u, v, w, x = (_mid((y * reciprocal).truncate(terms)) for y in (d, -b, -c, a))
        rests = u * j + v * e, w * j + x * e
        changes = (u * a + v * c - 1, u * b + v * d), (w * a + x * c, w * b + x * d - 1)
        return cls(system, path, terms, ((u, v), (w, x)), reciprocal, rests, changes)

    def improved(self) -> _Course | None:
        """Newton's step, which doubles the terms."""
        path = [
            _mid(x - rest.truncate(2 * self.terms)) for x, rest in zip(self.path, self.rests, strict=True)
        ]
        return _Course.along(self.system, (path[0], path[1]), 2 * self.terms, self.reciprocal)


@dataclass(frozen=True)
class _Trials:
    """Trials of tubes along a course.

    What is neglected of J and E is at most (reach/most)²ⁿ times the sums of the absolute values of all their
    terms at ``most``; of their slopes, (reach/most)ⁿ times.
    """

    course: _Course
    off: Two
    most: arb
    whole: list[arb_mat]

    @classmethod
    def of(cls, course: _Course, off: Two) -> _Trials:
        """Trials of tubes that hold a start, so far off the path."""
        most = _widest(course.path)
        p, q = (arb_poly([abs(c) for c in x.coeffs()])(most) for x in course.path)
        return cls(course, off, most, _tables(course, most, (p, q)))

    def longest(self, least: arb) -> tuple[arb, Two] | None:
        """A long reach at which the tube is proved, with its radii; None if it is proved for none."""
        best, reach, failed = None, (self.most * 0.7).mid(), None
        for _ in range(_TRIALS):
            if not reach > least:
                break
            radii, steep = self.radii(reach)
            if radii is not None:
                best = reach, radii
            elif best is not None:
                failed = reach
            else:
                failed, reach = reach, (reach * _shortening(steep, self.course.terms)).mid()
                continue
            if failed is None or failed < best[0] * _CLOSE:
                break
            reach = (best[0] * failed).sqrt().mid()
        return best

    def radii(self, reach: arb) -> tuple[Two | None, arb]:
        """As :func:`contracting_radii`."""
        course, r = self.course, arb(0, reach)
        share = (reach / self.most) ** course.terms
        inverse = [[abs(x(r)) for x in row] for row in course.inverse]
        left = [abs(table[0, 0]) * share * share for table in self.whole]
        residues = [
            (abs(rest(r)) + sum((x * y for x, y in zip(row, left, strict=True)), arb(0)) + offset).abs_upper()
            for rest, row, offset in zip(course.rests, inverse, self.off, strict=True)
        ]
        lost = [[abs(table[1, 0]) * share, abs(table[0, 1]) * share] for table in self.whole]
        # a curve that the path meets exactly, as a fixed pose, needs a positive radius all the same
        first, second = (2 * x if x > 0 else reach * _SLIM for x in residues)
        widest = _WIDER * first, _WIDER * second
        p, q = (abs(x(r)) + y for x, y in zip(course.path, widest, strict=True))
        bends = _tables(course, reach, (p, q))
        curved = [[[abs(t[2, 0]), abs(t[1, 1])], [abs(t[1, 1]), abs(t[0, 2])]] for t in bends]

        def slopes(radii: Two) -> Slopes:
            rows = []
            for change, row in zip(course.changes, inverse, strict=True):
                entries = [
                    abs(x(r))
                    + sum(
                        (
                            w * (lost[k][i] + curved[k][i][0] * radii[0] + curved[k][i][1] * radii[1])
                            for k, w in enumerate(row)
                        ),
                        arb(0),
                    )
                    for i, x in enumerate(change)
                ]
                rows.append((entries[0].abs_upper(), entries[1].abs_upper()))
            return rows[0], rows[1]

        radii, steep = contracting_radii((residues[0], residues[1]), (first, second), slopes)
        if radii is not None and not all(x <= y for x, y in zip(radii, widest, strict=True)):
            return None, steep.max(arb(1))
        return radii, steep


def _widest(path: Polynomials) -> arb:
    """About the greatest reach at which a path is not too long; 1 at most."""
    least = 0.0
    for polynomial in path:
        for k, c in enumerate(polynomial.coeffs()[1:], 1):
            if c:
                mantissa, exponent = c.man_exp()
                size = int(exponent) + int(mantissa).bit_length()
                least = max(least, (size + 1) / k)
    return arb(2) ** arb(-least)


def _tables(course: _Course, reach: arb, box: Two) -> list[arb_mat]:
    """Sums of the absolute values of all terms of J and E, and of their derivatives up to the second.

    For |r| ≤ reach, and p and q up to the corner of a box.
    """
    p, q = (arb(0, x.abs_upper()) for x in box)
    return tables([at_parameter(form, arb(0, reach)) for form in course.system.forms], p, q)


def _shortening(steepness: arb, terms: int) -> float:
    """By what to multiply a reach with this bound of the derivatives, which fall with its power."""
    if not steepness.is_finite():
        return 1 / 8
    size = float(steepness.log().mid()) if steepness > 0 else 0.0
    return min(max(exp(-(size + 1.2) / terms), 1 / 8), 0.85)


def _contracted(forms: tuple[Expansion, Expansion], r: arb, box: Two) -> Two:
    """The part of a box that can contain zeros, by interval Newton steps."""
    first, second = (at_parameter(form, r) for form in forms)
    middle = [x.mid() for x in box]
    (a, b), (c, d) = ((t[1, 0].mid(), t[0, 1].mid()) for t in tables([first, second], *middle))
    det = (a * d - b * c).mid()
    if not det or not det.is_finite():
        return box
    ready = [(x / det).mid() * first + (y / det).mid() * second for x, y in ((d, -b), (-c, a))]

    def step(point: Box, box: Box) -> Box | None:
        gaps = [table[0, 0] for table in tables(ready, *point)]
        return newton_image(point, gaps, [[t[1, 0], t[0, 1]] for t in tables(ready, *box)])

    # more digits than a box has to have in build, so that the next tube begins with this one
    p, q = narrowed(step, list(box), ctx.prec * 2 // 3)
    return p, q
