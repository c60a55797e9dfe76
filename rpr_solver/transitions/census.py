"""The census: every L at which the number of cusps changes, and the proved numbers between (survey.py)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, TypedDict

from rpr_solver.contract import (
    DEFAULT_DIGITS,
    MIN_DIGITS,
    Progress,
    check_digits,
    check_leg,
    check_type,
    document_head,
    silent,
)
from rpr_solver.exact.rationals import Exact, exact_str, parse_not_negative
from rpr_solver.model.joint_points import JointPoint, Kind, PoseKind
from rpr_solver.model.lengths import LengthRange, intervals_json
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.notebook import Row, counted, degenerate_words, html_table, shortened, with_floats
from rpr_solver.notebook.figure import Figure, Pictured, draw, shown_as_svg
from rpr_solver.transitions.degeneracies import Degeneracy, degeneracies
from rpr_solver.transitions.event_systems import Event, event_point, length_text
from rpr_solver.transitions.shared_joints import shared_degeneracies
from rpr_solver.transitions.survey import Survey, numbers_of_aspects, survey
from rpr_solver.transitions.windows import IgnoredWindow, Part, ignored


class LengthKind(Kind):
    """The kind of a transition, or of the end of a curve of cusps, to which no kind of pose applies.

    >>> LengthKind.OPEN == "open"
    True
    """

    SEVERAL = "several"
    """Degenerate poses of different kinds share this length."""
    UNCLASSIFIED = "unclassified"
    """The number of cusps changes, or may change, but no degenerate pose is known."""
    UNDECIDED = "undecided"
    """Curves are cut here: it is not proved which cusps continue through this length and which end there."""
    OPEN = "open"
    """No transition: the length 0, or infinity."""


class CensusCertificate(TypedDict):
    """The proof of a census.

    ``method`` is ``"events"`` if the degenerate poses of all slices are isolated, else ``"components"``: as
    for similar triangles, the events of the curves in α and θ that hold all cusps. ``lengths_examined`` is
    the number of their lengths; the cusps are counted in exact slices between neighbouring ones. Where legs
    share joints, it is ``"shared-joints"``: no slice has a cusp.
    """

    method: str
    lengths_examined: int
    counts_by: str


@dataclass(frozen=True)
class TransitionEvent:
    """A degenerate pose of a transition: its ``kind``, and its ``point`` in the slice of that length.

    >>> point = JointPoint(1, ("-164.31635", "1.9900466", "5.6731201", "34.945249"))
    >>> TransitionEvent(PoseKind.SWALLOWTAIL, point)
    <TransitionEvent swallowtail at alpha_deg=-164.31635 theta1_deg=1.9900466 l2=5.6731201 l3=34.945249>
    """

    kind: PoseKind
    point: JointPoint

    def __repr__(self) -> str:
        return f"<TransitionEvent {self.kind} at {repr(self.point)[12:-1]}>"

    def to_json(self) -> dict[str, str]:
        """The contract's object: the kind and the coordinates of the point."""
        return {"kind": self.kind.value, **self.point.to_json()}


@dataclass(frozen=True)
class Transition:
    """A length of the fixed leg at which cusps are born or vanish, or which has a degenerate pose.

    Attributes:
        length: a correctly rounded decimal, in the user's unit.
        kind: the common kind of its events, or why there is none.
        count_before: the number of cusps of the slices just below.
        count_after: the number of cusps of the slices just above.
        events: the degenerate poses.

    >>> Transition("37.3170907382", PoseKind.SWALLOWTAIL, count_before=6, count_after=4, events=())
    <Transition at 37.317090…: swallowtail, 6 to 4 cusps>
    """

    length: str
    kind: PoseKind | LengthKind
    count_before: int
    count_after: int
    events: tuple[TransitionEvent, ...]

    def __repr__(self) -> str:
        counts = f"{self.count_before} to {counted(self.count_after, 'cusp')}"
        return f"<Transition at {shortened(self.length)}: {self.kind}, {counts}>"


