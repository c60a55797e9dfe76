"""How a figure is set: its width, its font and symbols, and what stands around it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

Theme = Literal["auto", "light", "dark"]

THEMES: tuple[Theme, ...] = ("auto", "light", "dark")
"""``auto`` follows the reader's setting, where the picture is shown as SVG."""


@dataclass(frozen=True)
class Style:
    """How a figure is set: for a page, or for print.

    Attributes:
        width: of the sheet, in pixels, of which four are a millimetre in print; 0 for its own.
        is_print: whether the picture states its width in millimetres.
        has_symbols: whether quantities are set as symbols, in italics and with subscripts, in a serif font.
        unit: that of lengths, for the axes, or empty.
        has_title: whether the title is written above; every picture has it for screen readers.
        has_caption: whether the geometry is written below.
    """

    width: float = 0.0
    is_print: bool = False
    has_symbols: bool = False
    unit: str = ""
    has_title: bool = True
    has_caption: bool = True

    def axis(self, quantity: str) -> str:
        """The title of an axis of lengths.

        >>> Style(unit="mm").axis("L2")
        'L2 [mm]'
        """
        return f"{quantity} [{self.unit}]" if self.unit else quantity


SCREEN = Style()
"""For a page."""

PIXELS_IN_MM = 4.0
"""Pixels of a scene in a millimetre of print: letters of 13 pixels have 9 points."""


_SYMBOL = re.compile(r"(?<![\w−])([LABdaθ])([123])([xy]?)(?!\w)|(?<![\w])([αJ])(?!\w)")
_LOWER = str.maketrans("123x", "₁₂₃ₓ")


def symbols(words: str, pattern: str) -> str:
    """Words with quantities as symbols: letter and subscript, each in its place of ``pattern``.

    >>> symbols("A1 at L2 = 5, θ1, α", "<i>{}</i>{}")
    '<i>A</i>₁ at <i>L</i>₂ = 5, <i>θ</i>₁, <i>α</i>'
    """

    def set_(match: re.Match[str]) -> str:
        letter, leg, axis, alone = match.groups()
        return pattern.format(alone or letter, f"{leg or ''}{axis or ''}".translate(_LOWER))

    return _SYMBOL.sub(set_, words)
