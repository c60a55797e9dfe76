"""Scenes as PNG and PDF, drawn by matplotlib with its own font: the extra ``plot``."""

from __future__ import annotations

from io import BytesIO
from typing import Any

from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.figure import Figure as Canvas
from matplotlib.patches import Circle, PathPatch, Rectangle
from matplotlib.path import Path as Outline
from matplotlib.patheffects import withStroke
from matplotlib.transforms import Affine2D, Transform

from rpr_solver.notebook.scene import Box, Disc, Group, Paint, Path, Scene, Shape, Text, Theme, colour

_INCH = 96.0
"""Pixels of a scene in an inch, as in CSS."""
_POINT = 0.75
"""Points of print in a pixel."""
_SETTINGS: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "pdf.fonttype": 42,
    "svg.hashsalt": "rpr-cusps",
    "text.parse_math": False,
}


def drawn(scene: Scene, form: str, theme: Theme) -> bytes:
    """The scene as ``"png"`` or ``"pdf"``; the same scene gives the same bytes with one matplotlib."""
    with rc_context(_SETTINGS):
        canvas = Canvas(figsize=(scene.width / _INCH, scene.height / _INCH), dpi=_INCH)
        canvas.patch.set_facecolor(colour("paper", theme))
        axes = canvas.add_axes((0, 0, 1, 1))
        axes.set_axis_off()
        axes.set_xlim(0, scene.width)
        axes.set_ylim(scene.height, 0)
        _Artist(axes, theme).draw(scene.shapes, Affine2D(), None)
        target = BytesIO()
        if form == "pdf":
            facts = {"Title": scene.title, "CreationDate": None, "Creator": "rpr-cusps"}
            FigureCanvasPdf(canvas).print_pdf(target, metadata=facts)
        else:
            FigureCanvasAgg(canvas)
            canvas.savefig(target, format="png", dpi=2 * _INCH, metadata={"Software": None})
        return target.getvalue()


class _Artist:
    def __init__(self, axes: Any, theme: Theme) -> None:
        self._axes, self._theme, self._order = axes, theme, 0

    def draw(self, shapes: tuple[Shape, ...], place: Affine2D, clip: Box | None) -> None:
        for shape in shapes:
            self._order += 1
            match shape:
                case Path():
                    lines = [
                        [*line, line[0]] if shape.closed else line for line in shape.lines if len(line) > 1
                    ]
                    if lines:
                        outline = Outline.make_compound_path(*map(Outline, lines))
                        self._add(PathPatch(outline, **self._paint(shape.paint)), place, clip)
                case Disc():
                    self._add(Circle(shape.centre, shape.radius, **self._paint(shape.paint)), place, clip)
                case Text():
                    self._write(shape, place)
                case Group():
                    inner = place
                    if shape.motion is not None:
                        x, y, turn, stretch = shape.motion.places[0]
                        inner = Affine2D().scale(stretch, 1).rotate_deg(turn).translate(x, y) + place
                    self.draw(shape.shapes, inner, shape.clip or clip)

    def _add(self, patch: Any, place: Transform, clip: Box | None) -> None:
        patch.set_zorder(self._order)
        patch.set_transform(place + self._axes.transData)
        self._axes.add_artist(patch)
        if clip is not None:
            window = Rectangle((clip.x0, clip.y0), clip.width, clip.height, transform=self._axes.transData)
            patch.set_clip_path(window)

    def _write(self, text: Text, place: Affine2D) -> None:
        x, y = place.transform(text.at)
        border = (
            [withStroke(linewidth=4 * _POINT, foreground=colour(text.halo, self._theme))] if text.halo else []
        )
        self._axes.text(
            x,
            y,
            text.words,
            size=text.size * _POINT,
            color=colour(text.role, self._theme),
            ha={"start": "left", "middle": "center", "end": "right"}[text.anchor],
            va="center_baseline" if text.turn else "center",
            rotation=-text.turn,
            rotation_mode="anchor",
            weight="bold" if text.bold else "normal",
            path_effects=border,
            zorder=self._order,
        )

    def _paint(self, paint: Paint) -> dict[str, Any]:
        dashes = (0, tuple(x / paint.width for x in paint.dash)) if paint.dash else "-"
        area = (colour(paint.fill, self._theme), paint.opacity) if paint.fill else "none"
        return {
            "facecolor": area,
            "edgecolor": colour(paint.stroke, self._theme) if paint.stroke else "none",
            "linewidth": paint.width * _POINT if paint.stroke else 0,
            "linestyle": dashes,
            "joinstyle": "round",
            "capstyle": "butt",
        }
