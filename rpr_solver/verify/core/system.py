"""The equations of all slices and of one, derived by SymPy from the legs: no formula of the solver is used.

With leg i of length L in the direction θ, B_i = A_i + L (cos θ, sin θ), and every other corner of the
platform is B_k = B_i + R(α) (b_k − b_i). The free legs have the squared lengths f and g. From these two
SymPy differentiates

    J = f_α g_θ − f_θ g_α,    E = v·∇J  with  v = (−f_θ, f_α)  or  (−g_θ, g_α),    W = v·∇E:

J = 0 where two poses coalesce, E = 0 (v spans the kernel of the map's derivative there) where three do.
All lengths are multiplied by ``unit``, which makes the corners integers and integer multiples of ω.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import comb, gcd, lcm
from typing import Any, Generic, TypeVar

from rpr_solver.verify.core.numbers import Geometry
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.core.surds import ZERO, Poly, Ring, Surd, rational, trimmed

Monomial = tuple[int, int, int, int]
"""Exponents of cos α, sin α (0 or 1), cos θ, sin θ (0 or 1)."""

Trig = Mapping[Monomial, Surd]
"""A trigonometric polynomial in α and θ, in normal form: sin² is replaced by 1 − cos²."""

Graded = tuple[Trig, ...]
"""A trigonometric polynomial in α and θ by the powers of the scaled length of the fixed leg."""

Form = TypeVar("Form")
Other = TypeVar("Other")


@dataclass(frozen=True)
class Leg(Generic[Form]):
    """A free leg with its squared length, and what follows from it along its kernel vector v."""

    number: int
    squared: Form
    alpha: Form
    theta: Form
    """The derivatives of the squared length."""
    kernel: Form
    """E = v·∇J."""
    kernel2: Form
    """v·∇E."""

    def mapped(self, change: Callable[[Form], Other]) -> Leg[Other]:
        """The same leg with other forms."""
        forms = (self.squared, self.alpha, self.theta, self.kernel, self.kernel2)
        return Leg(self.number, *map(change, forms))


@dataclass(frozen=True)
class Surface:
    """All slices of a manipulator and one fixed leg at once; the equations are derived when first needed."""

    geometry: Geometry
    fixed: int

    @cached_property
    def _symbols(self) -> Variables:
        return variables(self.geometry)

    @property
    def unit(self) -> int:
        """What makes all lengths integers."""
        return self._symbols.unit

    @cached_property
    def ring(self) -> Ring:
        """The ring of the coefficients."""
        return Ring(self._symbols.radicand)

    @cached_property
    def _forms(self) -> tuple[Graded, Leg[Graded], Leg[Graded]]:
        spend(50_000, 8 * self.geometry.bits)
        singular, *legs = derive(self._symbols, self.geometry, self.fixed)
        first, second = (
            Leg(number, *(graded(self._symbols, part) for part in leg))
            for number, leg in zip(self.free, legs, strict=True)
        )
        return graded(self._symbols, singular[0]), first, second

    @property
    def free(self) -> tuple[int, int]:
        """The numbers of the free legs."""
        return self.geometry.free_legs(self.fixed)

    @property
    def singular(self) -> Graded:
        """J / L, without its content."""
        return self._forms[0]

    @property
    def legs(self) -> tuple[Leg[Graded], Leg[Graded]]:
        """The free legs."""
        return self._forms[1:]

    @property
    def coefficient_bits(self) -> int:
        """The size of the largest coefficient of J and E."""
        return longest(*self.singular, *(row for leg in self.legs for row in leg.kernel))

    @cached_property
    def slopes(self) -> tuple[Graded, Graded]:
        """The derivatives of J in α and θ."""
        return gradient(self.singular)[:2]

    def at(self, length: Fraction) -> System:
        """The slice of a length."""
        scaled = length * self.unit

        def here(p: Graded, degree: int | None = None) -> Trig:
            return at_length(p, scaled, degree)

        first, second = (replace(leg.mapped(here), squared=here(leg.squared, 2)) for leg in self.legs)
        return System(self, length, self.unit * scaled.denominator, (first, second), here(self.singular))


def at_length(p: Graded, scaled: Fraction, degree: int | None = None) -> Trig:
    """A positive multiple of a polynomial at a scaled length: by the length's denominator to the degree."""
    n, d = scaled.as_integer_ratio()
    result: dict[Monomial, Surd] = {}
    top = len(p) - 1 if degree is None else degree
    for k, row in enumerate(p):
        factor = n**k * d ** (top - k)
        for key, (a, b) in row.items():
            x, y = result.get(key, ZERO)
            result[key] = (x + a * factor, y + b * factor)
    return {key: x for key, x in result.items() if x != ZERO}


