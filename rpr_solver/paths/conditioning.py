"""The condition number along a path: bounds of it, proved, and a greatest one that a path must keep.

T, S and D (:mod:`rpr_solver.model.conditioning`) are power series in τ as J is, so that on a piece of
half-width r they lie in F(τ) + F′(τ)[−r, r] + F″(piece)[0, r²]/2; the condition number of these balls holds
that of every pose of the piece.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from heapq import heappop, heappush

from flint import arb, arb_poly, arb_series, ctx

from rpr_solver.errors import InputError, Unproved
from rpr_solver.exact.decimals import rounded_down, rounded_up
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.rationals import Exact, exact_or_none, exact_str, parse_exact
from rpr_solver.exact.real_roots import ball_of, fraction_of
from rpr_solver.model.conditioning import Invariants, Pair, arms, condition_json, read_scale, scale_of
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.proofs import BOUND_DIGITS, PROOF_BITS
from rpr_solver.paths.routes import Arc, EndPose, Point, Route, bounded
from rpr_solver.triangles import Surd

_CLOSE = arb("1.005")
"""By how much a bound may exceed a value that is attained."""
_FIRST_PIECES = 8
"""Of each arc."""
_MOST_PIECES = 20_000


@dataclass(frozen=True)
class AskedCondition:
    """What is asked of the condition numbers of a path, checked.

    Attributes:
        given: the length scale, in the user's unit; None for the radius of gyration of the platform's joints.
        most: what none may exceed; None without a requirement.
    """

    given: Fraction | None = None
    most: Fraction | None = None

    @classmethod
    def of(
        cls, *, condition: bool = False, length_scale: Exact | None = None, max_condition: Exact | None = None
    ) -> AskedCondition | None:
        """From the options; each of them asks for condition numbers. None if none is given.

        Raises:
            InputError: naming ``length_scale`` or ``max_condition``.
        """
        if not condition and length_scale is None and max_condition is None:
            return None
        most = None if max_condition is None else parse_exact(max_condition, "max_condition")
        if most is not None and most < 1:
            message = f"is {exact_str(most)}; a condition number is at least 1"
            raise InputError.of("max_condition", message)
        return cls(None if length_scale is None else read_scale(length_scale), most)

    def scale(self, manipulator: Manipulator) -> Surd:
        """λ."""
        return scale_of(manipulator, self.given)


@dataclass(frozen=True)
class PathCondition:
    """The condition numbers of all poses of a path.

    Attributes:
        scale: λ, by which rotations are measured.
        asked: what none may exceed; None without a requirement.
        least: none is less, proved; rounded down.
        greatest: none is greater, proved; rounded up. Both are as good as all these numbers are close to a
            value that is attained, within 0.5 %.
    """

    scale: Surd
    asked: Fraction | None
    least: Fraction
    greatest: Fraction

    @classmethod
    def of(cls, route: Route, scale: Surd, asked: Fraction | None = None) -> PathCondition:
        """That of a route on which J has one sign.

        Raises:
            Unproved: no bound could be proved.
        """
        with ctx.workprec(PROOF_BITS):
            numbers = _Numbers.on(route.slice_map, route.at(PROOF_BITS - 64), scale)
            goal = None if asked is None else ball_of(asked)
            greatest = numbers.greatest(lambda x: x, goal)
            least = 1 / numbers.greatest(lambda x: 1 / x)
            if not (greatest.is_finite() and least > 0):
                raise Unproved("the condition number along the path could not be bounded")
            low, high = fraction_of(least.lower()), fraction_of(greatest)
        most = rounded_up(high, BOUND_DIGITS)
        # a condition number is at least 1
        least_digits = max(Fraction(1), rounded_down(low, BOUND_DIGITS))
        return cls(scale, asked, least_digits, most if asked is None or high > asked else min(most, asked))

    @property
    def is_kept(self) -> bool:
        """Whether what was asked for is proved."""
        return self.asked is None or self.greatest <= self.asked

    def to_json(self) -> dict[str, str | None]:
        """The document's object."""
        return {
            **condition_json(str(self.scale)),
            "asked": exact_or_none(self.asked),
            "min": exact_str(self.least),
            "max": exact_str(self.greatest),
        }


def condition_at(slice_map: SliceMap, point: Point, scale: Surd) -> arb:
    """The condition number at a point of a path, at the working precision; not finite if J may be 0 there."""
    alpha, theta, length = (arb_poly([x]) for x in point)
    numbers = _Numbers.on(slice_map, [Arc(alpha, theta, length)], scale)
    return numbers.at(_Piece(numbers.arcs[0], arb(0), 0.0), wide=False)


