"""Documents on stdout: as tables that fit a terminal, as aligned text, or as JSON or CSV."""

from __future__ import annotations

import json
import re
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from rpr_solver.contract import LEGS
from rpr_solver.notebook import counted, degenerate_words, near_words
from service.cli import output
from service.cli.digits import PRINTED, rounded

if TYPE_CHECKING:
    from rich.console import Console

COLUMN_PADDING = 3
"""The border and the spaces beside a cell."""

_DECIMAL = re.compile(r"([ +-]?\d+\.)(\d+)((?:[eE][+-]?\d+)?)", re.ASCII)
_IN_TEXT = re.compile(r"(?<![\w.])-?\d+\.\d{9,}(?:[eE][+-]?\d+)?", re.ASCII)
_MIN_DIGITS = 2
_MIN_WIDTH = 20
_MIN_DIGITS_IN_TEXT = 12
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
    digits = max(_MIN_DIGITS, width - len(whole) - len(more) - len(exponent))
    short = whole + fraction[:digits] + more + exponent
    return short if len(short) < len(text) else text


def fitted(cell: str, width: int, more: str = "…") -> str:
    """Returns a cell that fits: a number shortened, a sentence in several lines.

    >>> fitted("1.23456789", 6), fitted("leg 2 has length zero, so no angle", 22)
    ('1.234…', 'leg 2 has length zero,\\nso no angle')
    """
    return "\n".join(wrapped(cell, width)) if _is_sentence(cell) else shortened(cell, width, more)


def fitted_column(cells: Sequence[str], width: int, more: str = "…") -> list[str]:
    """Returns the cells of a column that fit; those that differ still do, even if they are wider then.

    >>> fitted_column(["1.23456789", "1.23456799", "2.5"], 6)
    ['1.23456789', '1.23456799', '2.5']
    >>> fitted_column(["1.23416789", "1.23456799"], 6)
    ['1.2341…', '1.2345…']
    """
    short = [fitted(cell, width, more) for cell in cells]
    for text in set(short):
        places = [k for k, other in enumerate(short) if other == text]
        different = {cells[k] for k in places}
        room, most = width, max(map(len, different))
        while room < most and len({fitted(cell, room, more) for cell in different}) < len(different):
            room += 1
        for k in places if room > width else ():
            short[k] = fitted(cells[k], room, more)
    return short


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
        return max(_MIN_WIDTH, *map(len, cell.split()))
    return len(shortened(cell, 0, more))


def _is_sentence(cell: str) -> bool:
    return len(cell) > _MIN_WIDTH and len(cell.split()) > 2


def records(rows: Sequence[Sequence[str]], width: int, more: str = "…") -> Iterator[str]:
    """Yields a table that is too wide as a record a row, one line a cell."""
    headings, *body = rows
    margin = max(map(len, headings)) + 2
    columns = [fitted_column(column, width - margin, more) for column in zip(*body, strict=True)]
    for row in zip(*columns, strict=True):
        for heading, text in zip(headings, row, strict=True):
            if text.strip():
                yield from wrapped(heading.ljust(margin) + text, width, " " * margin)
        yield ""


