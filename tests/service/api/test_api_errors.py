"""Every error of every path has the same shape."""

from __future__ import annotations

import json
import re
import socket
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import anyio
import httpx
import pytest

from service.api.answer import json_of
from service.api.app import create_app
from service.api.problems import MEDIA_TYPE, ProblemError, ProblemType
from service.api.settings import Settings
from service.schemas.limits import LimitError, Limits
from tests.support.service_server import GEOMETRY, serving
from worker.jobs.view import JobView

GOOD = {"geometry": GEOMETRY, "l1": 1}


def problem_of(answer: httpx.Response, status: int, slug: str) -> dict[str, Any]:
    """Returns the problem document, after checking its shape."""
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == MEDIA_TYPE
    assert answer.headers["x-request-id"]
    document: dict[str, Any] = answer.json()
    assert {"type", "title", "status", "detail", "errors", "instance"} <= set(document)
    assert (document["status"], document["type"]) == (status, f"/problems/{slug}")
    assert document["instance"] == answer.request.url.path
    assert all(set(error) - {"pointer"} == {"field", "message"} for error in document["errors"])
    assert "Traceback" not in answer.text
    return document


@pytest.mark.parametrize(
    ("content", "slug"),
    [
        (b"{", "invalid-json"),
        (b"\xff\xfe", "invalid-json"),
        (b'{"l1": NaN}', "invalid-json"),
        (b'{"l1": 1, "l1": 2}', "invalid-json"),
        (b"[" * 1900, "invalid-json"),
    ],
)
def test_bad_json(idle: httpx.Client, content: bytes, slug: str) -> None:
    headers = {"Content-Type": "application/json"}
    problem_of(idle.post("/v1/cusp-tables", content=content, headers=headers), 400, slug)


@pytest.mark.parametrize("sent", ["text/plain", "application/jsonp"])
def test_another_content_type(idle: httpx.Client, sent: str) -> None:
    answer = idle.post("/v1/cusp-tables", content=json.dumps(GOOD), headers={"Content-Type": sent})
    problem_of(answer, 415, "unsupported-media-type")
    assert answer.headers["accept-post"] == "application/json"


def test_a_compressed_body(idle: httpx.Client) -> None:
    answer = idle.post("/v1/cusp-tables", json=GOOD, headers={"Content-Encoding": "gzip"})
    problem_of(answer, 415, "unsupported-media-type")


@pytest.mark.parametrize("media_type", ["application/vnd.x+json"])
def test_content_types_that_are_json(idle: httpx.Client, media_type: str) -> None:
    answer = idle.post("/v1/cusp-tables", content=json.dumps(GOOD), headers={"Content-Type": media_type})
    assert answer.status_code == 202


def test_a_body_that_is_declared_too_large(idle_url: str) -> None:
    """The answer comes before the body is sent."""
    host, port = idle_url.removeprefix("http://").split(":")
    with socket.create_connection((host, int(port)), timeout=10) as raw:
        raw.sendall(
            b"POST /v1/cusp-tables HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
            b"Content-Length: 2001\r\n\r\n"
        )
        assert raw.recv(65536).startswith(b"HTTP/1.1 413")


def test_an_undeclared_body_that_is_too_large(idle: httpx.Client) -> None:
    def endless() -> Iterator[bytes]:
        yield from (b" " * 500 for _ in range(10))

    headers = {"Content-Type": "application/json"}
    for content in (endless(), b" " * 5000):
        document = problem_of(
            idle.post("/v1/cusp-tables", content=content, headers=headers), 413, "body-too-large"
        )
        assert "limit max_body_bytes" in document["detail"]
        assert "2000" in document["detail"]


@pytest.mark.parametrize(
    ("change", "limit", "sent"),
    [
        ({"l1": [1, 2, 3, 4, 5, 6]}, {"name": "max_slices", "value": 5}, "6 slices"),
        ({"digits": 101}, {"name": "max_digits", "value": 100}, "101 digits"),
        ({"l1": "1" * 31}, {"name": "max_number_digits", "value": 30}, "31 digits"),
    ],
)
def test_a_limit(idle: httpx.Client, change: dict[str, Any], limit: dict[str, Any], sent: str) -> None:
    document = problem_of(idle.post("/v1/cusp-tables", json={**GOOD, **change}), 422, "limit-exceeded")
    assert document["limit"] == limit
    assert sent in document["detail"]
    assert limit["name"] in document["detail"]


