"""Poses, singular curves, aspects and verifications: documents that one call of the library gives. Cusp
curves: the whole ones are computed and kept; their parts and samples start from them. Pictures, drawn from
documents that are computed and kept as if they were asked for alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

import rpr_solver
from rpr_solver.contract import (
    DEFAULT_TOLERANCE,
    LEGS,
    LENGTHS,
    MIN_DIGITS,
    Progress,
    document_head,
    letter,
    number_of,
)
from rpr_solver.exact.rationals import exact_str
from rpr_solver.notebook import Style
from rpr_solver.notebook.figure import draw, size_of
from rpr_solver.sensed.angles import ANGLES
from worker.answers.censuses import CENSUS, MARGIN, SENSITIVITIES
from worker.answers.cost import (
    SHORT_BITS,
    TYPICAL_WINDOWS,
    Sizes,
    all_events,
    digits_of_bits,
    elimination,
    elimination_at_one,
    exact_bits,
    one_slice,
)
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
)
from worker.answers.paths import PATH, USUAL
from worker.answers.workspaces import WORKSPACE


def poses(request: JobRequest, _store: Store, _progress: Progress) -> Document:
    """Compute all poses of one joint vector, which takes milliseconds, or those along a leg, or with angles.

    Raises:
        SolverError: the moving leg has one length along a whole curve of poses.
    """
    lengths = {leg: request.content[leg] for leg in LEGS if leg in request.content}
    angles = {name: request.content[name] for name in ANGLES if name in request.content}
    if angles:
        tolerance = request.content.get("angle_tolerance_deg")
        return rpr_solver.sensed_poses(
            request.as_given, lengths, angles, angle_tolerance_deg=tolerance, digits=request.digits
        ).to_json()
    if (moving := _moving(request.content)) is None:
        table = rpr_solver.poses(request.as_given, *lengths.values(), digits=request.digits)
        if (asked := request.content.get("condition")) is not None:
            table = rpr_solver.with_condition(table, asked.get("length_scale"))
        return table.to_json()
    span = lengths.pop(moving)
    return rpr_solver.leg_poses(
        request.as_given, lengths, span["from"], span["to"], digits=request.digits
    ).to_json()


def _moving(content: Content) -> str | None:
    """The leg that has a range of lengths."""
    return next((leg for leg in LEGS if isinstance(content.get(leg), Mapping)), None)


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
    found = rpr_solver.aspects(request.manipulator, ends["from"], ends["to"], fixed_leg=leg)
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
    verified = rpr_solver.verify_document(request.content["document"], progress=progress)
    return {**request.identity_json(), **verified.to_json()}


_SECONDS, _CHARACTERS = 12.0, 100_000
"""The longest time of a verification, for each this number of characters."""


_OF_A_SURVEY, _OF_CURVES = 20, 130
"""Finding all events of a manipulator takes about as long as so many slices; so does following all curves."""


def parts_to_verify(document: Mapping[str, Any]) -> int:
    """Returns the work of a verification, in slices: those listed, one in each interval, and more."""
    slices, intervals, curves = (
        len(part) if isinstance(part := document.get(name), list) else 0
        for name in ("slices", "intervals", "curves")
    )
    surveyed = _OF_A_SURVEY if intervals or curves else 0
    return 1 + slices + intervals + surveyed + (_OF_CURVES if curves and "range" in document else 0)


def _to_verify(content: Content, size: Sizes) -> Sizes:
    document = content["document"]
    lengths = exact_bits(document, size.lengths, size.digits)
    limit = _SECONDS * max(1.0, len(str(document)) / _CHARACTERS)
    return replace(size, lengths=lengths, count=parts_to_verify(document), limit=limit)


def _part_to_verify(_content: Content, size: Sizes) -> Mapping[str, tuple[Sizes, str]]:
    part = replace(size, count=1, objects=0, lengths=min(size.lengths, SHORT_BITS))
    digits = digits_of_bits(size.lengths)
    has = f"its numbers have up to {digits} digits, and {size.objects} objects are listed"
    return {"document": (part, f"verify a part of it: {has}")}


def _verification_cost(size: Sizes) -> float:
    """Each slice is cut in boxes, whatever its digits; each cusp or pose is found and compared."""
    return min(size.limit, 0.1 + 0.1 * size.count + (0.004 + 4e-6 * size.digits) * size.objects)


_INTERVALS = 4
"""Intervals along a leg, of most questions; at most they are thirteen."""
_OF_FOLDS = 0.008
"""Seconds for the lengths at which poses merge, and the aspects of a slice."""
_OF_DISCS = 0.2
"""Seconds for the clearances of all poses."""


def _poses_sizes(content: Content, size: Sizes) -> Sizes:
    count = 1 if _moving(content) is None else _INTERVALS
    return replace(size, count=count, limited=int("condition" in content))


def _poses_cost(size: Sizes) -> float:
    """Of one joint vector, perhaps with condition numbers; along a leg, of one in each interval, and the
    aspects of a slice."""
    one = 0.005 + 1e-5 * (size.geometry + size.lengths + size.digits) + 1e-7 * size.spread**2
    if size.count > 1:
        return size.count * one + _OF_FOLDS
    return one + size.limited * (one + _OF_DISCS)


def _singular_cost(size: Sizes) -> float:
    """The slice, the sweep, a sextic for each region, and the drawing."""
    drawing = 0.08 + 8e-4 * size.fineness
    slices = 2 * one_slice(replace(size, nearness=size.nearness // 3))
    return drawing + elimination_at_one(size) + slices + 3e-4 * (size.geometry + size.lengths)


def _aspects_cost(size: Sizes) -> float:
    """The ends of the range, and the transitions of singular curves, which nearly special shapes hide."""
    return _singular_cost(size) + elimination(size) + 0.2 * max(0, size.nearness - 60)


POSES = Kind("poses", "po-", poses, _poses_cost, measure=_poses_sizes)
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
    if (whole := store.get_document(_whole_curves(request))) is None:
        return None
    return rpr_solver.CuspCurves.from_json(whole).within(*content_range(content)).to_json()


def curves(request: JobRequest, store: Store, progress: Progress) -> Document:
    """Compute curves; the whole ones are kept, for other ranges and samples.

    Raises:
        SolverError: a transition could not be decided, or a cusp not followed.
    """
    content, (follow, sample) = request.content, in_turn(progress)

    def solve() -> Document:
        return rpr_solver.cusp_curves(
            request.manipulator, fixed_leg=request.fixed_leg, digits=request.digits, progress=follow
        ).to_json()

    whole = rpr_solver.CuspCurves.from_json(store.document(_whole_curves(request), solve))
    return whole.part(
        *content_range(content),
        lengths=[Fraction(x) for x in content["lengths"]],
        samples=content["samples"],
        progress=sample,
    ).to_json()


def _whole_curves(request: JobRequest) -> JobRequest:
    content = {**request.content, "range": ALL_LENGTHS, "lengths": [], "samples": None}
    return JobRequest(CUSP_CURVES, content, points=request.points)


def curves_cost(size: Sizes) -> float:
    """All transitions, curves between them, and those of each length.

    Transitions of a nearly special shape are close to each other, which makes cusps hard to follow, up to a
    bound of work: 0.7 to 8 s.
    """
    narrow = min(1.8, 0.02 * size.nearness**2)
    return 0.9 + all_events(size) + narrow + (0.035 + one_slice(size)) * size.count


CUSP_CURVES = Kind("cusp-curves", "cc-", curves, curves_cost, derive=derive_curves)


OF_ALL_SLICES = ("census", "sensitivities", "margin", "locus", "projections")
"""Those of a range of lengths."""

DIGITS = MIN_DIGITS
"""The significant digits of the numbers from which pictures are drawn."""
TOLERANCE = exact_str(DEFAULT_TOLERANCE)
"""That of singular curves; pictures of any scale are refined from them."""
SAMPLES = 14
"""The points of each cusp curve in every interval between transitions."""

_PROVED_MARGINS = 4
"""The margins that are proved for a picture of them."""

_SHOWN: Mapping[str, tuple[Kind, tuple[str, ...], Content]] = {
    "census": (CENSUS, ("fixed_leg", "range"), {}),
    "moving": (CENSUS, ("fixed_leg", "range"), {SENSITIVITIES: True}),
    "all moving": (CENSUS, ("fixed_leg",), {"range": ALL_LENGTHS, SENSITIVITIES: True}),
    "margin": (MARGIN, ("fixed_leg",), {"weights": dict.fromkeys(LENGTHS, "1")}),
    "curves": (CUSP_CURVES, ("fixed_leg", "range"), {"lengths": [], "samples": SAMPLES}),
    "slice": (SINGULAR_CURVES, ("fixed_leg", "length"), {"tolerance": TOLERANCE}),
    "path": (PATH, ("fixed_leg", "length", "cusp"), USUAL),
    "poses": (POSES, ("l1", "l2", "l3"), {}),
    "workspace": (WORKSPACE, ("phi", "limits"), {}),
}
"""What a picture shows: the kind of the document, and the members of its question: those that are the
picture's, and others."""


