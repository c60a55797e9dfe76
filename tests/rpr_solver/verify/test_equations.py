"""The equations are those that SymPy derives from the lengths of the legs, and so are their derivatives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from flint import acb, arb, ctx
from hypothesis import assume, given
from hypothesis import strategies as st
from sympy.polys.domains import QQ
from sympy.polys.rings import ring

from rpr_solver.boxes import Balls
from rpr_solver.verify.equations import (
    ALPHA,
    THETA,
    Closing,
    Lengths,
    Mechanism,
    Slice,
    singular_of,
    slope,
    square_of,
)
from rpr_solver.verify.geometry import Geometry

RING, CA, SA, CT, ST, L, *COORDINATES = ring("ca,sa,ct,st,L,px,py,ax,ay,bx,by,ox,oy,mx,my,nx,ny", QQ)


def normal(p: Any) -> Any:
    """With sin² = 1 − cos², so that functions that are equal are one polynomial."""
    for cos, sin in ((CA, SA), (CT, ST)):
        place = RING.gens.index(sin)
        result, square = RING(0), 1 - cos**2
        for key, c in p.terms():
            power = key[place]
            rest = RING({(*key[:place], power % 2, *key[place + 1 :]): c})
            result += rest * square ** (power // 2)
        p = result
    return p


def d(p: Any, variable: int) -> Any:
    """The derivative in α or θ."""
    cos, sin = ((CA, SA), (CT, ST))[variable]
    return normal(p.diff(sin) * cos - p.diff(cos) * sin)


@dataclass(frozen=True)
class Complex:
    """A complex number with indeterminate coordinates, in place of FLINT's."""

    real: Any
    imag: Any

    def __add__(self, other: Complex | acb) -> Complex:
        x = _complex(other)
        return Complex(self.real + x.real, self.imag + x.imag)

    def __sub__(self, other: Complex) -> Complex:
        return Complex(self.real - other.real, self.imag - other.imag)

    def __mul__(self, other: Complex | acb | int) -> Complex:
        x = _complex(other)
        return Complex(self.real * x.real - self.imag * x.imag, self.real * x.imag + self.imag * x.real)

    __radd__, __rmul__ = __add__, __mul__

    def conjugate(self) -> Complex:
        return Complex(self.real, -self.imag)


def _complex(x: Complex | acb | int) -> Complex:
    if isinstance(x, Complex):
        return x
    if isinstance(x, int):
        return Complex(RING(x), RING(0))
    parts = (Fraction(float(x.real.mid())), Fraction(float(x.imag.mid())))
    return Complex(*(RING(QQ(y.numerator, y.denominator)) for y in parts))


def value(waves: Mapping[tuple[int, int], Any]) -> Any:
    """Σ Re(c exp(i (j α + k θ)))."""
    total = RING(0)
    for exponents, c in waves.items():
        turn = _complex(1)
        for power, unit in zip(exponents, (Complex(CA, SA), Complex(CT, ST)), strict=True):
            for _ in range(abs(power)):
                turn = turn * (unit if power > 0 else unit.conjugate())
        total += (_complex(c) * turn).real
    return normal(total)


def squared(base: tuple[Any, Any], corner: tuple[Any, Any]) -> Any:
    """|B − A|² of a free leg, B being B1 + R(α) (b − o), and B1 on the fixed leg that begins at p."""
    px, py, *_ = COORDINATES
    ox, oy = COORDINATES[6:8]
    x, y = corner[0] - ox, corner[1] - oy
    bx, by = px + L * CT + CA * x - SA * y, py + L * ST + SA * x + CA * y
    return normal((bx - base[0]) ** 2 + (by - base[1]) ** 2)


def test_sums_of_waves_are_what_sympy_derives_from_the_legs() -> None:
    px, py, ax, ay, bx, by, ox, oy, mx, my, nx, ny = COORDINATES
    bases, corners = ((ax, ay), (bx, by)), ((mx, my), (nx, ny))
    p, o = Complex(px, py), Complex(ox, oy)
    f, g = (squared(base, corner) for base, corner in zip(bases, corners, strict=True))
    forms = []
    for base, corner, own in zip(bases, corners, (f, g), strict=True):
        a, m = Complex(*base) - p, Complex(*corner) - o
        form = square_of(a, m)  # type: ignore[arg-type]
        constant = (a * a.conjugate() + m * m.conjugate()).real
        assert normal(constant + L**2 + value(form.still) + L * value(form.moving)) == own
        for variable in (ALPHA, THETA):
            slopes = value(slope(form.still, variable)) + L * value(slope(form.moving, variable))
            assert slopes == d(own, variable)
        assert not slope(form.still, THETA)
        forms.append(form)
    singular = singular_of(*forms)
    found = L * (value(singular.still) + L * value(singular.moving))
    assert normal(d(f, ALPHA) * d(g, THETA) - d(f, THETA) * d(g, ALPHA)) == normal(found)