@dataclass(frozen=True)
class Census(Pictured):
    """Every transition of the slices of one leg, and the numbers of cusps between.

    Proved: these are all transitions in the range, and every count and every printed digit is right.

    Attributes:
        manipulator: the geometry.
        fixed_leg: the leg whose length varies from slice to slice.
        digits: significant digits of every printed number.
        transitions: all transitions strictly within the range, ascending.
        counts: the number of cusps in each interval between, one entry more than ``transitions``.
        certificate: how the census is proved.
        range: the lengths of the fixed leg, in the user's unit.
        aspects: the number of aspects of the slices in each interval; None where it is not proved to be the
            same in all of them, as for similar or congruent triangles.
        degenerate: what is degenerate in every slice of an interval, or along a whole curve of one slice, as
            for flat or congruent triangles; empty for most manipulators.
        ignore_windows: windows that are narrower are ignored; 0: none.
        ignored_windows: by their places in ``counts``, the intervals that are.

    >>> from rpr_solver import EXAMPLES, census
    >>> table = census(EXAMPLES["zein-flat"], start=30, stop=40, digits=15)
    >>> table
    <Census L1 from 30 to 40: 5 transitions, 4 to 8 cusps, 15 digits>
    >>> [(row["from"], row["count"], row["transition_at_end"]) for row in table.rows()][:2]
    [(30.0, 6, 'beak-to-beak'), (31.8632047694475, 8, 'swallowtail')]
    """

    manipulator: Manipulator
    fixed_leg: int
    digits: int
    transitions: tuple[Transition, ...]
    counts: tuple[int, ...]
    certificate: CensusCertificate
    range: LengthRange
    aspects: tuple[int | None, ...] = ()
    degenerate: tuple[Degeneracy, ...] = ()
    ignore_windows: Fraction = Fraction(0)
    ignored_windows: Mapping[int, IgnoredWindow] = field(default_factory=dict)

    @property
    def kept_counts(self) -> tuple[int, ...]:
        """The numbers of cusps in the intervals that are not ignored; in all, if each of them is."""
        kept = tuple(n for k, n in enumerate(self.counts) if k not in self.ignored_windows)
        return kept or self.counts

    def __repr__(self) -> str:
        low, high = min(self.kept_counts), max(self.kept_counts)
        cusps = counted(high, "cusp") if low == high else f"{low} to {high} cusps"
        transitions = counted(len(self.transitions), "transition")
        narrow = counted(len(self.ignored_windows), "window")
        extra = f", {narrow} ignored" if self.ignored_windows else ""
        extra += ", degenerate" if self.degenerate else ""
        return f"<Census L{self.fixed_leg} {self.range}: {transitions}, {cusps}{extra}, {self.digits} digits>"

    def to_json(self) -> dict[str, Any]:
        """The contract's census document."""
        leg = self.fixed_leg
        return {
            **document_head(self.manipulator, self.digits, leg),
            "range": self.range.to_json(),
            "transitions": [
                {
                    f"l{leg}": t.length,
                    "kind": t.kind.value,
                    "count_before": t.count_before,
                    "count_after": t.count_after,
                    "events": [event.to_json() for event in t.events],
                }
                for t in self.transitions
            ],
            "intervals": self._intervals(),
            **(self._narrow() if self.ignore_windows else {}),
            "degenerate": [part.to_json() for part in self.degenerate],
            "certificate": dict(self.certificate),
        }

    def rows(self) -> list[Row]:
        """A row for each interval, for ``pandas.DataFrame(table.rows())``.

        ``from`` and ``to`` are floats, infinite for an open end; ``from_text`` and ``to_text`` have all
        digits. ``transition_at_end`` is the kind of the transition at ``to``, None at the end of the range.
        """
        return with_floats(self._records())

    def _intervals(self) -> list[dict[str, Any]]:
        ends = [*self.range.to_json().values()]
        ends[1:1] = [t.length for t in self.transitions]
        return intervals_json(ends, self.counts, self.aspects)

    def _narrow(self) -> dict[str, Any]:
        windows = [window.to_json() for window in self.ignored_windows.values()]
        return {"ignore_windows": exact_str(self.ignore_windows), "ignored_windows": windows}

    def _records(self) -> list[dict[str, object]]:
        kinds = [*(t.kind.value for t in self.transitions), None]
        records: list[dict[str, object]] = [
            {**interval, "transition_at_end": kind}
            for interval, kind in zip(self._intervals(), kinds, strict=True)
        ]
        if self.ignore_windows:
            for k, record in enumerate(records):
                record["ignored"] = k in self.ignored_windows
        return records

    def _repr_html_(self) -> str:
        notes = [degenerate_words(part.to_json(), self.fixed_leg) for part in self.degenerate]
        return html_table(repr(self)[1:-1], self._records(), notes, first=self.manipulator.remark)

    def _repr_svg_(self) -> str | None:
        return shown_as_svg(self)

    def figure(self) -> Figure:
        """A picture of the number of cusps against the length of the fixed leg.

        Narrow intervals are widened and marked; a fan of lines leads to an axis that is true to scale.

        Raises:
            InputError: the lengths are too large to be drawn.
        """
        return draw(self.to_json())


