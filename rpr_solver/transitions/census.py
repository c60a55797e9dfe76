"""The census: every L at which the number of cusps changes, and the proved number between (survey.py)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from flint import arb, ctx

from rpr_solver.contract import DEFAULT_DIGITS, Progress, check_digits, document_head, silent
from rpr_solver.errors import Unproved
from rpr_solver.exact.decimals import digit_bits, round_ball, round_fraction
from rpr_solver.exact.precision import GREATEST_BITS, TIMES_BEFORE_EXACT, decided
from rpr_solver.exact.rationals import exact_str
from rpr_solver.model.classify import Kind, PoseKind
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.joint_points import JointPoint, joint_point
from rpr_solver.transitions.event_types import Event, EventPose
from rpr_solver.transitions.length_range import check_range
from rpr_solver.transitions.survey import Survey, survey


class LengthKind(Kind):
    """What a transition or the end of a curve of cusps is, where no kind of pose names it."""

    SEVERAL = "several"
    """Degenerate poses of different kinds have this one length."""
    UNCLASSIFIED = "unclassified"
    """The number of cusps changes, or may change, but no pose is known that is degenerate."""
    UNDECIDED = "undecided"
    """Curves are cut here: which cusps pass this length, and which end and begin at it, is not proved."""
    OPEN = "open"
    """No transition: the length 0, or no end at all."""


@dataclass(frozen=True)
class TransitionPoint:
    """One degenerate pose of a transition."""

    kind: PoseKind
    point: JointPoint


@dataclass(frozen=True)
class Transition:
    """A length of the fixed leg at which cusps are born or die, or a degenerate pose is passed.

    ``length`` is a correctly rounded decimal in the user's unit. ``kind`` is that of its points, where they
    have one.
    """

    length: str
    kind: PoseKind | LengthKind
    count_before: int
    count_after: int
    points: tuple[TransitionPoint, ...]


@dataclass(frozen=True)
class Census:
    """All transitions strictly within a range, ascending, and the number of cusps in each interval between.

    ``counts`` has one entry more than ``transitions``. ``start`` and ``stop`` are in the user's unit; None
    is a range without end.
    """

    manipulator: Manipulator
    fixed_leg: int
    digits: int
    transitions: tuple[Transition, ...]
    counts: tuple[int, ...]
    certificate: dict[str, object] = field(repr=False)
    start: Fraction = Fraction(0)
    stop: Fraction | None = None

    def to_json(self) -> dict[str, object]:
        """The contract's census document."""
        leg = self.fixed_leg
        stop = None if self.stop is None else exact_str(self.stop)
        ends = [exact_str(self.start), *(t.length for t in self.transitions), stop]
        return {
            **document_head(self.manipulator, self.digits, leg),
            "range": {"from": ends[0], "to": ends[-1]},
            "transitions": [
                {
                    f"l{leg}": t.length,
                    "kind": t.kind.value,
                    "count_before": t.count_before,
                    "count_after": t.count_after,
                    "events": [{"kind": p.kind.value, **p.point.to_json(leg)} for p in t.points],
                }
                for t in self.transitions
            ],
            "intervals": [
                {"from": start, "to": stop, "count": count}
                for start, stop, count in zip(ends, ends[1:], self.counts, strict=False)
            ],
            "certificate": self.certificate,
        }


def census(
    manipulator: Manipulator,
    *,
    fixed_leg: int = 1,
    digits: int = DEFAULT_DIGITS,
    start: Fraction = Fraction(0),
    stop: Fraction | None = None,
    progress: Progress | None = None,
) -> Census:
    """Every transition of the slices of one leg, over all lengths > 0 or a range (method.md section 5).

    Args:
        manipulator: the geometry.
        fixed_leg: the leg that is held, 1, 2 or 3.
        digits: significant digits of every printed number.
        start, stop: the range in the user's unit, without its ends; None is no end.
        progress: told the steps done and their number.

    Raises:
        InputError: ``fixed_leg`` or ``digits`` is out of range, or the range is empty.
        SolverError: a transition could not be decided; nothing was guessed.
    """
    check_digits(digits)
    check_range(start, stop)
    found = survey(manipulator, fixed_leg, progress or silent, start=start, stop=stop)
    kept = {
        k: transition for k in range(len(found.groups)) if (transition := transition_at(found, k, digits))
    }
    certificate: dict[str, object] = {
        "method": found.method,
        "lengths_examined": len(found.groups),
        "counts_by": "exact slices between neighbours",
    }
    return Census(
        manipulator,
        fixed_leg,
        digits,
        tuple(kept.values()),
        (found.slices[0].count, *(found.slices[k + 1].count for k in kept)),
        certificate,
        start,
        stop,
    )


def transition_at(found: Survey, k: int, digits: int) -> Transition | None:
    """The transition at one of the lengths examined; None if the cusps pass it as if nothing was there."""
    group = found.groups[k]
    before, after = found.slices[k].count, found.slices[k + 1].count
    poses = [event.pose for event in group if event.pose]
    if before == after and not poses:
        return None
    points = tuple(TransitionPoint(pose.kind, _point(pose, digits)) for pose in poses)
    kinds = {pose.kind for pose in poses}
    kind = LengthKind.UNCLASSIFIED if not kinds else kinds.pop() if len(kinds) == 1 else LengthKind.SEVERAL
    length = length_text(found.eliminant.slice_map, group, digits)
    return Transition(length, kind, before, after, points)


def length_text(slice_map: SliceMap, group: Sequence[Event], digits: int) -> str:
    """The length of simultaneous events as a correctly rounded decimal in the user's unit."""
    for event in group:
        if event.exact_length is not None and event.exact_length.rational is not None:
            return round_fraction(event.exact_length.rational / slice_map.scale, digits)

    def length(bits: int) -> list[arb]:
        ball = group[0].scaled_length(bits)
        with ctx.workprec(bits):
            return [ball / slice_map.scale_ball()]

    return _rounded(length, digits, GREATEST_BITS)[0]


def _point(pose: EventPose, digits: int) -> JointPoint:
    limit = TIMES_BEFORE_EXACT * digit_bits(digits) if pose.exact else GREATEST_BITS
    try:
        return joint_point(_rounded(pose.coordinates, digits, limit))
    except Unproved:
        exact = pose.exact and pose.exact()
        if exact is None:
            raise
        return _point(exact, digits)


def _rounded(balls: Callable[[int], Sequence[arb]], digits: int, limit: int) -> list[str]:
    def texts(bits: int) -> list[str] | None:
        values = balls(bits)
        with ctx.workprec(bits):
            rounded = [round_ball(x, digits) for x in values]
        known = [text for text in rounded if text is not None]
        return known if len(known) == len(values) else None

    return decided(texts, digit_bits(digits) + 128, limit, "the digits of a transition could not be decided")
