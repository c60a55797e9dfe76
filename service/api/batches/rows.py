"""The items of a batch: questions as JSON, or as CSV with one geometry a row."""

from __future__ import annotations

import csv
import difflib
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import IO, Any, get_origin

from pydantic.fields import FieldInfo

from rpr_solver.contract import LEGS
from rpr_solver.errors import InputError, clipped
from rpr_solver.notebook import read_cell
from rpr_solver.sensed.angles import ANGLES
from service.api.answer import json_of
from service.api.batches.bodies import CheckSize, Sent, invalid, lines
from service.api.problems import ProblemError
from service.schemas import by_kind
from service.schemas.columns import COLUMNS as GEOMETRY
from service.schemas.columns import EXPECTED, advice_on, form_of, geometry_of
from service.schemas.document import Document, JsonNumber, Source, at, part
from service.schemas.foreign import foreign
from service.schemas.lengths import ENDS, LIMIT_COLUMNS, PHI_COLUMNS, SLICE_COLUMNS, leg_of
from service.schemas.limits import Limits
from service.schemas.questions import check_price
from service.schemas.resources import KIND_NAMES, BatchItem
from worker.answers import JobRequest
from worker.answers.kinds import Item, kind_named
from worker.answers.tables import CUSP_TABLE

_NUMBERS = ("fixed_leg", "digits", "samples", "pose", "tolerance")
_FLAGS = ("sensitivities",)
_TRUTH: Mapping[str, bool] = {"true": True, "false": False}
_REQUIREMENT = ("max_cusps", "min_cusps", "degenerate", "mode_change")
COLUMNS = (
    "id", "kind", *GEOMETRY, *LEGS, *SLICE_COLUMNS, *_NUMBERS, "method",
    *PHI_COLUMNS, *LIMIT_COLUMNS, *ANGLES, "angle_tolerance_deg",
    "plot", "theme", "cusp",
    *_REQUIREMENT, *_FLAGS,
)  # fmt: skip
"""All columns that there are."""

_SEPARATORS = (",", ";", "\t")
"""Separators of columns, chosen by the first line."""

_BEGINNING = 4096  # bytes, which show what a body is that is no table

_SEPARATOR_LINE = re.compile(r'"?sep=(.?)"?', re.IGNORECASE)
"""The first line of a table in which a spreadsheet names the separator."""


class Rows:
    """The rows of a table; the first line names the columns.

    Args:
        body: the file.
        longest: the bytes of a line at most.
        check: called with the size of a line that has more.
    """

    def __init__(self, body: IO[bytes], longest: int, check: CheckSize) -> None:
        self._beginning = body.read(_BEGINNING)
        body.seek(0)
        self._lines = lines(body, longest, check)
        self._columns: Sequence[str] = ()
        self._separator = ""
        self._is_begun = False

    def __iter__(self) -> Iterator[Mapping[str, str]]:
        """Yields the cells of the rows by columns.

        Raises:
            InputError: the columns are not known.
            ProblemError: this is no CSV in UTF-8.
        """
        return (row for number, line in self._lines for row in self._cells(number, line))

    def _cells(self, number: int, sent: bytes) -> Iterator[Mapping[str, str]]:
        line = self._decoded(sent)
        if not line.strip():
            return
        is_first, self._is_begun = not self._is_begun, True
        if is_first and (named := _SEPARATOR_LINE.fullmatch(line.rstrip(" "))):
            self._separator = _separator(named[1])
            return
        if not self._separator:
            self._separator = max(_SEPARATORS, key=line.count)
        place = f"line {number}"
        try:
            [cells] = csv.reader([line], strict=True, delimiter=self._separator)
        except csv.Error as error:
            raise invalid(f"{place}: {error}", "CSV") from None
        cells = [read_cell(cell.strip()) for cell in cells]
        if not self._columns:
            self._columns = _checked(cells, self._beginning)
            return
        yield {"kind": CUSP_TABLE.name, **self._row(cells, place)}

    def _decoded(self, sent: bytes) -> str:
        try:
            return sent.decode("utf-8" if self._is_begun else "utf-8-sig").rstrip("\r")
        except UnicodeDecodeError as error:
            fault = None if self._is_begun else foreign(self._beginning, is_table=True)
            raise invalid(fault or f"a byte is not UTF-8 ({error.reason})", "CSV") from None

    def _row(self, cells: Sequence[str], place: str) -> dict[str, str]:
        if len(cells) > len(self._columns):
            hint = "; write numbers with a decimal point" if self._separator == "," else ""
            raise invalid(f"{place} has {len(cells)} cells for {len(self._columns)} columns{hint}", "CSV")
        return {name: cell for name, cell in zip(self._columns, cells, strict=False) if cell}


def item_of(row: Mapping[str, str]) -> Mapping[str, Any]:
    """Returns the item that a row stands for; what does not fit its kind is left for its model to refuse.

    Raises:
        InputError: it gives a range of a leg that is not fixed, or of one whose lengths it gives, too; or its
            geometry has columns of two forms, or a cell of a triangle is empty.

    >>> item_of({"d1": "2", "l1_from": "1", "l1_to": "3", "l1_step": "1"})["request"]["l1"]
    {'from': '1', 'to': '3', 'step': '1'}
    """
    cells = dict(row)

    def taken(names: Iterable[str]) -> dict[str, str]:
        return {name: cells.pop(name) for name in names if name in cells}

    kind, name = cells.pop("kind", CUSP_TABLE.name), taken(["id"])
    fields = by_kind()[kind].model_fields if kind in by_kind() else {}
    parts = _parts_of(fields)
    has_range = any("range" in members for members in (fields, *parts.values()))
    _check_ranges(cells, of_fixed_leg=has_range)
    request: dict[str, Any] = {"geometry": geometry_of(taken(GEOMETRY))}
    for leg in LEGS:
        if ends := taken(f"{leg}_{end}" for end in ENDS):
            request["range" if has_range else leg] = {x.removeprefix(f"{leg}_"): ends[x] for x in ends}
        if leg in cells:
            request[leg] = _lengths(cells.pop(leg), fields.get(leg))
    request |= _of_workspace(taken(PHI_COLUMNS[1:]), taken(LIMIT_COLUMNS))
    request |= {x: JsonNumber(number) for x, number in taken(_NUMBERS).items()}
    request |= _with_truth(cells)
    for own, members in parts.items():
        moved = [x for x in members if x in request and x not in fields]
        request[own] = {**request.get(own, {}), **{x: request.pop(x) for x in moved}}
    return {**name, "kind": kind, "request": request}


