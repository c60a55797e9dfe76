"""Sheets: a figure with its title above, and a remark and the geometry below; as SVG, PNG and PDF.

A figure paints in axes of a given width. Then what it painted is measured: margins at the sides grow until
nothing leaves the sheet, and the sheet is as high as what is on it. There is no state between sheets.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from html import escape
from io import BytesIO
from threading import Lock
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Sheet
from matplotlib.transforms import Bbox

from rpr_solver.errors import InputError
from rpr_solver.notebook.style import Picture, Style

_POINTS = 72.0
"""Points in an inch; a sheet is laid out with one dot for each."""
_EDGE = 5.0
"""What stays free at every edge."""
_TRIES = 4
_TITLE, _REMARK, _CAPTION = 13.5, 9.0, 8.5
"""Sizes of letters."""
_LEADING = 1.35
"""The height of a line by the size of its letters."""
_SCREEN_DOTS, _PRINTED_DOTS = 192.0, 600.0
"""Dots of a PNG in an inch."""
_SIZE = re.compile(r"(?<=\")([\d.]+)pt(?=\")")
"""The width and the height of an SVG text."""
_DRAWING = Lock()
"""The settings of matplotlib are those of a process: threads draw one after another."""


def drawn_in(figure: Picture, ax: Axes | None) -> Axes:
    """Draws a figure in axes, or on a sheet of pyplot.

    Raises:
        InputError: naming ``ax``: they do not have three dimensions.
    """
    if ax is None:
        from matplotlib import pyplot as plt

        return laid_out(figure, plt.figure()).axes[0]
    if figure.is_spatial and not hasattr(ax, "get_zlim"):
        raise InputError.of("ax", "has two dimensions; make it with projection='3d'")
    figure.paint(ax, replace(figure.style, is_alone=False))
    if figure.style.has_title:
        taken = ax.get_tightbbox()
        above = 0.0 if taken is None else (taken.y1 - ax.get_window_extent().y1) * _scale(ax)
        ax.set_title(figure.style.words(figure.title), pad=max(above, 0.0) + _EDGE)
    return ax


def _scale(ax: Axes) -> float:
    """What a dot of the picture is in points."""
    sheet: Any = ax.get_figure()
    return _POINTS / float(sheet.dpi)


def encoded(figure: Picture, form: str) -> bytes:
    """A figure as ``"svg"``, ``"png"`` or ``"pdf"``."""
    style, target = figure.style, BytesIO()
    metadata: dict[str, Any] = {
        "svg": {"Title": figure.title, "Date": None, "Creator": None},
        "png": {"Software": None, "Title": figure.title},
        "pdf": {"Title": figure.title, "CreationDate": None, "Creator": "rpr-cusps"},
    }[form]
    with _DRAWING, rc_context(style.sheet()):
        dots = {"png": _PRINTED_DOTS if style.width else _SCREEN_DOTS}.get(form, _POINTS)
        sheet = Sheet(dpi=_POINTS)
        FigureCanvasAgg(sheet)
        laid_out(figure, sheet).savefig(target, format=form, dpi=dots, metadata=metadata)
    content = target.getvalue()
    return content if form != "svg" else _described(content.decode(), figure).encode()


def _described(svg: str, figure: Picture) -> str:
    """An SVG text that may stand in a page, with a description for screen readers, beside its title.

    For print it states its width in millimetres.
    """
    said = f"</title>\n <desc>{escape(figure.description, quote=False)}</desc>"
    head, rest = svg[svg.index("<svg ") :].replace("<svg ", '<svg role="img" ', 1).split("</title>", 1)
    if wide := figure.style.width_mm:
        points = [float(x) for x in _SIZE.findall(head)]
        sizes = iter((wide, wide * points[1] / points[0]))
        head = _SIZE.sub(lambda _: f"{round(next(sizes), 3):g}mm", head)
    return head + said + rest


def laid_out(figure: Picture, sheet: Sheet) -> Sheet:
    """Draws a figure on an empty sheet, which takes its size."""
    style, wide = figure.style, figure.style.width or figure.width
    ax, (left, inner, high), extent = _painted(figure, sheet, wide)
    room = wide - 2 * _EDGE
    above, below = [], [(figure.remark, _REMARK)] if figure.remark else []
    if style.has_title:
        lines = _wrapped(sheet, figure.title.split(" "), " ", room, _TITLE, style.words)
        above = [(line, _TITLE) for line in lines]
    if style.has_caption:
        lines = _wrapped(sheet, figure.caption, ", ", room, _CAPTION, style.words)
        below += [(line, _CAPTION) for line in lines]
    head, foot = (2 * _EDGE + sum(size * _LEADING for _, size in lines) for lines in (above, below))
    total = extent.height + head + foot
    sheet.set_size_inches(wide / _POINTS, total / _POINTS)
    ax.set_position((left / wide, (foot - extent.y0) / total, inner / wide, high / total))
    for lines_, start in ((above, total - _EDGE), (below, foot - _EDGE)):
        _write(sheet, lines_, start, style)
    return sheet


def _painted(figure: Picture, sheet: Sheet, wide: float) -> tuple[Axes, tuple[float, float, float], Bbox]:
    """The axes of a figure on its sheet, their left end, width and height, and the box of all in them.

    What leaves the sheet makes the margins wider, and the figure is painted anew in narrower axes.
    """
    left, right = figure.margins
    projection: Any = {"projection": "3d"} if figure.is_spatial else {}
    for _ in range(_TRIES):
        sheet.clear()
        inner = wide - left - right
        high = figure.height(inner)
        sheet.set_size_inches(wide / _POINTS, high / _POINTS)
        ax = sheet.add_axes((left / wide, 0.0, inner / wide, 1.0), **projection)
        figure.paint(ax, figure.style)
        taken = ax.get_tightbbox()
        assert taken is not None  # the axes are visible
        extent = Bbox(taken.get_points() * _scale(ax))
        beyond = max(_EDGE - extent.x0, 0.0), max(extent.x1 - wide + _EDGE, 0.0)
        if max(beyond) < 1:
            break
        left, right = left + beyond[0], right + beyond[1]
    return ax, (left, inner, high), extent


def _write(sheet: Sheet, lines: Sequence[tuple[str, float]], top: float, style: Style) -> None:
    """Writes lines with the sizes of their letters; those that are longer than the sheet are smaller."""
    wide, high = sheet.get_size_inches() * _POINTS
    scale = _POINTS / sheet.dpi
    for words, size in lines:
        look = {"ha": "center", "va": "top", "color": style.colour("soft" if size == _CAPTION else "ink")}
        text = sheet.text(0.5, top / high, style.words(words), size=size, **look)
        text.set_size(size * min(0.98 * (wide - 2 * _EDGE) / (text.get_window_extent().width * scale), 1.0))
        top -= size * _LEADING


def _wrapped(
    sheet: Sheet, items: Sequence[str], glue: str, room: float, size: float, set_: Callable[[str], str]
) -> list[str]:
    """An enumeration in lines that are not longer than ``room``, unless an item is."""
    lines: list[str] = []
    for item in items:
        longer = f"{lines[-1]}{glue}{item}" if lines else item
        probe = sheet.text(0, 0, set_(longer), size=size)
        fits = 1.03 * probe.get_window_extent().width * _POINTS / sheet.dpi <= room
        probe.remove()
        if lines and fits:
            lines[-1] = longer
        else:
            lines.append(item)
    return [line + glue.rstrip() for line in lines[:-1]] + lines[-1:]
