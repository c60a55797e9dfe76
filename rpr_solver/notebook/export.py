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

from rpr_solver.notebook.scene import Box, Disc, Group, Paint, Path, Scene, Shape, Text, colour
from rpr_solver.notebook.tables import PIXELS_IN_MM, Theme, symbols

_INCH = 96.0
"""Pixels of a scene in an inch, as in CSS."""
_PRINTED_INCH = 25.4 * PIXELS_IN_MM
_POINTS = 72.0
"""Points in an inch."""
_PRINTED_DOTS = 600.0
"""Dots in an inch of a PNG for print."""
_SETTINGS: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "pdf.fonttype": 42,
    "svg.hashsalt": "rpr-cusps",
    "text.parse_math": False,
}
_SERIF = {"font.family": "DejaVu Serif", "mathtext.fontset": "dejavuserif"}


def drawn(scene: Scene, form: str, theme: Theme) -> bytes:
    """The scene as ``"png"`` or ``"pdf"``; the same scene gives the same bytes with one matplotlib."""
    inch = _PRINTED_INCH if scene.style.is_print else _INCH
    with rc_context({**_SETTINGS, **(_SERIF if scene.style.has_symbols else {})}):
        canvas = Canvas(figsize=(scene.width / inch, (scene.height - scene.top) / inch), dpi=inch)
        canvas.patch.set_facecolor(colour("paper", theme))
        axes = canvas.add_axes((0, 0, 1, 1))
        axes.set_axis_off()
        axes.set_xlim(0, scene.width)
        axes.set_ylim(scene.height, scene.top)
        _Artist(axes, theme, _POINTS / inch, has_symbols=scene.style.has_symbols).draw(
            scene.shapes, Affine2D(), None
        )
        target = BytesIO()
        if form == "pdf":
            facts = {"Title": scene.title, "CreationDate": None, "Creator": "rpr-cusps"}
            FigureCanvasPdf(canvas).print_pdf(target, metadata=facts)
        else:
            FigureCanvasAgg(canvas)
            dots = _PRINTED_DOTS if scene.style.is_print else 2 * _INCH
            canvas.savefig(target, format="png", dpi=dots, metadata={"Software": None})
        return target.getvalue()


class _Artist:
    def __init__(self, axes: Any, theme: Theme, point: float, *, has_symbols: bool) -> None:
        self._axes, self._theme, self._order = axes, theme, 0
        self._point, self._has_symbols = point, has_symbols

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
            [withStroke(linewidth=4 * self._point, foreground=colour(text.halo, self._theme))]
            if text.halo
            else []
        )
        has_symbols = self._has_symbols and text.role != "cusp"
        self._axes.text(
            x,
            y,
            symbols(text.words, r"$\mathit{{{}}}$" + "{}") if has_symbols else text.words,
            parse_math=has_symbols,
            size=text.size * self._point,
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
            "linewidth": paint.width * self._point if paint.stroke else 0,
            "linestyle": dashes,
            "joinstyle": "round",
            "capstyle": "butt",
        }
