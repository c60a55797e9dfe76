"""Tables and lines that fit a width: numbers are shortened, words never."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator, Sequence

COLUMN_PADDING = 3
"""The border and the spaces beside a cell."""

_DECIMAL = re.compile(r"([ +-]?\d+\.)(\d+)((?:[eE][+-]?\d+)?)", re.ASCII)
_IN_TEXT = re.compile(r"(?<![\w.])-?\d+\.\d{9,}(?:[eE][+-]?\d+)?", re.ASCII)
_FEWEST = 2
_NARROWEST = 20
_FEWEST_IN_TEXT = 12
_UNBREAKABLE = "\u00a0"


def shortened(text: str, width: int, more: str = "…") -> str:
    """Returns a decimal with fewer digits after its point, to fit if it can; any other text as it is.

    >>> shortened("-69.129376061488", 9), shortened("1.234567890e-20", 10), shortened("swallowtail", 5)
    ('-69.1293…', '1.234…e-20', 'swallowtail')
    """
    match = _DECIMAL.fullmatch(text)
    if len(text) <= width or match is None:
        return text
    whole, fraction, exponent = match.groups()
    digits = max(_FEWEST, width - len(whole) - len(more) - len(exponent))
    short = whole + fraction[:digits] + more + exponent
    return short if len(short) < len(text) else text


def fitted(cell: str, width: int, more: str = "…") -> str:
    """Returns a cell that fits: a number shortened, a sentence in several lines.

    >>> fitted("1.23456789", 6), fitted("leg 2 has length zero, so no angle", 22)
    ('1.234…', 'leg 2 has length zero,\\nso no angle')
    """
    return "\n".join(wrapped(cell, width)) if _is_sentence(cell) else shortened(cell, width, more)


def column_widths(rows: Sequence[Sequence[str]], width: int, more: str = "…") -> list[int] | None:
    """Returns the widths of columns that fit together, or None if the words alone are too wide.

    Short columns leave their room to long ones.
    """
    columns = list(zip(*rows, strict=True))
    needed = [max(map(len, column)) for column in columns]
    least = [max(_least(cell, more) for cell in column) for column in columns]
    room = width - COLUMN_PADDING * len(columns) - 1
    if sum(least) > room:
        return None
    level = max(needed)
    while sum(widths := [max(min(n, level), low) for n, low in zip(needed, least, strict=True)]) > room:
        level -= 1
    return widths


def _least(cell: str, more: str) -> int:
    if _is_sentence(cell):
        return max(_NARROWEST, *map(len, cell.split()))
    return len(shortened(cell, 0, more))


def _is_sentence(cell: str) -> bool:
    return len(cell) > _NARROWEST and len(cell.split()) > 2


def records(rows: Sequence[Sequence[str]], width: int, more: str = "…") -> Iterator[str]:
    """Yields a table that is too wide as a record a row, one line a cell."""
    headings, *body = rows
    margin = max(map(len, headings)) + 2
    for row in body:
        for heading, cell in zip(headings, row, strict=True):
            text = shortened(cell, width - margin, more)
            if text.strip():
                yield from wrapped(heading.ljust(margin) + text, width, " " * margin)
        yield ""


def with_short_numbers(text: str, width: int, more: str = "…") -> str:
    """Returns a sentence whose long decimals have been shortened, to fit in one line if possible."""
    found = _IN_TEXT.findall(text)
    if len(text) <= width or not found:
        return text
    others = len(text) - sum(map(len, found))
    each = max(_FEWEST_IN_TEXT, (width - others) // len(found))
    return _IN_TEXT.sub(lambda match: shortened(match[0], each, more), text)


def wrapped(text: str, width: int, indent: str = "") -> list[str]:
    """Returns a text in lines that break between words, and never within `name = value`."""
    joined = text.replace(" = ", f"{_UNBREAKABLE}={_UNBREAKABLE}")
    head = joined[: len(joined) - len(joined.lstrip())]
    lines = textwrap.wrap(
        joined.lstrip(),
        max(width, 20),
        initial_indent=head,
        subsequent_indent=indent or head,
        break_long_words=False,
        break_on_hyphens=False,
        drop_whitespace=True,
    )
    return [line.replace(_UNBREAKABLE, " ") for line in lines] or [""]
