"""Samples of a path: points of the proved path in decimals, with their times and their clearance.

The clearance of a sample is a proved lower bound of the distance to all singular poses of the slice: in a
direction of unit length, J changes at first by |∇J| at most, and its second derivative is at most M anywhere.
So J ≠ 0 within the positive root ρ of |J| − |∇J| ρ − M ρ²/2. M follows from the amplitudes of the sinusoids
of which J consists.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from math import ceil, degrees
from typing import TypeAlias

from flint import acb, arb, ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.decimals import digit_bits, round_all, round_ball, round_down
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.rationals import exact_str
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.given_poses import IN_GIVEN_FRAME, working_bits
from rpr_solver.model.given_poses import Course as GivenCourse
from rpr_solver.model.jets import Jet
from rpr_solver.model.slice_map import Leg, SliceMap
from rpr_solver.notebook import shortened
from rpr_solver.paths.conditioning import condition_at
from rpr_solver.paths.proofs import BOUND_DIGITS
from rpr_solver.paths.routes import Angles, Arc, EndPose, Point, Route, Turns, by_leg, local_map
from rpr_solver.triangles import Surd, UserFrame


def clearance_of(slice_map: SliceMap, length: arb, j: Jet[arb]) -> arb:
    """A ball whose lower end bounds the distance, in radians, to the nearest singular pose of the slice.

    ``j`` is the jet of J at the pose, ``length`` the fixed length, scaled.
    """
    value = abs(j.value)
    slope = (j.alpha.value**2 + j.theta.value**2).sqrt()
    return 2 * value / (slope + (slope**2 + 2 * bend_bound(slice_map, length) * value).sqrt())


def bend_bound(slice_map: SliceMap, length: arb) -> arb:
    """An upper bound of the second directional derivatives of J anywhere in the slice.

    f_α is a sum of sinusoids in α − θ and in α, f_θ of sinusoids in α − θ and in θ. In a direction of unit
    length the derivative of the first kind is at most √2 times the amplitude, that of the others at most 1.
    """
    (f_alpha, f_theta), (g_alpha, g_theta) = (_slopes(leg, length) for leg in (slice_map.f, slice_map.g))

    def product(p: list[arb], q: list[arb]) -> arb:
        return p[0] * q[2] + 2 * p[1] * q[1] + p[2] * q[0]

    return product(f_alpha, g_theta) + product(f_theta, g_alpha)


def _slopes(leg: Leg, length: arb) -> tuple[list[arb], list[arb]]:
    """Bounds of f_α and f_θ (of half the square) and of their first and second directional derivatives."""
    platform, base = arb(leg.platform2).sqrt(), arb(leg.base2).sqrt()
    root = arb(2).sqrt()
    both = [length * platform * root**k for k in range(3)]
    return [x + platform * base for x in both], [x + length * base for x in both]


_Known: TypeAlias = tuple[str | None, str | None]
"""α and θ as text, where they are known."""
_TRIES = 4
_TAU_STEPS = 10**15
_BESIDE = 1009
"""Parameters of samples are decimals of 15 places; one beside another is this many steps away, a prime: where
a coordinate of a path with exact control points lies half-way between two roundings, those beside do not."""


@dataclass(frozen=True)
class PathSample:
    """A point of a path at its time: decimals, correctly rounded to the digits of the path.

    Attributes:
        time: exact, from 0 to the duration.
        lengths: L1, L2 and L3, in the user's unit.
        alpha_deg: the orientation of the platform, in degrees. It begins in (−180, 180] and is continuous
            along the path, so that it may leave that turn.
        theta_deg: the angle of the fixed leg, likewise.
        determinant: J / (L1 L2 L3), in the user's unit: up to its sign the determinant of the partial
            derivatives of L1, L2, L3 by a translation of the platform and its rotation in radians; zero at
            singular poses.
        clearance_deg: a proved lower bound, rounded down, of the distance to the nearest singular pose with
            the same fixed length, in degrees: that far α and θ may change together (in the Euclidean norm).
        place: where on the arcs of the path, exact: the number of the arc, from 0, plus its parameter τ.
        given: x, y and φ in degrees, where base or platform were given by points: the place of the platform's
            frame in that of the base (:class:`~rpr_solver.triangles.UserFrame`). φ is continuous as α is.
        condition: the condition number (:mod:`rpr_solver.model.conditioning`); None unless asked for.

    >>> from rpr_solver import EXAMPLES, cusp_loop
    >>> cusp_loop(EXAMPLES["innocenti"], 27, "A", samples=3, duration=10).samples[1].time
    Fraction(5, 1)
    """

    time: Fraction
    lengths: tuple[str, str, str]
    alpha_deg: str
    theta_deg: str
    determinant: str
    clearance_deg: str
    place: Fraction
    given: tuple[str, str, str] | None = None
    condition: str | None = None

    def __repr__(self) -> str:
        legs = " ".join(f"l{leg}={shortened(text)}" for leg, text in enumerate(self.lengths, 1))
        time = shortened(exact_str(self.time))
        return f"<PathSample at {time}: {legs} alpha_deg={shortened(self.alpha_deg)}>"

    def to_json(self, fixed_leg: int) -> dict[str, str]:
        """The document's object."""
        l1, l2, l3 = self.lengths
        return {
            "time": exact_str(self.time),
            "l1": l1,
            "l2": l2,
            "l3": l3,
            "alpha_deg": self.alpha_deg,
            f"theta{fixed_leg}_deg": self.theta_deg,
            "determinant": self.determinant,
            "clearance_deg": self.clearance_deg,
            **({} if self.condition is None else {"condition": self.condition}),
            "place": exact_str(self.place),
            **dict(zip(IN_GIVEN_FRAME, self.given or (), strict=False)),
        }


