"""Samples of a path: points of the proved path in decimals, with their times and their clearance; and the
clearance of a whole path, if that is asked for.

The clearance of a sample is a proved lower bound of the distance to all singular poses of the slice: in a
direction of unit length, J changes at first by |∇J| at most, and its second derivative is at most M anywhere.
So J ≠ 0 within the positive root ρ of |J| − |∇J| ρ − M ρ²/2. M follows from the amplitudes of the sinusoids
of which J consists.

The clearance of a path is how far it keeps from all singular poses of its slice: the radius, in degrees of
(α, θ), of a tube round the path in which J is proved to have no zero; and, as a change of leg lengths, what
both free legs may at least change together before the pose meets a fold.
"""

from __future__ import annotations

import cmath
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import ceil, degrees, isqrt

from flint import arb, ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.decimals import digit_bits, round_all, round_ball, round_down, rounded_down
from rpr_solver.exact.rationals import exact_or_none, exact_str
from rpr_solver.exact.real_roots import ball_of, fraction_of
from rpr_solver.model.jets import Jet
from rpr_solver.model.slice_map import Leg, SliceMap
from rpr_solver.notebook import shortened
from rpr_solver.paths import (
    Angles,
    Arc,
    DecimalPose,
    EndPose,
    Point,
    Route,
    Turns,
    by_leg,
    local_map,
)
from rpr_solver.paths.proofs import PROOF_BITS

Joint = Callable[[int, float], tuple[float, float, float]]
"""The leg lengths at a parameter of an arc, of which the number is given."""


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


BEST = "best"
"""Asks for the widest path; a number, in degrees, for one with at least this clearance."""
BOUND_DIGITS = 6
"""The significant digits of bounds, which are rounded down."""
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
            "place": exact_str(self.place),
        }


