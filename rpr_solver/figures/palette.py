"""The colours of pictures by their roles, in a light and in a dark theme.

Hues are after Okabe and Ito, told apart by the colour-blind; neighbouring areas differ in lightness too, so
that they stay apart in grey. Pictures never distinguish by colour alone: areas and curves are labelled, and
marks differ in shape.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

Theme = Literal["auto", "light", "dark"]

THEMES: tuple[Theme, ...] = ("auto", "light", "dark")
"""``auto`` follows the reader's setting, where the picture is shown as SVG."""

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
"""Role → colour in the light and in the dark theme."""


def colour(role: str, theme: Theme) -> str:
    """The colour of a role; the light one if the theme is ``auto``."""
    return COLOURS[role][theme == "dark"]
