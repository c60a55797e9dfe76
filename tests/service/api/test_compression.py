"""Large responses are compressed for clients that accept it, and each encoding has its own validator."""

from __future__ import annotations

import gzip

import httpx
import pytest
from starlette.datastructures import Headers

from service.api.http.middleware import accepts_gzip

BUNDLE = "/static/swagger-ui/swagger-ui-bundle.js"


def raw(client: httpx.Client, path: str, **headers: str) -> tuple[httpx.Response, bytes]:
    """Returns a response and its body as sent."""
    names = {name.replace("_", "-"): value for name, value in headers.items()}
    with client.stream("GET", path, headers=names) as answer:
        return answer, b"".join(answer.iter_raw())


@pytest.mark.parametrize(
    ("accept", "taken"),
    [
        ("gzip", True),
        ("br, gzip;q=0.5", True),
        ("*", True),
        ("GZIP", True),
        ("", False),
        ("identity", False),
        ("gzip;q=0", False),
        ("gzip;q=0, *", False),
    ],
)
def test_which_clients_accept_gzip(accept: str, taken: bool) -> None:
    assert accepts_gzip(Headers({"Accept-Encoding": accept})) == taken


@pytest.mark.parametrize("path", [BUNDLE, "/openapi.json", "/problems"])
def test_large_responses_are_compressed_on_request(idle: httpx.Client, path: str) -> None:
    plain, body = raw(idle, path, accept_encoding="gzip;q=0")
    packed, sent = raw(idle, path, accept_encoding="gzip")
    assert "content-encoding" not in plain.headers
    assert packed.headers["content-encoding"] == "gzip"
    assert packed.headers["vary"] == plain.headers["vary"] == "Accept-Encoding"
    assert len(sent) < len(body)
    assert gzip.decompress(sent) == body


def test_problems_are_compressed_too(idle: httpx.Client) -> None:
    body = {"geometry": {f"unknown-{i}": 1 for i in range(30)}}
    answer = idle.post("/v1/cusp-tables", json=body, headers={"Accept-Encoding": "gzip"})
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.headers["content-encoding"] == "gzip"
    assert answer.json()["errors"]


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
