"""Partial derivatives of a slice's map at a pose, over any ring: balls or an algebraic number field.

The squared length of a leg is a sum of sinusoids (legs.py), so its derivatives are closed formulas; those
of J, E and further functions follow by the product rule. No polynomial is expanded.
Below are angles by the tangents of their halves, as balls and as floats.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from math import atan, comb, pi
from operator import sub
from typing import Any, Generic, Protocol, TypeVar

from flint import acb, arb, arb_mat, arb_poly

from rpr_solver.exact.modular import sylvester
from rpr_solver.exact.plane import PlaneNumber
from rpr_solver.legs import Derivatives, cross, turns
from rpr_solver.model.slice_map import Leg, SliceMap


class Ring(Protocol):
    """The operations of a jet's entries."""

    def __add__(self, other: Any, /) -> Any: ...
    def __sub__(self, other: Any, /) -> Any: ...
    def __mul__(self, other: Any, /) -> Any: ...
    def __neg__(self) -> Any: ...


R = TypeVar("R", bound=Ring)
S = TypeVar("S", bound=Ring)


@dataclass(frozen=True)
class Jet(Generic[R]):
    """Partial derivatives at one point: ``table[i][j]`` is ∂α^i ∂θ^j, for i + j ≤ order."""

    table: tuple[tuple[R, ...], ...]

    @classmethod
    def build(cls, order: int, entry: Callable[[int, int], R]) -> Jet[R]:
        """The jet with the given entries."""
        return cls(tuple(tuple(entry(i, j) for j in range(order + 1 - i)) for i in range(order + 1)))

    @property
    def order(self) -> int:
        """The order of the highest derivatives."""
        return len(self.table) - 1

    @property
    def value(self) -> R:
        """The function itself."""
        return self.table[0][0]

    @property
    def alpha(self) -> Jet[R]:
        """∂/∂α."""
        return Jet(self.table[1:])

    @property
    def theta(self) -> Jet[R]:
        """∂/∂θ."""
        return Jet(tuple(row[1:] for row in self.table[:-1]))

    @property
    def gradient(self) -> tuple[Jet[R], Jet[R]]:
        """∂/∂α and ∂/∂θ."""
        return self.alpha, self.theta

    def joined(self, other: Jet[R], join: Callable[[R, R], R]) -> Jet[R]:
        """The jet whose entries are made of those of two."""
        order = min(self.order, other.order)
        return Jet.build(order, lambda i, j: join(self.table[i][j], other.table[i][j]))

    def mapped(self, function: Callable[[R], S]) -> Jet[S]:
        """The image of the jet in another ring."""
        return Jet(tuple(tuple(map(function, row)) for row in self.table))

    def up_to(self, order: int) -> Jet[R]:
        """The derivatives up to a lower order."""
        return Jet.build(order, lambda i, j: self.table[i][j])

    def of_product(self, other: Jet[R], i: int, j: int) -> R:
        """∂α^i ∂θ^j of the product with another function."""
        total: Any = None
        for k in range(i + 1):
            for m in range(j + 1):
                term = self.table[k][m] * other.table[i - k][j - m]
                weight = comb(i, k) * comb(j, m)
                term = term * weight if weight != 1 else term
                total = term if total is None else total + term
        return total  # type: ignore[no-any-return]

    def __mul__(self, other: Jet[R]) -> Jet[R]:
        return Jet.build(min(self.order, other.order), partial(self.of_product, other))

    def __sub__(self, other: Jet[R]) -> Jet[R]:
        return self.joined(other, sub)


@dataclass(frozen=True)
class Pose(Generic[R]):
    """A pose of a slice: cosines and sines of α and θ, the fixed length L and ω (scaled units)."""

    cos_alpha: R
    sin_alpha: R
    cos_theta: R
    sin_theta: R
    length: R
    omega: R

    def mapped(self, function: Callable[[R], S]) -> Pose[S]:
        """The image of the pose in another ring."""
        angles = self.cos_alpha, self.sin_alpha, self.cos_theta, self.sin_theta
        return Pose(*map(function, (*angles, self.length, self.omega)))


@dataclass(frozen=True)
class LocalMap(Generic[R]):
    """The slice's map (α, θ) → (f, g) near a pose: jets of f/2 and g/2, each less a constant.

    A pose in balls is one of the article's frame. In other rings it has the coordinates of the forms, with y
    in √ρ, and all derivatives are those by √ρ ∂/∂α and √ρ ∂/∂θ, so that they are in the ring.
    """

    slice_map: SliceMap
    pose: Pose[R]
    f: Jet[R]
    g: Jet[R]

    @classmethod
    def at(cls, slice_map: SliceMap, pose: Pose[R], order: int) -> LocalMap[R]:
        """All derivatives up to ``order``."""
        rho = 1 if isinstance(pose.omega, arb) else slice_map.rho
        number: Any = acb if isinstance(pose.omega, arb) else partial(PlaneNumber, rho=rho)
        tip = number(pose.cos_theta, pose.sin_theta) * pose.length
        at = turns(number(pose.cos_alpha, pose.sin_alpha), tip)
        f, g = (
            Jet.build(order, _scaled(leg.waves(pose.omega).turned(*at).derivatives(), rho))
            for leg in (slice_map.f, slice_map.g)
        )
        return cls(slice_map, pose, f, g)

    def squared_lengths(self) -> tuple[R, R]:
        """f and g themselves (scaled units)."""

        def square(leg: Leg, jet: Jet[R]) -> R:
            constant = leg.platform2 + leg.base2
            return self.pose.length * self.pose.length + jet.value * 2 + constant  # type: ignore[no-any-return]

        return square(self.slice_map.f, self.f), square(self.slice_map.g, self.g)

    def singularity(self) -> Jet[R]:
        """J = f_α g_θ − f_θ g_α, zero at singular poses."""
        j: Jet[R] = cross(self.f.gradient, self.g.gradient)
        return j

    def along(self, leg: Jet[R], function: Jet[R]) -> Jet[R]:
        """v·∇function, with v = (−leg_θ, leg_α) tangent to the curve on which ``leg`` is constant."""
        slope: Jet[R] = cross(leg.gradient, function.gradient)
        return slope


