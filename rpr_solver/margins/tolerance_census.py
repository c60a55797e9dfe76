"""The census of a tolerance: what holds for every geometry within it (mathematics.md#census-of-a-tolerance).

Each transition of the given geometry is located for all geometries (located.py), and exclusion.py shows that
none of them has another. Where that fails, a range of lengths stays open, and is named.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any, Unpack

from rpr_solver.contract import DEFAULT_DIGITS, LENGTHS, check_type, silent
from rpr_solver.exact.rationals import Exact, exact_or_none, exact_str
from rpr_solver.margins.bands import (
    Bands,
    OpenRange,
    Piece,
    Span,
    Transition,
    merged,
    transitions_of,
    zones_of,
)
from rpr_solver.margins.exclusion import exclude
from rpr_solver.margins.expansions import ANGLES
from rpr_solver.margins.options import TOO_WIDE, SearchOptions, changes, check_margins, degenerate_throughout
from rpr_solver.margins.problems import GeometryBox, Problem, validity
from rpr_solver.model.lengths import LengthRange
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.notebook import counted
from rpr_solver.transitions.census import census

MOST_BOXES = 120_000
"""The number of boxes of a search, some ten seconds."""


@dataclass(frozen=True)
class ToleranceCensus:
    """What holds for all geometries within a tolerance.

    Attributes:
        document: the census of the given geometry, as the contract has it.
        tolerance: how much each length may be off, by the names of the lengths.
        spans: for each transition of the range the lengths between which every geometry has it, with as many
            events and no others; None if that is not proved.
        pieces: the range in parts, ascending, with bounds of the numbers of cusps of all geometries.
        open: the ranges about which not all is proved; empty if every geometry has these transitions, in
            this order, with these numbers of cusps between, and no others.
        boxes: the number of boxes of the proof.

    >>> from rpr_solver import EXAMPLES, tolerance_census
    >>> table = tolerance_census(EXAMPLES["innocenti"], "0.0001", start=27, stop="28.1", digits=15)
    >>> table.complete, [float(end) for end in table.spans[0]]
    (True, [28.094052, 28.095737])
    """

    document: Mapping[str, Any]
    tolerance: Mapping[str, Fraction]
    spans: tuple[Span | None, ...]
    pieces: tuple[Piece, ...]
    open: tuple[OpenRange, ...]
    boxes: int

    def __repr__(self) -> str:
        span = LengthRange.of(self.document["range"]["from"], self.document["range"]["to"])
        known = "complete" if self.complete else f"{counted(len(self.open), 'range')} open"
        transitions = counted(len(self.spans), "transition")
        return f"<ToleranceCensus L{self.document['fixed_leg']} {span}: {transitions}, {known}>"

    @property
    def complete(self) -> bool:
        """Whether nothing is open."""
        return not self.open

    def to_json(self) -> dict[str, Any]:
        """The contract's census document, with what holds for all geometries."""
        ends = ((None, None) if span is None else map(exact_or_none, span) for span in self.spans)
        return {
            **self.document,
            "transitions": [
                {**transition, "from": low, "to": high}
                for transition, (low, high) in zip(self.document["transitions"], ends, strict=True)
            ],
            "tolerance": {name: exact_str(x) for name, x in self.tolerance.items()},
            "complete": self.complete,
            "open": [
                {"from": exact_str(span.start), "to": exact_or_none(span.stop), "reason": reason}
                for span, reason in self.open
            ],
            "certificate": {**self.document["certificate"], "boxes": self.boxes},
        }


def tolerance_census(
    manipulator: Manipulator,
    tolerance: Exact | Mapping[str, Exact],
    *,
    fixed_leg: int = 1,
    digits: int = DEFAULT_DIGITS,
    start: Exact = 0,
    stop: Exact | None = None,
    **search: Unpack[SearchOptions],
) -> ToleranceCensus:
    """The transitions of all geometries within a tolerance, and the numbers of cusps between them.

    Args:
        manipulator: the geometry.
        tolerance: of all lengths, or by their names, those that are missing being exact.
        fixed_leg: the leg whose length varies from slice to slice, 1, 2 or 3.
        digits: significant digits of the census of the given geometry.
        start: the lower end of the range, exact, in the user's unit; 0 is an open end.
        stop: its upper end; None is an open end.
        search: ``most_boxes``, ``may_go_on`` and ``progress``, as for
            :func:`~rpr_solver.margins.margin.margin`.

    Raises:
        InputError: naming the argument at fault.
        SolverError: the census of the given geometry could not be decided.

    >>> from rpr_solver import EXAMPLES
    >>> table = tolerance_census(EXAMPLES["innocenti"], "0.0001", start=28, stop="28.2", digits=15)
    >>> [(float(piece.span.start), piece.least, piece.most) for piece in table.pieces]
    [(28.0, 8, 8), (28.094052, 8, 10), (28.095737, 10, 10), (28.106592, 8, 10), (28.108269, 8, 8)]
    """
    check_type(manipulator, Manipulator, "manipulator")
    check_margins(manipulator)
    span, _ = LengthRange.of(start, stop), changes(None, tolerance)
    of = partial(census, manipulator, fixed_leg=fixed_leg, digits=digits)
    whole = of().to_json()
    part = whole if span == LengthRange() else of(start=span.start, stop=span.stop).to_json()
    return within_tolerance(whole, part, tolerance, **search)