@dataclass(frozen=True)
class Points:
    """The points of a route in decimals; its arcs by their precision."""

    slice_map: SliceMap
    digits: int
    arcs: dict[int, list[Arc]]

    @classmethod
    def of(cls, route: Route, digits: int) -> Points:
        start = digit_bits(digits) + 64
        return cls(route.slice_map, digits, {bits: route.at(bits) for bits in (start, 4 * start)})

    def between(self, number: int, tau: Fraction | float, time: Fraction) -> PathSample:
        """The sample at a parameter of an arc."""
        near = round(tau * _TAU_STEPS)
        for attempt in range(_TRIES):
            # a coordinate that is exactly 0 or half-way between decimals cannot be rounded; beside it, it can
            beside = Fraction(near + attempt * _BESIDE * (1 if tau < 0.5 else -1), _TAU_STEPS)
            for bits, arcs in self.arcs.items():
                with ctx.workprec(bits):
                    sample = self._rounded(arcs[number].at(ball_of(beside)), time, number + beside)
                if sample is not None:
                    return sample
        raise Unproved("the digits of a sample could not be proved")

    def end(self, pose: EndPose, angles: tuple[str, str], time: Fraction, place: Fraction) -> PathSample:
        """The sample of a pose at an end; ``angles`` are its own as text, apart from whole turns."""
        turns = turns_of(pose.angles, angles)
        kept = [None if n else text for n, text in zip(turns, angles, strict=True)]
        for bits in self.arcs:
            with ctx.workprec(bits):
                point = *pose.refined(bits), ball_of(pose.legs[0])
                sample = self._rounded(point, time, place, (kept[0], kept[1]))
                if sample is not None:
                    return sample
        raise Unproved("the digits of an end could not be proved")

    def _rounded(
        self,
        point: Point,
        time: Fraction,
        place: Fraction,
        known: tuple[str | None, str | None] = (None, None),
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
        return PathSample(time, lengths, angles[0], angles[1], texts[3], clearance, place)


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


def joint_of(slice_map: SliceMap, arcs: Sequence[Arc]) -> Joint:
    """The leg lengths along the arcs as floats, in a unit in which none is too large or too small for one.

    All units are powers of two, so that no rounding depends on them.
    """
    legs = slice_map.f, slice_map.g
    size = max(abs(x) for leg in legs for x in (leg.m, leg.ax, leg.ay)) + fraction_of(
        abs(arcs[0].length[0]).mid()
    )
    unit, root = _power_of_two(size), _power_of_two(Fraction(isqrt(slice_map.radicand) + 1))
    scale = float(slice_map.scale / _power_of_two(Fraction(slice_map.scale)))
    omega = float(slice_map.radicand / root**2) ** 0.5
    points = [
        (
            complex(float(leg.m / unit), float(leg.n * root / unit) * omega),
            complex(float(leg.ax / unit), float(leg.ay / unit)),
        )
        for leg in legs
    ]
    lengths = [[float(fraction_of(c.mid()) / unit) for c in arc.length] for arc in arcs]
    angles = [[[float(c.mid()) for c in p] for p in (arc.alpha, arc.theta)] for arc in arcs]

    def joint(number: int, tau: float) -> tuple[float, float, float]:
        alpha, theta, length = (
            sum(c * tau**k for k, c in enumerate(p)) for p in (*angles[number], lengths[number])
        )
        tip, turn = cmath.rect(length, theta), cmath.rect(1, alpha)
        first, second = (abs(tip + turn * platform - base) for platform, base in points)
        return length / scale, first / scale, second / scale

    return joint


def _power_of_two(x: Fraction) -> Fraction:
    """A power of two near a number > 0."""
    return Fraction(2) ** (x.numerator.bit_length() - x.denominator.bit_length())


@dataclass(frozen=True)
class Clearance:
    """How far a path keeps from all singular poses with the same fixed length.

    Attributes:
        asked: ``"best"``, or what was required, in degrees.
        proved: in degrees: from any pose of the path, α and θ may change together (in the Euclidean norm) by
            less than this, and no singular pose is met. Rounded down.
        bound: in degrees: no path between these poses has a greater clearance, proved. Rounded up; None if
            none was found.
        legs: from any pose of the path, both free legs may change together (in the Euclidean norm) by less
            than this before a fold can be met; in the user's unit. Rounded down.
        radius: the least radius of curvature of the path, in degrees of (α, θ). Rounded down; None if the
            path has a corner, or is straight.
    """

    asked: str
    proved: Fraction
    bound: Fraction | None
    legs: Fraction
    radius: Fraction | None

    def to_json(self) -> dict[str, str | None]:
        """The document's object."""
        return {
            "asked": self.asked,
            "proved": exact_str(self.proved),
            "bound": exact_or_none(self.bound),
            "legs": exact_str(self.legs),
            "radius": exact_or_none(self.radius),
        }


def turning_radius(route: Route) -> Fraction | None:
    """The least radius of curvature in degrees of (α, θ), rounded down; None with corners, or if straight."""
    if not all(_is_straight(arc[-2], arc[-1], following[1]) for arc, following in pairwise(route.arcs)):
        return None
    with ctx.workprec(PROOF_BITS):
        radii = [radius for arc in route.at(PROOF_BITS - 64) if (radius := _radius(arc)) is not None]
        if not radii:
            return None
        least = radii[0]
        for radius in radii[1:]:
            least = least.min(radius)
        bound = (least * 180 / arb.pi()).abs_lower()
        found = fraction_of(bound) if bound.is_finite() else None  # where only the fixed leg moves
    return rounded_down(found, BOUND_DIGITS) if found else None


def _is_straight(*points: DecimalPose | None) -> bool:
    """Whether a path goes straight on at the middle one of three points; not if one is a pose."""
    places = [(p.alpha_deg, p.theta_deg) for p in points if p is not None]
    steps = [(q[0] - p[0], q[1] - p[1]) for p, q in pairwise(places)]
    if len(steps) < len(points) - 1:
        return False
    (a, b), (c, d) = steps
    return a * d == b * c and a * c + b * d >= 0


def _radius(arc: Arc) -> arb | None:
    """A lower bound of the radius of curvature of an arc, |B′|³ / |B′ × B″|; None if it is straight."""
    (x, bend_x), (y, bend_y) = ((p[1], 2 * p[2]) for p in (arc.alpha, arc.theta))
    cross = abs(x * bend_y - y * bend_x)
    if cross == 0:
        return None
    bend = bend_x**2 + bend_y**2
    along = x * bend_x + y * bend_y
    ends = (x**2 + y**2).min((x + bend_x) ** 2 + (y + bend_y) ** 2)
    # the slope is shortest where it is at right angles to B″, if that is between the ends
    outside = along >= 0 or along + bend <= 0
    least = ends if outside else ends.min(cross**2 / bend)
    return least.sqrt() ** 3 / cross
