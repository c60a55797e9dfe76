"""Pictures of answers, drawn from documents that are computed and kept as if they were asked for alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

import rpr_solver
from rpr_solver.contract import DEFAULT_TOLERANCE, MIN_DIGITS, Progress, document_head, letter, number_of
from rpr_solver.exact.rationals import exact_str
from rpr_solver.margins import LENGTHS
from rpr_solver.notebook import PIXELS_IN_MM, SCREEN, Style
from worker.answers import ALL_LENGTHS, Content, Document, JobRequest, Kind, Store, answer
from worker.answers.censuses import CENSUS, MARGIN, SENSITIVITIES
from worker.answers.cost import INTERVALS, MARGINS, Sizes, all_events, elimination, one_slice
from worker.answers.documents import CUSP_CURVES, POSES, SINGULAR_CURVES, curves_cost
from worker.answers.paths import PATH, USUAL

OF_ALL_SLICES = ("census", "sensitivities", "margin", "locus", "projections")
"""Those of a range of lengths."""

DIGITS = MIN_DIGITS
"""The significant digits of the numbers from which pictures are drawn."""
TOLERANCE = exact_str(DEFAULT_TOLERANCE)
"""That of singular curves; pictures of any scale are refined from them."""
SAMPLES = 14
"""The points of each cusp curve in every interval between transitions."""

_SHOWN: Mapping[str, tuple[Kind, tuple[str, ...], Content]] = {
    "census": (CENSUS, ("fixed_leg", "range"), {}),
    "moving": (CENSUS, ("fixed_leg", "range"), {SENSITIVITIES: True}),
    "all moving": (CENSUS, ("fixed_leg",), {"range": ALL_LENGTHS, SENSITIVITIES: True}),
    "margin": (MARGIN, ("fixed_leg",), {"weights": dict.fromkeys(LENGTHS, "1")}),
    "curves": (CUSP_CURVES, ("fixed_leg", "range"), {"lengths": [], "samples": SAMPLES}),
    "slice": (SINGULAR_CURVES, ("fixed_leg", "length"), {"tolerance": TOLERANCE}),
    "path": (PATH, ("fixed_leg", "length", "cusp"), USUAL),
    "poses": (POSES, ("l1", "l2", "l3"), {}),
}
"""What a picture shows: the kind of the document, and the members of its question: those that are the
picture's, and others."""


def compute(request: JobRequest, store: Store, progress: Progress) -> Document:
    """Draw a picture; the documents that it shows are kept for other questions.

    Raises:
        InputError: the slice has no such cusp, the legs have no such pose, or the lengths are too large.
        SolverError: what the picture shows could not be computed.
    """
    drawn = figure(request, store, progress)
    return {
        **document_head(request, DIGITS, request.fixed_leg),
        "plot": request.content["plot"],
        "theme": request.content["theme"],
        "title": drawn.scene.title,
        "description": drawn.scene.description,
        "width": drawn.scene.width,
        "height": drawn.scene.height,
        "svg": drawn.svg(),
    }


def figure(request: JobRequest, store: Store, progress: Progress) -> rpr_solver.Figure:
    """Draw the same, for any format of a picture.

    Raises:
        InputError: there is no such cusp or pose, or the lengths are too large to be drawn.
        SolverError: a document could not be computed.
    """
    content = request.content

    def shown(name: str, **more: str) -> Document:
        """A document that is known, or that is computed and kept."""
        kind, own, others = _SHOWN[name]
        asked = {
            "geometry": content["geometry"],
            "digits": DIGITS,
            **{member: content[member] for member in own},
        }
        return answer(JobRequest(kind, {**asked, **others, **more}), store, progress)

    drawn = _DRAWN[content["plot"]](content, shown)
    style = style_of(content.get("style", {}))
    return replace(drawn if style == SCREEN else drawn.styled(style), theme=content["theme"])


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


Shown = Callable[..., Document]
"""Gives a document that a picture shows, by its name in `_SHOWN` and more members of its question."""
Drawing = Callable[[Content, Shown], rpr_solver.Figure]


def _figure_of(document: Document, **options: Any) -> rpr_solver.Figure:
    from rpr_solver.figures import figure_of  # by those who draw: a service starts sooner

    return figure_of(document, **options)


def _view(name: str, view: str) -> Drawing:
    """What draws a view of a document."""
    return lambda _content, shown: _figure_of(shown(name), view=view)


def _mechanism(content: Content, shown: Shown) -> rpr_solver.Figure:
    if "l1" in content:
        return _figure_of(shown("poses"), pose=content["pose"])
    from rpr_solver.figures.mechanism import point_figure

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


def _margin(content: Content, shown: Shown) -> rpr_solver.Figure:
    from rpr_solver.figures.margins import lengths_to_prove, margin_figure

    document, span = shown("all moving"), content["range"]
    found = [shown("margin", length=length) for length in lengths_to_prove(document, span, MARGINS)]
    return margin_figure(document, span, found)


_DRAWN: Mapping[str, Drawing] = {
    "slice": _view("slice", "joints"),
    "torus": _view("slice", "torus"),
    "census": _view("census", "counts"),
    "sensitivities": _view("moving", "sensitivities"),
    "margin": _margin,
    "locus": _view("curves", "space"),
    "projections": _view("curves", "projections"),
    "loop": lambda _content, shown: _figure_of(shown("path"), curves=shown("slice")),
    "mechanism": _mechanism,
}
PLOTS = tuple(_DRAWN)
"""What can be drawn."""


def _measure(content: Content, size: Sizes) -> Sizes:
    plot = content["plot"]
    return replace(
        size,
        count=INTERVALS * SAMPLES if plot in ("locus", "projections") else 1,
        is_slice=plot not in OF_ALL_SLICES,
        censuses=MARGINS if plot == "margin" else 0,
    )


def _cost(size: Sizes) -> float:
    """A slice that is traced, or all transitions, and perhaps curves sampled between them."""
    if size.count > 1:
        return 0.2 + curves_cost(size)
    if size.is_slice:
        return 0.15 + elimination(size) + 2 * one_slice(size)
    return 0.2 + all_events(size) + size.censuses * MARGIN.cost(size)


PLOT = Kind("plot", "pl-", compute, _cost, measure=_measure, fewer=lambda _content, _size: {})
