"""From a root u of the eliminant to the pose, its joint point, and the proof that it is a cusp."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, arb_mat, arb_poly, ctx

from rpr_solver.jets import LocalMap, Pose
from rpr_solver.modular import sylvester
from rpr_solver.roots import RealPolynomial, ball_of, omega_ball
from rpr_solver.surface import BiForm, Surface


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
        side = 180 if n * d > 0 else -180
        return side - (d / n).atan() * 360 / arb.pi() + offset


def pose_of(alpha: HalfTangent, theta: HalfTangent, length: arb, omega: arb) -> Pose[arb]:
    """The pose with these angles of a slice (scaled units)."""
    (cos_a, sin_a), (cos_t, sin_t) = alpha.cos_sin(), theta.cos_sin()
    return Pose(cos_a, sin_a, cos_t, sin_t, length, omega)


@dataclass(frozen=True)
class CuspBalls:
    """A cusp as balls, in the user's unit, with the numbers that prove it."""

    alpha_deg: arb
    theta_deg: arb
    first: arb
    second: arb
    proof: CuspProof


@dataclass(frozen=True)
class CuspProof:
    """Balls that exclude zero where a cusp needs it (method.md section 2), lengths scaled."""

    rank: arb
    """A partial derivative of f: the map has rank 1."""
    gradient: arb
    """J_α or J_θ: the singular curve is smooth."""
    transversal: arb
    """v·∇E: exactly three poses coalesce."""

    @property
    def holds(self) -> bool:
        """Whether every condition is proved at this precision."""
        return not any(x.contains(0) for x in (self.rank, self.gradient, self.transversal))


class SlicePoses:
    """The slice L at one working precision, ready to turn roots into poses."""

    def __init__(self, surface: Surface, length: Fraction, bits: int) -> None:
        self.surface = surface
        self.bits = bits
        self._singular = _balls(surface.singular, surface, length, bits)
        self._coalescence = _balls(surface.coalescence, surface, length, bits)
        with ctx.workprec(bits):
            self.length = ball_of(length)
            self.scale = surface.scale_ball()
            self.omega = omega_ball(surface.radicand, bits)

    def alpha(self, u: arb) -> HalfTangent | None:
        """tan(α/2) of the one pose above a simple root u; None if the precision does not tell."""
        j = [p(u) for p in self._singular]
        e = [p(u) for p in self._coalescence]
        return common_root(j, e)

    def cusp(self, u: arb, t: HalfTangent) -> CuspBalls | None:
        """The cusp at (t, u), or None where a ball is still too wide."""
        pose = pose_of(t, HalfTangent(u, arb(1)), self.length, self.omega)
        local = LocalMap.at(self.surface, pose, 3)
        j = local.singularity()
        e = local.along(local.f, j)
        proof = CuspProof(
            rank=_larger(local.f.alpha.value, local.f.theta.value),
            gradient=_larger(j.alpha.value, j.theta.value),
            transversal=local.along(local.f, e).value,
        )
        f, g = local.squared_lengths(self.surface, pose)
        at_half_turn = t.denominator.contains(0)  # α = ±180° cannot be told apart by a ball
        if at_half_turn or not (proof.holds and f > 0 and g > 0):
            return None
        return CuspBalls(
            alpha_deg=t.degrees(),
            theta_deg=HalfTangent(u, arb(1)).degrees(),
            first=f.sqrt() / self.scale,
            second=g.sqrt() / self.scale,
            proof=proof,
        )


def _balls(form: BiForm, surface: Surface, length: Fraction, bits: int) -> list[arb_poly]:
    return [RealPolynomial(a, b, surface.radicand).ball(bits) for a, b in form.at(length)]


def common_root(j: Sequence[arb], e: Sequence[arb]) -> HalfTangent | None:
    """The common root t of two forms that share exactly one; None if the precision does not tell."""
    return _finite_common_root(j, e) or _inverse(_finite_common_root(j[::-1], e[::-1]))


def _finite_common_root(j: Sequence[arb], e: Sequence[arb]) -> HalfTangent | None:
    """t = −s0/s1 from the first subresultant s1 t + s0, where s1 is proved not to vanish."""
    size = len(j) + len(e) - 4
    full = sylvester(j, e, arb(0))
    # t^(n−2)J … J, t^(m−2)E … E: one row less of each, and the columns t^(m+n−2) … 1
    rows = [row[1:] for i, row in enumerate(full) if i not in (0, len(e) - 1)]
    s1 = arb_mat([row[:size] for row in rows]).det()
    s0 = arb_mat([[*row[: size - 1], row[size]] for row in rows]).det()
    return None if s1.contains(0) else HalfTangent(-s0, s1)


def _inverse(t: HalfTangent | None) -> HalfTangent | None:
    return HalfTangent(t.denominator, t.numerator) if t else None


def _larger(x: arb, y: arb) -> arb:
    return x if x.abs_lower() >= y.abs_lower() else y