@dataclass(frozen=True)
class System:
    """A slice: the manipulator with one leg of a given length; forms are right but for positive factors.

    Squared lengths are those of lengths in ``unit``.
    """

    surface: Surface
    length: Fraction
    unit: int
    legs: tuple[Leg[Trig], Leg[Trig]]
    singular: Trig

    @classmethod
    def of(cls, geometry: Geometry, fixed: int, length: Fraction) -> System:
        """The equations of one slice."""
        return Surface(geometry, fixed).at(length)

    @property
    def fixed(self) -> int:
        """The fixed leg."""
        return self.surface.fixed

    @property
    def ring(self) -> Ring:
        """The ring of the coefficients."""
        return self.surface.ring

    @cached_property
    def along(self) -> Poly:
        """The quadratic in u = tan(θ/2) of a fixed leg along the base line to the first free leg."""
        ax, ay = self.base_side(self.legs[0].number)
        return rational([ay, -2 * ax, -ay])

    @cached_property
    def closed(self) -> Poly:
        """The quadratic in u of the poses with the first free leg closed."""
        return trimmed(self.closed_lines(self.legs[0].number))

    def closed_lines(self, leg: int) -> Poly:
        """The form in u of |L e(θ) − a|² = |m|², a free leg having length 0, of formal degree 2."""
        ax, ay = self.base_side(leg)
        length = int(self.length * self.unit)
        side = self.surface.geometry.side_squared(self.fixed, leg)
        even = length**2 + ax**2 + ay**2 - int(side * self.unit**2)
        return (even - 2 * length * ax, 0), (-4 * length * ay, 0), (even + 2 * length * ax, 0)

    def base_side(self, leg: int) -> tuple[int, int]:
        """From the base of the fixed leg to that of another, in the unit of the slice."""
        here, there = (self.surface.geometry.base[k - 1] for k in (self.fixed, leg))
        x, y = (int((b - a) * self.unit) for a, b in zip(here, there, strict=True))
        return x, y


@dataclass(frozen=True)
class Variables:
    """SymPy's polynomial ring in the cosines and sines of two angles, ω and a length, with the corners."""

    alpha: tuple[Any, Any]
    theta: tuple[Any, Any]
    omega: Any
    length: Any
    unit: int
    radicand: int
    base: tuple[tuple[int, int], ...]
    platform: tuple[tuple[Any, Any], ...]


def variables(geometry: Geometry, squares: Iterable[Fraction] = ()) -> Variables:
    """The ring, with a unit that makes the corners, and given squares of lengths, integral."""
    from sympy.polys.domains.pythonintegerring import PythonIntegerRing
    from sympy.polys.rings import ring

    factor, radicand = geometry.height
    numbers = (geometry.a2x, geometry.a3x, geometry.a3y, geometry.d1, geometry.foot, factor)
    unit = lcm(*(x.denominator for x in (*numbers, *squares)))
    # Python's own integers, whatever else is installed
    polynomials, ca, sa, ct, st, w, ell = ring("ca, sa, ct, st, w, ell", PythonIntegerRing())
    omega = polynomials(1) if radicand == 1 else w
    platform = (
        (polynomials(0), polynomials(0)),
        (polynomials(int(geometry.d1 * unit)), polynomials(0)),
        (polynomials(int(geometry.foot * unit)), int(factor * unit) * omega),
    )
    base = tuple((int(x * unit), int(y * unit)) for x, y in geometry.base)
    return Variables((ca, sa), (ct, st), w, ell, unit, radicand, base, platform)


