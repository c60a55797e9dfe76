"""How answers are shown: rows for data frames, and tables of plain data.

Floats occur only here, for display and data frames; nothing is decided by them.
"""

from __future__ import annotations

import csv
import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from html import escape
from itertools import chain
from typing import Any

from rpr_solver.errors import clipped

Row = dict[str, Any]

_SHOWN_DIGITS, _SHOWN_ROWS = 12, 50
_QUANTITY = re.compile(r"l[123]|\w+_deg|b1_[xy]|from|to")


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
        return clipped(text)
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


def degenerate_words(part: Mapping[str, Any], fixed_leg: int) -> str:
    """One line on what is degenerate in a range of lengths, as documents list it under ``degenerate``.

    >>> degenerate_words({"kind": "quadruple", "from": "0", "to": None, "count": 4}, 1)
    '4 poses of kind quadruple in every slice'
    >>> degenerate_words({"kind": "node", "from": "0", "to": "25.000000000", "count": 2}, 1)
    '2 poses of kind node in every slice for L1 from 0 to 25.000000…'
    >>> degenerate_words({"kind": "curve", "from": "5", "to": "5", "equation": "alpha = 0 deg"}, 2)
    'curve of degenerate poses at L2 = 5: alpha = 0 deg'
    """
    start, stop = part["from"], part["to"]
    if start == stop:
        where = f"at L{fixed_leg} = {shortened(start)}"
    elif start == "0" and stop is None:
        where = "in every slice"
    else:
        end = "" if stop is None else f" to {shortened(stop)}"
        where = f"in every slice for L{fixed_leg} from {shortened(start)}{end}"
    if part["kind"] == "curve":
        return f"curve of degenerate poses {where}" + (f": {part['equation']}" if "equation" in part else "")
    return f"{counted(part['count'], 'pose')} of kind {part['kind']} {where}"


HARMLESS = "harmless"
"""The effect of a special shape nearby with the same cusps, of which readers are told nothing."""


def near_words(document: Mapping[str, Any]) -> str:
    """The first line of every form of a document whose geometry is near a special shape that contradicts or
    weakens the answer: what holds there, and how to spell it. Empty without one.

    >>> shape = {"shape": "similar", "distance": "0.0000020", "says": "base and platform are similar"}
    >>> spelling = {"base": {"equilateral": "10"}, "platform": {"equilateral": "sqrt(3)"}}
    >>> print(near_words({"near": [{**shape, "spelling": spelling, "effect": "contradicts"}]}))
    Within 0.0000020 of a special shape: base and platform are similar. ... give {"base": {"equilateral": ...
    >>> near_words({"near": [{**shape, "spelling": spelling, "effect": "harmless"}]})
    ''
    """
    for shape in document.get("near", ()):
        if shape["effect"] != HARMLESS:
            return (
                f"Within {shape['distance']} of a special shape: {shape['says']}. This answer is about the "
                f"numbers as given; for the exact shape give {json.dumps(shape['spelling'])}"
            )
    return ""


def html_table(
    title: str, records: Sequence[Mapping[str, object]], notes: Iterable[str] = (), *, first: str = ""
) -> str:
    """A table with a column for each name, in the colours of the page; digits are shortened.

    Args:
        title: what it is.
        records: its rows.
        notes: lines below it.
        first: a line above all, if there is one.
    """
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
    above = f"<p>{escape(first)}</p>" if first else ""
    return f"<div>{above}<p><strong>{escape(title)}</strong></p>{table}{below}</div>"


def text_table(title: str, records: Sequence[Mapping[str, object]]) -> str:
    """A table in columns, for ``print``; digits are shortened.

    >>> print(text_table("a slice", [{"cusp": 1, "l2": "0.845282018280357"}, {"cusp": 2, "l2": "9"}]))
    a slice
    cusp  l2
    1     0.845282018280…
    2     9
    """
    names = list(dict.fromkeys(name for record in records for name in record))
    rows = [names, *([_shown(record.get(name)) for name in names] for record in records)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows if records)
    return "\n".join((title, *lines))


def _float(text: str) -> float:
    if text.startswith("sqrt("):
        return math.sqrt(_float(text[5:-1]))
    try:
        return float(Fraction(text)) if "/" in text else float(text)
    except OverflowError:
        return math.inf


def _shown(value: object) -> str:
    return "" if value is None else shortened(str(value), _SHOWN_DIGITS)


def _cell(value: object) -> str:
    return escape(_shown(value))


_NAMES = ("id", "name")
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?:/\d+)?", re.ASCII)
_OF_FORMULAS = ("=", "+", "-", "@", "\t", "\r", "\n", "＝", "＋", "－", "＠", "'")


def csv_text(columns: Sequence[str], records: Iterable[Mapping[str, object]]) -> str:
    """Records as CSV: a line for each, in the order of the columns; members without a column are left out.

    No cell is a formula to a spreadsheet: a text that begins like one, or with an apostrophe, has an
    apostrophe before it, which :func:`read_cell` takes off. Numbers are never changed.

    >>> print(csv_text(["id", "l2"], [{"id": "=1+1", "l2": "-0.5"}, {"id": "'a", "l2": "2"}]))
    id,l2
    '=1+1,-0.5
    ''a,2
    <BLANKLINE>
    """
    rows = ([_cell_of(name, record.get(name)) for name in columns] for record in records)
    return "".join(map(csv.writer(_Lines()).writerow, chain([columns], rows)))


class _Lines:
    """The file of a writer, whose ``writerow`` returns what ``write`` does: the line, ended by ``\\n``.

    The writer ends lines with ``\\r\\n``, and so quotes cells that have either of the two.
    """

    @staticmethod
    def write(line: str) -> str:
        return line.removesuffix("\r\n") + "\n"


def _cell_of(column: str, value: object) -> str:
    text = "" if value is None else str(value)
    is_formula = text.startswith(_OF_FORMULAS) and (column in _NAMES or not _NUMBER.fullmatch(text))
    return f"'{text}" if is_formula else text


def read_cell(cell: str) -> str:
    """The text of a cell as :func:`csv_text` writes it.

    >>> read_cell("'=1+1"), read_cell("''a"), read_cell("-0.5")
    ('=1+1', "'a", '-0.5')
    """
    return cell.removeprefix("'")