def _of_workspace(ends: Mapping[str, str], limits: Mapping[str, str]) -> dict[str, Any]:
    """The orientations and the joint limits that cells give."""
    found: dict[str, Any] = {"phi": {x.removeprefix("phi_"): ends[x] for x in ends}} if ends else {}
    for column, text in limits.items():
        leg, _, end = column.partition("_")
        found.setdefault("limits", {}).setdefault(leg, {})[end] = text
    return found


def _check_ranges(cells: Mapping[str, str], *, of_fixed_leg: bool) -> None:
    """Refuse a range that would not count: of a leg that is not fixed, or beside lengths of its leg."""
    own = leg_of(cells)
    for name in cells:
        leg, _, end = name.partition("_")
        if leg in LEGS and end in ENDS:
            if of_fixed_leg and own is not None and leg != f"l{own}":
                raise InputError.of(name, f"with fixed_leg {own} the range is that of l{own}")
            if not of_fixed_leg and leg in cells:
                raise InputError.of(name, f"is given beside {leg}; leave one of them out")


def _with_truth(cells: Mapping[str, str]) -> dict[str, bool | str]:
    """Cells, those of flags as truth values."""
    return {x: _TRUTH.get(cell.lower(), cell) if x in _FLAGS else cell for x, cell in cells.items()}


def _lengths(text: str, field: FieldInfo | None) -> str | list[str]:
    is_list = field is not None and get_origin(field.annotation) is tuple
    return text.split(";") if is_list else text


def _parts_of(fields: Mapping[str, FieldInfo]) -> Mapping[str, Sequence[str]]:
    """Required parts of a question that are documents themselves → their members."""
    models = {name: info.annotation for name, info in fields.items() if info.is_required()}
    return {
        name: [*model.model_fields]
        for name, model in models.items()
        if isinstance(model, type) and issubclass(model, Document)
    }


def _separator(text: str) -> str:
    """Returns the separator that a first line names."""
    if text not in _SEPARATORS:
        raise invalid(f"line 1 names the separator {text!r}; give a comma, a semicolon or a tab", "CSV")
    return text


def _checked(sent: Sequence[str], beginning: bytes) -> Sequence[str]:
    names = [name if name in COLUMNS else name.lower() for name in sent]
    for given, name in zip(sent, names, strict=True):
        if name not in COLUMNS:
            if other := foreign(beginning, is_table=True):
                raise invalid(other, "CSV")
            near = difflib.get_close_matches(name[:60], COLUMNS, n=1)
            known = f"did you mean {near[0]}?" if near else f"known are {', '.join(COLUMNS)}"
            hint = advice_on(name) or known
            raise InputError.of(clipped(given, 60) or "body", f"unknown column; {hint}")
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise InputError.of(twice[0], "this column is given twice")
    missing = [name for name in form_of(names) if name not in names]
    if missing:
        raise InputError.of(missing[0], f"this column is missing; {EXPECTED}")
    return names


def read_item(sent: Sent, index: int, limits: Limits) -> Item:
    """Read an item."""
    place, name, kind = f"items[{index}]", None, None
    try:
        value = json_of(sent, limits) if isinstance(sent, bytes) else sent
        if isinstance(value, Mapping) and type(value.get("id")) is str:
            name = clipped(value["id"], 200)
        if isinstance(value, Mapping) and value.get("kind") in KIND_NAMES:
            kind = str(value["kind"])
        members = value if isinstance(sent, bytes) else item_of(sent)
        item = part(BatchItem.model_validate, members, Source(limits))
        request = _job_request(item, limits)
    except ProblemError as error:  # it is not JSON
        faults = [(place if field == "body" else f"{place}.{field}", text) for field, text in error.errors]
        problem = ProblemError(error.kind, f"{place}: {error.detail}", errors=faults)
        return Item(name, problem=problem.document())
    except InputError as error:
        return Item(name, problem=ProblemError.of_input(at(error, place)).document(), kind=kind)
    return Item(item.id, request)


def _job_request(item: BatchItem, limits: Limits) -> JobRequest:
    sent = dict(item.request)
    if sent.pop("deadline_seconds", None) is not None:
        raise InputError.of("request.deadline_seconds", "is not allowed in items; omit it")
    if sent.pop("callback_url", None) is not None:
        raise InputError.of("request.callback_url", "is not allowed in items; give it with the batch")
    implied = kind_named(item.kind).implied
    if implied is not None:
        sent.setdefault(*implied)
    try:
        question = by_kind()[item.kind]
        request = part(question.model_validate, sent, Source(limits)).job_request()
        if implied is not None and item.kind != request.kind.name:
            raise InputError.of(implied[0], f"does not fit an item of the kind {item.kind}")
        check_price(request, limits)
    except InputError as error:
        raise at(error, "request") from None
    return request
