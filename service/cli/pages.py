"""What a person sees on a terminal: tables and progress. What a program reads: JSON, CSV, aligned text."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import TracebackType
from typing import Any, Self, TextIO

from rich import box
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bar
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


class Progress:
    """A progress bar on stderr; nothing at all when that is no terminal."""

    def __init__(self, total: int, what: str = "slices") -> None:
        self._bar = Bar(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            console=Console(stderr=True),
            transient=True,
            disable=not sys.stderr.isatty(),
        )
        self._task = self._bar.add_task(what, total=total)

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.stop()

    def update(self, done: int, total: int) -> None:
        """Show how many of all are done."""
        self._bar.update(self._task, completed=done, total=total)


@dataclass(frozen=True)
class Section:
    """A title, a table under it (the first row are the headings), and lines of text."""

    title: str
    rows: Sequence[Sequence[str]] = ()
    notes: Sequence[str] = ()
    failed: bool = False


@dataclass(frozen=True)
class Page:
    """What a person sees of one document."""

    about: str
    sections: Sequence[Section] = field(default_factory=list)
    digits: int | None = None


def write_table(table: dict[str, Any], form: str, out: TextIO | None = None) -> None:
    """Print a cusp table as `table`, `json` or `csv`."""
    sections = []
    for part in table["slices"]:
        sections += [_slice(part), *([_audit(part["audit"])] if "audit" in part else [])]
    page = Page(about(table), sections, table["digits"])
    write_document(table, page, form, out, csv=rpr_solver.table_csv)


def write_document(
    document: Any,
    page: Page,
    form: str,
    out: TextIO | None = None,
    csv: Callable[[Any], str] | None = None,
) -> None:
    """Print a document as `json`, as `csv`, or its page: fitted to a terminal, or as aligned text with all
    digits."""
    out = out or sys.stdout
    if form == "json":
        out.write(json.dumps(document, indent=2, ensure_ascii=False) + "\n")
    elif form == "csv" and csv is not None:
        out.write(csv(document))
    elif out.isatty():
        _write_rich(page, Console(file=out))
    else:
        out.writelines(line + "\n" for line in _text_lines(page))


def rows_of(points: Sequence[Mapping[str, Any]], keys: Sequence[str] | None = None) -> list[list[str]]:
    """Points under their headings; a sign's place is kept free, so that digits align."""
    if not points:
        return []
    keys = list(points[0]) if keys is None else list(keys)
    body = [[str(point[key]) for key in keys] for point in points]
    signed = [any(row[i].startswith("-") for row in body) for i in range(len(keys))]
    body = [
        [
            f" {cell}" if sign and not cell.startswith("-") else cell
            for cell, sign in zip(row, signed, strict=True)
        ]
        for row in body
    ]
    return [[_HEADINGS.get(key, key) for key in keys], *body]


def about(document: Mapping[str, Any]) -> str:
    """Which manipulator a document belongs to."""
    geometry = document["geometry"]
    lengths = "  ".join(f"{key} = {value}" for key, value in geometry.items() if key != "orientation")
    return f"3-RPR manipulator  {lengths}  ({geometry['orientation']})"


def counted(count: int, what: str) -> str:
    """A number of things.

    >>> counted(1, "cusp"), counted(2, "cusp")
    ('1 cusp', '2 cusps')
    """
    return f"{count} {what}{'' if count == 1 else 's'}"


def failures(table: dict[str, Any]) -> list[tuple[str, dict[str, str]]]:
    """The slices without an answer, each with the error that it carries."""
    return [(_where(part), part["error"]) for part in table["slices"] if "error" in part]


def describe_point(point: Mapping[str, Any]) -> str:
    """A point that is no ordinary cusp, in one line."""
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
    """The factors of the article's eliminant, and what became of their real solutions."""
    rows = [["factor", "degree", "mult.", "real roots", "kept", "degenerate", "rejected", "why"]]
    for factor in audit["factors"]:
        verdicts = [couple["verdict"] for couple in factor["couples"]]
        numbers = [factor["degree"], factor["multiplicity"], factor["real_roots"]]
        numbers += [verdicts.count(verdict) for verdict in ("kept", "degenerate", "rejected")]
        rows.append([factor["origin"], *map(str, numbers), factor["reason"]])
    title = f"The article's eliminant of degree {audit['eliminant_degree']}, factor by factor"
    notes = [f"h: {audit['h']}", audit["conjecture"]["answer"]]
    rejected = [
        (f["origin"], c) for f in audit["factors"] for c in f["couples"] if c["verdict"] == "rejected"
    ]
    notes += [
        f"rejected ({origin}): α {c['alpha_deg']}, θ1 {c['theta1_deg']}: {c['reason']}"
        for origin, c in rejected
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
            shown = Table(box=box.ROUNDED)
            for key in headings:
                shown.add_column(Text(key), no_wrap=True)
            for row in rows:
                shown.add_row(*(Text(_fit(cell, width)) for cell, width in zip(row, widths, strict=True)))
            shortened = shortened or any(
                len(cell) > width for row in rows for cell, width in zip(row, widths, strict=True)
            )
            console.print(shown)
        for note in section.notes:
            console.print(Text(f"  {note}"), no_wrap=True, overflow="ellipsis")
    if shortened:
        everywhere = "Cut to fit; all digits are in --format json or csv, and in a pipe or file."
        if page.digits is not None:
            everywhere = everywhere.replace("all digits", f"all {page.digits} digits")
        console.print(Text(everywhere, style="dim"))


def _fitting(rows: Sequence[Sequence[str]], width: int) -> list[int]:
    """Widths of columns that fit; short columns leave their room to long ones."""
    needed = [max(map(len, column)) for column in zip(*rows, strict=True)]
    left, widths = width - _COLUMN_PADDING * len(needed), [0] * len(needed)
    for rest, i in zip(
        range(len(needed), 0, -1), sorted(range(len(needed)), key=needed.__getitem__), strict=True
    ):
        widths[i] = max(min(needed[i], left // rest), _LEAST_WIDTH)
        left -= widths[i]
    return widths


def _where(part: dict[str, Any]) -> str:
    key = next(name for name in ("l1", "l2", "l3") if name in part)
    return f"{key.upper()} = {part[key]}"


def _fit(cell: str, width: int) -> str:
    return cell if len(cell) <= width else f"{cell[: width - 1]}…"
