"""What every picture must be: well-formed, named, with texts that cover no other and leave no sheet."""

from __future__ import annotations

from fractions import Fraction
from random import Random
from typing import Any
from xml.etree import ElementTree

import numpy as np

from rpr_solver import Figure, Manipulator
from rpr_solver.notebook.style import Style

SVG = "{http://www.w3.org/2000/svg}"
GEOMETRY = {
    **{"a2x": "15.91", "a3x": "0", "a3y": "10", "d1": "17.04", "d2": "16.54", "d3": "20.84"},
    "orientation": "ccw",
}
STYLES = [Style(), *(Style(width_mm=mm, has_symbols=True, unit="mm") for mm in (80, 400))]


def random_robot(rng: Random) -> Manipulator:
    """A manipulator with proper triangles of random sizes."""
    sides = [Fraction(rng.randint(2, 40), rng.choice((1, 2, 5, 10))) for _ in range(5)]
    d3 = abs(sides[3] - sides[4]) + Fraction(rng.randint(1, 99), 100) * 2 * min(sides[3], sides[4])
    return Manipulator(sides[0], rng.randint(-15, 15), sides[2], sides[3], sides[4], d3)


def sheet_of(figure: Figure) -> Any:
    """The sheet of a figure, drawn: matplotlib makes ticks as late as this."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure as Sheet

    from rpr_solver.notebook.sheet import laid_out

    with rc_context(figure.style.sheet()):
        sheet = laid_out(figure, FigureCanvasAgg(Sheet(dpi=72)).figure)
        sheet.canvas.draw()
    return sheet


def texts(sheet: Any) -> list[tuple[str, Any]]:
    """The texts that are seen on a sheet, each with its box in points."""
    from matplotlib.text import Text

    hidden = {id(text) for axes in _all_axes(sheet) for text in _hidden(axes)}
    seen = [text for text in sheet.findobj(Text) if text.get_visible() and text.get_text().strip()]
    for axes in _all_axes(sheet):
        if hasattr(axes, "zaxis"):  # whose axes are no children
            for axis in axes._axis_map.values():
                ticks = [tick.label1 for tick in _drawn_ticks(axis)]
                seen += [text for text in (axis.label, *ticks) if text.get_text().strip()]
    return [
        (text.get_text(), text.get_window_extent()) for text in dict.fromkeys(seen) if id(text) not in hidden
    ]


def _all_axes(sheet: Any) -> list[Any]:
    from matplotlib.axes import Axes

    return list(dict.fromkeys(sheet.findobj(Axes)))


def _hidden(axes: Any) -> list[Any]:
    """The texts of axes that are not drawn: those of ticks beyond the limits, and of axes that are off."""
    hidden, is_on = [], getattr(axes, "_axis3don", axes.axison)
    for axis in axes._axis_map.values():
        drawn = _drawn_ticks(axis) if is_on else []
        ticks = [tick for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()) if tick not in drawn]
        hidden += [text for tick in ticks for text in (tick.label1, tick.label2)]
        hidden += [] if is_on else [axis.label, axis.offsetText]
    return hidden


def _drawn_ticks(axis: Any) -> list[Any]:
    """The ticks of an axis within its limits."""
    low, high = sorted(axis.get_view_interval())
    near = 1e-9 * (high - low)
    ticks = (*axis.get_major_ticks(), *axis.get_minor_ticks())
    return [tick for tick in ticks if low - near <= tick.get_loc() <= high + near]


def words(figure: Figure) -> list[str]:
    """The texts of a picture."""
    return [text for text, _ in texts(sheet_of(figure))]


def check(figure: Figure) -> None:
    """Check a picture: its texts and names."""
    root = ElementTree.fromstring(figure.svg())
    assert (root.tag, root.attrib["role"]) == (f"{SVG}svg", "img")
    assert [root.find(f"{SVG}{name}").text for name in ("title", "desc")] == [
        figure.title,
        figure.description,
    ]  # type: ignore[union-attr]
    check_texts(sheet_of(figure))


def check_texts(sheet: Any, slack: float = 0.6) -> None:
    """No two texts overlap, and none leaves the sheet."""
    found = texts(sheet)
    boxes = np.array([box.extents for _, box in found])
    wide, high = sheet.get_size_inches() * sheet.dpi
    for (words, _), (x0, y0, x1, y1) in zip(found, boxes, strict=True):
        assert -slack < x0 <= x1 < wide + slack, words
        assert -slack < y0 <= y1 < high + slack, words
    for k, (words, _) in enumerate(found):
        x0, y0, x1, y1 = boxes[k] + (slack, slack, -slack, -slack)
        later = boxes[k + 1 :]
        hit = (later[:, 0] < x1) & (later[:, 2] > x0) & (later[:, 1] < y1) & (later[:, 3] > y0)
        assert not hit.any(), (words, [found[k + 1 + int(i)][0] for i in np.flatnonzero(hit)])