def census(
    manipulator: Manipulator,
    *,
    fixed_leg: int = 1,
    digits: int = DEFAULT_DIGITS,
    start: Exact = 0,
    stop: Exact | None = None,
    ignore_windows: Exact = 0,
    progress: Progress | None = None,
) -> Census:
    """Every transition of the slices of one leg, over all lengths > 0 or a range, and the counts between.

    Cusps are born and die only at poses where four poses coalesce (swallowtails) or the singular curve is
    not smooth (lips, beak-to-beak). The lengths of these poses are real algebraic numbers, computed by
    elimination rather than sampling, so that no interval is too narrow.

    Args:
        manipulator: the geometry.
        fixed_leg: the leg whose length varies from slice to slice, 1, 2 or 3.
        digits: significant digits of every printed number, 15 to 10000; all are proved.
        start: the lower end of the range, exact, in the user's unit, excluded; 0 is an open end.
        stop: its upper end, excluded; None is an open end.
        ignore_windows: a width, exact: intervals that are narrower are listed as ignored.
        progress: callback ``progress(done, total)``; ``total`` may grow.

    Raises:
        InputError: naming ``manipulator``, ``fixed_leg``, ``digits``, ``start``, ``stop`` or
            ``ignore_windows``.
        SolverError: a transition could not be decided, or whether a window is narrower.

    >>> from rpr_solver import EXAMPLES
    >>> census(EXAMPLES["zein-flat"], digits=15).counts
    (0, 2, 4, 6, 8, 6, 8, 6, 8, 6, 8, 6, 4)
    >>> census(EXAMPLES["zein-flat"], digits=15, ignore_windows="0.001").kept_counts
    (0, 2, 4, 6, 8, 6, 8, 6, 6, 8, 6, 4)
    """
    digits, fixed_leg = check_digits(digits), check_leg(fixed_leg)
    span, narrow = LengthRange.of(start, stop), parse_not_negative(ignore_windows, "ignore_windows")
    check_type(manipulator, Manipulator, "manipulator")
    if manipulator.geometry.shared_joints:
        return _without_cusps(manipulator, fixed_leg, span, digits, narrow)
    result = survey(manipulator, fixed_leg, progress or silent, start=span.start, stop=span.stop)
    table = _census(result, manipulator, span, digits, has_aspects=True)
    if not narrow:
        return table
    # the groups of events that are transitions, as in the table
    groups = [group for k, group in enumerate(result.groups) if transition_at(result, k, MIN_DIGITS)]
    return _without_narrow(table, result.eliminant.slice_map, groups, narrow)


def _without_narrow(
    table: Census, slice_map: SliceMap, groups: Sequence[Sequence[Event]], least: Fraction
) -> Census:
    """The census with the intervals that are narrower than a width; their ends are those events."""
    ends, texts = [table.range.start, *groups, table.range.stop], table.to_json()["intervals"]
    parts = [
        Part(start, stop, (text["from"], text["to"]), text["count"])
        for start, stop, text in zip(ends, ends[1:], texts, strict=False)
    ]
    windows = {k: window for k, part in enumerate(parts) if (window := ignored(slice_map, [part], least))}
    return replace(table, ignore_windows=least, ignored_windows=windows)


def _without_cusps(
    manipulator: Manipulator, fixed_leg: int, span: LengthRange, digits: int, narrow: Fraction
) -> Census:
    """The census where legs share joints (mathematics.md#shared-joints)."""
    proof: CensusCertificate = {
        "method": "shared-joints",
        "lengths_examined": 0,
        "counts_by": "the lemma on shared joints",
    }
    slice_map = SliceMap.of(manipulator, fixed_leg, with_shared=True)
    degenerate = shared_degeneracies(slice_map, span, digits)
    table = Census(manipulator, fixed_leg, digits, (), (0,), proof, span, (), degenerate)
    return _without_narrow(table, slice_map, (), narrow)


def bare_census(manipulator: Manipulator, fixed_leg: int, digits: int) -> Census:
    """The census of all lengths without the numbers of aspects, which take a third of its time.

    Raises:
        SolverError: a transition could not be decided.
    """
    result = survey(manipulator, fixed_leg, silent)
    return _census(result, manipulator, LengthRange(), digits, has_aspects=False)


def _census(
    result: Survey, manipulator: Manipulator, span: LengthRange, digits: int, *, has_aspects: bool
) -> Census:
    transitions = {
        k: transition for k in range(len(result.groups)) if (transition := transition_at(result, k, digits))
    }
    proof: CensusCertificate = {
        "method": result.method,
        "lengths_examined": len(result.groups),
        "counts_by": "exact slices between neighbours",
    }
    return Census(
        manipulator,
        result.eliminant.slice_map.fixed_leg,
        digits,
        tuple(transitions.values()),
        (result.slices[0].count, *(result.slices[k + 1].count for k in transitions)),
        proof,
        span,
        numbers_of_aspects(result, list(transitions)) if has_aspects else (),
        degeneracies(result, span, digits),
    )


def transition_at(result: Survey, k: int, digits: int) -> Transition | None:
    """The transition at one of the candidate lengths; None if no pose is degenerate and no count changes."""
    group = result.groups[k]
    before, after = result.slices[k].count, result.slices[k + 1].count
    poses = [event.pose for event in group if event.pose and not (event.lasting and before == after)]
    # on components, only poses that cusps meet are events
    if before == after and (not poses or (result.method == "components" and not before)):
        return None
    leg = result.eliminant.slice_map.fixed_leg
    events = tuple(TransitionEvent(pose.kind, event_point(pose, leg, digits)) for pose in poses)
    kinds = {pose.kind for pose in poses}
    kind = LengthKind.UNCLASSIFIED if not kinds else kinds.pop() if len(kinds) == 1 else LengthKind.SEVERAL
    length = length_text(result.eliminant.slice_map, group, digits)
    return Transition(length, kind, before, after, events)