def with_short_numbers(text: str, width: int, more: str = "…") -> str:
    """Returns a sentence whose long decimals have been shortened, to fit in one line if possible."""
    found = _IN_TEXT.findall(text)
    if len(text) <= width or not found:
        return text
    others = len(text) - sum(map(len, found))
    each = max(_MIN_DIGITS_IN_TEXT, (width - others) // len(found))
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


_HEADINGS = {
    "alpha_deg": "α [deg]",
    "phi_deg": "φ [deg]",
    **{f"theta{i}_deg": f"θ{i} [deg]" for i in (1, 2, 3)},
    **{f"l{i}": f"L{i}" for i in (1, 2, 3)},
    "b1_x": "B1 x",
    "b1_y": "B1 y",
    "multiplicity": "mult.",
}


@dataclass(frozen=True)
class Section:
    """A title, a table (its first row is the headings), and lines of text."""

    title: str
    rows: Sequence[Sequence[str]] = ()
    notes: Sequence[str] = ()
    failed: bool = False

    def spelled(self) -> Section:
        """Returns the section in ASCII."""
        rows = [list(map(output.spelled, row)) for row in self.rows]
        notes = list(map(output.spelled, self.notes))
        return Section(output.spelled(self.title), rows, notes, self.failed)


@dataclass(frozen=True)
class Page:
    """A document as a person reads it.

    Attributes:
        about: the first line about the document.
        sections: what follows.
        digits: the significant digits of its numbers, if they all have the same.
        formats: the values of `--format` that keep all digits on a terminal.
        last: the last line.
        first: lines above all others, of special shapes that contradict or weaken the answer.
    """

    about: str
    sections: Sequence[Section]
    digits: int | None = None
    formats: Sequence[str] = ("json",)
    last: str = ""
    first: Sequence[str] = ()

    def spelled(self) -> Page:
        """Returns the page in ASCII."""
        return replace(
            self,
            about=output.spelled(self.about),
            sections=[section.spelled() for section in self.sections],
            last=output.spelled(self.last),
            first=list(map(output.spelled, self.first)),
        )


def write_table(table: dict[str, Any], form: str, digits: int = PRINTED) -> None:
    """Print a cusp table as a `table`, whose numbers have so many digits, or as `json`, with all of them."""
    sections = []
    for part in rounded(table, digits)["slices"]:
        sections += [_slice(part), *([_audit(part["audit"])] if "audit" in part else [])]
    page = Page(about(table), sections, table["digits"], formats=("json", "csv"))
    write_document(table, page, form)


def write_document(document: Any, page: Page, form: str, csv: Callable[[Any], str] | None = None) -> None:
    """Print a document as `json` or `csv`, or its page: fitted to a terminal, else aligned text."""
    out = output.stdout()
    unicode = output.is_unicode(out)
    if form == "json":
        output.write(json.dumps(document, indent=2, ensure_ascii=not unicode) + "\n")
        return
    line = near_words(document)
    if form == "csv" and csv is not None:
        output.write(csv(document))
        say_near(line)
        return
    if line:
        page = replace(page, first=[line, *page.first])
    if csv is not None:
        page = replace(page, formats=("json", "csv"))
    if not unicode:
        page = page.spelled()
    if out.isatty():
        from rich.console import Console

        console = Console(file=out, highlight=False, soft_wrap=True)
        with console.capture() as captured:
            _print_fitted(page, console, "…" if unicode else "...")
        output.write(captured.get())
    else:
        output.write("".join(line + "\n" for line in _text_lines(page)))


def say_near(line: str) -> None:
    """Print the line about a special shape on stderr, for forms that have no place for it."""
    if line:
        output.say(f"rpr-cusps: {line}")


def nearby(pose: Mapping[str, str]) -> str:
    """Returns a pose of few digits in a line.

    >>> nearby({"alpha_deg": "1.5", "theta1_deg": "-20", "l1": "27"})
    'α = 1.5°, θ1 = -20°, L1 = 27'
    """
    names = {"alpha_deg": "α", **{f"theta{leg}_deg": f"θ{leg}" for leg in (1, 2, 3)}}
    angles = (f"{words} = {pose[name]}°" for name, words in names.items() if name in pose)
    lengths = (f"{name.upper()} = {pose[name]}" for name in LEGS if name in pose)
    return ", ".join((*angles, *lengths))


def all_legs(part: Mapping[str, Any]) -> str:
    """Returns the three leg lengths in a document or a part of it, in a line."""
    return ", ".join(f"{name.upper()} = {part[name]}" for name in LEGS)


def rows_of(points: Sequence[Mapping[str, Any]], keys: Sequence[str] | None = None) -> list[list[str]]:
    """Returns points as a table with headings; unsigned numbers leave room for a sign and stay aligned."""
    if not points:
        return []
    return list(map(list, zip(*(_column(key, points) for key in keys or points[0]), strict=True)))


def _column(key: str, points: Sequence[Mapping[str, Any]]) -> list[str]:
    cells = [str(point[key]) for point in points]
    if any(cell.startswith("-") for cell in cells):
        cells = [cell if cell.startswith("-") else f" {cell}" for cell in cells]
    return [_HEADINGS.get(key, key), *cells]


def tolerance_words(tolerance: Mapping[str, str]) -> str:
    """Returns the greatest change of each length in words."""
    if len({*tolerance.values()}) == 1:
        return f"all lengths within {next(iter(tolerance.values()))}"
    return ", ".join(f"{name} within {number}" for name, number in tolerance.items() if number != "0")


def about(document: Mapping[str, Any]) -> str:
    """Returns the line that describes the manipulator of a document."""
    geometry = document["geometry"]
    if "base" in geometry:
        triangles = (
            f"{name} {', '.join(geometry[name])} ({geometry[f'{name}_orientation']})"
            for name in ("base", "platform")
        )
        return "3-RPR manipulator  " + "  ".join(triangles)
    lengths = "  ".join(f"{key} = {value}" for key, value in geometry.items() if key != "orientation")
    return f"3-RPR manipulator  {lengths}  ({geometry['orientation']})"


SIGNS = {1: "+", -1: "−", 0: "0", None: "?"}
"""The sign of J as tables have it."""


def ends_in_words(span: Mapping[str, str | None]) -> str:
    """Returns a range in words; its upper end may be missing."""
    return f"from {span['from']}" + ("" if span["to"] is None else f" to {span['to']}")


def counted_range(low: int, high: int, what: str) -> str:
    """Returns a range of counts with its noun.

    >>> counted_range(2, 2, "cusp"), counted_range(0, 2, "cusp")
    ('2 cusps', '0 to 2 cusps')
    """
    return counted(low, what) if low == high else f"{low} to {high} {what}s"


def failures(table: dict[str, Any]) -> list[tuple[str, dict[str, str]]]:
    """Returns the slices without an answer, each with its error."""
    return [(_where(part), part["error"]) for part in table["slices"] if "error" in part]


def describe_point(point: Mapping[str, Any]) -> str:
    """Returns one line on a point that is not an ordinary cusp."""
    values = ", ".join(
        f"{_HEADINGS.get(k, k)} {v}" for k, v in point.items() if k != "kind" and isinstance(v, str)
    )
    return f"{point.get('kind', 'degenerate point')}: {values}"


def degenerate_notes(document: Mapping[str, Any]) -> list[str]:
    """Returns a line for each thing that is degenerate throughout a range of lengths."""
    leg = document["fixed_leg"]
    return [f"degenerate: {degenerate_words(part, leg)}" for part in document.get("degenerate", ())]


def _slice(part: dict[str, Any]) -> Section:
    if "error" in part:
        return Section(f"{_where(part)}: no answer: {part['error']['detail']}", failed=True)
    title = f"{_where(part)}: {counted(part['count'], 'cusp')}"
    return Section(
        title, rows_of(part["cusps"]), [describe_point(p) for p in part.get("degenerate_points", ())]
    )


def _audit(audit: Mapping[str, Any]) -> Section:
    """The factors of the article's eliminant, and the verdicts on their real solutions."""
    rows = [["factor", "degree", "mult.", "real roots", "kept", "degenerate", "rejected", "why"]]
    for factor in audit["factors"]:
        verdicts = [couple["verdict"] for couple in factor["couples"]]
        numbers = [factor["degree"], factor["multiplicity"], factor["real_roots"]]
        numbers += [verdicts.count(verdict) for verdict in ("kept", "degenerate", "rejected")]
        rows.append([factor["origin"], *map(str, numbers), factor["reason"]])
    title = f"The article's eliminant of degree {audit['eliminant_degree']}, factor by factor"
    notes = [f"h: {audit['h']}", audit["conjecture"]["answer"]]
    notes += [
        f"rejected ({factor['origin']}): α {c['alpha_deg']}, θ1 {c['theta1_deg']}: {c['reason']}"
        for factor in audit["factors"]
        for c in factor["couples"]
        if c["verdict"] == "rejected"
    ]
    return Section(title, rows, notes)


def _text_lines(page: Page) -> Iterator[str]:
    yield from page.first
    yield page.about
    for section in page.sections:
        yield ""
        yield section.title
        yield from output.columns(section.rows)
        yield from (f"  {note}" for note in section.notes)
    if page.last:
        yield ""
        yield page.last


def _print_fitted(page: Page, console: Console, more: str) -> None:
    from rich.text import Text

    width = console.width
    shortened = False

    def lines(text: str, style: str = "", indent: str = "") -> None:
        nonlocal shortened
        short = with_short_numbers(text, width, more)
        shortened = shortened or short != text
        for line in wrapped(short, width, indent):
            console.print(Text(line, style=style))

    for line in page.first:
        lines(line, "bold yellow")
    lines(page.about, "dim")
    for section in page.sections:
        console.print()
        lines(section.title, "bold red" if section.failed else "bold", "  ")
        if section.rows:
            shortened |= _print_rows(section.rows, console, more)
        for note in section.notes:
            lines(f"  {note}", indent="    ")
    if page.last:
        console.print()
        lines(page.last, "bold")
    if shortened or (page.digits or 0) > PRINTED:
        digits = "All digits" if page.digits is None else f"All {page.digits} digits"
        lines(f"{digits} are in --format {' or '.join(page.formats)}.", "dim")


def _print_rows(rows: Sequence[Sequence[str]], console: Console, more: str) -> bool:
    """Print a table; returns whether a number was shortened."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    widths = column_widths(rows, console.width, more)
    columns = [
        [heading, *fitted_column(column, width, more)]
        for (heading, *column), width in zip(zip(*rows, strict=True), widths or (), strict=False)
    ]
    needed = (
        sum(COLUMN_PADDING + max(len(line) for cell in x for line in cell.split("\n")) for x in columns) + 1
    )
    if widths is None or needed > console.width:
        lines = list(records(rows, console.width, more))
        for line in lines[:-1]:
            console.print(Text(line))
        return any(more in line for line in lines)
    cells = list(zip(*columns, strict=True))
    table = Table(box=box.ROUNDED)
    for heading in cells[0]:
        table.add_column(Text(heading), no_wrap=True)
    for row in cells[1:]:
        table.add_row(*map(Text, row))
    console.print(table)
    return any(more in cell for row in cells for cell in row)


def _where(part: dict[str, Any]) -> str:
    key = next(name for name in LEGS if name in part)
    return f"{key.upper()} = {part[key]}"
