"""The number of aspects of the slices in each interval of a census.

The singular curves of two slices are isotopic if no slice between them has a pose with ∇J = 0 at which they
change: the torus is compact, and elsewhere J = 0 moves smoothly with L. All poses with ∇J = 0 are degenerate,
so they are among the events of the survey; a swallowtail is none of them. If events are not isolated, their
lengths are not known, and no number is given.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise

from rpr_solver.errors import SolverError
from rpr_solver.model.classify import PoseKind
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.singular.aspects import aspect_cells
from rpr_solver.singular.sweep import sweep
from rpr_solver.transitions.event_types import Event
from rpr_solver.transitions.survey import Survey


def numbers_of_aspects(result: Survey, transitions: Sequence[int]) -> tuple[int | None, ...]:
    """The number of aspects between the groups of events that are transitions; None where it is not known.

    Args:
        result: the survey.
        transitions: the numbers of the groups at which intervals end.
    """
    if result.method != "events":
        return (None,) * (len(transitions) + 1)
    slice_map = result.eliminant.slice_map
    numbers: list[int | None] = []
    for k, table in enumerate(result.slices):
        same = bool(k) and all(map(_keeps_the_curve, result.groups[k - 1]))
        numbers.append(numbers[-1] if same else _number(slice_map, table.length))
    ends = [0, *(k + 1 for k in transitions), len(numbers)]
    parts = (set(numbers[start:stop]) for start, stop in pairwise(ends))
    return tuple(part.pop() if len(part) == 1 else None for part in parts)


def _keeps_the_curve(event: Event) -> bool:
    return event.pose is not None and event.pose.kind is PoseKind.SWALLOWTAIL


def _number(slice_map: SliceMap, length: Fraction) -> int | None:
    """The number of aspects of the slice of a length in the user's unit."""
    try:
        return len(aspect_cells(sweep(slice_map, length * slice_map.scale)))
    except SolverError:
        return None
