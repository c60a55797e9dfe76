"""Notebook output: rows for data frames, HTML tables and small SVG pictures of plain data.

Floats occur only here, for display and data frames; nothing is decided by them.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from html import escape
from typing import Any

Row = dict[str, Any]
Point = tuple[float, float]

_SHOWN_DIGITS, _SHOWN_ROWS = 12, 50
_QUANTITY = re.compile(r"l[123]|\w+_deg|b1_[xy]|from|to")
_WIDTH, _HEIGHT, _MARGIN = 320, 200, 24


def with_floats(records: Iterable[Mapping[str, object]]) -> list[Row]:
    """Rows for a data frame: each length and angle as a float, and its text beside it as ``<name>_text``.

    None, an open end, becomes infinity.

    >>> with_floats([{"cusp": 1, "l2": "0.845282018280357"}])
    [{'cusp': 1, 'l2': 0.845282018280357, 'l2_text': '0.845282018280357'}]
    """
    rows: list[Row] = []
    for record in records:
        row: Row = {}
        for name, value in record.items():
            if _QUANTITY.fullmatch(name):
                row[name] = math.inf if value is None else _float(str(value))
                row[f"{name}_text"] = value
            else:
                row[name] = value
        rows.append(row)
    return rows


def shortened(text: str, digits: int = 8) -> str:
    """A decimal cut after ``digits`` significant digits, but not before the decimal point, with an ellipsis.

    >>> shortened("50.678560496513"), shortened("-0.000123456789"), shortened("1.23456789e+20", 3)
    ('50.678560…', '-0.00012345678…', '1.23…e+20')
    """
    mantissa, mark, exponent = text.partition("e")
    whole, point, part = mantissa.partition(".")
    if not point or not part.isdigit():
        return text if len(text) <= 40 else f"{text[:40]}…"
    leading = len(part) - len(part.lstrip("0")) if whole.lstrip("-") == "0" else -len(whole.lstrip("-"))
    kept = max(digits + leading, 0)
    if kept >= len(part):
        return text
    return f"{whole}.{part[:kept]}".removesuffix(".") + "…" + mark + exponent


def counted(number: int, noun: str) -> str:
    """A number with its noun, in the plural unless the number is 1.

    >>> counted(1, "cusp"), counted(0, "cusp")
    ('1 cusp', '0 cusps')
    """
    return f"{number} {noun}{'' if number == 1 else 's'}"


def html_table(title: str, records: Sequence[Mapping[str, object]], notes: Iterable[str] = ()) -> str:
    """A table with a column for each name, in the colours of the page; digits are shortened."""
    names = list(dict.fromkeys(name for record in records for name in record))
    head = "".join(f"<th>{escape(name)}</th>" for name in names)
    body = "".join(
        f"<tr>{''.join(f'<td>{_cell(record.get(name))}</td>' for name in names)}</tr>"
        for record in records[:_SHOWN_ROWS]
    )
    left_out = len(records) - _SHOWN_ROWS
    notes = [*notes, *([f"… and {left_out} more rows"] if left_out > 0 else [])]
    table = f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>" if records else ""
    below = "".join(f"<p>{escape(note)}</p>" for note in notes)
    return f"<div><p><strong>{escape(title)}</strong></p>{table}{below}</div>"


def svg_triangles(base: Sequence[Point], platform: Sequence[Point]) -> str:
    """The base, the platform, and the three legs between their corners."""
    place = _fitted([*base, *platform], square=True)
    a, b = list(map(place, base)), list(map(place, platform))
    legs = "".join(f"M{_at(p)}L{_at(q)}" for p, q in zip(a, b, strict=True))
    corners = "".join(
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3"/>'
        f'<text x="{x + 5:.1f}" y="{y - 5:.1f}" stroke="none">{name}{k}</text>'
        for name, triangle in (("A", a), ("B", b))
        for k, (x, y) in enumerate(triangle, 1)
    )
    return _svg(
        f'<path d="{_path(a)}Z" stroke-dasharray="4 3"/><path d="{_path(b)}Z" fill="currentColor"'
        f' fill-opacity="0.15"/><path d="{legs}" stroke-width="2"/><g fill="currentColor">{corners}</g>'
    )


def svg_steps(ends: Sequence[float], heights: Sequence[int], axis: str) -> str:
    """A step curve: each height from one end to the next."""
    place = _fitted([(ends[0], 0), (ends[-1], max(*heights, 1))])
    steps = [
        point
        for a, b, n in zip(ends, ends[1:], heights, strict=False)
        for point in (place((a, n)), place((b, n)))
    ]
    bottom, top = _HEIGHT - 6, max(heights)
    labels = "".join(
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(text)}</text>'
        for x, y, anchor, text in (
            (_MARGIN, bottom, "start", f"{ends[0]:.6g}"),
            (_WIDTH / 2, bottom, "middle", axis),
            (_WIDTH - _MARGIN, bottom, "end", f"{ends[-1]:.6g}"),
            (_MARGIN - 4, place((ends[0], top))[1] + 4, "end", str(top)),
            (_MARGIN - 4, place((ends[0], 0))[1] + 4, "end", "0"),
        )
    )
    return _svg(f'<path d="{_path(steps)}"/><g stroke="none" fill="currentColor">{labels}</g>')


def _float(text: str) -> float:
    if text.startswith("sqrt("):
        return math.sqrt(_float(text[5:-1]))
    try:
        return float(Fraction(text)) if "/" in text else float(text)
    except OverflowError:
        return math.inf


def _cell(value: object) -> str:
    return "" if value is None else escape(shortened(str(value), _SHOWN_DIGITS))


def _fitted(points: Sequence[Point], *, square: bool = False) -> Callable[[Point], Point]:
    """The map from a plane, y upwards, into the picture; ``square`` keeps proportions."""
    (left, right), (low, high) = ((min(axis), max(axis)) for axis in zip(*points, strict=True))
    scales = [
        (size - 2 * _MARGIN) / (b - a or 1) for size, a, b in ((_WIDTH, left, right), (_HEIGHT, low, high))
    ]
    sx, sy = [min(scales)] * 2 if square else scales

    def place(point: Point) -> Point:
        return _MARGIN + (point[0] - left) * sx, _HEIGHT - _MARGIN - (point[1] - low) * sy

    return place


def _at(point: Point) -> str:
    return f"{point[0]:.1f} {point[1]:.1f}"


def _path(points: Iterable[Point]) -> str:
    return "M" + "L".join(map(_at, points))


def _svg(content: str) -> str:
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {_HEIGHT}" width="{_WIDTH}"'
        f' height="{_HEIGHT}" font-family="sans-serif" font-size="11" fill="none" stroke="currentColor">'
        f"{content}</svg>"
    )
