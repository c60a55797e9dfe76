"""Documents on stdout, as tables for a terminal or as JSON, CSV and aligned text; progress on stderr."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from rich import box
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

import rpr_solver

_HEADINGS = {
    "alpha_deg": "α [deg]",
    **{f"theta{i}_deg": f"θ{i} [deg]" for i in (1, 2, 3)},
    **{f"l{i}": f"L{i}" for i in (1, 2, 3)},
    "b1_x": "B1 x",
    "b1_y": "B1 y",
}
_COLUMN_PADDING = 3
_LEAST_WIDTH = 8


@contextmanager
def progress_bar(total: int, what: str = "slices") -> Iterator[rpr_solver.Progress]:
    """A progress bar on stderr, if that is a terminal; gives the callback that moves it."""
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not sys.stderr.isatty()) as progress:
        task = progress.add_task(what, total=total)
        yield lambda done, total: progress.update(task, completed=done, total=total)


@dataclass(frozen=True)
class Section:
    """A title, a table (its first row is the headings), and lines of text."""

    title: str
    rows: Sequence[Sequence[str]] = ()
    notes: Sequence[str] = ()
    failed: bool = False


@dataclass(frozen=True)
class Page:
    """A document as a person reads it."""

    about: str
    sections: Sequence[Section]
    digits: int | None = None


def write_table(table: dict[str, Any], form: str) -> None:
    """Print a cusp table as `table`, `json` or `csv`."""
    sections = []
    for part in table["slices"]:
        sections += [_slice(part), *([_audit(part["audit"])] if "audit" in part else [])]
    page = Page(about(table), sections, table["digits"])
    write_document(table, page, form, csv=rpr_solver.table_csv)


def write_document(document: Any, page: Page, form: str, csv: Callable[[Any], str] | None = None) -> None:
    """Print a document as `json` or `csv`, or its page: fitted to a terminal, else aligned text with all
    digits."""
    out = sys.stdout
    if form == "json":
        out.write(json.dumps(document, indent=2, ensure_ascii=False) + "\n")
    elif form == "csv" and csv is not None:
        out.write(csv(document))
    elif out.isatty():
        _write_rich(page, Console(file=out))
    else:
        out.writelines(line + "\n" for line in _text_lines(page))


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


def about(document: Mapping[str, Any]) -> str:
    """Returns the line that describes the manipulator of a document."""
    geometry = document["geometry"]
    lengths = "  ".join(f"{key} = {value}" for key, value in geometry.items() if key != "orientation")
    return f"3-RPR manipulator  {lengths}  ({geometry['orientation']})"


def counted(count: int, what: str) -> str:
    """Returns a count with its noun.

    >>> counted(1, "cusp"), counted(2, "cusp")
    ('1 cusp', '2 cusps')
    """
    return f"{count} {what}{'' if count == 1 else 's'}"


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
    yield page.about
    for section in page.sections:
        yield ""
        yield section.title
        if section.rows:
            widths = [max(map(len, column)) for column in zip(*section.rows, strict=True)]
            yield from (
                "  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip()
                for row in section.rows
            )
        yield from (f"  {note}" for note in section.notes)


def _write_rich(page: Page, console: Console) -> None:
    console.print(Text(page.about, style="dim"))
    shortened = False
    for section in page.sections:
        console.print()
        console.print(Text(section.title, style="bold red" if section.failed else "bold"))
        if section.rows:
            headings, *rows = section.rows
            # border and padding on both sides of every column
            widths = _fitting([*section.rows], console.width - 2)
            table = Table(box=box.ROUNDED)
            for key in headings:
                table.add_column(Text(key), no_wrap=True)
            for row in rows:
                cells = [_fit(cell, width) for cell, width in zip(row, widths, strict=True)]
                shortened = shortened or cells != row
                table.add_row(*map(Text, cells))
            console.print(table)
        for note in section.notes:
            console.print(Text(f"  {note}"), no_wrap=True, overflow="ellipsis")
    if shortened:
        digits = "all digits" if page.digits is None else f"all {page.digits} digits"
        hint = f"Cut to fit; {digits} are in --format json or csv, and in a pipe or file."
        console.print(Text(hint, style="dim"))


def _fitting(rows: Sequence[Sequence[str]], width: int) -> list[int]:
    """Returns column widths that fit; short columns leave their room to long ones."""
    needed = [max(map(len, column)) for column in zip(*rows, strict=True)]
    left, widths = width - _COLUMN_PADDING * len(needed), [0] * len(needed)
    for n, i in enumerate(sorted(range(len(needed)), key=needed.__getitem__)):
        widths[i] = max(min(needed[i], left // (len(needed) - n)), _LEAST_WIDTH)
        left -= widths[i]
    return widths


def _where(part: dict[str, Any]) -> str:
    key = next(name for name in ("l1", "l2", "l3") if name in part)
    return f"{key.upper()} = {part[key]}"


def _fit(cell: str, width: int) -> str:
    return cell if len(cell) <= width else f"{cell[: width - 1]}…"