def _reduced(symbols: Variables, p: Any) -> Any:
    """The normal form, in which sin² is 1 − cos² and ω² the radicand."""
    result: dict[tuple[int, ...], int] = {}
    for (i, j, k, m, n, power), c in p.terms():
        c *= symbols.radicand ** (n // 2)
        for a, x in enumerate(_alternating(j // 2)):
            for b, y in enumerate(_alternating(m // 2)):
                key = (i + 2 * a, j % 2, k + 2 * b, m % 2, n % 2, power)
                result[key] = result.get(key, 0) + c * x * y
    return symbols.omega.ring.from_dict({key: c for key, c in result.items() if c})


def _alternating(power: int) -> list[int]:
    """The coefficients of (1 − x)^power."""
    return [(-1) ** k * comb(power, k) for k in range(power + 1)]


def normal_form(symbols: Variables, p: Any) -> Trig:
    """A polynomial of SymPy without the length, in normal form."""
    [trig] = graded(symbols, p)
    return trig


def graded(symbols: Variables, p: Any) -> tuple[Trig, ...]:
    """A polynomial of SymPy in normal form, by the powers of the length."""
    result: dict[int, dict[Monomial, Surd]] = {0: {}}
    for (i, j, k, m, n, power), c in _reduced(symbols, p).terms():
        row = result.setdefault(power, {})
        a, b = row.get((i, j, k, m), ZERO)
        row[i, j, k, m] = (a, b + int(c)) if n else (a + int(c), b)
    return tuple(result.get(power, {}) for power in range(max(result) + 1))


def derive(symbols: Variables, geometry: Geometry, fixed: int) -> tuple[tuple[Any, ...], ...]:
    """Derives the equations from the legs, for SymPy: J / L, and for each free leg what :class:`Leg` has."""
    (ca, sa), (ct, st), length = symbols.alpha, symbols.theta, symbols.length

    def normal(p: Any) -> Any:
        return _reduced(symbols, p)

    def d_alpha(p: Any) -> Any:
        return p.diff(sa) * ca - p.diff(ca) * sa

    def d_theta(p: Any) -> Any:
        return p.diff(st) * ct - p.diff(ct) * st

    def squared(leg: int) -> Any:
        (bx, by), (ox, oy) = symbols.platform[leg - 1], symbols.platform[fixed - 1]
        (ax, ay), (px, py) = symbols.base[leg - 1], symbols.base[fixed - 1]
        mx, my = bx - ox, by - oy
        x = px + length * ct + ca * mx - sa * my - ax
        y = py + length * st + sa * mx + ca * my - ay
        return normal(x**2 + y**2)

    first, second = geometry.free_legs(fixed)
    f, g = squared(first), squared(second)
    singular = normal(d_alpha(f) * d_theta(g) - d_theta(f) * d_alpha(g))
    content = gcd(*(int(c) for c in singular.coeffs())) or 1
    singular = singular.quo_ground(content).quo(length)  # the derivatives in θ hold it

    def leg_of(p: Any) -> tuple[Any, ...]:
        slopes = d_alpha(p), d_theta(p)

        def along(q: Any) -> Any:
            return normal(slopes[0] * d_theta(q) - slopes[1] * d_alpha(q))

        kernel = along(singular)
        return (p, *slopes, kernel, along(kernel))

    return (singular,), leg_of(f), leg_of(g)


def derivative(p: Trig, *, theta: bool) -> Trig:
    """∂/∂θ or ∂/∂α of a trigonometric polynomial in normal form."""
    result: dict[Monomial, Surd] = {}

    def add(cos: int, sin: int, other: tuple[int, int], x: Surd, times: int) -> None:
        key = (*other, cos, sin) if theta else (cos, sin, *other)
        a, b = result.get(key, ZERO)
        result[key] = (a + times * x[0], b + times * x[1])

    for (i, j, k, m), x in p.items():
        cos, sin, other = (k, m, (i, j)) if theta else (i, j, (k, m))
        if sin:
            # (cosⁿ sin)′ = cosⁿ⁺¹ − n cosⁿ⁻¹ sin² = (n + 1) cosⁿ⁺¹ − n cosⁿ⁻¹
            add(cos + 1, 0, other, x, cos + 1)
            if cos:
                add(cos - 1, 0, other, x, -cos)
        elif cos:
            add(cos - 1, 1, other, x, -cos)
    return {key: x for key, x in result.items() if x != ZERO}


def longest(*forms: Trig) -> int:
    """The bits of the longest coefficient."""
    return max((part.bit_length() for p in forms for x in p.values() for part in x), default=0)


def slope(p: Graded, *, theta: bool) -> Graded:
    """The derivative of each row."""
    return tuple(derivative(row, theta=theta) for row in p)


def gradient(p: Graded) -> tuple[Graded, Graded, Graded]:
    """The derivatives in α, in θ and in the length."""
    in_length = tuple(multiple(row, k) for k, row in enumerate(p) if k) or ({},)
    return slope(p, theta=False), slope(p, theta=True), in_length


def multiple(p: Trig, factor: int) -> Trig:
    """An integer multiple."""
    return {key: (a * factor, b * factor) for key, (a, b) in p.items()}


def less(squared: Graded, square: Fraction) -> Graded:
    """A multiple of a squared length less a number."""
    one: Monomial = (0, 0, 0, 0)
    n, d = square.as_integer_ratio()
    rows = [multiple(row, d) for row in squared]
    a, b = rows[0].get(one, ZERO)
    return ({**rows[0], one: (a - n, b)}, *rows[1:])


def at_half_tangent(p: Trig, degree: int, n: int, d: int = 1) -> tuple[Surd, ...]:
    """The coefficients in t = tan(α/2), 2 · degree + 1, of a polynomial of this degree in α and in θ, at
    tan(θ/2) = n/d, which may be ∞.

    They are multiplied by (n² + d²)^degree.
    """
    cos, sin, one = d * d - n * n, 2 * n * d, d * d + n * n
    return in_half_tangent(p, degree, lambda k, m: cos**k * sin**m * one ** (degree - k - m))


def in_half_tangent(p: Trig, degree: int, weight: Any) -> tuple[Surd, ...]:
    """Σ weight(k, m) · x · cosⁱα sinʲα as a polynomial in t, times (1 + t²)^degree."""
    rows: dict[tuple[int, int], Surd] = {}
    for (i, j, k, m), (a, b) in p.items():
        value = weight(k, m)
        c, e = rows.get((i, j), ZERO)
        rows[i, j] = (c + a * value, e + b * value)
    result = [ZERO] * (2 * degree + 1)
    for (i, j), (a, b) in rows.items():
        for power, factor in enumerate(half_angle_form(i, j, degree)):
            if factor:
                result[power] = (result[power][0] + a * factor, result[power][1] + b * factor)
    return tuple(result)


def half_angle_form(cos: int, sin: int, degree: int) -> list[int]:
    """(1 − t²)^cos (2 t)^sin (1 + t²)^(degree − cos − sin), by powers of t."""
    result = [1]
    for factor, times in (([1, 0, -1], cos), ([0, 2], sin), ([1, 0, 1], degree - cos - sin)):
        for _ in range(times):
            grown = [0] * (len(result) + len(factor) - 1)
            for i, x in enumerate(result):
                for k, y in enumerate(factor, i):
                    grown[k] += x * y
            result = grown
    return result
