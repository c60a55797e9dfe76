"""Censuses: the whole census is computed and kept, and its parts are cut from it. Checks of requirements, and
margins: how far the lengths of a geometry may change."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import rpr_solver
from rpr_solver import Requirement
from rpr_solver.contract import MIN_DIGITS, Progress
from rpr_solver.margins.options import OPEN, PROVED, REFUTED
from rpr_solver.triangles import Canonical
from worker.answers.cost import Sizes, all_events
from worker.answers.kind import (
    ALL_LENGTHS,
    Content,
    Document,
    JobRequest,
    Kind,
    Store,
    answer,
    content_range,
    in_turn,
    known_document,
)

SENSITIVITIES, TOLERANCE, IGNORE_WINDOWS = "sensitivities", "tolerance", "ignore_windows"
"""Members of a question about the same census: for the sensitivities of its events, or all geometries within
a tolerance, or for the intervals that are narrow."""
_BOXES_SECONDS = 6.0


def derive(request: JobRequest, store: Store) -> Document | None:
    """Returns a census that follows from known ones, else None: from the whole one with as many digits or
    more; with sensitivities from the same without them."""
    return _cut(request, store) if _is_plain(request) else _moved(request, store)


def _is_plain(request: JobRequest) -> bool:
    return request.content.keys().isdisjoint({SENSITIVITIES, TOLERANCE, IGNORE_WINDOWS})


def _without(request: JobRequest, member: str) -> JobRequest:
    content = {name: value for name, value in request.content.items() if name != member}
    return replace(request, content=content)


def _moved(request: JobRequest, store: Store) -> Document | None:
    """Returns a census with sensitivities that follows from the same without them, else None."""
    if SENSITIVITIES not in request.content:
        return None
    plain = known_document(_without(request, SENSITIVITIES), store)
    return None if plain is None else rpr_solver.with_sensitivities(plain)


def _with_more(request: JobRequest, store: Store, progress: Progress) -> Document:
    """The same census with sensitivities, for all geometries within a tolerance, or with what is narrow."""
    if SENSITIVITIES in request.content:
        return rpr_solver.with_sensitivities(answer(_without(request, SENSITIVITIES), store, progress))
    if IGNORE_WINDOWS in request.content:
        return solved(request, progress)  # its decimals may not tell how wide an interval is
    part = answer(_without(request, TOLERANCE), store, progress)
    whole = answer(_whole(request, request.digits), store, progress)
    return rpr_solver.within_tolerance(whole, part, request.content[TOLERANCE], progress=progress).to_json()


def _cut(request: JobRequest, store: Store) -> Document | None:
    start, stop = content_range(request.content)
    for digits in store.census_digits(_family(request)):
        whole = store.get_document(_whole(request, digits)) if digits >= request.digits else None
        part = whole and rpr_solver.restrict_census(whole, start, stop, request.digits)
        if part:
            return part
    return None


def census(request: JobRequest, store: Store, progress: Progress) -> Document:
    """Compute a census; the whole one is kept for other ranges.

    Raises:
        SolverError: a transition could not be decided.
    """
    if not _is_plain(request):
        return _with_more(request, store, progress)
    if not store.keeps:
        return solved(request, progress)
    whole = store.document(
        _whole(request, request.digits), lambda: solved(_whole(request, request.digits), progress)
    )
    store.note_census(_family(request), request.digits)
    if request == _whole(request, request.digits):
        return whole
    part = rpr_solver.restrict_census(whole, *content_range(request.content))
    # None: the decimals do not separate an end of the range from a transition that is very near or equal
    return solved(request, progress) if part is None else part


def solved(request: JobRequest, progress: Progress) -> Document:
    """The census of a range, computed from scratch.

    Raises:
        SolverError: a transition could not be decided.
    """
    start, stop = content_range(request.content)
    return rpr_solver.census(
        request.manipulator,
        fixed_leg=request.fixed_leg,
        digits=request.digits,
        start=start,
        stop=stop,
        ignore_windows=request.content.get(IGNORE_WINDOWS, 0),
        progress=progress,
    ).to_json()


def _whole(request: JobRequest, digits: int) -> JobRequest:
    """Returns the request for the census of all lengths."""
    of = {"geometry": request.geometry, "fixed_leg": request.fixed_leg}
    return JobRequest(CENSUS, {**of, "digits": digits, "range": ALL_LENGTHS}, points=request.points)


def _family(request: JobRequest) -> JobRequest:
    """Returns a request that stands for the census of a manipulator and a leg at any number of digits."""
    return JobRequest(CENSUS, {"geometry": request.geometry, "fixed_leg": request.fixed_leg})


def _measure_census(content: Content, size: Sizes) -> Sizes:
    return replace(size, censuses=1) if TOLERANCE in content else size


def _census_cost(size: Sizes) -> float:
    return all_events(size) + (_BOXES_SECONDS if size.censuses else 0)


CENSUS = Kind("census", "ce-", census, _census_cost, derive=derive, measure=_measure_census)


_CENSUSES = 2
"""Censuses and slices of other geometries, in the search for a counter-example."""
_MARGIN_BOXES_SECONDS = 0.8
_MODES_SECONDS = 1.7
"""Of a change of assembly mode in a range, possible (0.6) or excluded (4 to 5)."""


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
        requirement=None
        if requirement is None
        else rpr_solver.Requirement.from_json(requirement, max_digits=1 << 20),
        window=content.get("window"),
        fixed_leg=request.fixed_leg,
        weights=content.get("weights"),
        tolerance=content.get("tolerance"),
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
    first, second = in_turn(progress)
    wish = Requirement.from_json(content["requirement"], max_digits=1 << 20)
    if wish.mode_change is not None:
        return _with_mode_change(replace(request, content=content), wish, store, (first, second), tolerance)
    report = answer(replace(request, content=content), store, first)
    if not report["passed"]:
        return within_tolerance(report, None, tolerance)
    asked = {"requirement": content["requirement"], "fixed_leg": content["requirement"]["fixed_leg"]}
    question = replace(margin_request(request.geometry, asked, tolerance), points=request.points)
    found = answer(question, store, second)
    return within_tolerance(report, found, tolerance)


def _with_mode_change(
    request: JobRequest,
    wish: Requirement,
    store: Store,
    progress: tuple[Progress, Progress],
    tolerance: Mapping[str, str],
) -> Document:
    """A report on changes of assembly mode for all geometries within a tolerance, and on numbers of cusps if
    these are required, too."""
    report = rpr_solver.check(
        request.manipulator, wish, digits=request.digits, tolerance=tolerance, progress=progress[0]
    )
    document, counts = report.to_json(), wish.counts_alone()
    if counts is None:
        return document
    content = {**request.content, "requirement": counts.to_json(), "tolerance": tolerance}
    own = answer(replace(request, content=content), store, progress[1])
    return {**document, "passed": report.passed and own["passed"], "margin": own["margin"]}


def margin_request(geometry: Canonical, asked: Mapping[str, Any], tolerance: Mapping[str, str]) -> JobRequest:
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
    """Measured within a limit of 10^390 for an open range: 7 s more."""
    limits = 0.005 * size.spread * size.limited
    margin_of_counts = _margin_cost(size) if size.censuses else 0
    return all_events(size) + limits + _MODES_SECONDS * size.modes + margin_of_counts


def _measure_check(content: Content, size: Sizes) -> Sizes:
    wish = content["requirement"]
    has_counts = any(wish.get(name) is not None for name in ("max_cusps", "min_cusps"))
    return replace(
        size,
        limited=int(bool(wish.get("limits"))),
        censuses=_CENSUSES if "tolerance" in content and has_counts else 0,
        modes=int(wish.get("mode_change") is not None),
    )


def _measure_margin(content: Content, size: Sizes) -> Sizes:
    """The margin of a slice is 0 at once if the platform is flat."""
    return replace(size, censuses=0 if size.is_thin and "length" in content else _CENSUSES)


def _margin_cost(size: Sizes) -> float:
    if not size.censuses:
        return 0.03
    return _MARGIN_BOXES_SECONDS + _CENSUSES * all_events(replace(size, digits=max(size.digits, 30)))


MARGIN = Kind("margin", "ma-", margin, _margin_cost, measure=_measure_margin, unit="boxes")
CHECK = Kind("check", "ch-", check, _check_cost, measure=_measure_check)
