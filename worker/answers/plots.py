"""Pictures of answers, drawn from documents that are computed and kept as if they were asked for alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from rpr_solver.contract import MIN_DIGITS, Progress, document_head
from rpr_solver.errors import InputError
from rpr_solver.exact.rationals import exact_str
from rpr_solver.figures.census import census_figure
from rpr_solver.figures.figure import Figure
from rpr_solver.figures.joint_plane import joint_figure
from rpr_solver.figures.locus import locus_figure
from rpr_solver.figures.loop import loop_figure
from rpr_solver.figures.mechanism import point_figure, poses_figure
from rpr_solver.figures.torus import torus_figure
from rpr_solver.figures.wording import letters
from rpr_solver.singular.singular_curves import DEFAULT_TOLERANCE
from worker.answers import censuses, curves, paths, poses, singular
from worker.answers.requests import JobRequest, Kind
from worker.answers.single_flight import single_flight
from worker.answers.store import ResultStore

KIND = Kind("plot", "pl-")

Document = dict[str, Any]
Compute = Callable[[JobRequest, ResultStore, Progress], Document]

DIGITS = MIN_DIGITS
"""The significant digits of the numbers from which pictures are drawn."""
TOLERANCE = exact_str(DEFAULT_TOLERANCE)
"""That of singular curves; pictures of any scale are refined from them."""
SAMPLES = 14
"""The points of each cusp curve in every interval between transitions."""


@dataclass(frozen=True)
class Sources:
    """Where the documents come from that pictures show.

    Attributes:
        census: of a range of lengths.
        curves: of a range of lengths, sampled.
        slices: the singular curves of the slice.
        path: the loop round the cusp.
        poses: of the leg lengths.
    """

    census: Callable[[], Document]
    curves: Callable[[], Document]
    slices: Callable[[], Document]
    path: Callable[[], Document]
    poses: Callable[[], Document]


def figure_of(content: Mapping[str, Any], sources: Sources) -> Figure:
    """Draws what a request's content asks for.

    Raises:
        InputError: there is no such cusp or pose, or the lengths are too large to be drawn.
        SolverError: a document could not be computed.
    """
    figure = _DRAWN[content["plot"]](content, sources)
    return Figure(figure.scene, content["theme"])


def compute(request: JobRequest, store: ResultStore, progress: Progress) -> Document:
    """Draw a picture; the documents that it shows are kept for other questions.

    Raises:
        InputError: the slice has no such cusp, the legs have no such pose, or the lengths are too large.
        SolverError: what the picture shows could not be computed.
    """
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


def plot_json(request: JobRequest, figure: Figure) -> Document:
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


def _mechanism(content: Mapping[str, Any], sources: Sources) -> Figure:
    if "l1" in content:
        return poses_figure(sources.poses(), content["pose"])
    document, number = sources.slices(), content["cusp"]
    vertices = (
        vertex
        for component in document["components"]
        for strand in component["strands"]
        for vertex in strand["vertices"]
    )
    cusps = {vertex["cusp"]: vertex for vertex in vertices if vertex["kind"] == "cusp"}
    if number not in cusps:
        there_are = f"give 1 to {len(cusps)}" if cusps else "the slice has none"
        raise InputError.of("cusp", f"is {number}; {there_are}")
    leg, length = content["fixed_leg"], content["length"]
    title = f"The mechanism at cusp {letters(number)}, L{leg} = {length}"
    return point_figure(content["geometry"], leg, length, cusps[number], title)


_DRAWN: Mapping[str, Callable[[Mapping[str, Any], Sources], Figure]] = {
    "slice": lambda _, sources: joint_figure(sources.slices()),
    "torus": lambda _, sources: torus_figure(sources.slices()),
    "census": lambda _, sources: census_figure(sources.census()),
    "locus": lambda _, sources: locus_figure(sources.curves()),
    "loop": lambda _, sources: loop_figure(sources.path(), sources.slices()),
    "mechanism": _mechanism,
}
PLOTS = tuple(_DRAWN)
"""What can be drawn."""
