"""How figures are set: widths, titles, units, symbols; the style sheets of screen and paper, and colours.

A style sheet is a dictionary of matplotlib's settings. Colours are roles such as ``"ink"`` or ``"cusp"``,
each with a colour on light and on dark paper. Hues are after Okabe and Ito, which colour-blind readers can
distinguish; neighbouring areas differ in lightness too, so that they stay apart in grey.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:  # all answers name their figures, few are drawn
    from matplotlib.axes import Axes

Theme = Literal["light", "dark"]
"""The paper on which a picture is drawn."""

_POINTS_IN_MM = 72 / 25.4


@dataclass(frozen=True)
class Style:
    """How a figure is set: for a page, or for print.

    Attributes:
        width_mm: of the sheet, for print; 0 for a page, where each picture has its own.
        has_symbols: whether quantities are set as symbols, in italics and with subscripts, in a serif font.
        unit: that of lengths, for the axes, or empty.
        has_title: whether the title is written above; SVG has it for screen readers in any case.
        has_caption: whether the geometry is written below.
        theme: the paper: ``"light"`` or ``"dark"``.
        is_alone: whether axes have a sheet for themselves, with room below for insets.
    """

    width_mm: float = 0.0
    has_symbols: bool = False
    unit: str = ""
    has_title: bool = True
    has_caption: bool = True
    theme: Theme = "light"
    is_alone: bool = True

    @property
    def width(self) -> float:
        """The width in points, or 0."""
        return self.width_mm * _POINTS_IN_MM

    def axis(self, quantity: str) -> str:
        """The title of an axis of lengths.

        >>> Style(unit="mm").axis("L2"), Style(has_symbols=True).axis("L2")
        ('L2 [mm]', '$\\\\mathit{L}_{2}$')
        """
        return self.words(f"{quantity} [{self.unit}]" if self.unit else quantity)

    def words(self, text: str) -> str:
        """A text as it is set: with symbols, if the style has them."""
        return _SYMBOL.sub(_symbol, text) if self.has_symbols else text

    def colour(self, role: str) -> str:
        """The colour of a role."""
        return COLOURS[role][self.theme == "dark"]

    def sheet(self) -> dict[str, Any]:
        """The settings of matplotlib for a whole sheet in this style."""
        text = {name: self.colour("ink") for name in ("text.color", "axes.labelcolor")}
        lines = {name: self.colour("soft") for name in ("axes.edgecolor", "xtick.color", "ytick.color")}
        papers = ("figure.facecolor", "axes.facecolor", "savefig.facecolor")
        colours = {**text, **lines, **{name: self.colour("paper") for name in papers}}
        return {
            **_SHEET,
            **(PAPER if self.has_symbols else SCREEN),
            **colours,
            "grid.color": self.colour("faint"),
        }


_SYMBOL = re.compile(r"(?<![\w−])([LABdaθ])([123])([xy]?)(?!\w)|(?<![\w])([αJ])(?!\w)")


def _symbol(match: re.Match[str]) -> str:
    letter, leg, axis, alone = match.groups()
    return rf"$\mathit{{{alone or letter}}}" + (f"_{{{leg}{axis or ''}}}$" if leg else "$")


_SHEET: Mapping[str, Any] = {
    "axes.axisbelow": True,
    "axes.formatter.limits": (-4, 6),
    "axes.formatter.useoffset": False,
    "axes.labelsize": 11.0,
    "axes.linewidth": 0.75,
    "grid.linewidth": 0.45,
    "legend.borderaxespad": 0.0,
    "legend.columnspacing": 1.2,
    "legend.fontsize": 9.5,
    "legend.frameon": False,
    "legend.handletextpad": 0.5,
    "lines.linewidth": 1.3,
    "lines.scale_dashes": False,
    "path.simplify_threshold": 0.06,
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
    "svg.hashsalt": "rpr-cusps",
    "xtick.labelsize": 9.5,
    "ytick.labelsize": 9.5,
}
"""What all sheets share: text stays text, and nothing in a file is of its day or of chance."""

SCREEN: Mapping[str, Any] = {"font.family": "DejaVu Sans", "text.parse_math": False}
"""The style sheet of a page."""

PAPER: Mapping[str, Any] = {
    "font.family": "STIXGeneral",
    "mathtext.fontset": "stix",
    "axes.labelsize": 12.0,
    "legend.fontsize": 10.5,
    "xtick.labelsize": 10.0,
    "ytick.labelsize": 10.0,
}
"""The style sheet of a paper: quantities are symbols, letters have serifs."""

COLOURS: Mapping[str, tuple[str, str]] = {
    "paper": ("#ffffff", "#12171d"),
    "ink": ("#1b1f24", "#e9edf1"),
    "soft": ("#4c545d", "#b4bec8"),
    "faint": ("#c3cad1", "#47525d"),
    "ghost": ("#8b949e", "#7c8894"),
    "curve": ("#16324f", "#dbe8f4"),
    "cusp": ("#b8430b", "#ffa35c"),
    "mark": ("#0b6b50", "#4fd0a5"),
    "tint": ("#f1f3f5", "#1c232b"),
    # numbers of poses, from few to many
    "poses0": ("#ffffff", "#12171d"),
    "poses2": ("#e4eef7", "#1a2c3d"),
    "poses4": ("#b5d3ea", "#22506f"),
    "poses6": ("#7db2d8", "#2f6d94"),
    # aspects: J > 0 in blues, J < 0 in yellows
    "plus1": ("#a5cce8", "#1b4160"),
    "plus2": ("#6aa9d2", "#33709a"),
    "plus3": ("#d3e6f4", "#172f44"),
    "minus1": ("#fbe7b5", "#6b5415"),
    "minus2": ("#efc765", "#7c611a"),
    "minus3": ("#fdf4dc", "#3b3114"),
    # curves of cusps
    "line1": ("#0067b0", "#5ab4ec"),
    "line2": ("#c4480a", "#ff9a52"),
    "line3": ("#00795a", "#2fb98f"),
    "line4": ("#6d1a66", "#c98ab5"),
    "line5": ("#1b1f24", "#e9edf1"),
    # kinds of transitions
    "swallowtail": ("#0060a0", "#5ab4ec"),
    "beak": ("#b8430b", "#ff9a52"),
    "lips": ("#00795a", "#37c79c"),
}
"""Role → colour on light and on dark paper."""


_PAGE = Style()

WIDTH = 570.0
"""Of a figure on a page, in points: 760 pixels."""


@dataclass(frozen=True)
class Picture:
    """What is drawn, and how it is set.

    Attributes:
        title: one line that says what it shows.
        description: what is in it, in sentences, for those who do not see it.
        paint: draws it in axes of matplotlib, in a style.
        height: that of the axes by their width, both in points.
        caption: the geometry, for the lines below.
        remark: a line above these.
        width: of a sheet on a page, in points.
        margins: on the left and on the right of the axes, in points; what needs more gets it.
        is_spatial: whether its axes have three dimensions.
        style: how it is set.
    """

    title: str
    description: str
    paint: Callable[[Axes, Style], None] = field(repr=False)
    height: Callable[[float], float] = field(repr=False)
    caption: Sequence[str] = ()
    remark: str = ""
    width: float = WIDTH
    margins: tuple[float, float] = (44.0, 12.0)
    is_spatial: bool = False
    style: Style = _PAGE