def plot(request: JobRequest, store: Store, progress: Progress) -> Document:
    """Draw a picture; the documents that it shows are kept for other questions.

    Raises:
        InputError: the slice has no such cusp, the legs have no such pose, or the lengths are too large.
        SolverError: what the picture shows could not be computed.
    """
    drawn = figure(request, store, progress)
    svg = drawn.svg()
    width, height = size_of(svg)
    return {
        **document_head(request, DIGITS, request.fixed_leg),
        "plot": request.content["plot"],
        "theme": request.content["theme"],
        "title": drawn.title,
        "description": drawn.description,
        "width": width,
        "height": height,
        "svg": svg,
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
        asked = {member: content[member] for member in ("geometry", *own)}
        asked |= {"points": content["points"]} if "points" in content else {}
        question = {**asked, "digits": DIGITS, **others, **more}
        return answer(JobRequest(kind, question, points=request.points), store, progress)

    drawn = _DRAWN[content["plot"]](content, shown)
    return drawn.styled(style_of(content.get("style", {})), theme=content["theme"])


def style_of(setting: Mapping[str, Any]) -> Style:
    """The style that a request asks for: ``width_mm``, ``has_symbols``, ``unit`` and ``labels``."""
    width, labels = setting.get("width_mm"), setting.get("labels", "both")
    return Style(
        width_mm=float(Fraction(width)) if width else 0.0,
        has_symbols=setting.get("has_symbols", False),
        unit=setting.get("unit", ""),
        has_title=labels in ("both", "title"),
        has_caption=labels in ("both", "caption"),
    )


Shown = Callable[..., Document]
"""Gives a document that a picture shows, by its name in `_SHOWN` and more members of its question."""
Drawing = Callable[[Content, Shown], rpr_solver.Figure]


def _view(name: str, view: str) -> Drawing:
    """What draws a view of a document."""
    return lambda _content, shown: draw(shown(name), view=view)


def _mechanism(content: Content, shown: Shown) -> rpr_solver.Figure:
    if "l1" in content:
        return draw(shown("poses"), pose=content["pose"])
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
    found = [shown("margin", length=length) for length in lengths_to_prove(document, span, _PROVED_MARGINS)]
    return margin_figure(document, span, found)


_DRAWN: Mapping[str, Drawing] = {
    "slice": _view("slice", "joints"),
    "torus": _view("slice", "torus"),
    "census": _view("census", "counts"),
    "sensitivities": _view("moving", "sensitivities"),
    "margin": _margin,
    "locus": _view("curves", "space"),
    "projections": _view("curves", "projections"),
    "loop": lambda _content, shown: draw(shown("path"), curves=shown("slice")),
    "mechanism": _mechanism,
    "workspace": lambda _content, shown: draw(shown("workspace")),
}
PLOTS = tuple(_DRAWN)
"""What can be drawn."""


def _plot_sizes(content: Content, size: Sizes) -> Sizes:
    plot = content["plot"]
    return replace(
        size,
        count=TYPICAL_WINDOWS * SAMPLES if plot in ("locus", "projections") else 1,
        is_slice=plot not in OF_ALL_SLICES,
        censuses=_PROVED_MARGINS if plot == "margin" else 0,
    )


def _plot_cost(size: Sizes) -> float:
    """A slice that is traced, or all transitions, and perhaps curves sampled between them."""
    if size.count > 1:
        return 0.2 + curves_cost(size)
    if size.is_slice:
        return 0.15 + elimination(size) + 2 * one_slice(size)
    # the proofs of many windows take twice as long as that of one slice
    return 0.2 + all_events(size) + 2 * size.censuses * MARGIN.cost(size)


PLOT = Kind("plot", "pl-", plot, _plot_cost, measure=_plot_sizes, fewer=lambda _content, _size: {})
