"""Pictures of answers, drawn from documents that are computed and kept as if they were asked for alone."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import rpr_solver
from rpr_solver.contract import DEFAULT_TOLERANCE, MIN_DIGITS, Progress, document_head
from rpr_solver.exact.rationals import exact_str
from worker.answers import censuses, curves, paths, poses, singular
from worker.answers.requests import JobRequest, Kind
from worker.answers.single_flight import single_flight
from worker.answers.store import ResultStore

KIND = Kind("plot", "pl-")

PLOTS = ("slice", "torus", "census", "locus", "loop", "mechanism")
"""What can be drawn."""

Document = dict[str, Any]
Compute = Callable[[JobRequest, ResultStore, Progress], Document]

DIGITS = MIN_DIGITS
"""The significant digits of the numbers from which pictures are drawn."""
TOLERANCE = exact_str(DEFAULT_TOLERANCE)
"""That of singular curves; pictures of any scale are refined from them."""
SAMPLES = 14
"""The points of each cusp curve in every interval between transitions."""


def compute(request: JobRequest, store: ResultStore, progress: Progress) -> Document:
    """Draw a picture; the documents that it shows are kept for other questions.

    Raises:
        InputError: the slice has no such cusp, the legs have no such pose, or the lengths are too large.
        SolverError: what the picture shows could not be computed.
    """
    from worker.answers.pictures import Sources, figure_of  # by those who draw: a service starts sooner

    content = request.content
    of_slice = {"fixed_leg": request.fixed_leg, "length": content.get("length")}
    of_range = {"fixed_leg": request.fixed_leg, "range": content.get("range")}

    def kept(kind: Kind, compute: Compute, **members: object) -> Document:
        """A document that is known, or that is computed and kept."""
        own = JobRequest(kind, {"geometry": content["geometry"], "digits": DIGITS, **members})

        def make() -> Document:
            document = compute(own, store, progress)
            store.put_document(own, document)
            return document

        # not the document's own lock, which the computation of a whole census or of whole curves takes
        return single_flight(lambda: store.get_document(own), lambda: store.answer_lock(own), make)

    sources = Sources(
        census=lambda: kept(censuses.KIND, censuses.compute, **of_range),
        curves=lambda: kept(curves.KIND, curves.compute, **of_range, lengths=[], samples=SAMPLES),
        slices=lambda: kept(singular.KIND, singular.compute, **of_slice, tolerance=TOLERANCE),
        path=lambda: kept(paths.KIND, paths.compute, **of_slice, cusp=content["cusp"], **paths.USUAL),
        poses=lambda: kept(poses.KIND, poses.compute, **{leg: content[leg] for leg in ("l1", "l2", "l3")}),
    )
    return plot_json(request, figure_of(content, sources))


def plot_json(request: JobRequest, figure: rpr_solver.Figure) -> Document:
    """The document of a picture."""
    return {
        **document_head(request, DIGITS, request.fixed_leg),
        "plot": request.content["plot"],
        "theme": request.content["theme"],
        "title": figure.scene.title,
        "description": figure.scene.description,
        "width": figure.scene.width,
        "height": figure.scene.height,
        "svg": figure.svg(),
    }