@pytest.mark.parametrize(
    "body",
    [
        b"{" + b",".join(b'"k%d":1' % i for i in range(90_000)) + b"}",
        b"[" + b",".join([b"[]"] * 340_000) + b"]",
        b"[" + b",".join([b"[" * 30 + b"]" * 30] * 16_000) + b"]",
        b"[" * (1 << 20),
    ],
)
def test_a_body_of_very_many_members_is_refused_before_it_is_parsed(body: bytes) -> None:
    begin = time.process_time()
    with pytest.raises(LimitError, match="limit max_body_members is 20000"):
        json_of(body, Limits())
    assert time.process_time() - begin < 0.5


def test_wrong_fields_are_all_listed(idle: httpx.Client) -> None:
    body = {"geometry": {**GEOMETRY, "d1": -1, "d4": 1}, "l1": "x", "Digits": 30}
    document = problem_of(idle.post("/v1/cusp-tables", json=body), 422, "invalid-request")
    fields = {error["field"]: error["message"] for error in document["errors"]}
    assert set(fields) == {"geometry.d1", "geometry.d4", "l1", "Digits"}
    assert fields["Digits"] == "unknown field; did you mean digits?"


def test_a_manipulator_that_does_not_exist(idle: httpx.Client) -> None:
    body = {"geometry": {**GEOMETRY, "d1": 1000}, "l1": 1}
    document = problem_of(idle.post("/v1/cusp-tables", json=body), 422, "invalid-request")
    assert document["errors"][0]["field"] == "geometry.d1"
    assert "triangle inequality" in document["detail"]


def test_text_that_cannot_be_encoded_is_still_quoted(idle: httpx.Client) -> None:
    headers = {"Content-Type": "application/json"}
    answer = idle.post("/v1/cusp-tables", content=rb'{"\ud800": "\u0000"}', headers=headers)
    problem_of(answer, 422, "invalid-request")


@pytest.mark.parametrize("body", ["[]", '"x"'])
def test_a_body_that_is_not_an_object(idle: httpx.Client, body: str) -> None:
    answer = idle.post("/v1/cusp-tables", content=body, headers={"Content-Type": "application/json"})
    problem_of(answer, 422, "invalid-request")


@pytest.mark.parametrize(
    "path",
    ["/nope", "/v1/jobs/ct-0", "/v1/jobs/%00", "/problems/x"],
)
def test_not_found(idle: httpx.Client, path: str) -> None:
    answer = idle.get(path)
    assert problem_of(answer, 404, "not-found")["detail"]


@pytest.mark.parametrize(
    ("method", "path", "allow"),
    [
        ("GET", "/v1/checks", "POST"),
        ("PUT", "/v1/jobs/x", "DELETE, GET, HEAD"),
        ("OPTIONS", "/v1/jobs/x/result", "GET, HEAD"),
    ],
)
def test_method_not_allowed(idle: httpx.Client, method: str, path: str, allow: str) -> None:
    answer = idle.request(method, path)
    problem_of(answer, 405, "method-not-allowed")
    assert answer.headers["allow"] == allow


@pytest.mark.parametrize(
    "accept", ["image/png", "application/json;q=0, text/csv;q=0, application/x-ndjson;q=0"]
)
def test_not_acceptable(idle: httpx.Client, accept: str) -> None:
    answer = idle.post("/v1/cusp-tables", json=GOOD, headers={"Accept": accept})
    problem_of(answer, 406, "not-acceptable")


@pytest.mark.parametrize("last", ["x", "-1", f"1-{2**64}"])
def test_an_invalid_event_id(idle: httpx.Client, last: str) -> None:
    job_id = idle.post("/v1/cusp-tables", json={**GOOD, "l1": 3}).json()["id"]
    answer = idle.get(f"/v1/jobs/{job_id}/events", headers={"Last-Event-ID": last})
    problem_of(answer, 400, "invalid-header")


@pytest.fixture(scope="module")
def without_redis(tmp_path_factory: pytest.TempPathFactory) -> Iterator[httpx.Client]:
    socket_path: Path = tmp_path_factory.mktemp("r") / "none.sock"
    settings = Settings(redis_url=f"unix://{socket_path}", require_keys="never")
    with serving(settings) as url, httpx.Client(base_url=url) as client:
        yield client


