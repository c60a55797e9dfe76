"""Pose connections: which poses of a joint vector, or of two, are joined."""

from __future__ import annotations

from dataclasses import replace

import rpr_solver
from rpr_solver.contract import MOST_POSES, Progress
from worker.answers.cost import Sizes, one_slice
from worker.answers.requests import Content, Document, JobRequest, Kind, Store

_SUBDIVISION = 0.5
"""Seconds of the subdivision of a slice within joint limits."""
_RANGE = 6
"""A range takes as long as so many slices."""


def compute(request: JobRequest, _store: Store, _progress: Progress) -> Document:
    """Decide for each pair of poses whether a path joins them.

    Raises:
        InputError: the range does not hold the lengths of the fixed leg, or both joint vectors are the same.
        SolverError: the slice could not be decided.
    """
    content = request.content
    to, between = content.get("to"), content.get("between")
    return rpr_solver.pose_connections(
        request.manipulator,
        *(content[leg] for leg in ("l1", "l2", "l3")),
        to=to and [to[leg] for leg in ("l1", "l2", "l3")],
        between=between and (between["from"], between["to"]),
        limits={leg: (part["min"], part["max"]) for leg, part in content.get("limits", {}).items()},
        fixed_leg=request.fixed_leg,
        digits=request.digits,
    ).to_json()


def _measure(content: Content, size: Sizes) -> Sizes:
    slices = _RANGE if "between" in content or "to" in content else 1
    return replace(size, count=slices, limited=slices if "limits" in content else 0)


def _cost(size: Sizes) -> float:
    """The poses, the aspects of the slice or of the range, and the subdivision for both signs."""
    poses = (
        2
        * MOST_POSES
        * (1e-3 + 1e-6 * (size.geometry + size.lengths + size.digits) + 1.5e-8 * size.digits**2)
    )
    return (
        0.02 + poses + 0.015 * size.nearness + size.count * one_slice(size) + 2 * size.limited * _SUBDIVISION
    )


CONNECTIONS = Kind("pose-connections", "pc-", compute, _cost, measure=_measure)
"""Pose connections: the question which poses are joined, and the answer."""
