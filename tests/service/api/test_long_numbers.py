"""Numbers of 250,000 digits, in every member of every question, cost next to nothing."""

from __future__ import annotations

import copy
import csv
import io
import json
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import Any

import httpx
import pytest

from rpr_solver.errors import InputError
from service.api.answer import question_in
from service.api.batches.bodies import Elements, lines
from service.api.batches.rows import COLUMNS, Rows, read_item
from service.api.problems import ProblemError
from service.api.settings import Settings
from service.schemas.limits import Limits
from service.schemas.plots import VerificationRequest
from service.schemas.questions import EXAMPLE_GEOMETRY, Question
from service.schemas.registry import all_questions
from service.schemas.tables import EXAMPLE_TABLE
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import PATIENCE
from tests.support.sampling import long
from tests.support.service_server import serving

MOST = 0.5
"""Seconds of processor time for one body."""
_MARK = "@long@"
_N = 250_000
NUMBERS = {
    "integer": "9" * _N,
    "decimal": "-1." + "0" * _N + "1",
    "exponent": "1e" + "9" * _N,
    "text of an integer": f'"{"9" * _N}"',
    "text of a decimal": f'"1.{"0" * _N}1"',
    "text of leading zeros": f'"{"0" * _N}1x"',
    "text of a fraction": f'"1/{"9" * _N}"',
    "text of an exponent": f'"1e{"0" * _N}1"',
}
Asked = tuple[type[Question], Any]


def marked() -> Iterator[Asked]:
    """All questions, each with a mark in the place of one member, which stands for a long number."""
    for question in all_questions():
        head = {"geometry": EXAMPLE_GEOMETRY} if question.names_geometry else {}
        bodies = [{**head, **body, "deadline_seconds": 5} for _, body in question.examples.values()]
        bodies += [{"document": EXAMPLE_TABLE}] if question is VerificationRequest else []
        seen = set()
        for body in bodies:
            for place in _leaves(body):
                name = tuple(step for step in place if isinstance(step, str))
                if name not in seen:
                    seen.add(name)
                    yield question, _with_mark(body, place)


def _leaves(value: Any) -> Iterator[tuple[Any, ...]]:
    pairs = value.items() if isinstance(value, Mapping) else enumerate(value)
    for key, item in list(pairs):
        if isinstance(item, Mapping | list):
            yield from ((key, *rest) for rest in _leaves(item))
        else:
            yield (key,)


def _with_mark(body: Any, place: tuple[Any, ...]) -> Any:
    changed = inner = copy.deepcopy(body)
    for step in place[:-1]:
        inner = inner[step]
    inner[place[-1]] = _MARK
    return changed


def text_of(value: Any, number: str) -> bytes:
    return json.dumps(value).replace(f'"{_MARK}"', number).encode()


def items_of(cut: Any, body: bytes) -> list[Any]:
    """The items that a batch has, as the service cuts and reads them."""
    sent = cut(io.BytesIO(body), _N * 8, lambda _: None)
    return [read_item(item, k, Limits()) for k, item in enumerate(sent)]


def lines_of(*given: Any) -> list[bytes]:
    return [line for _, line in lines(*given)]


def seconds(read: Any, *given: Any) -> float:
    begin = time.process_time()
    with suppress(InputError, ProblemError):
        read(*given)
    return time.process_time() - begin


@pytest.mark.parametrize("share", [slice(1, None, 11), long(slice(None), id="all")], ids=["some", "all"])
def test_a_long_number_in_any_member_is_cheap(share: slice) -> None:
    cases = [(*asked, name) for asked in marked() for name in NUMBERS]
    assert len(cases) > 1000
    for question, body, name in cases[share]:
        taken = seconds(question_in, question, text_of(body, NUMBERS[name]), Limits())
        assert taken < MOST, (question.__name__, name, body)
    for question, body, name in cases[share][::3]:
        item = {"kind": question.kinds[0].name, "request": {**body, "deadline_seconds": None}}
        for cut, form in ((Elements, {"items": [item, item]}), (lines_of, item)):
            taken = seconds(items_of, cut, text_of(form, NUMBERS[name]))
            assert taken < 2 * MOST, (question.__name__, name, body)


@pytest.mark.parametrize("column", [*COLUMNS[:6], *(long(name) for name in COLUMNS[6:])])
def test_a_long_number_in_any_cell_is_cheap(column: str) -> None:
    row = {"id": "a", "kind": "cusp-table", **{k: str(x) for k, x in EXAMPLE_GEOMETRY.items()}, "l1": "14.98"}
    for number in NUMBERS.values():
        for length in (100_000, None):  # the longest cell that is read at all has 131,072 characters
            table = io.StringIO()
            csv.writer(table).writerows([row | {column: ""}, (row | {column: number[:length]}).values()])
            assert seconds(items_of, Rows, table.getvalue().encode()) < MOST


def test_a_header_of_very_many_columns_is_cheap() -> None:
    assert seconds(items_of, Rows, b",".join([b"d1"] * 300_000) + b"\n1") < 1


SHARES = [slice(5, None, 199), long(slice(None, None, 5), id="all")]


@pytest.mark.parametrize("share", SHARES, ids=["some", "all"])
def test_a_long_number_leaves_the_service_to_others(valkey: EmbeddedValkey, share: slice) -> None:
    cases = [(*asked, number) for asked in marked() for number in NUMBERS.values()]
    headers = {"Content-Type": "application/json"}
    slowest = waited = 0.0
    with (
        serving(Settings(redis_url=valkey.url)) as url,
        httpx.Client(base_url=url, timeout=PATIENCE) as client,
        httpx.Client(base_url=url, timeout=PATIENCE) as other,
        ThreadPoolExecutor(1) as beside,
    ):
        for question, body, number in cases[share]:
            text = text_of(body, number)
            begin, clock = time.process_time(), time.perf_counter()
            sent = beside.submit(client.post, question.path, content=text, headers=headers)
            assert other.get("/healthz").status_code == 200
            waited = max(waited, time.perf_counter() - clock)
            assert sent.result().status_code in (400, 422), (body, sent.result().text)
            slowest = max(slowest, time.process_time() - begin)
    print(f"/healthz took {1000 * waited:.0f} ms at most")  # shown by `pytest -rP`
    assert slowest < 2 * MOST  # of the clients, too
