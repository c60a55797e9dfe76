"""Samples of a path: points of the proved path in decimals, with their times."""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, isqrt

from flint import arb, ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.decimals import angle_text, digit_bits, round_all, round_down
from rpr_solver.exact.rationals import exact_str
from rpr_solver.exact.real_roots import ball_of, fraction_of
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.notebook import shortened
from rpr_solver.paths.arcs import Arc, Point
from rpr_solver.paths.clearance import clearance_of
from rpr_solver.paths.isolated import IsolatedPose, local_map
from rpr_solver.paths.route import Route
from rpr_solver.paths.timing import TIMINGS, Joint, places

_BOUND_DIGITS = 6
_TRIES = 4


@dataclass(frozen=True)
class PathSample:
    """A point of a path at its time: decimals, correctly rounded to the digits of the path.

    Attributes:
        time: exact, from 0 to the duration.
        lengths: L1, L2 and L3, in the user's unit.
        alpha_deg: the orientation of the platform, in degrees in (−180, 180], as all angles.
        theta_deg: the angle of the fixed leg.
        determinant: J / (L1 L2 L3), in the user's unit: up to its sign the determinant of the partial
            derivatives of L1, L2, L3 by a translation of the platform and its rotation in radians; zero at
            singular poses.
        clearance_deg: a proved lower bound, rounded down, of the distance to the nearest singular pose with
            the same fixed length, in degrees: that far α and θ may change together (in the Euclidean norm).

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
        }


def sampled(
    route: Route,
    angles: tuple[tuple[str, str], tuple[str, str]],
    digits: int,
    count: int,
    timing: str,
    duration: Fraction,
) -> tuple[PathSample, ...]:
    """``count`` samples of a path at equal intervals of time, its ends included.

    ``angles`` are α and θ at the ends, as text.

    Raises:
        Unproved: the digits of a sample could not be proved.
    """
    law = TIMINGS[timing]
    rough = route.at(64)
    where = places(_joint(route.slice_map, rough), len(rough), [law(k / (count - 1)) for k in range(count)])
    points = _Points.of(route, digits)
    samples = []
    for k, (arc, tau) in enumerate(where):
        time = duration * Fraction(k, count - 1)
        if 0 < k < count - 1:
            samples.append(points.between(arc, tau, time))
        else:
            pose = route.start if k == 0 else route.stop
            samples.append(points.end(pose, angles[0 if k == 0 else 1], time))
    return tuple(samples)


@dataclass(frozen=True)
class _Points:
    """The points of a route in decimals; its arcs by their precision."""

    slice_map: SliceMap
    digits: int
    arcs: dict[int, list[Arc]]

    @classmethod
    def of(cls, route: Route, digits: int) -> _Points:
        start = digit_bits(digits) + 64
        return cls(route.slice_map, digits, {bits: route.at(bits) for bits in (start, 4 * start)})

    def between(self, number: int, tau: float, time: Fraction) -> PathSample:
        """The sample at a parameter of an arc."""
        for attempt in range(_TRIES):
            # a coordinate that is exactly 0 cannot be rounded; beside it, it can
            beside = arb(tau + attempt * 2.0**-40 * (1 if tau < 0.5 else -1))
            for bits, arcs in self.arcs.items():
                with ctx.workprec(bits):
                    sample = self._rounded(arcs[number].at(beside), time)
                if sample is not None:
                    return sample
        raise Unproved("the digits of a sample could not be proved")

    def end(self, pose: IsolatedPose, angles: tuple[str, str], time: Fraction) -> PathSample:
        """The sample of a pose at an end."""
        for bits in self.arcs:
            with ctx.workprec(bits):
                point = *pose.refined(bits), ball_of(pose.legs[0])
                sample = self._rounded(point, time, angles)
                if sample is not None:
                    return sample
        raise Unproved("the digits of an end could not be proved")

    def _rounded(
        self, point: Point, time: Fraction, angles: tuple[str, str] | None = None
    ) -> PathSample | None:
        """The sample at a point; None if the balls are too wide."""
        alpha, theta, length = point
        local = local_map(self.slice_map, length, (alpha, theta), 2)
        j, scale = local.singularity(), self.slice_map.scale_ball()
        first, second = (square.sqrt() for square in local.squared_lengths())
        determinant = j.value / (length * first * second)
        texts = round_all((length / scale, first / scale, second / scale, determinant / scale), self.digits)
        if texts is None:
            return None
        if angles is None:
            degrees = round_all((wrapped(alpha), wrapped(theta)), self.digits)
            if degrees is None:
                return None
            angles = angle_text(degrees[0]), angle_text(degrees[1])
        clearance = clearance_of(self.slice_map, length, j) * 180 / arb.pi()
        leg = self.slice_map.fixed_leg
        legs = dict(zip((leg, *free_legs(leg)), texts[:3], strict=True))
        bound = round_down(clearance.lower(), _BOUND_DIGITS)
        return PathSample(time, (legs[1], legs[2], legs[3]), *angles, texts[3], bound)


def wrapped(angle: arb) -> arb:
    """An angle in degrees, in (−180, 180] up to the width of its ball."""
    degrees = angle * 180 / arb.pi()
    return degrees - 360 * ceil((float(degrees.mid()) - 180) / 360)


def _joint(slice_map: SliceMap, arcs: Sequence[Arc]) -> Joint:
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
