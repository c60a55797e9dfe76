"""A figure of an answer: drawn in axes of matplotlib, or as SVG, PNG, PDF, a file, in a notebook.

This module knows no document. The package registers the function that makes figures of documents
(:func:`draw_with`), which stands above the rooms that ask for figures (:func:`draw`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rpr_solver.errors import InputError, installing
from rpr_solver.notebook.style import Picture, Style

if TYPE_CHECKING:  # all answers name their figures, few are drawn
    from matplotlib.axes import Axes

SUFFIXES = (".svg", ".png", ".pdf")
"""The kinds of files in which pictures are kept."""

_drawers: list[Callable[..., Figure]] = []


def draw_with(figure_of: Callable[..., Figure]) -> Callable[..., Figure]:
    """Makes a function of a document and options make all figures that :func:`draw` is asked for."""
    _drawers[:] = [figure_of]
    return figure_of


def draw(document: dict[str, Any], **options: Any) -> Figure:
    """The figure of a document, or of the geometry of a manipulator.

    Raises:
        InputError: an option is wrong, a length is too large to be drawn, or matplotlib is not installed.
    """
    [figure_of] = _drawers
    try:
        return figure_of(document, **options)
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] != "matplotlib":
            raise
        raise InputError.of("figure", f"needs matplotlib; {installing('plot')}") from None


def shown_as_svg(document: Pictured) -> str | None:
    """What a notebook shows of an answer with a figure: its SVG text; nothing without matplotlib."""
    try:
        return document.figure().svg()
    except InputError:
        return None


class Pictured:
    """An answer with a figure."""

    def figure(self, *args: Any, **options: Any) -> Figure:
        """A picture of the answer."""
        raise NotImplementedError

    def plot(self, ax: Axes | None = None, **options: Any) -> Axes:
        """Draws the answer in axes of matplotlib, or in new ones of pyplot, as ``figure(…).draw(ax)`` does.

        Args:
            ax: the axes.
            options: those of ``figure``.

        Raises:
            InputError: an option is wrong, a length is too large to be drawn, or matplotlib is not installed.
        """
        return self.figure(**options).draw(ax)


@dataclass(frozen=True, repr=False)
class Figure(Picture):
    """A picture of an answer.

    In a notebook it shows itself. With one version of matplotlib the same answer gives the same bytes.

    >>> from rpr_solver import EXAMPLES
    >>> figure = EXAMPLES["innocenti"].figure()
    >>> figure
    <Figure 'Manipulator at α = 0'>
    >>> figure.styled(width_mm=86, theme="dark").style.width_mm
    86
    """

    def __repr__(self) -> str:
        return f"<Figure {self.title!r}>"

    def styled(self, style: Style | None = None, **changes: Any) -> Figure:
        """The same picture in another style, or with some properties of its style changed."""
        return replace(self, style=replace(style or self.style, **changes))

    def draw(self, ax: Axes | None = None) -> Axes:
        """Draws it in axes of your own, or in new ones of pyplot, which it returns.

        What is drawn are matplotlib's own objects, in the unit of the answer: limits, ticks, titles, colours
        and sizes change as in any figure. Pictures of several planes are axes within the given ones
        (``ax.child_axes``).

        Args:
            ax: the axes; those of a cusp locus must be three-dimensional (``projection="3d"``).

        Raises:
            InputError: naming ``ax``: they do not have three dimensions.
        """
        from rpr_solver.notebook import sheet

        return sheet.drawn_in(self, ax)

    def svg(self) -> str:
        """The picture as an SVG document, in which text is text."""
        return self.encoded(".svg").decode()

    def png(self) -> bytes:
        """The picture as PNG: 192 dots per inch, 600 for print."""
        return self.encoded(".png")

    def pdf(self) -> bytes:
        """The picture as PDF, with embedded fonts."""
        return self.encoded(".pdf")

    def save(self, path: str | PathLike[str]) -> None:
        """Writes the picture to a file: SVG, PNG or PDF, as its suffix says.

        Raises:
            InputError: naming ``path``: its suffix is another, or it cannot be written.
        """
        target = Path(fspath(path))
        content = self.encoded(suffix_of(target))
        try:
            target.write_bytes(content)
        except OSError as error:
            raise InputError.of("path", f"{str(target)!r} cannot be written: {error.strerror}") from None

    def encoded(self, suffix: str) -> bytes:
        """The content of a file with this suffix, one of ``.svg``, ``.png`` and ``.pdf``."""
        from rpr_solver.notebook import sheet

        return sheet.encoded(self, suffix[1:])

    def _repr_svg_(self) -> str:
        return self.svg()


def size_of(svg: str) -> tuple[float, float]:
    """Width and height of a picture as SVG, in the pixels of a page, 96 in an inch.

    >>> size_of('<svg viewBox="0 0 570 401.25">')
    (760.0, 535.0)
    """
    _, _, width, height = svg.partition('viewBox="')[2].partition('"')[0].split()
    return float(width) * 4 / 3, float(height) * 4 / 3


def suffix_of(path: Path) -> str:
    """The suffix of a picture's file, in lower case.

    Raises:
        InputError: naming ``path``: it is no suffix of pictures.
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        known = f"{', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}"
        raise InputError.of(
            "path", f"{str(path)!r} does not end in {known}, which names the form of a picture"
        )
    return suffix
