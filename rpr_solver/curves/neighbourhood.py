"""J = E = 0 about one of its points, expanded exactly in local coordinates.

The coordinates are x = tan(δα/2), y = tan(δθ/2) and z = (L − L₀)/(L + L₀), numbered 0, 1, 2. Rotating the
half angles moves the point to x = y = 0, so it is never at infinity; all lengths > 0 are −1 < z < 1. Angles
are those of the turns of the forms (model/bridge.py), and forms are taken at the tangents of their halves.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from flint import arb, arb_mat, arb_poly, ctx

from rpr_solver.exact.biform import BiForm, T, U
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.model.bridge import Bridge
from rpr_solver.model.jets import HalfTangent, LocalMap, pose_of
from rpr_solver.model.slice_map import SliceMap

ORDER = 6
ALONG_L = 2

Two = tuple[arb, arb]
Three = tuple[arb, arb, arb]
Expansion = list[arb_mat]
"""The coefficients of 1, r, r², … (r one coordinate), each a matrix with powers of the other two."""


@dataclass(frozen=True)
class PoseBox:
    """A box in (α, θ) of one slice, by the tangents of half the angles of turns."""

    alpha: HalfTangent
    theta: HalfTangent

    def apart(self, other: PoseBox) -> bool:
        """Whether two boxes are proved to be disjoint."""
        pairs = ((self.alpha, other.alpha), (self.theta, other.theta))
        crossed = (a.numerator * b.denominator - b.numerator * a.denominator for a, b in pairs)
        return any(not x.contains(0) for x in crossed)


class CuspForms:
    """J, and E along either leg, as matrices of balls at any precision (scaled units)."""

    def __init__(self, slice_map: SliceMap) -> None:
        self.slice_map = slice_map
        along_g = replace(slice_map, f=slice_map.g, g=slice_map.f)
        # J, of degrees 4 and 4, times (1+ρt²)(1+ρu²), so that all forms have one size
        circular = (1 + slice_map.rho * T**2) * (1 + slice_map.rho * U**2)
        self._singular = slice_map.singular * BiForm.of(circular, slice_map.radicand, 2, 2)
        self._coalescence = slice_map.coalescence, along_g.coalescence
        self._known: dict[int, tuple[Expansion, tuple[Expansion, Expansion]]] = {}

    def at(self, bits: int) -> tuple[Expansion, tuple[Expansion, Expansion]]:
        """J, and E along leg f and along leg g, by powers of L: powers of t down and of u across."""
        if bits not in self._known:
            rho = self.slice_map.rho
            along_f, along_g = (_balls(form, rho, bits) for form in self._coalescence)
            self._known[bits] = _balls(self._singular, rho, bits), (along_f, along_g)
        return self._known[bits]

    def steeper(self, place: PoseBox, length: arb, bits: int) -> int:
        """0 for leg f or 1 for leg g: the leg with the larger gradient in proportion to its size."""
        omega = omega_ball(self.slice_map.radicand, bits)
        angles = Bridge.of(self.slice_map).angles_of(_middle(place.alpha), _middle(place.theta))
        pose = pose_of(*angles, length, omega)
        local = LocalMap.at(self.slice_map, pose, 1)
        steep = [
            (jet.alpha.value**2 + jet.theta.value**2) / (leg.platform2 + leg.base2)
            for jet, leg in ((local.f, self.slice_map.f), (local.g, self.slice_map.g))
        ]
        return 0 if steep[0].mid() >= steep[1].mid() else 1


def _middle(t: HalfTangent) -> HalfTangent:
    return HalfTangent(t.numerator.mid(), t.denominator.mid())


def _balls(form: BiForm, rho: int, bits: int) -> Expansion:
    """By tangents of half angles, which are half tangents times √ρ."""
    balls = [[polynomial.ball(bits) for polynomial in row] for row in form.coefficients]
    with ctx.workprec(bits):
        share = [arb(rho) ** (arb(-n) / 2) for n in range(2 * ORDER + 1)] if rho > 1 else None
        return [
            arb_mat(
                [
                    [row[k][j] * share[i + j] if share else row[k][j] for j in range(ORDER + 1)]
                    for i, row in enumerate(balls)
                ]
            )
            for k in range(len(balls[0]))
        ]


@dataclass(frozen=True)
class Frame:
    """The origin of local coordinates: half angles as exact (sin, cos), nearly normalized, and L."""

    alpha: Two
    theta: Two
    length: arb

    @classmethod
    def about(cls, place: PoseBox, length: arb) -> Frame:
        """The frame whose origin is the midpoint of a box."""

        def origin(t: HalfTangent) -> Two:
            n, d = t.numerator.mid(), t.denominator.mid()
            norm = (n * n + d * d).sqrt()
            return (n / norm).mid(), (d / norm).mid()

        return cls(origin(place.alpha), origin(place.theta), length.mid())

    def inside(self, place: PoseBox, length: arb) -> Three:
        """A box in local coordinates."""
        origins = (self.alpha, place.alpha), (self.theta, place.theta)
        x, y = (
            (t.numerator * c - t.denominator * s) / (t.numerator * s + t.denominator * c)
            for (s, c), t in origins
        )
        return x, y, self.of_length(length)

    def of_length(self, length: arb) -> arb:
        """The coordinate z of a length."""
        return (length - self.length) / (length + self.length)

    def length_at(self, z: arb) -> arb:
        """The length at a coordinate z."""
        return self.length * (1 + z) / (1 - z)

    def outside(self, x: arb, y: arb) -> PoseBox:
        """The box with these local coordinates."""
        alpha, theta = (HalfTangent(c * w + s, c - s * w) for (s, c), w in ((self.alpha, x), (self.theta, y)))
        return PoseBox(alpha, theta)

    def expanded(self, *forms: Expansion) -> Iterator[Expansion]:
        """Forms, times (1 − z)², by powers of z, those of x down and of y across."""
        left, right = _moved(self.alpha).transpose(), _moved(self.theta)
        for form in forms:
            c0, c1, c2 = [left * (c * self.length**k) * right for k, c in enumerate((*form, form[0] * 0)[:3])]
            # c0 (1 − z)² + c1 (1 + z) (1 − z) + c2 (1 + z)²
            yield [c0 + c1 + c2, (c2 - c0) * 2, c0 - c1 + c2]


def _moved(origin: Two) -> arb_mat:
    """Row i: the coefficients of (c x + s)ⁱ (c − s x)⁶⁻ⁱ, what tⁱ becomes about t = s/c."""
    s, c = origin
    ups, downs = [arb_poly([1])], [arb_poly([1])]
    for _ in range(ORDER):
        ups.append(ups[-1] * arb_poly([s, c]))
        downs.append(downs[-1] * arb_poly([c, -s]))
    rows = ((up * down).coeffs() for up, down in zip(ups, reversed(downs), strict=True))
    return arb_mat([row + [arb(0)] * (ORDER + 1 - len(row)) for row in rows])


@dataclass(frozen=True)
class Neighbourhood:
    """The neighbourhood of a point of the curve: J and E in local coordinates, and a box about the point."""

    frame: Frame
    forms: tuple[Expansion, Expansion]
    box: Three
    bits: int

    @classmethod
    def at(cls, forms: CuspForms, place: PoseBox, length: arb, bits: int) -> Neighbourhood:
        """The neighbourhood of the point of the curve in a box."""
        frame = Frame.about(place, length)
        singular, coalescence = forms.at(bits)
        e = coalescence[forms.steeper(place, length, bits)]
        first, second = frame.expanded(singular, e)
        return cls(frame, (first, second), frame.inside(place, length), bits)

    def heading(self, axis: int, forwards: bool) -> tuple[int, bool, bool | None] | None:
        """The best parameter, and whether it and L increase along the curve in a given direction.

        The direction is that in which coordinate ``axis`` increases (``forwards``) or decreases. None if the
        balls do not decide it; the last entry is None if they do not decide it for L.
        """
        tangent = self._tangent()
        best = max(range(3), key=lambda i: abs(tangent[i].mid()))
        if any(tangent[i].contains(0) or not tangent[i].is_finite() for i in (axis, best)):
            return None
        reverse = (tangent[axis] > 0) != forwards
        upwards = None if tangent[ALONG_L].contains(0) else bool(tangent[ALONG_L] > 0) != reverse
        return best, bool(tangent[best] > 0) != reverse, upwards

    def _tangent(self) -> Three:
        """∇J × ∇E."""
        (a, b, c), (d, e, f) = (self._gradient(form) for form in self.forms)
        return b * f - c * e, c * d - a * f, a * e - b * d

    def _gradient(self, form: Expansion) -> Three:
        x, y, z = self.box
        [table] = tables([at_parameter(form, z)], x, y)
        [slope] = value_of_each([form[1] + form[2] * (2 * z)], x, y)
        return table[1, 0], table[0, 1], slope


def at_parameter(form: Expansion, r: arb) -> arb_mat:
    """The expansion at one value of its parameter."""
    total = form[-1]
    for coefficient in reversed(form[:-1]):
        total = total * r + coefficient
    return total


def value_of_each(forms: Sequence[arb_mat], p: arb, q: arb) -> list[arb]:
    """The values at (p, q) of forms of one size."""
    rows, columns = forms[0].nrows(), forms[0].ncols()
    left, right = arb_mat(1, rows, _powers(p, rows)), arb_mat(columns, 1, _powers(q, columns))
    return [(left * form * right)[0, 0] for form in forms]


def tables(forms: Sequence[arb_mat], p: arb, q: arb) -> list[arb_mat]:
    """The derivatives of forms of one size at (p, q), up to the second: those in p down, in q across."""
    left, right = _table(p, forms[0].nrows()), _table(q, forms[0].ncols()).transpose()
    return [left * form * right for form in forms]


def _table(x: arb, size: int) -> arb_mat:
    """1, x, x², … and, below, their first and second derivatives."""
    powers = _powers(x, size)
    slopes = [arb(0), *((k + 1) * powers[k] for k in range(size - 1))]
    return arb_mat([powers, slopes, [arb(0), *((k + 1) * slopes[k] for k in range(size - 1))]])


def _powers(x: arb, size: int) -> list[arb]:
    powers = [arb(1)]
    for _ in range(size - 1):
        powers.append(powers[-1] * x)
    return powers
