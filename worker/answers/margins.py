"""Margins: how far the lengths of a geometry may change. Checks of requirements, which may ask for one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import rpr_solver
from rpr_solver import Requirement
from rpr_solver.contract import MIN_DIGITS, SHORT, Progress
from rpr_solver.margins.questions import OPEN, PROVED, REFUTED
from worker.answers.cost import Sizes, all_events
from worker.answers.requests import Content, Document, JobRequest, Kind, Store, answer

_CENSUSES = 6
"""Censuses and slices of other geometries, in the search for a counter-example."""
_BOXES_SECONDS = 4.0


def margin(request: JobRequest, _store: Store, progress: Progress) -> Document:
    """Compute the margin of a slice, of a requirement or of a window.

    Raises:
        SolverError: the geometry itself could not be decided.
    """
    content = request.content
    requirement = content.get("requirement")
    return rpr_solver.margin(
        request.manipulator,
        content.get("length"),
        requirement=None if requirement is None else rpr_solver.Requirement.from_json(requirement),
        window=content.get("window"),
        fixed_leg=request.fixed_leg,
        weights=content.get("weights"),
        tolerance=content.get("tolerance"),
        certificate=content.get("certificate", SHORT),
        progress=progress,
    ).to_json()


_OF_MARGIN = ("verdict", "reason", "validity", "first_order", "counterexample", "certificate")
_ITSELF = "the manipulator itself does not satisfy the requirement"
_NOTHING_FOUND = "no proof and no counter-example was found in {boxes} boxes"
_CHANGES = "; the number of cusps changes within the range, which makes proofs harder"


def check(request: JobRequest, store: Store, progress: Progress) -> Document:
    """Prove or refute a requirement, with a tolerance for every geometry within it.

    Raises:
        SolverError: it could not be decided for the geometry itself.
    """
    content = dict(request.content)
    tolerance = content.pop("tolerance", None)
    if tolerance is None:
        requirement = Requirement.from_json(content["requirement"], max_digits=1 << 20)
        return rpr_solver.check(
            request.manipulator, requirement, digits=request.digits, progress=progress
        ).to_json()
    steps = 0

    def first(done: int, total: int) -> None:
        nonlocal steps
        steps = total
        progress(done, total)

    report = answer(replace(request, content=content), store, first)
    if not report["passed"]:
        return within_tolerance(report, None, tolerance)
    asked = {"requirement": content["requirement"], "fixed_leg": content["requirement"]["fixed_leg"]}
    found = answer(
        margin_request(request.geometry, asked, tolerance),
        store,
        lambda done, total: progress(steps + done, steps + total),
    )
    return within_tolerance(report, found, tolerance)


def margin_request(
    geometry: Mapping[str, str], asked: Mapping[str, Any], tolerance: Mapping[str, str]
) -> JobRequest:
    """Returns the question whether all geometries within a tolerance have a property.

    `asked` is the property as in the canonical form of a question for a margin, with `fixed_leg`.
    """
    content = {"geometry": geometry, "digits": MIN_DIGITS, **asked, "tolerance": tolerance}
    return JobRequest(MARGIN, content)


def within_tolerance(report: Document, found: Document | None, tolerance: Mapping[str, str]) -> Document:
    """Returns a report of a check that passes only if all geometries within the tolerance do.

    `found` is the margin; None if the geometry itself does not satisfy the requirement.
    """
    margin = {"tolerance": dict(tolerance), **dict.fromkeys(_OF_MARGIN)}
    if found is None:
        margin |= {"verdict": REFUTED, "reason": _ITSELF}
    else:
        margin |= {name: found[name] for name in _OF_MARGIN}
        if margin["verdict"] == OPEN and margin["reason"] is None:
            changes = _CHANGES if len(report.get("intervals", ())) > 1 else ""
            margin["reason"] = _NOTHING_FOUND.format(boxes=found["certificate"]["boxes"]) + changes
    return {**report, "passed": margin["verdict"] == PROVED, "margin": margin}


def _check_cost(size: Sizes) -> float:
    return all_events(size) + (_cost(size) if size.censuses else 0)


def _measure_check(content: Content, size: Sizes) -> Sizes:
    return replace(size, censuses=_CENSUSES) if "tolerance" in content else size


def _cost(size: Sizes) -> float:
    return _BOXES_SECONDS + _CENSUSES * all_events(replace(size, digits=max(size.digits, 30)))


MARGIN = Kind("margin", "ma-", margin, _cost, unit="boxes")
CHECK = Kind("check", "ch-", check, _check_cost, measure=_measure_check)
