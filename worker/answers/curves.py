"""Cusp curves: the whole curves are computed and kept; their parts and samples start from them."""

from __future__ import annotations

from fractions import Fraction

import rpr_solver
from rpr_solver.contract import FULL, Progress
from worker.answers.cost import Sizes, all_events, one_slice, proofs_near_special
from worker.answers.requests import ALL_LENGTHS, Document, JobRequest, Kind, Store, content_range


def derive(request: JobRequest, store: Store) -> Document | None:
    """Returns a part of known curves without further points, else None."""
    content = request.content
    if content["lengths"] or content["samples"] is not None:
        return None
    whole = store.get_document(_whole(request))
    return (
        None
        if whole is None
        else rpr_solver.CuspCurves.from_json(whole).within(*content_range(content)).to_json()
    )


def compute(request: JobRequest, store: Store, progress: Progress) -> Document:
    """Compute curves; the whole ones are kept for other ranges and samples.

    Raises:
        SolverError: a transition could not be decided, or a cusp not followed.
    """
    return part(request, store, progress).to_json()


def certified(request: JobRequest, store: Store, progress: Progress) -> Document:
    """Compute curves with a full certificate; the whole ones are kept without.

    Raises:
        SolverError: a transition could not be decided, or a cusp not followed.
    """
    return part(request, store, progress).to_json(certificate=FULL, progress=progress)


def part(request: JobRequest, store: Store, progress: Progress) -> rpr_solver.CuspCurves:
    """Compute the same, not as a document."""
    content = request.content
    steps = 0

    def follow(done: int, total: int) -> None:
        nonlocal steps
        steps = total
        progress(done, total)

    def solve() -> Document:
        return rpr_solver.cusp_curves(
            request.manipulator, fixed_leg=request.fixed_leg, digits=request.digits, progress=follow
        ).to_json()

    whole = rpr_solver.CuspCurves.from_json(store.document(_whole(request), solve))
    return whole.part(
        *content_range(content),
        lengths=[Fraction(x) for x in content["lengths"]],
        samples=content["samples"],
        progress=lambda done, total: progress(steps + done, steps + total),
    )


def _whole(request: JobRequest) -> JobRequest:
    content = {**request.content, "range": ALL_LENGTHS, "lengths": [], "samples": None}
    return JobRequest(CUSP_CURVES, content)


def cost(size: Sizes) -> float:
    """All transitions, curves between them, and those of each length."""
    return 1.4 + all_events(size) + _narrow(size) + (0.035 + one_slice(size)) * size.count


def _narrow(size: Sizes) -> float:
    """To follow cusps between the transitions of a nearly special shape, which are close to each other."""
    return min(20.0, 0.04 * size.nearness**2)


def _certified_cost(size: Sizes) -> float:
    """Tubes along the curves, which take two to three times as long as these."""
    shape = proofs_near_special(size) + _narrow(size)
    return 3.5 * (cost(size) - shape) + shape


CUSP_CURVES = Kind("cusp-curves", "cc-", compute, cost, derive=derive)
CERTIFIED_CURVES = Kind("certified-curves", "cv-", certified, _certified_cost, implied=("certificate", FULL))
