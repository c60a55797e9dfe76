"""Exact coordinates of both triangles of a manipulator, with y measured in √ρ, over one quadratic field.

Up to a turn, a triangle with the squared sides a, b, c is a₀ (0, 1, τ) in the complex plane, where |a₀|² = a
and

    τ = (a + c − b ± √−H) / (2 a).

Let H be a square times ρ, and j² = −ρ. If a₀ = x + y j with rational x and y, which is x² + ρ y² = a, all
corners are x + y j with rational x and y: the *frame* of the triangle. There is one along each rational side.
If base and platform have frames with ρ and r, then j √(r/ρ) takes the place of √−r, and all coordinates lie
in ℚ(ω), ω = √(ρ r): so do those of a platform in the frame of the base. Otherwise a₀ is sought in ℚ(ω, j),
and where ω is rational, ω may be chosen (mathematics.md#frames, mathematics.md#one-field). What becomes of
turns, half tangents and the equations is in mathematics.md#the-norm-form.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from math import gcd, lcm
from typing import TypeAlias

from rpr_solver.errors import InputError
from rpr_solver.exact.quadratic import QuadraticNumber
from rpr_solver.exact.rationals import rational_sqrt
from rpr_solver.triangles.geometry import Geometry
from rpr_solver.triangles.norms import (
    FACTORED_BITS,
    SquareClass,
    TooLargeToFactor,
    norm_equation,
    point_over,
    ramified,
    split_square,
    splits,
    without_squares,
)
from rpr_solver.triangles.surds import Surd
from rpr_solver.triangles.triangle import Triangle

Rational2: TypeAlias = tuple[Fraction, Fraction]


@dataclass(frozen=True)
class Corner:
    """x + y √−ρ."""

    x: QuadraticNumber[Fraction]
    y: QuadraticNumber[Fraction]
    rho: int

    def __mul__(self, other: Corner) -> Corner:
        """The product of complex numbers."""
        real = self.x * other.x - self.y * other.y * self.rho
        return Corner(real, self.x * other.y + self.y * other.x, self.rho)

    def __neg__(self) -> Corner:
        return Corner(-self.x, -self.y, self.rho)

    @property
    def conjugate(self) -> Corner:
        """x − y √−ρ."""
        return Corner(self.x, -self.y, self.rho)

    @property
    def norm(self) -> QuadraticNumber[Fraction]:
        """x² + ρ y², the squared distance from 0."""
        return self.x * self.x + self.y * self.y * self.rho


@dataclass(frozen=True)
class CommonFrame:
    """Base and platform in one plane over one field, corner 1 of each at 0.

    With y measured in √ρ a turn is (c, s) with c² + ρ s² = 1. The pose of the article's angles α and θ has
    the turns z = (c, s) of the platform and e of the fixed leg with α = arg(z m₀ / a₀) and θ = arg(e / a₀),
    where a₀ and m₀ are the *axes*: the directions of the article's x-axis and of B1B2.

    Attributes:
        rho: ρ, a positive integer.
        radicand: ω², a positive integer; 1 if all coordinates are rational.
        base, platform: corners 1, 2 and 3, in the user's unit of length.
        axes: of the base and of the platform, not 0.
    """

    rho: int
    radicand: int
    base: tuple[Corner, Corner, Corner]
    platform: tuple[Corner, Corner, Corner]
    axes: tuple[Corner, Corner]

    @classmethod
    def of(cls, geometry: Geometry) -> CommonFrame:
        """The frame of a geometry; that of its canonical form, unless numbers are too large to factor.

        Raises:
            InputError: naming ``geometry.base`` or ``geometry.platform``: no frame of its sides is found, or
                base and platform have none over one quadratic field.

        >>> from rpr_solver.triangles.geometry import read_geometry
        >>> platform = {"sides": [6, 7, 5]}
        >>> frame = CommonFrame.of(read_geometry({"base": {"equilateral": 10}, "platform": platform}))
        >>> frame.rho, frame.radicand, frame.base[2].y.a, frame.platform[2].y.b
        (3, 2, Fraction(5, 1), Fraction(2, 1))
        """
        base, platform = geometry.base, geometry.platform
        rho, radicand, first, second = _own_frames(geometry) or _over_a_field(geometry)
        sign = -1 if geometry.half_turn else 1
        corners = [_corners(first, base, rho, radicand, sign), _corners(second, platform, rho, radicand)]
        return cls(rho, radicand, corners[0], corners[1], (first, second))


def _corners(
    axis: Corner, triangle: Triangle, rho: int, radicand: int, sign: int = 1
) -> tuple[Corner, Corner, Corner]:
    """0, a₀ and a₀ τ; where corners 1 and 2 are one, 0, 0 and a₀."""
    x, y = triangle.corner3
    zero, height = _rational(Fraction(0), radicand), in_unit(y, rho, radicand)
    length = axis.x.a
    if axis == Corner(_rational(length, radicand), zero, rho):
        third = Corner(_rational(x * length, radicand), height * length, rho)
    else:
        third = axis * Corner(_rational(x, radicand), height, rho)
    origin = Corner(zero, zero, rho)
    second = axis if triangle.squares[0] else origin
    return (origin, second, third) if sign > 0 else (origin, -second, -third)


def in_unit(y: Surd, rho: int, radicand: int) -> QuadraticNumber[Fraction]:
    """y / √ρ in ℚ(ω).

    Raises:
        ValueError: it is not in this field.
    """
    square = y.square / rho
    if (root := rational_sqrt(square)) is not None:
        return QuadraticNumber(y.sign * root, Fraction(0), radicand)
    if (root := rational_sqrt(square / radicand)) is not None:
        return QuadraticNumber(Fraction(0), y.sign * root, radicand)
    raise ValueError(f"{y} is no multiple of √{rho} or √{rho * radicand}")


@dataclass(frozen=True)
class Axis:
    """The axis a₀ = x + y √−ρ of a triangle in a frame of its own."""

    rho: int
    x: Fraction
    y: Fraction


def own_axis(triangle: Triangle, rho: int) -> Axis | None:
    """The frame of a triangle along its first rational side, or by the norm equation, or that of its points.

    A flat triangle has one along its sides, on the x-axis (ρ = 1) or on the y-axis.

    Args:
        triangle: of the class ``rho`` (:func:`class_of`).
        rho: ρ; not used for a flat triangle.

    Raises:
        TooLargeToFactor: the norm equation has too large numbers, and there are no points with such
            coordinates.
    """
    square = triangle.axis2
    if not triangle.area16:
        if (root := rational_sqrt(square)) is not None:
            return Axis(1, root, Fraction(0))
        free = without_squares(square.numerator * square.denominator)
        return Axis(free, Fraction(0), in_unit(Surd.root(square), free, 1).a)
    if (length := triangle.sides[0].rational) is not None:
        return Axis(rho, length, Fraction(0))
    x, height = triangle.corner3
    y = in_unit(height, rho, 1).a
    # the directions of the sides 23 and 31, where corner 2 is 1
    for side, (u, v) in zip(triangle.sides[1:], ((x - 1, y), (x, y)), strict=True):
        if (length := side.rational) is not None:
            norm = u * u + rho * v * v
            return Axis(rho, length * u / norm, -length * v / norm)
    try:
        solution = norm_equation(rho, square)
    except TooLargeToFactor:
        if (given := _given_axis(triangle, rho)) is None:
            raise
        return given
    return None if solution is None else Axis(rho, *solution)


def class_of(triangle: Triangle, *, plain: bool = False) -> int:
    """ρ of a triangle, H being a square times ρ; 1 if it is flat.

    ``plain`` leaves squares of large primes in ρ.
    """
    if not triangle.area16:
        return 1
    # times a square that makes H an integer; that of rational sides is the fourth power of their denominator
    unit = lcm(*(square.denominator for square in triangle.squares))
    integer = int(triangle.area16 * unit**2)
    return split_square(integer)[1] if plain else without_squares(integer)


def _given_axis(triangle: Triangle, rho: int) -> Axis | None:
    """The frame of the points of a triangle, if one coordinate is rational and the other a multiple of √ρ."""
    if triangle.points is None:
        return None
    (x, y), (u, v), _ = triangle.points
    across, along = _difference(u, x), _difference(v, y)
    if across is None or along is None:
        return None
    for first, second in ((across, along), (along, -across)):
        root = rational_sqrt(second.square / rho)
        if first.rational is not None and root is not None:
            return Axis(rho, first.rational, second.sign * root)
    return None


def points_needed(geometry: Geometry) -> dict[str, list[list[str]]]:
    """The points of the triangles whose coordinates are perhaps not found from their sides alone.

    These are triangles without a rational side whose numbers are too large to factor; whoever keeps the
    canonical form of a geometry keeps these points beside it (:meth:`Geometry.with_points`).
    """
    triangles = {"base": geometry.base, "platform": geometry.platform}
    return {name: geometry.points_of(name) for name, own in triangles.items() if _needs_points(own)}


def _needs_points(triangle: Triangle) -> bool:
    if triangle.points is None or any(side.rational is not None for side in triangle.sides):
        return False
    numbers = (triangle.axis2, triangle.area16)
    return any(max(x.numerator, x.denominator).bit_length() > FACTORED_BITS for x in numbers)


def _difference(x: Surd, y: Surd) -> Surd | None:
    """x − y, if it is a surd."""
    if not x or not y:
        return x if x else -y
    product = (x * y).rational
    return None if product is None else x * (1 - product / x.square)


_Axes: TypeAlias = tuple[int, int, Corner, Corner]
"""ρ, ω², a₀ and m₀."""


def _own_frames(geometry: Geometry) -> _Axes | None:
    """From frames of their own, if both triangles have one.

    Where all lengths are rational, ρ = 1 and ω² is as in all versions.
    """
    base, platform = geometry.base, geometry.platform
    classes = class_of(base), class_of(platform, plain=geometry.is_rational)
    axes = [_axis_or_refused(*args) for args in zip((base, platform), classes, _NAMES, strict=True)]
    first, second = axes
    if first is None or second is None:
        return None
    is_on_axis = not platform.area16 and not second.y
    radicand = 1 if is_on_axis else product_class(first.rho, second.rho)
    height = in_unit(Surd.root(second.y**2 * second.rho, 1 if second.y > 0 else -1), first.rho, radicand)
    a0 = Corner(_rational(first.x, radicand), _rational(first.y, radicand), first.rho)
    return first.rho, radicand, a0, Corner(_rational(second.x, radicand), height, first.rho)


_NAMES = ("base", "platform")


def _rational(x: Fraction, radicand: int) -> QuadraticNumber[Fraction]:
    return QuadraticNumber(x, Fraction(0), radicand)


def product_class(rho: int, r: int) -> int:
    """ω² of two triangles: ρ r without squares."""
    common = gcd(rho, r)
    return split_square(rho // common * (r // common))[1]


def _axis_or_refused(triangle: Triangle, rho: int, name: str) -> Axis | None:
    try:
        return own_axis(triangle, rho)
    except TooLargeToFactor:
        message = (
            "no side is rational, and its coordinates are not found, since numbers of more than "
            f"{FACTORED_BITS} bits are not factored; give points, with x rational and y in multiples of one "
            "root"
        )
        raise InputError.of(f"geometry.{name}", message) from None


def _over_a_field(geometry: Geometry) -> _Axes:
    """a₀ and m₀ in ℚ(ω, √−ρ), where a triangle has no frame of its own.

    Two triangles that are not flat decide ω. If it is rational, or one triangle is flat, ω may be any root
    over which no ramified prime is left.
    """
    base, platform = geometry.base, geometry.platform
    rho, r = class_of(base), class_of(platform)
    radicand = product_class(rho, r) if base.area16 and platform.area16 else 1
    if not base.area16:
        rho = r
    squares = base.axis2, platform.axis2
    try:
        own, first, second = SquareClass.of(rho), SquareClass.of(squares[0]), SquareClass.of(squares[1])
        bad = ramified(own, first) | ramified(own, second)
        for omega2 in [radicand] if radicand > 1 else _radicands(first, second):
            if not splits(bad, omega2):
                continue
            points = [point_over(rho, omega2, square) for square in squares]
            if points[0] is not None and points[1] is not None:
                return rho, omega2, _corner(points[0], rho, omega2), _corner(points[1], rho, omega2)
    except TooLargeToFactor:
        pass
    raise _refused(geometry, radicand)


_LARGEST_RADICAND = 200


def _radicands(first: SquareClass, second: SquareClass) -> Iterator[int]:
    """Radicands to try: those of the sides 12, then small ones."""
    likely = (first.free, second.free, product_class(first.free, second.free))
    yield from (
        n for n in dict.fromkeys((*likely, *range(2, _LARGEST_RADICAND))) if without_squares(n) == n > 1
    )


def _corner(point: tuple[Rational2, Rational2], rho: int, radicand: int) -> Corner:
    x, y = (QuadraticNumber(*part, radicand) for part in point)
    return Corner(x, y, rho)


def _refused(geometry: Geometry, radicand: int) -> InputError:
    triangles = zip(_NAMES, (geometry.base, geometry.platform), strict=True)
    alone = next(name for name, triangle in triangles if own_axis(triangle, class_of(triangle)) is None)
    needed = "" if radicand == 1 else f" beside sqrt({radicand}), which the shapes of base and platform need"
    message = (
        f"has no coordinates without a second root{needed}; two roots at once are not supported: give a "
        f"{alone} with a rational side"
    )
    return InputError.of(f"geometry.{alone}", message)
