"""How a path is sampled: by a number of samples, one in each step of time, or as many as are needed for a
small deviation of legs that move linearly from row to row.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import inf
from statistics import median

from rpr_solver.contract import DEFAULT_SAMPLES, MOST_SAMPLES
from rpr_solver.errors import InputError, Unproved, shown
from rpr_solver.exact.decimals import rounded_up
from rpr_solver.exact.numerals import double
from rpr_solver.exact.rationals import Exact, exact_str, parse_positive
from rpr_solver.model.lengths import OF_LIMITS, MotionLimits, MotionQuestion, Sampling, rows_of, sample_count
from rpr_solver.paths.motion import Motion
from rpr_solver.paths.proofs import BOUND_DIGITS
from rpr_solver.paths.routes import Route
from rpr_solver.paths.samples import PathSample, Points
from rpr_solver.paths.timing import NO_DEVIATION, TIMINGS, Course, Deviation, Place, TimedCourse
from rpr_solver.triangles import Surd, UserFrame

_FEW, _PARTS, _BEYOND = 64, 32, 8
"""After so many halvings the number of samples is estimated, by the median of so many parts. Bounds of their
deviations are too large, but hardly 64 times, so that this many times too many samples are too many."""
_SPARE = Fraction(999, 1000)
"""The share of a chord that is used, the rest being for digits."""


@dataclass(frozen=True)
class Sampled:
    """The samples of a path, and what follows from them.

    Attributes:
        samples: points of the path.
        duration: the time of the last one.
        motion: within limits; None if a law of time was given.
        deviation: bounds, by legs, of what linear motion between rows deviates from the path. None unless
            limits of motion or another sampling than by number were asked for.
    """

    samples: tuple[PathSample, ...]
    duration: Fraction
    motion: Motion | None = None
    deviation: Deviation | None = None


@dataclass(frozen=True)
class SamplingPlan:
    """How a path is sampled, and at which times.

    Attributes:
        count: the number of samples; None if they come by steps or chords.
        timing: the law of time; ``"motion"`` with limits of motion.
        duration: the time of the last sample; None with limits of motion.
        step: the time between samples.
        chord: what linear motion between rows may deviate.
        limits: of the motion.
    """

    count: int | None
    timing: str
    duration: Fraction | None
    step: Fraction | None = None
    chord: Fraction | None = None
    limits: MotionLimits | None = None

    @classmethod
    def of(
        cls,
        samples: int | None = None,
        timing: str | None = None,
        duration: Exact | None = None,
        motion: MotionQuestion | None = None,
        sampling: Sampling | None = None,
    ) -> SamplingPlan:
        """The plan, checked; without options that of a path of which nothing more is said.

        Raises:
            InputError: naming ``samples``, ``timing``, ``duration``, ``motion`` or ``sampling``; what follows
                from another one may not be given.
        """
        spare = {"samples": (samples, sampling), "timing": (timing, motion), "duration": (duration, motion)}
        for name, (given, asked) in spare.items():
            if given is not None and asked is not None:
                other = "sampling" if name == "samples" else "motion"
                raise InputError.of(name, f"follows from {other}; leave it out")
        samples = DEFAULT_SAMPLES if samples is None else samples
        timing = "cosine" if timing is None else timing
        rows = (sample_count(samples), None, None) if sampling is None else rows_of(sampling)
        count, step, chord = rows
        if timing not in TIMINGS:
            raise InputError.of("timing", f"{shown(timing)} is unknown; give {', '.join(TIMINGS)}")
        if motion is None:
            time = parse_positive(1 if duration is None else duration, "duration", "a duration must be > 0")
            if step is not None:
                check_steps(step, time)
            return cls(count, timing, time, step, chord)
        return cls(count, OF_LIMITS, None, step, chord, MotionLimits.of(motion))

    def json(self) -> dict[str, dict[str, str]]:
        """The contract's ``sampling``; empty for samples by number."""
        own = {"step": self.step, "chord": self.chord}
        asked = {name: exact_str(x) for name, x in own.items() if x is not None}
        return {"sampling": asked} if asked else {}

    def sampled(
        self,
        route: Route,
        angles: tuple[tuple[str, str], tuple[str, str]],
        digits: int,
        frame: UserFrame | None,
        scale: Surd | None = None,
    ) -> Sampled:
        """The samples of a path, its ends included, and in the given frame if there is one; with condition
        numbers if a length scale is given.

        ``angles`` are α and θ at the ends, as text, in (−180, 180].

        Raises:
            InputError: naming ``sampling`` or ``motion``.
            Unproved: the digits of a sample could not be proved.
        """
        course: Course
        if self.limits is None:
            assert self.duration is not None, "a law of time has a duration"
            course, motion = TimedCourse(route, self.timing, self.duration), None
        else:
            course = motion = Motion.of(route, self.limits)
        points, samples = Points.of(route, digits, frame, scale), []
        times = list(self._times(course))
        for k, time in enumerate(times):
            if 0 < k < len(times) - 1:
                arc, tau = course.place(time)
                samples.append(points.between(arc, tau, time))
            else:
                pose = route.stop if k else route.start
                place = Fraction(len(route.arcs) if k else 0)
                samples.append(points.end(pose, angles[1 if k else 0], time, place))
        deviation = None
        if motion is not None or self.count is None:
            deviation = self._deviation(course, samples, route, digits)
        return Sampled(tuple(samples), course.duration, motion, deviation)

    def _times(self, course: Course) -> Iterator[Fraction]:
        duration = course.duration
        if self.count is not None:
            yield from (duration * Fraction(k, self.count - 1) for k in range(self.count))
        elif self.step is not None:
            check_steps(self.step, duration)
            yield from (self.step * k for k in range(-int(-duration / self.step // 1)))
            yield duration
        else:
            yield from self._by_chord(course)

    def _by_chord(self, course: Course) -> Iterator[Fraction]:
        """Times, halved until linear motion between them is near enough to the path."""
        assert self.chord is not None, "a plan has a number, a step or a chord"
        most = self.chord * _SPARE
        zero, end = Fraction(0), course.duration
        stack, count = [(zero, end)], 1
        yield zero
        while stack:
            low, high = stack.pop()
            if max(course.deviation((low, high), (course.place(low), course.place(high)))) <= most:
                yield high
                continue
            count += 1
            needed = self._needed(course, most) if count == _FEW else [0.0]
            if count >= MOST_SAMPLES or len(needed) * median(needed) > _BEYOND * MOST_SAMPLES:
                message = f"is {exact_str(self.chord)}; it needs more than {MOST_SAMPLES} samples"
                if 0 < (total := sum(needed)) < inf:
                    enough = rounded_up(self.chord * Fraction(2 * total / MOST_SAMPLES) ** 2, 1)
                    message += f": give about {exact_str(enough)} or more"
                raise InputError.of("sampling.chord", message)
            middle = (low + high) / 2
            stack += [(middle, high), (low, middle)]

    def _needed(self, course: Course, most: Fraction) -> list[float]:
        """About how many samples are needed in each of a few parts of the path, from their deviations.

        A chord that is far too small is refused by it at once, rather than after as many samples as may be.
        """
        marks = [
            (time, course.place(time)) for time in (course.duration * k / _PARTS for k in range(_PARTS + 1))
        ]
        return [double(max(own) / most) ** 0.5 for own in _deviations(course, marks)]

    def _deviation(
        self, course: Course, samples: Sequence[PathSample], route: Route, digits: int
    ) -> Deviation:
        """The greatest deviation between rows, rounded up; with what their digits may be wrong."""
        marks = [(sample.time, _arc_of(sample.place, len(route.arcs))) for sample in samples]
        worst = tuple(map(max, *_deviations(course, marks), NO_DEVIATION))
        rounding = [
            max(Fraction(sample.lengths[k]) for sample in samples) / 10 ** (digits - 1) for k in range(3)
        ]
        held, length = route.slice_map.fixed_leg - 1, route.start.legs[0] / route.slice_map.scale
        if not worst[held] and all(Fraction(sample.lengths[held]) == length for sample in samples):
            rounding[held] = Fraction(0)
        if self.chord is not None and max(map(sum, zip(worst, rounding, strict=True))) > self.chord:
            raise Unproved("the chord is too small for these digits; ask for more digits")
        return tuple(rounded_up(x + y, BOUND_DIGITS) for x, y in zip(worst, rounding, strict=True))


def _deviations(course: Course, marks: Sequence[tuple[Fraction, Place]]) -> list[Deviation]:
    """Those between each time and place and the next."""
    return [course.deviation((a, b), (x, y)) for (a, x), (b, y) in pairwise(marks)]


def _arc_of(place: Fraction, arcs: int) -> Place:
    arc = min(int(place), arcs - 1)
    return arc, place - arc


def check_steps(step: Fraction, duration: Fraction) -> None:
    """Checks that steps of time do not give too many samples.

    Raises:
        InputError: naming ``sampling.step``.
    """
    if duration / step > MOST_SAMPLES - 1:
        message = f"is {exact_str(step)}; it gives more than {MOST_SAMPLES} samples"
        raise InputError.of("sampling.step", message)