def is_beyond(pose: EndPose, scale: Surd, most: Fraction | None) -> bool:
    """Whether the condition number of a pose is proved to be greater than a number."""
    with ctx.workprec(PROOF_BITS):
        point = *pose.refined(PROOF_BITS - 64), ball_of(pose.legs[0])
        return most is not None and bool(condition_at(pose.slice_map, point, scale) > ball_of(most))


@dataclass(frozen=True)
class _Piece:
    """A part of an arc: its middle and half its length."""

    arc: Arc
    tau: arb
    half: float

    @property
    def halves(self) -> Iterator[_Piece]:
        """Both halves."""
        quarter = self.half / 2
        return (_Piece(self.arc, self.tau + step, quarter) for step in (-quarter, quarter))


@dataclass(frozen=True)
class _Numbers:
    """The condition numbers on the arcs of a path."""

    slice_map: SliceMap
    arcs: Sequence[Arc]
    scale: arb
    platform: tuple[Pair, Pair, Pair]

    @classmethod
    def on(cls, slice_map: SliceMap, arcs: Sequence[Arc], scale: Surd) -> _Numbers:
        """Those on arcs, at the working precision."""
        omega = omega_ball(slice_map.radicand, ctx.prec)
        first, second = (leg.points(omega)[0] for leg in (slice_map.f, slice_map.g))
        corners = arms((first.real, first.imag), (second.real, second.imag))
        return cls(slice_map, arcs, scale.ball() * slice_map.scale_ball(), corners)

    def greatest(self, of: Callable[[arb], arb], goal: arb | None = None) -> arb:
        """An upper bound of a function of the condition number, hardly greater than a value that it has; with
        a goal, at most that if this is so.

        Invariant: each pose of the path is on a piece that waits, by its bound. The piece of the greatest
        bound is halved, until this is close to a value; that happens, as the bounds of small pieces are close
        to their values. It ends with what is proved if there are too many pieces.
        """
        best, count = arb(0), 0
        waiting: list[tuple[float, int, arb, _Piece]] = []
        width = 0.5 / _FIRST_PIECES
        fresh = [
            _Piece(arc, (2 * k + 1) * arb(width), width) for arc in self.arcs for k in range(_FIRST_PIECES)
        ]
        while True:
            for piece in fresh:
                value = of(self.at(piece, wide=False))
                best = best.max(value.lower()) if value.is_finite() else best
                bound = of(self.at(piece, wide=True)).upper()
                bound = bound if bound.is_finite() else arb("inf")
                count += 1
                heappush(waiting, (-float(bound), count, bound, piece))
            most = waiting[0][2]
            is_open = goal is not None and best <= goal < most
            if count > _MOST_PIECES or (most <= best * _CLOSE and not is_open):
                return most
            fresh = list(heappop(waiting)[3].halves)

    def at(self, piece: _Piece, *, wide: bool) -> arb:
        """That at the middle of a piece, or those of all of its poses; not finite if that is open."""
        near = self._expanded(piece.arc, piece.tau, 1 if wide else 0)
        whole = self._expanded(piece.arc, arb(piece.tau, piece.half), 2) if wide else near
        if near is None or whole is None:
            return arb("nan")
        if not wide:
            return Invariants(*(x[0] for x in near)).condition()
        pairs = zip(near, whole, strict=True)
        return Invariants(*(bounded(x, y, arb(piece.half)) for x, y in pairs)).condition()

    def _expanded(self, arc: Arc, tau: arb, order: int) -> tuple[arb_series, ...] | None:
        """T, S and D along an arc up to the power ``order``; None if a leg may have the length 0."""
        size, shift = order + 1, arb_poly([tau, 1])
        alpha, theta, length = (
            arb_series(list(p(shift))[:size], prec=size) for p in (arc.alpha, arc.theta, arc.length)
        )
        (sin_a, cos_a), (sin_t, cos_t) = alpha.sin_cos(), theta.sin_cos()
        turned = [(cos_a * x - sin_a * y, sin_a * x + cos_a * y) for x, y in self.platform]
        own = turned[0]
        directions = [(cos_t, sin_t)]
        omega = omega_ball(self.slice_map.radicand, ctx.prec)
        for arm, leg in zip(turned[1:], (self.slice_map.f, self.slice_map.g), strict=True):
            a = leg.points(omega)[1]
            x, y = length * cos_t + (arm[0] - own[0]) - a.real, length * sin_t + (arm[1] - own[1]) - a.imag
            square = x * x + y * y
            if not square[0] > 0:
                return None
            inverse = square.rsqrt()
            directions.append((x * inverse, y * inverse))
        found = Invariants.of(directions, turned, self.scale)
        return found.trace, found.minors, found.determinant2