@pytest.mark.parametrize(
    ("method", "path"),
    [("POST", "/v1/cusp-tables"), ("GET", "/v1/jobs/x/events"), ("GET", "/readyz")],
)
def test_without_redis(without_redis: httpx.Client, method: str, path: str) -> None:
    answer = without_redis.request(method, path, **({"json": GOOD} if method == "POST" else {}))
    problem_of(answer, 503, "unavailable")
    assert "none.sock" not in answer.text  # where Redis should be is no business of a client's
    assert int(answer.headers["retry-after"]) >= 1


@pytest.mark.parametrize("path", ["/healthz", "/docs", "/metrics"])
def test_routes_that_need_no_redis_work_without_it(without_redis: httpx.Client, path: str) -> None:
    answer = without_redis.get(path)
    assert answer.status_code == 200
    if path == "/metrics":
        assert "rpr_cusps_up 0.0" in answer.text


def test_an_unexpected_error_reveals_no_internals(caplog: pytest.LogCaptureFixture) -> None:
    app = create_app(Settings(require_keys="never"))

    @app.get("/boom")
    def boom() -> None:
        raise RuntimeError("secret")

    async def call() -> httpx.Response:
        async with httpx.AsyncClient(
            transport=httpx.ASGITransport(app), base_url="http://localhost"
        ) as client:
            return await client.get("/boom", headers={"X-Request-ID": "abc-1"})

    answer = anyio.run(call)
    document = problem_of(answer, 500, "internal-error")
    assert "secret" not in answer.text
    assert "abc-1" in document["detail"]
    assert answer.headers["x-request-id"] == "abc-1"
    assert "secret" in caplog.text


def test_every_type_has_its_page(idle: httpx.Client) -> None:
    listed = idle.get("/problems").text
    for kind in ProblemType:
        page = idle.get(kind.uri)
        assert page.status_code == 200
        assert kind.meaning.split(".")[0].split("'")[0] in page.text
        assert f'href="problems/{kind.slug}"' in listed


@pytest.mark.parametrize("path", ["/", "/problems/not-found"])
def test_pages_need_nothing_from_outside(idle: httpx.Client, path: str) -> None:
    page = idle.get(path)
    assert "default-src 'none'" in page.headers["content-security-policy"]
    for address in re.findall(r'(?:src|href)="([^"]+)"', page.text):
        linked = idle.get(str(page.url.join(address)))
        assert linked.status_code in (200, 503), address
        assert linked.url.host == page.url.host


def test_a_malicious_host_is_not_echoed_as_markup(idle_url: str, tmp_path: Path) -> None:
    host = {"Host": 'x"><script>alert(1)</script>'}
    problem_of(httpx.get(idle_url, headers=host), 421, "unknown-host")
    anyhow = Settings(redis_url=f"unix://{tmp_path}/none.sock", allowed_hosts="*")
    with serving(anyhow) as url:
        page = httpx.get(url, headers=host)
    assert page.status_code == 200
    assert "<script>alert" not in page.text


def test_errors_in_a_body_have_json_pointers(idle: httpx.Client) -> None:
    faulty = {"geometry": {**GEOMETRY, "d1": "x", "~/": 1}, "l1": [1, "two"]}
    document = problem_of(idle.post("/v1/cusp-tables", json=faulty), 422, "invalid-request")
    pointers = {error["field"]: error["pointer"] for error in document["errors"]}
    assert pointers == {"geometry.d1": "/geometry/d1", "geometry.~/": "/geometry/~0~1", "l1[1]": "/l1/1"}
    whole = problem_of(idle.post("/v1/cusp-tables", json=[]), 422, "invalid-request")
    assert whole["errors"][0]["pointer"] == ""
    header = idle.get("/v1/jobs/x/events", headers={"Last-Event-ID": "?"}).json()
    assert all("pointer" not in error for error in header["errors"])


@pytest.mark.parametrize(("job_id", "path"), [("ct-0", "/v1/jobs/ct-0"), ("ba-0", "/v1/batches/ba-0")])
def test_a_problem_leads_to_the_job_or_batch_that_failed(job_id: str, path: str) -> None:
    view = JobView(job_id, "failed", 0, 1, "2026-01-15T09:30:00.000Z", None, None, error=None, run="0")
    assert ProblemError.of_job(view).document()["job"] == path
