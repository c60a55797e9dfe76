"""Pictures, drawn from documents."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any, Protocol

from rpr_solver.contract import letter, number_of
from rpr_solver.figures.census import census_figure
from rpr_solver.figures.joint_plane import joint_figure
from rpr_solver.figures.locus import locus_figure
from rpr_solver.figures.loop import loop_figure
from rpr_solver.figures.margins import lengths_to_prove, margin_figure, sensitivities_figure
from rpr_solver.figures.mechanism import point_figure, poses_figure
from rpr_solver.figures.projections import projections_figure
from rpr_solver.figures.strands import torus_figure
from rpr_solver.notebook import PIXELS_IN_MM, SCREEN, Style
from rpr_solver.notebook.figure import Figure
from worker.answers.cost import MARGINS

Document = dict[str, Any]


class Source(Protocol):
    """Gives the documents that a picture shows: the `census`, the same `moving`, with sensitivities, or the
    `curves` of a range of lengths; the census of all lengths, `all moving`, and the `margin` of a slice; the
    singular curves of the `slice`, the `path` round the cusp, the `poses` of the leg lengths."""

    def __call__(self, name: str, **more: str) -> Document:
        """The document; `more` are members of its question."""


def figure_of(content: Mapping[str, Any], shown: Source) -> Figure:
    """Draws what a request's content asks for.

    Raises:
        InputError: there is no such cusp or pose, or the lengths are too large to be drawn.
        SolverError: a document could not be computed.
    """
    figure = DRAWN[content["plot"]](content, shown)
    style = style_of(content.get("style", {}))
    return replace(figure if style == SCREEN else figure.styled(style), theme=content["theme"])


def style_of(setting: Mapping[str, Any]) -> Style:
    """The style that a request asks for: ``width_mm``, ``has_symbols``, ``unit`` and ``labels``."""
    width, labels = setting.get("width_mm"), setting.get("labels", "both")
    return Style(
        width=float(Fraction(width)) * PIXELS_IN_MM if width else 0.0,
        is_print=width is not None,
        has_symbols=setting.get("has_symbols", False),
        unit=setting.get("unit", ""),
        has_title=labels in ("both", "title"),
        has_caption=labels in ("both", "caption"),
    )


def _mechanism(content: Mapping[str, Any], shown: Source) -> Figure:
    if "l1" in content:
        return poses_figure(shown("poses"), content["pose"])
    document, number = shown("slice"), content["cusp"]
    vertices = (
        vertex
        for component in document["components"]
        for strand in component["strands"]
        for vertex in strand["vertices"]
    )
    cusps = {vertex["cusp"]: vertex for vertex in vertices if vertex["kind"] == "cusp"}
    number = number_of(number, len(cusps))
    leg, length = content["fixed_leg"], content["length"]
    title = f"The mechanism at cusp {letter(number)}, L{leg} = {length}"
    return point_figure(content["geometry"], leg, length, cusps[number], title)


def _margin(content: Mapping[str, Any], shown: Source) -> Figure:
    document, span = shown("all moving"), content["range"]
    found = [shown("margin", length=length) for length in lengths_to_prove(document, span, MARGINS)]
    return margin_figure(document, span, found)


DRAWN: Mapping[str, Callable[[Mapping[str, Any], Source], Figure]] = {
    "slice": lambda _, shown: joint_figure(shown("slice")),
    "torus": lambda _, shown: torus_figure(shown("slice")),
    "census": lambda _, shown: census_figure(shown("census")),
    "sensitivities": lambda _, shown: sensitivities_figure(shown("moving")),
    "margin": _margin,
    "locus": lambda _, shown: locus_figure(shown("curves")),
    "projections": lambda _, shown: projections_figure(shown("curves")),
    "loop": lambda _, shown: loop_figure(shown("path"), shown("slice")),
    "mechanism": _mechanism,
}
"""What can be drawn, by name."""
