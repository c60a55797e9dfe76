"""Cusp curves: the whole ones are computed and kept; parts and samples of them set out from there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import rpr_solver
from rpr_solver import CuspCurves, Manipulator, exact_str
from rpr_solver.curves.cusp_curves import part_of
from worker.answers.single_flight import single_flight
from worker.answers.store import ResultStore
from worker.jobs.requests import ALL_LENGTHS, DocumentRequest, content_range, scan_content

Document = dict[str, Any]


def curves_request(
    manipulator: Manipulator,
    *,
    fixed_leg: int = 1,
    digits: int = 90,
    start: Fraction = Fraction(0),
    stop: Fraction | None = None,
    lengths: Sequence[Fraction] = (),
    samples: int | None = None,
) -> DocumentRequest:
    """The request for the curves that meet a range, with points at these lengths, and in each interval."""
    content = {
        **scan_content(manipulator, fixed_leg, digits, start, stop),
        "lengths": [exact_str(x) for x in sorted(set(lengths))],
        "samples": samples,
    }
    return DocumentRequest("cusp-curves", content)


def known_curves(request: DocumentRequest, store: ResultStore) -> Document | None:
    """A part of curves that are known, without other points."""
    content = request.content
    if content["lengths"] or content["samples"] is not None:
        return None
    whole = store.get_document(_whole(request))
    return None if whole is None else CuspCurves.from_json(whole).within(*content_range(content)).to_json()


def compute_curves(
    request: DocumentRequest, store: ResultStore, progress: Callable[[int, int], None]
) -> Document:
    """Compute curves; the whole ones are kept for the sake of other ranges and samples.

    Raises:
        SolverError: a transition could not be decided, or a cusp not followed.
    """
    content, wanted = request.content, _whole(request)
    steps = 0

    def on_the_way(done: int, total: int) -> None:
        nonlocal steps
        steps = total
        progress(done, total)

    def make() -> Document:
        manipulator = Manipulator.from_json(content["geometry"])
        found = rpr_solver.cusp_curves(
            manipulator, fixed_leg=content["fixed_leg"], digits=content["digits"], progress=on_the_way
        ).to_json()
        store.put_document(wanted, found)
        return found

    whole = single_flight(lambda: store.get_document(wanted), lambda: store.document_lock(wanted), make)
    return part_of(
        CuspCurves.from_json(whole),
        *content_range(content),
        [Fraction(x) for x in content["lengths"]],
        content["samples"],
        lambda done, total: progress(steps + done, steps + total),
    ).to_json()


def _whole(request: DocumentRequest) -> DocumentRequest:
    content = {**request.content, "range": ALL_LENGTHS, "lengths": [], "samples": None}
    return DocumentRequest("cusp-curves", content)
