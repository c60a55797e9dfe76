"""Figures of answers: documents in, pictures by matplotlib out.

This room stands above all others of the solver: it reads their documents. Floats draw here and decide
nothing; what a figure shows was proved before, in the document it is drawn from.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rpr_solver.errors import InputError, shown
from rpr_solver.figures.census import along_figure, census_figure, design_figure
from rpr_solver.figures.connections import connections_figure
from rpr_solver.figures.joint_plane import joint_figure
from rpr_solver.figures.locus import locus_figure, projections_figure
from rpr_solver.figures.loop import loop_figure
from rpr_solver.figures.margins import sensitivities_figure
from rpr_solver.figures.mechanism import geometry_figure, poses_figure
from rpr_solver.figures.torus import torus_figure
from rpr_solver.figures.workspace import sweep_figure, workspace_figure
from rpr_solver.notebook.figure import Figure


def _by_view(views: Mapping[str, Callable[[Mapping[str, Any]], Figure]]) -> Callable[..., Figure]:
    """The function that draws a document in one of these views, the first one unless another is named."""
    usual = next(iter(views))

    def figure(document: Mapping[str, Any], view: str = usual) -> Figure:
        if view not in views:
            raise InputError.of("view", f"is {shown(view)}; give {' or '.join(views)}")
        return views[view](document)

    return figure


_FIGURES: Mapping[str, Callable[..., Figure]] = {
    "trace": design_figure,
    "matrix": connections_figure,
    "moving_leg": along_figure,
    "conic": workspace_figure,
    "orientations": sweep_figure,
    "poses": poses_figure,
    "components": _by_view({"joints": joint_figure, "torus": torus_figure}),
    "transitions": _by_view({"counts": census_figure, "sensitivities": sensitivities_figure}),
    "curves": _by_view({"space": locus_figure, "projections": projections_figure}),
    "duration": loop_figure,
    "d1": geometry_figure,
    "platform": geometry_figure,
}
"""The first of these members that a document has, and its figure."""


def figure_of(document: Mapping[str, Any], **options: Any) -> Figure:
    """The figure of a document, or of the geometry of a manipulator.

    Args:
        document: the singular curves of a slice, a census, curves of cusps, a path, a table of poses, poses
            along a leg, a workspace, connections of poses, a design, or a geometry, as ``to_json()`` gives
            it.
        options: ``view`` (``"joints"`` or ``"torus"``) of a slice, ``view`` (``"counts"``, or
            ``"sensitivities"`` if it has them) of a census, ``view`` (``"space"`` or ``"projections"``)
            of curves of cusps, ``pose`` (a number) of a table of poses, ``curves`` (the singular curves of
            its slice) of a path.

    Raises:
        InputError: the document has no figure, an option is wrong, or a length is too large to be drawn.

    >>> from rpr_solver import EXAMPLES, poses
    >>> figure_of(poses(EXAMPLES["innocenti"], "14.98", 16, 20).to_json(), pose=2)
    <Figure 'Pose 2 of 6 with these legs'>
    """
    for member, draw in _FIGURES.items():
        if member in document:
            return draw(document, **options)
    known = "curves, a census, a path, poses, a workspace, connections, a design or a geometry"
    raise InputError.of("document", f"has no figure; give {known}")
