"""What may be asked of a path beside its ends."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypedDict

from rpr_solver.contract import DEFAULT_SAMPLES, PATH_DIGITS, check_digits, check_leg
from rpr_solver.exact.rationals import Exact
from rpr_solver.model.lengths import Bounds, ExactLimits, read_limits
from rpr_solver.model.motion_limits import MotionQuestion, Sampling
from rpr_solver.paths.sampling import SamplingPlan


class PathOptions(TypedDict, total=False):
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
    """

    limits: ExactLimits | None
    fixed_leg: int
    digits: int
    samples: int
    timing: str
    duration: Exact
    motion: MotionQuestion | None
    sampling: Sampling | None


@dataclass(frozen=True)
class PathTerms:
    """The options of a path, checked: the fixed leg, the digits, how it is sampled, and its joint limits."""

    leg: int
    digits: int
    plan: SamplingPlan
    bounds: Mapping[int, Bounds]

    @classmethod
    def of(
        cls,
        *,
        limits: ExactLimits | None = None,
        fixed_leg: int = 1,
        digits: int = PATH_DIGITS,
        samples: int = DEFAULT_SAMPLES,
        timing: str = "cosine",
        duration: Exact = 1,
        motion: MotionQuestion | None = None,
        sampling: Sampling | None = None,
    ) -> PathTerms:
        """The terms of :class:`PathOptions`.

        Raises:
            InputError: naming the option at fault.
        """
        digits, leg = check_digits(digits), check_leg(fixed_leg)
        plan = SamplingPlan.of(samples, timing, duration, motion, sampling)
        return cls(leg, digits, plan, read_limits({} if limits is None else limits, "limits"))
