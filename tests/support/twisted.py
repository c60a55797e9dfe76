"""J, E and the eliminant of a slice from exact coordinates with y measured in √ρ: forms over ℤ[ω] in half
tangents.

They are written once more here, from cross products in the plane with the form x² + ρ y², and serve as a
witness: the solver's own model is not used, but for its resultants and its real roots.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import lcm

from flint import arb, ctx, fmpz_mpoly

from rpr_solver.exact.biform import OMEGA, RING, BiForm, L, T, U
from rpr_solver.exact.elimination import resultant
from rpr_solver.exact.modular import simple_and_finite
from rpr_solver.exact.quadratic import Form, QuadraticNumber
from rpr_solver.exact.real_roots import RealRoot, real_roots
from rpr_solver.triangles import CommonFrame, Corner

Vector = tuple[fmpz_mpoly, fmpz_mpoly]


@dataclass(frozen=True)
class Slices:
    """The slices of one fixed leg, with lengths times ``scale``, which makes all coordinates integral."""

    frame: CommonFrame
    scale: int
    legs: tuple[tuple[Vector, Vector], tuple[Vector, Vector]]
    """The platform point and the base point of each free leg, seen from the fixed one."""

    @classmethod
    def of(cls, frame: CommonFrame, fixed_leg: int = 1) -> "Slices":
        corners = (*frame.base, *frame.platform)
        parts = [x for corner in corners for z in (corner.x, corner.y) for x in (z.a, z.b)]
        scale = lcm(*(x.denominator for x in parts))
        free = [leg for leg in range(3) if leg != fixed_leg - 1]

        def seen(points: Sequence[Corner], leg: int) -> Vector:
            own, other = points[leg], points[fixed_leg - 1]
            return number(own.x - other.x, scale), number(own.y - other.y, scale)

        first, second = ((seen(frame.platform, leg), seen(frame.base, leg)) for leg in free)
        return cls(frame, scale, (first, second))

    @property
    def rho(self) -> int:
        return self.frame.rho

    @property
    def slopes(self) -> list[Vector]:
        """f_α / (2 √ρ) and f_θ / (2 √ρ L) of the free legs, times (1 + ρ t²) (1 + ρ u²)."""
        (ca, sa, na), (ct, st, nt) = ((1 - self.rho * x**2, 2 * x, 1 + self.rho * x**2) for x in (T, U))
        slopes = []
        for (mx, my), (ax, ay) in self.legs:
            x, y = ca * mx - self.rho * sa * my, sa * mx + ca * my
            along = x * (L * st - ay * nt) - y * (L * ct - ax * nt)
            across = ct * (y - ay * na) - st * (x - ax * na)
            slopes.append((along, across))
        return slopes

    @property
    def forms(self) -> tuple[BiForm, BiForm]:
        """J / L and E, up to constants: degrees 4 and 6 in t and in u."""
        (fa, ft), (ga, gt) = self.slopes
        j = fa * gt - ft * ga
        e = fa * along(j, 1, self.rho) - L * ft * along(j, 0, self.rho)
        radicand = self.frame.radicand
        return BiForm.of(j, radicand, 4, 4), BiForm.of(e, radicand, 6, 6)

    def known(self, length: Fraction) -> Form:
        """w² (1 + ρ u²)⁹ q, in lengths times the scale: the factors of the eliminant without a cusp."""
        (mx, my), (ax, ay) = self.legs[0]
        cos, one, rho = 1 - self.rho * U**2, 1 + self.rho * U**2, self.rho
        collinear = cos * ay - 2 * U * ax
        p, q = length.numerator, length.denominator
        rest = p * p + q * q * (ax**2 + rho * ay**2 - mx**2 - rho * my**2)
        closed = one * rest - 2 * p * q * (ax * cos + 2 * rho * ay * U)
        [polynomial] = BiForm.of(collinear**2 * one**9 * closed, self.frame.radicand, 0, 24).rows
        return Form(polynomial, 24)

    def eliminant(self, length: Fraction) -> Form:
        """Q of one length in the user's unit; it has degree 24 in u."""
        scaled = length * self.scale
        j, e = (form.sliced(scaled) for form in self.forms)
        return resultant(j, e, self.known(scaled))

    def roots(self, length: Fraction) -> list[RealRoot]:
        """The real roots u of Q, where they are simple."""
        q = self.eliminant(length)
        assert simple_and_finite(q.polynomial, q.degree), "a degenerate slice"
        return real_roots(q.polynomial)


def number(z: QuadraticNumber[Fraction], scale: int) -> fmpz_mpoly:
    """``scale`` times a + b ω as an element of the ring of forms."""
    return RING.constant(int(z.a * scale)) + OMEGA * int(z.b * scale)


def along(p: fmpz_mpoly, variable: int, rho: int) -> fmpz_mpoly:
    """√ρ times the derivative by α (0) or θ (1) of a form of degree 4, times 2."""
    x = (T, U)[variable]
    return (1 + rho * x**2) * p.derivative(variable) - 4 * rho * x * p


def article_angle(half_tangent: arb, axis: Corner, bits: int) -> arb:
    """The angle in degrees from an axis to the direction with a half tangent."""
    with ctx.workprec(bits):
        omega, root = arb(axis.x.radicand).sqrt(), arb(axis.rho).sqrt()
        x, y = (omega * fraction(z.b) + fraction(z.a) for z in (axis.x, axis.y))
        c, s = 1 - axis.rho * half_tangent**2, 2 * half_tangent
        # e · conj(axis)
        return arb.atan2(root * (s * x - c * y), c * x + axis.rho * s * y) * 180 / arb.pi()


def fraction(x: Fraction) -> arb:
    return arb(x.numerator) / x.denominator