GEOMETRIES = st.tuples(
    *[st.fractions(-9, 9, max_denominator=9)] * 3, *[st.fractions(5, 9, max_denominator=9)] * 3, st.booleans()
).filter(lambda x: x[0] != 0 and (x[1], x[2]) not in ((0, 0), (x[0], 0)))
POINTS = st.tuples(st.floats(0, 6), st.floats(0, 6), st.floats(0.1, 1))


def geometry_of(*numbers: Any) -> Geometry:
    """From six numbers and whether the platform is clockwise."""
    return Geometry.of_lengths(numbers[:-1], clockwise=numbers[-1])


@given(numbers=GEOMETRIES, point=POINTS, fixed=st.integers(1, 3))
def test_a_slice_is_that_of_all_lengths(numbers: Any, point: tuple[float, float, float], fixed: int) -> None:
    mechanism = Mechanism(geometry_of(*numbers), fixed)
    alpha, theta, t = point
    length = Fraction(t) * Fraction(2) ** mechanism.geometry.size
    own = Slice(mechanism, length).on([arb(alpha), arb(theta)], 3)
    all_lengths = Lengths(mechanism).on([arb(alpha), arb(theta), arb(t)], 3)
    for leg in mechanism.free:
        first, second = own.along(own.singular, leg), all_lengths.along(all_lengths.singular, leg)
        assert first.value.overlaps(second.value)
        assert all(x.overlaps(y) for x, y in zip(first.gradient, second.gradient[:2], strict=True))
        assert own.square(leg).value.overlaps(all_lengths.square(leg).value)


@pytest.mark.parametrize("space", ["slice", "lengths", "beyond"])
@given(
    numbers=GEOMETRIES,
    point=POINTS,
    fixed=st.integers(1, 3),
    radius=st.floats(0, 0.5),
    share=st.floats(-1, 1),
)
def test_arrays_of_balls_hold_the_values_of_all_functions(
    space: str, numbers: Any, point: tuple[float, float, float], fixed: int, radius: float, share: float
) -> None:
    mechanism = Mechanism(geometry_of(*numbers), fixed)
    own: Slice | Lengths = Lengths(mechanism, beyond=space == "beyond")
    if space == "slice":
        own = Slice(mechanism, Fraction(point[2]))
    variables = point[: own.variables]
    inside = own.on([arb(x + radius * share) for x in variables], 3)
    boxes = own.on([Balls(np.array([x]), np.array([radius * (1 + 1e-12) + 1e-12])) for x in variables], 3)
    with ctx.workprec(200):
        for leg in mechanism.free:
            exact, found = inside.along(inside.singular, leg), boxes.along(boxes.singular, leg)
            pairs = [*zip(exact.terms, found.terms, strict=True)]
            exact, found = inside.along(exact, leg), boxes.along(found, leg)
            pairs += [*zip(exact.terms, found.terms, strict=True)]
            pairs += [*zip(inside.square(leg).terms, boxes.square(leg).terms, strict=True)]
            for x, y in pairs:
                assert arb(float(y.mid[0]), float(y.rad[0])).overlaps(x)


@given(numbers=GEOMETRIES, point=POINTS, fixed=st.sampled_from([1, 2]), sign=st.sampled_from([1, -1]))
def test_beside_legs_that_close_functions_are_multiples_of_those_of_all_lengths(
    numbers: Any, point: tuple[float, float, float], fixed: int, sign: int
) -> None:
    mechanism = Mechanism(geometry_of(sign * numbers[3], *numbers[1:]), fixed)
    assume((numbers[1], numbers[2]) != (sign * numbers[3], 0))
    closing = 3 - fixed
    assert closing in mechanism.closing_legs
    with ctx.workprec(300):
        own = Closing(mechanism, closing=closing)
        psi, theta, t = point[0] / 4 - 0.75, point[1], arb(point[2])
        y, length = t * arb(psi).sin(), t * arb(psi).cos()
        turn = own.start * acb(1, y) / acb(1, -y)
        here = own.on([arb(psi), arb(theta), t], 4)
        there = Lengths(mechanism).on([turn.log().imag, arb(theta), length], 4)
        d = 1 + y * y
        j, found = there.singular.value * d**2 / t, here.singular.value
        assert abs(j - found) < arb(1e-40)
        for leg in mechanism.free:
            (q, p), (own_q, own_p) = (x.kernel(leg) for x in (there, here))
            factor = d / t if leg == closing else d
            assert abs(p.value * factor - own_p.value) < arb(1e-40)
            assert abs(q.value * factor * d / (2 * t) - own_q.value) < arb(1e-40)
            # (p ∂/∂θ − q ∂/∂α) (c J) for c = (1 + y²)²/t, of which the derivative in α is
            slope = (4 * y * d / t - d**2 * y / t**3) * d / 2
            e = d**2 / t * there.along(there.singular, leg).value - there.singular.value * q.value * slope
            assert abs(e * factor - here.along(here.singular, leg).value) < arb(1e-40)
