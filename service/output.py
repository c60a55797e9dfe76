"""What a person sees on a terminal: tables and progress. What a program reads: JSON, CSV, aligned text."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
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
}
_COLUMN_PADDING = 3
_LEAST_WIDTH = 8


class Progress:
    """A progress bar on stderr; nothing at all when that is no terminal."""

    def __init__(self, total: int) -> None:
        self._bar = Bar(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            console=Console(stderr=True),
            transient=True,
            disable=not sys.stderr.isatty(),
        )
        self._task = self._bar.add_task("slices", total=total)

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.stop()

    def update(self, done: int, total: int) -> None:
        """Show how many of all slices are done."""
        self._bar.update(self._task, completed=done, total=total)


def write_table(table: dict[str, Any], form: str, out: TextIO | None = None) -> None:
    """Print a cusp table as `table`, `json` or `csv`."""
    out = out or sys.stdout
    if form == "json":
        out.write(json.dumps(table, indent=2, ensure_ascii=False) + "\n")
    elif form == "csv":
        out.write(rpr_solver.table_csv(table))
    elif out.isatty():
        _write_rich(table, Console(file=out))
    else:
        out.writelines(line + "\n" for line in text_lines(table))


def text_lines(table: dict[str, Any]) -> Iterator[str]:
    """A table as aligned text, with all digits."""
    yield _about(table)
    for part in table["slices"]:
        yield ""
        yield _title(part)
        if rows := _rows(part):
            widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
            yield from (
                "  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip() for row in rows
            )
        yield from (f"  {_point(point)}" for point in part.get("degenerate_points", ()))


def failures(table: dict[str, Any]) -> list[tuple[str, dict[str, str]]]:
    """The slices without an answer, each with the error that it carries."""
    return [(_where(part), part["error"]) for part in table["slices"] if "error" in part]


def _write_rich(table: dict[str, Any], console: Console) -> None:
    console.print(Text(_about(table), style="dim"))
    shortened = False
    for part in table["slices"]:
        console.print()
        console.print(Text(_title(part), style="bold red" if "error" in part else "bold"))
        if rows := _rows(part):
            # border and padding on both sides of every column
            width = max(_LEAST_WIDTH, (console.width - 2) // len(rows[0]) - _COLUMN_PADDING)
            shown = Table(box=box.ROUNDED)
            for key in rows[0]:
                shown.add_column(Text(key), no_wrap=True)
            for row in rows[1:]:
                shown.add_row(*(Text(_fit(cell, width)) for cell in row))
            shortened = shortened or any(len(cell) > width for row in rows[1:] for cell in row)
            console.print(shown)
        for point in part.get("degenerate_points", ()):
            console.print(Text(f"  {_point(point)}"), no_wrap=True, overflow="ellipsis")
    if shortened:
        note = f"Cut to fit; all {table['digits']} digits are in --format json or csv, and in a pipe or file."
        console.print(Text(note, style="dim"))


def _rows(part: dict[str, Any]) -> list[list[str]]:
    """The cusps of a slice under their headings; a sign's place is kept free, so that digits align."""
    cusps = part.get("cusps") or []
    if not cusps:
        return []
    keys = list(cusps[0])
    body = [[str(cusp[key]) for key in keys] for cusp in cusps]
    signed = [any(row[i].startswith("-") for row in body) for i in range(len(keys))]
    body = [
        [
            f" {cell}" if sign and not cell.startswith("-") else cell
            for cell, sign in zip(row, signed, strict=True)
        ]
        for row in body
    ]
    return [[_HEADINGS.get(key, key) for key in keys], *body]


def _about(table: dict[str, Any]) -> str:
    geometry = table["geometry"]
    lengths = "  ".join(f"{key} = {value}" for key, value in geometry.items() if key != "orientation")
    return f"3-RPR manipulator  {lengths}  ({geometry['orientation']})"


def _title(part: dict[str, Any]) -> str:
    if "error" in part:
        return f"{_where(part)}: no answer: {part['error']['detail']}"
    count = part["count"]
    return f"{_where(part)}: {count} cusp{'' if count == 1 else 's'}"


def _where(part: dict[str, Any]) -> str:
    key = next(name for name in ("l1", "l2", "l3") if name in part)
    return f"{key.upper()} = {part[key]}"


def _point(point: dict[str, Any]) -> str:
    values = ", ".join(
        f"{_HEADINGS.get(k, k)} {v}" for k, v in point.items() if k != "kind" and isinstance(v, str)
    )
    return f"{point.get('kind', 'degenerate point')}: {values}"


def _fit(cell: str, width: int) -> str:
    return cell if len(cell) <= width else f"{cell[: width - 1]}…"
