"""Poses, singular curves, aspects and verifications: documents that one call of the library gives.
Cusp curves: the whole curves are computed and kept; their parts and samples start from them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

import rpr_solver
from rpr_solver.contract import FULL, Progress, document_head
from worker.answers import ALL_LENGTHS, Content, Document, JobRequest, Kind, Store, content_range
from worker.answers.cost import (
    SHORT_BITS,
    Sizes,
    all_events,
    digits_of_bits,
    elimination,
    exact_bits,
    one_slice,
    proofs_near_special,
)


def poses(request: JobRequest, _store: Store, _progress: Progress) -> Document:
    """Compute all poses of one joint vector, which takes milliseconds."""
    lengths = (request.content[leg] for leg in ("l1", "l2", "l3"))
    return rpr_solver.poses(request.manipulator, *lengths, digits=request.digits).to_json()


def singular_curves(request: JobRequest, store: Store, _progress: Progress) -> Document:
    """Compute the singular curves of a slice, with its regions and aspects; the eliminant is kept.

    Raises:
        SolverError: the slice could not be decided, or has a curve that is not supported.
    """
    length, tolerance = request.content["length"], request.content["tolerance"]
    return rpr_solver.trace_slice(
        store.eliminant(request), length, tolerance=tolerance, digits=request.digits
    ).to_json()


def aspects(request: JobRequest, _store: Store, _progress: Progress) -> Document:
    """Compute the aspects while the length of one leg varies within a range, a fraction of a second.

    Raises:
        SolverError: the ends of the range could not be compared.
    """
    leg, ends = request.fixed_leg, request.content["range"]
    found = rpr_solver.range_aspects(request.manipulator, ends["from"], ends["to"], fixed_leg=leg)
    return {
        **document_head(request, request.digits, leg),
        "range": dict(ends),
        "aspects": [aspect.to_json() for aspect in found],
    }


def verification(request: JobRequest, _store: Store, progress: Progress) -> Document:
    """Verify a document by independent means; nothing that is kept is used.

    Raises:
        InputError: it is no document that can be verified.
    """
    document, effort = request.content["document"], request.content.get("effort", 1)
    verified = rpr_solver.verify_document(document, effort=effort, progress=progress)
    return {**request.identity_json(), **verified.to_json()}


_SECONDS, _CHARACTERS = 12.0, 100_000
"""How long a verification takes at most for each so many characters, at the usual effort."""


def parts_to_verify(document: Mapping[str, Any]) -> int:
    """Returns the number of slices that a verification solves: those listed, or one in each interval.

    Ten tubes, or a hundred parts of the proof of a margin, of a full certificate cost as much as one.
    """
    lists = [document.get(name) for name in ("slices", "intervals", "violations", "curves")]
    slices = sum(len(part) for part in lists if isinstance(part, list)) or 1
    return slices + _tubes(document) // 10 + _parts_of_a_proof(document) // 100


def _tubes(document: Mapping[str, Any]) -> int:
    match document.get("certificate"):
        case {"full": {"chains": [*chains]}}:
            lists = [chain.get("tubes") for chain in chains if isinstance(chain, Mapping)]
            return sum(len(tubes) for tubes in lists if isinstance(tubes, list))
    return 0


def _parts_of_a_proof(document: Mapping[str, Any]) -> int:
    match document.get("certificate"):
        case {"full": {"cuts": [*texts]}}:
            return sum(text.count(".") for text in texts if isinstance(text, str))
    return 0


def _to_verify(content: Content, size: Sizes) -> Sizes:
    document = content["document"]
    lengths = exact_bits(document, size.lengths, size.digits)
    limit = _SECONDS * content.get("effort", 1) * max(1.0, len(str(document)) / _CHARACTERS)
    return replace(size, lengths=lengths, count=parts_to_verify(document), limit=limit)


def _part_to_verify(content: Content, size: Sizes) -> Mapping[str, tuple[Sizes, str]]:
    part = replace(size, count=1, objects=0, lengths=min(size.lengths, SHORT_BITS))
    digits = digits_of_bits(size.lengths)
    has = f"its numbers have up to {digits} digits, and {size.objects} objects are listed"
    effort = content.get("effort", 1)
    less = {"effort": (replace(size, limit=size.limit / effort), "1 is the least")} if effort > 1 else {}
    return {"document": (part, f"verify a part of it: {has}"), **less}


def _verification_cost(size: Sizes) -> float:
    """Each slice is eliminated by itself; each cusp or pose is proved; digits and long numbers make intervals
    wide."""
    bits = size.geometry + size.lengths
    numbers = 0.012 * size.geometry + 1e-4 * size.geometry**2 + 2e-3 * size.lengths + 8e-6 * size.lengths**2
    slices = 0.2 + numbers + 2e-4 * size.digits + 2e-8 * size.digits**2
    objects = 0.012 + 2e-5 * (bits + size.digits) + 3e-6 * size.objects
    return min(size.limit, 0.3 + slices * size.count + objects * size.objects)


def _poses_cost(size: Sizes) -> float:
    return 0.005 + 1e-5 * (size.geometry + size.lengths + size.digits) + 1e-7 * size.spread**2


def _singular_cost(size: Sizes) -> float:
    """The slice, the sweep, a sextic for each region, and the drawing."""
    drawing = 0.08 + 8e-4 * size.fineness
    return drawing + elimination(size) + 2 * one_slice(size) + 1e-3 * (size.geometry + size.lengths)


def _aspects_cost(size: Sizes) -> float:
    """The ends of the range, and the transitions of singular curves, which nearly special shapes hide."""
    return _singular_cost(size) + 0.2 * max(0, size.nearness - 60)


POSES = Kind("poses", "po-", poses, _poses_cost)
SINGULAR_CURVES = Kind("singular-curves", "sc-", singular_curves, _singular_cost)
ASPECTS = Kind("aspects", "as-", aspects, _aspects_cost)
VERIFICATION = Kind(
    "verification", "ve-", verification, _verification_cost, measure=_to_verify, fewer=_part_to_verify
)


def derive_curves(request: JobRequest, store: Store) -> Document | None:
    """Returns a part of known curves without further points, else None."""
    content = request.content
    if content["lengths"] or content["samples"] is not None:
        return None
    whole = store.get_document(_whole_curves(request))
    return (
        None
        if whole is None
        else rpr_solver.CuspCurves.from_json(whole).within(*content_range(content)).to_json()
    )


def curves(request: JobRequest, store: Store, progress: Progress) -> Document:
    """Compute curves; the whole ones are kept for other ranges and samples.

    Raises:
        SolverError: a transition could not be decided, or a cusp not followed.
    """
    return curves_part(request, store, progress).to_json()


def certified_curves(request: JobRequest, store: Store, progress: Progress) -> Document:
    """Compute curves with a full certificate; the whole ones are kept without.

    Raises:
        SolverError: a transition could not be decided, or a cusp not followed.
    """
    return curves_part(request, store, progress).to_json(certificate=FULL, progress=progress)


def curves_part(request: JobRequest, store: Store, progress: Progress) -> rpr_solver.CuspCurves:
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

    whole = rpr_solver.CuspCurves.from_json(store.document(_whole_curves(request), solve))
    return whole.part(
        *content_range(content),
        lengths=[Fraction(x) for x in content["lengths"]],
        samples=content["samples"],
        progress=lambda done, total: progress(steps + done, steps + total),
    )


def _whole_curves(request: JobRequest) -> JobRequest:
    content = {**request.content, "range": ALL_LENGTHS, "lengths": [], "samples": None}
    return JobRequest(CUSP_CURVES, content)


def curves_cost(size: Sizes) -> float:
    """All transitions, curves between them, and those of each length."""
    return 1.4 + all_events(size) + _narrow(size) + (0.035 + one_slice(size)) * size.count


def _narrow(size: Sizes) -> float:
    """To follow cusps between the transitions of a nearly special shape, which are close to each other."""
    return min(20.0, 0.04 * size.nearness**2)


def _certified_cost(size: Sizes) -> float:
    """Tubes along the curves, which take two to three times as long as these."""
    shape = proofs_near_special(size) + _narrow(size)
    return 3.5 * (curves_cost(size) - shape) + shape


CUSP_CURVES = Kind("cusp-curves", "cc-", curves, curves_cost, derive=derive_curves)
CERTIFIED_CURVES = Kind(
    "certified-curves", "cv-", certified_curves, _certified_cost, implied=("certificate", FULL)
)
