"""Pictures, drawn from documents."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from rpr_solver.contract import number_of
from rpr_solver.figures.census import census_figure
from rpr_solver.figures.joint_plane import joint_figure
from rpr_solver.figures.locus import locus_figure
from rpr_solver.figures.loop import loop_figure
from rpr_solver.figures.mechanism import point_figure, poses_figure
from rpr_solver.figures.sheet import letters
from rpr_solver.figures.torus import torus_figure
from rpr_solver.notebook.figure import Figure

Document = dict[str, Any]


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
    figure = DRAWN[content["plot"]](content, sources)
    return Figure(figure.scene, content["theme"])


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
    number = number_of(number, len(cusps))
    leg, length = content["fixed_leg"], content["length"]
    title = f"The mechanism at cusp {letters(number)}, L{leg} = {length}"
    return point_figure(content["geometry"], leg, length, cusps[number], title)


DRAWN: Mapping[str, Callable[[Mapping[str, Any], Sources], Figure]] = {
    "slice": lambda _, sources: joint_figure(sources.slices()),
    "torus": lambda _, sources: torus_figure(sources.slices()),
    "census": lambda _, sources: census_figure(sources.census()),
    "locus": lambda _, sources: locus_figure(sources.curves()),
    "loop": lambda _, sources: loop_figure(sources.path(), sources.slices()),
    "mechanism": _mechanism,
}
"""What can be drawn, by name."""
