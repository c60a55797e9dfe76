"""What may be asked of a path beside its ends; and its clearance, if that is asked for.

The clearance is how far a path keeps from all singular poses of its slice: the radius, in degrees of (α, θ),
of a tube round the path in which J is proved to have no zero; and, as a change of leg lengths, what both free
legs may at least change together before the pose meets a fold.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import TypedDict, Unpack

from flint import arb, ctx

from rpr_solver.contract import DEFAULT_SAMPLES, PATH_DIGITS, check_digits, check_leg
from rpr_solver.exact.decimals import rounded_down
from rpr_solver.exact.rationals import Exact, exact_or_none, exact_str, parse_positive
from rpr_solver.exact.real_roots import fraction_of
from rpr_solver.model.lengths import Bounds, ExactLimits, MotionQuestion, Sampling, read_limits
from rpr_solver.paths.proofs import PROOF_BITS
from rpr_solver.paths.route import Arc, ControlPoint, Route
from rpr_solver.paths.samples import BOUND_DIGITS
from rpr_solver.paths.sampling import SamplingPlan

BEST = "best"
"""Asks for the widest path; a number, in degrees, for one with at least this clearance."""


def read_clearance(asked: Exact | None) -> Fraction | None:
    """The clearance that is required, in degrees; 0 for the greatest one, None if none is asked for.

    Raises:
        InputError: naming ``clearance``.
    """
    if asked is None:
        return None
    if asked == BEST:
        return Fraction(0)
    return parse_positive(asked, "clearance", f"give {BEST!r} or a number of degrees > 0")


class SamplingOptions(TypedDict, total=False):
    """The options of :class:`PathOptions` that say how a path is sampled."""

    samples: int
    timing: str
    duration: Exact
    motion: MotionQuestion | None
    sampling: Sampling | None


class PathOptions(SamplingOptions, total=False):
    """What may be asked of a path beside its ends.

    Attributes:
        limits: joint limits that the path keeps: the least and the greatest length of legs, exact, None for
            an open end: ``{"l2": (5, "20.5"), "l3": (None, 30)}``, or with the legs' numbers as keys.
        fixed_leg: the leg of fixed length, 1, 2 or 3; 1 unless given.
        digits: significant digits of every printed number, 15 to 10000; all are proved. 15 unless given.
        samples: the number of samples, 2 to 10001 (see :meth:`Path.resampled`); 101 unless given.
        timing: the law of time: ``"cosine"`` unless given, ``"trapezoid"`` or ``"constant"``.
        duration: the time of the last sample, exact, > 0; 1 unless given.
        motion: limits of speed, acceleration and perhaps jerk of the legs, from which the times follow
            (see :meth:`Path.resampled`).
        sampling: instead of ``samples``: ``{"step": …}`` or ``{"chord": …}``.
        clearance: ``"best"`` for the path that keeps as far from singular poses as possible, or how far it
            must keep from them, exact, in degrees (:class:`Clearance`). Any path unless given.
    """

    limits: ExactLimits | None
    fixed_leg: int
    digits: int
    clearance: Exact | None


_USUAL: SamplingOptions = {"samples": DEFAULT_SAMPLES, "timing": "cosine", "duration": 1}


@dataclass(frozen=True)
class PathTerms:
    """The options of a path, checked: the fixed leg, the digits, how it is sampled, and its joint limits.

    ``clearance`` is in degrees, 0 for the greatest one, and None for any path.
    """

    leg: int
    digits: int
    plan: SamplingPlan
    bounds: Mapping[int, Bounds]
    clearance: Fraction | None

    @classmethod
    def of(
        cls,
        *,
        limits: ExactLimits | None = None,
        fixed_leg: int = 1,
        digits: int = PATH_DIGITS,
        clearance: Exact | None = None,
        **sampled: Unpack[SamplingOptions],
    ) -> PathTerms:
        """The terms of :class:`PathOptions`.

        Raises:
            InputError: naming the option at fault.
        """
        digits, leg = check_digits(digits), check_leg(fixed_leg)
        given: SamplingOptions = {**_USUAL, **sampled}
        plan = SamplingPlan.of(**given)
        bounds = read_limits({} if limits is None else limits, "limits", held=leg)
        return cls(leg, digits, plan, bounds, read_clearance(clearance))


def span_json(ends: tuple[Fraction, Fraction] | None) -> dict[str, str] | None:
    """A closed range of lengths, exact."""
    return ends and {"from": exact_str(ends[0]), "to": exact_str(ends[1])}


def document_lengths(lengths: Sequence[Fraction] | None) -> dict[str, str]:
    """The leg lengths at both ends by name, exact; none if each end has its own."""
    return {f"l{leg}": exact_str(length) for leg, length in enumerate(lengths or (), 1)}


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


def _is_straight(*points: ControlPoint | None) -> bool:
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