def within_tolerance(
    whole: Mapping[str, Any],
    part: Mapping[str, Any],
    tolerance: Exact | Mapping[str, Exact],
    **search: Unpack[SearchOptions],
) -> ToleranceCensus:
    """As :func:`tolerance_census`, from known censuses of the given geometry.

    Args:
        whole: that of all lengths, as the contract has it.
        part: that of the range.
        tolerance: of all lengths, or by their names.
        search: as there.

    Raises:
        InputError: naming ``tolerance`` or a member of it.

    >>> from rpr_solver import EXAMPLES, census, restrict_census
    >>> whole = census(EXAMPLES["innocenti"], digits=15).to_json()
    >>> table = within_tolerance(whole, restrict_census(whole, 32, 40), {"d1": "0.1"})
    >>> table
    <ToleranceCensus L1 from 32 to 40: 0 transitions, complete>
    """
    weights = changes(None, tolerance)
    names = dict(zip(LENGTHS, weights, strict=True))
    ends = LengthRange.of(part["range"]["from"], part["range"]["to"])
    span = Span(ends.start, ends.stop)
    manipulator = Manipulator.from_json(part["geometry"], max_digits=1 << 20)
    check_margins(manipulator)
    if reason := _flaw(manipulator, weights, whole):
        unknown = (None,) * len(part["transitions"])
        return ToleranceCensus(
            part, names, unknown, (Piece(span, None, None),), (OpenRange(span, reason),), 0
        )
    box = GeometryBox(manipulator, part["fixed_leg"], Fraction(1), weights)
    transitions = transitions_of(whole["transitions"], box)
    boxes, left = _exclude_others(box, span, transitions, **search)
    result = Bands(span, transitions, left, [item["count"] for item in whole["intervals"]])
    lengths = [Fraction(transition[f"l{box.fixed_leg}"]) for transition in part["transitions"]]
    spans = tuple(result.span_of(length) for length in lengths)
    return ToleranceCensus(part, names, spans, tuple(result.pieces()), tuple(result.open()), boxes)


def _flaw(manipulator: Manipulator, weights: Sequence[Fraction], whole: Mapping[str, Any]) -> str | None:
    """Why nothing can be proved; None if nothing of the kind is known."""
    radius = validity(manipulator, weights)
    if radius is not None and radius <= 1:
        return TOO_WIDE
    if reason := degenerate_throughout(part["kind"] for part in whole["degenerate"]):
        return reason
    if whole["certificate"]["method"] != "events":
        return "the triangles are special, and the least change resolves degenerate poses"
    return None


def _exclude_others(
    box: GeometryBox, span: Span, transitions: Sequence[Transition], **search: Unpack[SearchOptions]
) -> tuple[int, list[Span]]:
    """The number of boxes, and the lengths at which geometries may have other degenerate poses, merged."""
    unknown = [one.span for one in transitions if not one.is_whole and one.span.meets(span)]
    progress, most = search.get("progress", silent), search.get("most_boxes", MOST_BOXES)
    may_go_on = search.get("may_go_on", lambda: True)
    boxes, left = 0, list(unknown)
    for problem in box.over(span.start, span.stop, {}):
        zones = zones_of(problem, box, transitions, unknown, goes_on=True)
        result = exclude(problem, max(most - boxes, 0), may_go_on, zones)
        boxes += result.boxes
        progress(min(boxes, most), most)
        low, high = result.left.low[ANGLES], result.left.high[ANGLES]
        left += [_of_user(problem, a, b) for a, b in set(zip(low, high, strict=True))]
    return boxes, [one.rounded() for one in merged(left)]


def _of_user(problem: Problem, low: float, high: float) -> Span:
    """Lengths of a problem in the user's unit."""
    a, b = Fraction(float(low)), Fraction(float(high))
    if problem.inverse:
        return Span(problem.unit / b, problem.unit / a if a else None)
    return Span(a * problem.unit, b * problem.unit)
