"""All poses of one joint vector."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import rpr_solver
from rpr_solver import DEFAULT_DIGITS, Manipulator, exact_str
from worker.answers.requests import JobRequest, Kind, Progress
from worker.answers.store import ResultStore

KIND = Kind("poses", "po-")
LEGS = ("l1", "l2", "l3")


def poses_request(
    manipulator: Manipulator, lengths: Sequence[Fraction], *, digits: int = DEFAULT_DIGITS
) -> JobRequest:
    """The request for the poses with three leg lengths."""
    legs = {leg: exact_str(length) for leg, length in zip(LEGS, lengths, strict=True)}
    return JobRequest(KIND, {"geometry": manipulator.to_json(), **legs, "digits": digits})


def compute_poses(request: JobRequest, _store: ResultStore, _progress: Progress) -> dict[str, Any]:
    """Compute all poses, which takes milliseconds."""
    lengths = (request.content[leg] for leg in LEGS)
    return rpr_solver.poses(request.manipulator, *lengths, digits=request.digits).to_json()
