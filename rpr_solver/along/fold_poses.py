"""The coordinates of the singular poses at the ends of intervals, as documents have them.

With W known (folds.py), X = (r v + W v⊥)/(w N) is the vector of the leg c; X + v and X + V_k are those of
both others. Balls give their digits; a number that is 0, or half way between two decimals, needs a number
field.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

from flint import arb, ctx, fmpq

from rpr_solver.along.folds import FourBar, Place, place_of
from rpr_solver.exact import decided
from rpr_solver.exact.decimals import angle_text, digit_bits, round_all
from rpr_solver.exact.number_field import Algebraic, adjoin_real_roots
from rpr_solver.exact.precision import GREATEST_BITS
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.bridge import Bridge
from rpr_solver.model.fibre import coordinate
from rpr_solver.model.given_poses import IN_GIVEN_FRAME, digits_before, in_given_frame
from rpr_solver.model.jets import HalfTangent, direction
from rpr_solver.model.joint_points import free_legs
from rpr_solver.triangles import UserFrame

_Vector: TypeAlias = tuple[Any, Any]
_Exact: TypeAlias = tuple[Algebraic, Algebraic, dict[int, _Vector]]
_FIRST_BITS = 128


@dataclass(frozen=True)
class FoldPose:
    """A singular pose.

    Attributes:
        four_bar: the poses with two legs held.
        moving: the third leg.
        place: where the pose is.
        is_closed: whether the moving leg has length 0, and so no angle.
    """

    four_bar: FourBar
    moving: int
    place: Place
    is_closed: bool

    def texts(self, digits: int, frame: UserFrame | None) -> Mapping[str, str]:
        """Its coordinates by their names in documents, correctly rounded.

        Raises:
            Unproved: a digit could not be decided.
        """
        known = dict(zip(self._names, self._decimals(digits), strict=True))
        if frame is None:
            return known
        alpha, *_, x, y = self._decimals(digits_before(digits))
        return known | dict(zip(IN_GIVEN_FRAME, in_given_frame(frame, (alpha, x, y), digits), strict=True))

    @property
    def _legs(self) -> list[int]:
        """The legs with an angle."""
        return [leg for leg in (1, 2, 3) if not (self.is_closed and leg == self.moving)]

    @property
    def _names(self) -> list[str]:
        return ["alpha_deg", *(f"theta{leg}_deg" for leg in self._legs), "b1_x", "b1_y"]

    def _decimals(self, digits: int) -> list[str]:
        start = digit_bits(digits) + _FIRST_BITS
        found = None if self.place.free else self._by_balls(start, digits)
        if found is None:
            exact = self._exactly()
            found = decided(
                lambda bits: self._rounded(exact, bits, digits),
                start,
                GREATEST_BITS,
                "the digits of a singular pose could not be decided",
            )
        *angles, x, y = found
        return [*map(angle_text, angles), x, y]

    def _by_balls(self, bits: int, digits: int) -> Sequence[str] | None:
        """The decimals, if balls of a precision decide them."""
        four_bar, slice_map = self.four_bar, self.four_bar.slice_map
        t, omega = self.place.root.refined(2 * bits), omega_ball(slice_map.radicand, 2 * bits)
        with ctx.workprec(2 * bits):
            bridge = Bridge.of(slice_map)
            first = self._of_fixed_leg(t, omega, four_bar.w(t, omega, self.place.sign))
            vectors = {k: bridge.vector(*v) for k, v in self._vectors(t, omega, first).items()}
            alpha = bridge.alpha(four_bar.turn.whole(HalfTangent(t, arb(1)))).degrees()
            scale = slice_map.scale_ball()
            b1 = [z / scale for z in vectors[1]]
            angles = [direction(*vectors[leg]) for leg in self._legs]
            return round_all((alpha, *angles, *b1), digits)

    def _of_fixed_leg(self, t: Any, omega: Any, w: Any) -> _Vector:
        """X."""
        four_bar, rho = self.four_bar, self.four_bar.slice_map.rho
        x, y = (part(t, omega) for part in four_bar.vector)
        right = four_bar.right(t, omega)
        over = _inverse((x * x + y * y * rho) * (2 * four_bar.den))
        return (right * x - w * y * rho) * over, (right * y + w * x) * over

    def _vectors(self, t: Any, omega: Any, first: _Vector) -> dict[int, _Vector]:
        """Those of all legs, by their numbers."""
        four_bar, fixed = self.four_bar, self.four_bar.slice_map.fixed_leg
        [held] = (leg for leg in free_legs(fixed) if leg != self.moving)
        *of_moving, one = (part(t, omega) for part in four_bar.other)
        of_held = [part(t, omega) for part in four_bar.vector]
        over = _inverse(one)
        x, y = first
        others = {held: of_held, self.moving: of_moving}
        return {fixed: first} | {leg: (x + u * over, y + v * over) for leg, (u, v) in others.items()}

    def _exactly(self) -> _Exact:
        """t, ω and the vectors of the legs in one field."""
        four_bar, sign = self.four_bar, self.place.sign
        if self.place.free:
            t, omega, x, y = self.place.free
            return t, omega, self._vectors(t, omega, (x, y))
        roots = four_bar.exact_roots
        t, omega = roots[place_of(self.place.root.refined, [x.root for x in roots])].in_field()
        w = t.field(0) if sign is not None else -four_bar.a(t, omega) * four_bar.b(t, omega).inverse()
        if sign:
            square = four_bar.q(t, omega) * t.field(fmpq(1, four_bar.slice_map.rho))
            extensions = adjoin_real_roots(t.field, [-square, t.field(0), t.field(1)])
            [own] = (x for x in extensions if x.root.sign == sign)
            t, omega, w = own.lift(t), own.lift(omega), own.root
        return t, omega, self._vectors(t, omega, self._of_fixed_leg(t, omega, w))

    def _rounded(self, exact: _Exact, bits: int, digits: int) -> Sequence[str] | None:
        t, omega, vectors = exact
        slice_map = self.four_bar.slice_map
        bridge, rho = Bridge.of(slice_map), slice_map.rho
        c, s, _ = self.four_bar.turn.rotation
        cos, sin = t * t * -rho + 1, t * 2
        with ctx.workprec(bits):
            alpha = bridge.alpha_degrees(cos * c - sin * (rho * s), sin * c + cos * s, omega, bits)
            angles = [bridge.theta_degrees(*vectors[leg], omega, bits) for leg in self._legs]
            b1 = [coordinate(*z) for z in bridge.coordinates(*vectors[1], omega)]
            scale = slice_map.scale
            point = [z / scale if isinstance(z, Fraction) else z(bits) / ball_of(scale) for z in b1]
            return round_all((alpha, *angles, *point), digits)


def _inverse(x: Any) -> Any:
    return x.inverse() if isinstance(x, Algebraic) else 1 / x
