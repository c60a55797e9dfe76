"""A figure and its export formats: SVG text, PNG, PDF, a file, a notebook.

This module knows no document. The package registers the function that draws documents
(:func:`draw_with`), which stands above the rooms that ask for figures (:func:`draw`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import wraps
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec

from rpr_solver.errors import InputError, installing
from rpr_solver.notebook.tables import SCREEN, THEMES, Style, Theme

if TYPE_CHECKING:  # all answers name their figures, few are drawn
    from rpr_solver.notebook.scene import Scene

P = ParamSpec("P")

SUFFIXES = (".svg", ".png", ".pdf")
"""The kinds of files in which pictures are kept."""

_drawers: list[Callable[..., Figure]] = []


def draw_with(figure_of: Callable[..., Figure]) -> Callable[..., Figure]:
    """Makes a function of a document and options draw all figures that :func:`draw` is asked for."""
    _drawers[:] = [figure_of]
    return figure_of


def draw(document: dict[str, Any], **options: Any) -> Figure:
    """The figure of a document, or of the geometry of a manipulator.

    Raises:
        InputError: an option is wrong, or a length is too large to be drawn.
    """
    [figure_of] = _drawers
    return figure_of(document, **options)


@dataclass(frozen=True)
class Figure:
    """A picture of an answer.

    In a notebook it shows itself. Its SVG text is the same, byte for byte, wherever it is made from the same
    answer.

    Attributes:
        scene: what it consists of.
        theme: ``"auto"`` follows the reader's setting of light or dark; ``"light"`` and ``"dark"`` are fixed.
        set_in: draws the same in another style.

    >>> from rpr_solver import EXAMPLES
    >>> figure = EXAMPLES["innocenti"].figure()
    >>> figure
    <Figure 'Manipulator at α = 0'>
    >>> figure.svg("light")[:44]
    '<svg xmlns="http://www.w3.org/2000/svg" view'
    """

    scene: Scene
    theme: Theme = "auto"
    set_in: Callable[[Style], Scene] | None = field(default=None, repr=False, compare=False)

    def styled(self, style: Style) -> Figure:
        """The same picture in another style, such as one for print.

        >>> from rpr_solver import EXAMPLES
        >>> figure = EXAMPLES["innocenti"].figure().styled(Style(width=400, is_print=True))
        >>> figure.svg()[40:96]
        'viewBox="0 0 400 456" width="100mm" height="114mm" role='
        """
        return self if self.set_in is None else replace(self, scene=self.set_in(style))

    def __repr__(self) -> str:
        return f"<Figure {self.scene.title!r}>"

    def svg(self, theme: Theme | None = None) -> str:
        """The picture as an SVG document.

        Args:
            theme: ``"auto"``, ``"light"`` or ``"dark"``; None is that of the figure.

        Raises:
            InputError: naming ``theme``.
        """
        from rpr_solver.notebook.svg import svg_of

        return svg_of(self.scene, self._theme(theme))

    def png(self, theme: Theme | None = None) -> bytes:
        """The picture as PNG, two pixels for each of the SVG; ``"auto"`` is light. Needs the extra ``plot``.

        Raises:
            InputError: naming ``theme``, or ``png``: the extra is not installed.
        """
        return self._drawn("png", theme)

    def pdf(self, theme: Theme | None = None) -> bytes:
        """The picture as PDF, with embedded fonts; ``"auto"`` is light. Needs the extra ``plot``.

        Raises:
            InputError: naming ``theme``, or ``pdf``: the extra is not installed.
        """
        return self._drawn("pdf", theme)

    def save(self, path: str | PathLike[str], theme: Theme | None = None) -> None:
        """Writes the picture to a file: SVG, PNG or PDF, as its suffix says.

        Raises:
            InputError: naming ``path``: its suffix is another, or it cannot be written; naming ``theme``.
        """
        target = Path(fspath(path))
        content = self.encoded(suffix_of(target), theme)
        try:
            target.write_bytes(content)
        except OSError as error:
            raise InputError.of("path", f"{str(target)!r} cannot be written: {error.strerror}") from None

    def encoded(self, suffix: str, theme: Theme | None = None) -> bytes:
        """The content of a file with this suffix, one of ``.svg``, ``.png`` and ``.pdf``."""
        return self.svg(theme).encode() if suffix == ".svg" else self._drawn(suffix[1:], theme)

    def _repr_svg_(self) -> str:
        return self.svg()

    def _drawn(self, form: str, theme: Theme | None) -> bytes:
        theme = self._theme(theme)
        try:
            from rpr_solver.notebook.export import drawn
        except ModuleNotFoundError as error:
            if error.name != "matplotlib":
                raise
            need = f"needs matplotlib; {installing('plot')}; or take SVG, which needs nothing"
            raise InputError.of(form, need) from None
        return drawn(self.scene, form, theme)

    def _theme(self, theme: Theme | None) -> Theme:
        chosen = self.theme if theme is None else theme
        if chosen not in THEMES:
            raise InputError.of("theme", f"is {chosen!r}; give {', '.join(THEMES[:-1])} or {THEMES[-1]}")
        return chosen


def drawing(scene: Callable[Concatenate[Style, P], Scene]) -> Callable[P, Figure]:
    """The function that makes figures of what ``scene`` draws in a style."""

    @wraps(scene)
    def figure(*args: P.args, **options: P.kwargs) -> Figure:
        def set_in(style: Style) -> Scene:
            return scene(style, *args, **options)

        return Figure(set_in(SCREEN), set_in=set_in)

    return figure


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