@dataclass(frozen=True)
class Points:
    """The points of a route in decimals; its arcs by their precision."""

    slice_map: SliceMap
    digits: int
    arcs: dict[int, list[Arc]]
    course: GivenCourse | None = None
    scale: Surd | None = None

    @classmethod
    def of(
        cls, route: Route, digits: int, frame: UserFrame | None = None, scale: Surd | None = None
    ) -> Points:
        start = digit_bits(digits) + 64
        # the second is also that of poses in the given frame, which need twice the digits
        arcs = {bits: route.at(bits) for bits in (start, max(4 * start, working_bits(digits)))}
        course = None if frame is None else GivenCourse(frame, digits)
        return cls(route.slice_map, digits, arcs, course, scale)

    def _on_arc(self, number: int, tau: Fraction, bits: int) -> Point:
        return self.arcs[bits][number].at(ball_of(tau))

    def _placed(self, sample: PathSample, point_at: Callable[[int], Point]) -> PathSample:
        """The sample, also in the given frame if there is one."""
        if self.course is None:
            return sample
        bits = max(self.arcs)
        with ctx.workprec(bits):
            alpha, theta, length = point_at(bits)
            slice_map = self.slice_map
            b1 = acb(0, theta).exp() * length
            if slice_map.fixed_leg != 1:
                # the first free leg is leg 1, whose vector is B1
                m, a = slice_map.f.points(omega_ball(slice_map.radicand, bits))
                b1 += acb(0, alpha).exp() * m - a
            b1 /= slice_map.scale_ball()
            return replace(sample, given=self.course.placed(alpha, (b1.real, b1.imag)))

    def between(self, number: int, tau: Fraction | float, time: Fraction) -> PathSample:
        """The sample at a parameter of an arc."""
        near = round(tau * _TAU_STEPS)
        for attempt in range(_TRIES):
            # a coordinate that is exactly 0 or half-way between decimals cannot be rounded; beside it, it can
            beside = Fraction(near + attempt * _BESIDE * (1 if tau < 0.5 else -1), _TAU_STEPS)
            sample = self._sample(partial(self._on_arc, number, beside), time, number + beside)
            if sample is not None:
                return sample
        raise Unproved("the digits of a sample could not be proved")

    def end(self, pose: EndPose, angles: tuple[str, str], time: Fraction, place: Fraction) -> PathSample:
        """The sample of a pose at an end; ``angles`` are its own as text, apart from whole turns."""
        turns = turns_of(pose.angles, angles)
        kept = [None if n else text for n, text in zip(turns, angles, strict=True)]
        if (sample := self._sample(partial(_at_end, pose), time, place, (kept[0], kept[1]))) is None:
            raise Unproved("the digits of an end could not be proved")
        return sample

    def _sample(
        self, point_at: Callable[[int], Point], time: Fraction, place: Fraction, known: _Known = (None, None)
    ) -> PathSample | None:
        """The sample at a point, at the first precision that proves its digits; None if none does."""
        for bits in self.arcs:
            with ctx.workprec(bits):
                sample = self._rounded(point_at(bits), time, place, known)
            if sample is not None:
                return self._placed(sample, point_at)
        return None

    def _rounded(
        self,
        point: Point,
        time: Fraction,
        place: Fraction,
        known: _Known,
    ) -> PathSample | None:
        """The sample at a point, with the angles that are known; None if the balls are too wide."""
        alpha, theta, length = point
        local = local_map(self.slice_map, length, (alpha, theta), 2)
        j, scale = local.singularity(), self.slice_map.scale_ball()
        first, second = (square.sqrt() for square in local.squared_lengths())
        determinant = j.value / (length * first * second)
        texts = round_all((length / scale, first / scale, second / scale, determinant / scale), self.digits)
        if texts is None:
            return None
        angles = []
        for angle, text in zip((alpha, theta), known, strict=True):
            text = text or round_ball(angle * 180 / arb.pi(), self.digits)
            if text is None:
                return None
            angles.append(text)
        clearance = round_down(
            (clearance_of(self.slice_map, length, j) * 180 / arb.pi()).lower(), BOUND_DIGITS
        )
        lengths = by_leg(self.slice_map.fixed_leg, texts[:3])
        condition = None
        if self.scale is not None:
            condition = round_ball(condition_at(self.slice_map, point, self.scale), self.digits)
            if condition is None:
                return None
        return PathSample(
            time, lengths, angles[0], angles[1], texts[3], clearance, place, condition=condition
        )


def _at_end(pose: EndPose, bits: int) -> Point:
    return *pose.refined(bits), ball_of(pose.legs[0])


def turns_of(angles: Angles, texts: tuple[str, str]) -> Turns:
    """The whole turns by which angles in radians exceed the same angles as text in degrees."""
    alpha, theta = (
        round((degrees(float(angle)) - float(text)) / 360) for angle, text in zip(angles, texts, strict=True)
    )
    return alpha, theta


def wrapped(angle: arb) -> arb:
    """An angle in degrees, in (−180, 180] up to the width of its ball."""
    in_degrees = angle * 180 / arb.pi()
    return in_degrees - 360 * ceil((float(in_degrees.mid()) - 180) / 360)
