"""Large tables are sent slice by slice, with the bytes and validators of the whole document."""

from __future__ import annotations

import gzip
from collections.abc import Callable, Iterator
from typing import Any

import httpx
import pytest

import rpr_solver
from service.api.settings import Settings
from service.schemas.answers import json_bytes, ndjson_bytes
from service.schemas.limits import Limits
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.jobs import a_request
from tests.support.large_table import DIGITS, keep_table
from tests.support.processes import PATIENCE
from tests.support.service_server import GEOMETRY, serving
from worker.answers.store import packed
from worker.answers.stored_tables import StoredTable
from worker.connection import connect
from worker.jobs.queue import JobQueue

FORMS: list[tuple[str, Callable[[Any], bytes]]] = [
    ("application/json", json_bytes),
    ("application/x-ndjson", ndjson_bytes),
    ("text/csv", lambda table: rpr_solver.table_csv(table).encode()),
]


@pytest.fixture(scope="module")
def queue(valkey: EmbeddedValkey) -> Iterator[JobQueue]:
    with connect(f"{valkey.url}?db=2") as client:
        client.flushdb()
        yield JobQueue(client)


@pytest.fixture(scope="module")
def client(valkey: EmbeddedValkey, queue: JobQueue) -> Iterator[httpx.Client]:  # noqa: ARG001
    limits = Limits(max_result_bytes=2 << 20)
    with (
        serving(Settings(redis_url=f"{valkey.url}?db=2", limits=limits)) as url,
        httpx.Client(base_url=url, timeout=PATIENCE, headers={"Accept-Encoding": "identity"}) as client,
    ):
        yield client


@pytest.mark.parametrize("count", [1, 7, 30])
@pytest.mark.parametrize(("form", "encode"), FORMS)
def test_the_bytes_are_those_of_the_document(
    queue: JobQueue, client: httpx.Client, form: str, encode: Callable[[Any], bytes], count: int
) -> None:
    job_id, document = keep_table(queue, count)
    path, accept = f"/v1/jobs/{job_id}/result", {"Accept": form}
    whole = client.get(path, headers=accept)
    assert whole.status_code == 200
    assert whole.content == encode(document)
    if form != "text/csv":
        assert whole.headers["content-length"] == str(len(whole.content))

    etag = whole.headers["etag"]
    head = client.head(path, headers=accept)
    assert (head.headers["etag"], head.content) == (etag, b"")
    again = client.get(path, headers={**accept, "If-None-Match": etag})
    assert (again.status_code, again.content, again.headers["etag"]) == (304, b"", etag)
    body = {"geometry": GEOMETRY, "l1": [part["l1"] for part in document["slices"]], "digits": DIGITS}
    posted = client.post("/v1/cusp-tables", json=body, headers=accept)
    assert (posted.content, posted.headers["etag"]) == (whole.content, etag)
    with client.stream("GET", path, headers={**accept, "Accept-Encoding": "gzip"}) as packed:
        assert packed.headers["etag"] == etag[:-1] + '-gzip"'
        assert gzip.decompress(b"".join(packed.iter_raw())) == whole.content


def test_each_form_has_its_own_validator(queue: JobQueue, client: httpx.Client) -> None:
    job_id, _ = keep_table(queue, 3)
    answers = [client.head(f"/v1/jobs/{job_id}/result", headers={"Accept": form}) for form, _ in FORMS]
    assert len({answer.headers["etag"] for answer in answers}) == 3


def test_a_result_over_the_limit_is_refused_with_its_size(queue: JobQueue, client: httpx.Client) -> None:
    job_id, _ = keep_table(queue, 90)
    answer = client.get(f"/v1/jobs/{job_id}/result")
    assert answer.status_code == 422
    assert answer.json()["limit"] == {"name": "max_result_bytes", "value": 2 << 20}


def test_slices_with_more_digits_and_errors_are_read_in_batches_too(queue: JobQueue) -> None:
    _, document = keep_table(queue, 20)
    short = a_request(*(part["l1"] for part in document["slices"]), "1", digits=900)
    assert queue.known(short) is None
    error = {"l1": "1", "error": {"type": "solver-error", "detail": "no"}}
    [key] = queue.store.slice_keys(short, ["1"])
    queue.redis.sadd(queue.store.keys.digits(short.geometry_hash, 1), DIGITS)
    queue.redis.set(key, packed(error))
    table = queue.known(short)
    assert isinstance(table, StoredTable)
    assert table.has_errors
    expected = [rpr_solver.shorten_slice(part, DIGITS, 900) for part in document["slices"]]
    assert table.document()["slices"] == [*expected, error]
