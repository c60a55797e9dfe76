"""The forms of an answer: media types, preferences, compression, and large tables slice by slice."""

from __future__ import annotations

import gzip
import time
from collections.abc import Callable, Iterator
from typing import Any

import httpx
import pytest
from hypothesis import given
from hypothesis import strategies as st
from starlette.datastructures import Headers

import rpr_solver
from service.api.answer import Preferences, parse_prefer
from service.api.forms import negotiate
from service.api.http.middleware import accepts_gzip
from service.api.problems import ProblemError
from service.api.settings import Settings
from service.schemas.answers import CSV, JSON, NDJSON, json_bytes, ndjson_bytes
from service.schemas.limits import Limits
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.jobs import a_request
from tests.support.large_table import DIGITS, keep_table
from tests.support.processes import PATIENCE
from tests.support.service_server import GEOMETRY, serving
from worker.answers.kind import Kept
from worker.answers.layout import dump
from worker.answers.store import packed
from worker.answers.tables import StoredTable
from worker.connection import connect
from worker.jobs.queue import JobQueue

OFFERED = (JSON, CSV, NDJSON)


JSON_VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=12,
)


@given(st.dictionaries(st.text(), JSON_VALUES, max_size=4))
def test_a_document_is_sent_as_it_is_kept(document: dict[str, Any]) -> None:
    """So the text that is kept need not be written again."""
    text = dump(document).encode()
    kept = Kept(text)
    assert kept == document
    assert json_bytes(kept) is kept.text
    assert json_bytes(document) == text


@pytest.mark.parametrize(
    ("accept", "chosen"),
    [
        ([], JSON),
        (["text/*"], CSV),
        (["text/csv;q=0.5, application/json;q=0.4"], CSV),
        (["*/*;q=0.1, text/csv"], CSV),
        (["application/json;q=0, */*"], CSV),
        (["image/png", "text/csv"], CSV),
    ],
)
def test_the_form_that_the_client_likes_best(accept: list[str], chosen: str) -> None:
    assert negotiate(accept, OFFERED) == chosen


@pytest.mark.parametrize("accept", ["image/png", "*/*;q=0", "application/json;q=x"])
def test_no_acceptable_form(accept: str) -> None:
    with pytest.raises(ProblemError, match="matches none of application/json, text/csv"):
        negotiate([accept], OFFERED)


@pytest.mark.parametrize(
    ("headers", "expected"),
    [
        ([], Preferences()),
        (["wait=10"], Preferences(wait=10)),
        (["respond-async", "wait=10"], Preferences(True, 10)),
        (["wait=1, wait=9"], Preferences(wait=1)),
        (['foo="respond-async, wait=3"'], Preferences()),
        (['foo; bar="a;b,wait=3"; x, wait=4'], Preferences(wait=4)),
        (["wait=-1"], Preferences()),
        (["wait=٣"], Preferences()),
        (['"', "wait=2"], Preferences(wait=2)),
    ],
)
def test_prefer(headers: list[str], expected: Preferences) -> None:
    assert parse_prefer(headers) == expected


def test_a_long_wait_is_read_in_no_time() -> None:
    assert parse_prefer(["wait=" + "9" * 60_000]).wait is not None


@pytest.mark.parametrize(
    "header",
    [
        *('"' * 60_000, ";" * 60_000, 'a="' * 20_000, "\\" * 60_000),
        *('"\\' * 30_000, 'a="' + '\\"' * 30_000, "a" + " " * 60_000 + "!", "a=" + " " * 60_000 + "("),
    ],
    ids=lambda header: header[:4],
)
def test_hostile_headers_are_read_in_no_time(header: str) -> None:
    begin = time.process_time()
    assert parse_prefer([header]) == Preferences()
    assert time.process_time() - begin < 0.5


BUNDLE = "/static/jsxgraph/jsxgraphcore.mjs"


def raw(client: httpx.Client, path: str, **headers: str) -> tuple[httpx.Response, bytes]:
    """Returns a response and its body as sent."""
    names = {name.replace("_", "-"): value for name, value in headers.items()}
    with client.stream("GET", path, headers=names) as answer:
        return answer, b"".join(answer.iter_raw())


@pytest.mark.parametrize(
    ("accept", "taken"),
    [("gzip", True), ("br, gzip;q=0.5", True), ("", False), ("gzip;q=0", False), ("gzip;q=0, *", False)],
)
def test_which_clients_accept_gzip(accept: str, taken: bool) -> None:
    assert accepts_gzip(Headers({"Accept-Encoding": accept})) == taken


@pytest.mark.parametrize("path", [BUNDLE, "/openapi.json"])
def test_large_responses_are_compressed_on_request(idle: httpx.Client, path: str) -> None:
    plain, body = raw(idle, path, accept_encoding="gzip;q=0")
    packed, sent = raw(idle, path, accept_encoding="gzip")
    assert "content-encoding" not in plain.headers
    assert packed.headers["content-encoding"] == "gzip"
    assert packed.headers["vary"] == plain.headers["vary"] == "Accept-Encoding"
    assert len(sent) < len(body)
    assert gzip.decompress(sent) == body


def test_small_responses_are_not_compressed(idle: httpx.Client) -> None:
    answer, body = raw(idle, "/healthz", accept_encoding="gzip")
    assert "content-encoding" not in answer.headers
    assert body == b'{"status":"ok"}'


def test_each_encoding_has_its_own_validator(idle: httpx.Client) -> None:
    plain = raw(idle, BUNDLE, accept_encoding="identity")[0].headers["etag"]
    packed = raw(idle, BUNDLE, accept_encoding="gzip")[0].headers["etag"]
    assert packed == plain[:-1] + '-gzip"'
    for encoding, sent, etag in [
        ("identity", plain, plain),
        ("gzip", packed, packed),
        ("gzip", f"W/{packed}", packed),
        ("gzip", f"{plain}, {packed}", packed),
        ("identity", f"{plain}, {packed}", plain),
        ("gzip", plain, plain),
        ("identity", packed, packed),
    ]:
        answer, body = raw(idle, BUNDLE, accept_encoding=encoding, if_none_match=sent)
        assert (answer.status_code, answer.headers["etag"], body) == (304, etag, b""), (encoding, sent)
        assert answer.headers["vary"] == "Accept-Encoding"


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


@pytest.mark.parametrize("count", [30])
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
