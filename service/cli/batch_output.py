"""The results of a batch on stdout, each as soon as it is there."""

from __future__ import annotations

import csv
import io
from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from typing import TYPE_CHECKING, Any

import rpr_solver
from rpr_solver.errors import InputError
from service.cli import output

if TYPE_CHECKING:  # httpx is slow to load
    from service.client import ItemResult

FORMS = ("ndjson", "csv")

_ERROR = b'"error":{'
_TABLE = "cusp-table"


def print_results(name: str, results: Generator[ItemResult, None, None], form: str) -> int:
    """Print results as they come, and how many are no answers on stderr; returns the exit status.

    Ctrl-C never cuts a line; it is handed on to the iterator, which knows what becomes of the batch.

    Raises:
        InputError: one is no cusp table, and cannot be printed as CSV.
    """
    text = _Rows().text if form == "csv" else _line
    count = without = 0
    with closing(results):
        try:
            for result in results:
                with output.unbroken():
                    output.write(text(result))
                    output.flush()
                count += 1
                without += result.answer is None or _ERROR in result.answer.content
        except KeyboardInterrupt as interrupt:
            results.throw(interrupt)
    if without:
        output.say(f"rpr-cusps {name}: {without} of {count} items have no complete answer; each says why")
    return 1 if without else 0


def _line(result: ItemResult) -> str:
    return result.line.decode() + "\n"


class _Rows:
    """Cusp tables as CSV: the rows of each, after the number and the name of its item."""

    def __init__(self) -> None:
        self._leg: int | None = None
        self._is_begun = False

    def text(self, result: ItemResult) -> str:
        """Returns the rows of a result; the header comes before those of the first."""
        if result.answer is None:
            table: Mapping[str, Any] = {"fixed_leg": self._leg or 1, "slices": []}
        else:
            table = self._checked(result)
        columns, *rows = csv.reader(io.StringIO(rpr_solver.table_csv(table)))
        if result.answer is None:
            rows = [[_reason(result) if column == "error" else "" for column in columns]]
        header = [] if self._is_begun else [["index", "id", *columns]]
        self._is_begun = True
        return _csv([*header, *([str(result.index), result.name or "", *row] for row in rows)])

    def _checked(self, result: ItemResult) -> Mapping[str, Any]:
        assert result.answer is not None
        if result.kind != _TABLE:
            raise InputError.of("--format", f"csv is for cusp tables; items[{result.index}] is {result.kind}")
        table = result.answer.document
        leg = table["fixed_leg"]
        if self._leg not in (None, leg):
            other = f"items[{result.index}] fixes leg {leg}, those before it leg {self._leg}"
            raise InputError.of("--format", f"csv has the columns of one fixed leg; {other}")
        self._leg = leg
        return table


def _reason(result: ItemResult) -> str:
    return result.status if result.problem is None else result.problem.detail


def _csv(rows: Sequence[Sequence[str]]) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue()