def _scaled(derivatives: Derivatives, rho: int) -> Derivatives:
    """Those by √ρ times the angles' ones: the real parts of 1, j, j², …, are 1, 0, −ρ, 0, ρ², …, times one of
    1, and the imaginary parts in √ρ."""
    if rho == 1:
        return derivatives
    return lambda i, j: derivatives(i, j) * rho ** ((i + j + 1) // 2)


@dataclass(frozen=True)
class HalfTangent:
    """tan(angle/2) = numerator / denominator as balls; the denominator is 0 at 180°."""

    numerator: arb
    denominator: arb

    def cos_sin(self) -> tuple[arb, arb]:
        """Cosine and sine of the angle."""
        n, d = self.numerator, self.denominator
        nn, dd = n * n, d * d
        norm = nn + dd
        return (dd - nn) / norm, 2 * n * d / norm

    def degrees(self, offset: int = 0) -> arb:
        """The angle in degrees, in (−180, 180] for the exact value; ``offset`` is 0 or 180."""
        n, d = self.numerator, self.denominator
        if abs(n) < abs(d):
            return (n / d).atan() * 360 / arb.pi() + offset
        side = -180 if n * d < 0 else 180
        return side - (d / n).atan() * 360 / arb.pi() + offset


def whole_angle(half_tangent: Fraction, unit: float = 1.0) -> float:
    """The angle in radians, about; half a turn where the tangent is beyond the range of floats.

    The tangent is measured in 1 over a unit, √ρ.
    """
    try:
        return 2 * atan(unit * half_tangent)
    except OverflowError:
        return pi if half_tangent > 0 else -pi


def direction(x: arb, y: arb) -> arb:
    """The angle of (x, y) in degrees; a ball that meets the negative x-axis has a valid but wide result."""
    return arb.atan2(y, x) * 180 / arb.pi()


def pose_of(alpha: HalfTangent, theta: HalfTangent, length: arb, omega: arb) -> Pose[arb]:
    """The pose with these angles of a slice (scaled units)."""
    (cos_a, sin_a), (cos_t, sin_t) = alpha.cos_sin(), theta.cos_sin()
    return Pose(cos_a, sin_a, cos_t, sin_t, length, omega)


def singular_length(
    slice_map: SliceMap, alpha: tuple[arb, arb], direction: tuple[arb, arb], omega: arb
) -> arb:
    """L = −J0/J1, at which the pose with these cosines and sines is singular: J is L (J0 + L J1)."""
    at = turns(acb(*alpha), acb(*direction))
    f, g = (leg.waves(omega).turned(*at) for leg in (slice_map.f, slice_map.g))
    phi, other = f.q + f.d, g.q + g.d
    length: arb = (f.w * other - phi * g.w) / (f.q * other - phi * g.q)
    return length


def common_root(j: Sequence[arb], e: Sequence[arb]) -> HalfTangent | None:
    """The common root t of two forms that share exactly one; None if the precision is insufficient."""
    found = _by_remainders(j, e) or _finite_common_root(j, e)
    return found or _inverse(_finite_common_root(j[::-1], e[::-1]))


def _by_remainders(j: Sequence[arb], e: Sequence[arb]) -> HalfTangent | None:
    """From the last remainder but one of Euclid's algorithm, if it has degree 1; else None.

    The forms have no common root at infinity if a leading coefficient is not 0.
    """
    longer, shorter = (j, e) if len(j) >= len(e) else (e, j)
    first, second, degree = arb_poly(list(longer)), arb_poly(list(shorter)), len(shorter) - 1
    while degree >= 1:
        lead = second[degree]
        if not lead.is_finite() or lead.contains(0):
            return None
        if degree == 1:
            return HalfTangent(-second[0], lead)
        first, second, degree = second, first % second, degree - 1
    return None


def _finite_common_root(j: Sequence[arb], e: Sequence[arb]) -> HalfTangent | None:
    """t = −s0/s1 from the first subresultant s1 t + s0, if s1 ≠ 0 is proved."""
    size = len(j) + len(e) - 4
    full = sylvester(j, e, arb(0))
    # t^(n−2)J … J, t^(m−2)E … E: one row less of each, and the columns t^(m+n−2) … 1
    rows = [row[1:] for i, row in enumerate(full) if i not in (0, len(e) - 1)]
    s1 = arb_mat([row[:size] for row in rows]).det()
    s0 = arb_mat([[*row[: size - 1], row[size]] for row in rows]).det()
    return None if s1.contains(0) else HalfTangent(-s0, s1)


def _inverse(t: HalfTangent | None) -> HalfTangent | None:
    return HalfTangent(t.denominator, t.numerator) if t else None
