"""Clients that send invalid requests."""

from __future__ import annotations

import json
import random
import time
from collections.abc import Callable, Iterator
from copy import deepcopy
from typing import Any

import httpx
import pytest

from service.api.app import create_app
from service.api.settings import Settings
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import PATIENCE
from tests.support.service_server import serving

ODD: list[Any] = [
    None, True, -1, 0, 1e400, -0.0, 10**400, "", " ", "NaN", "1/0", "1e999999999", "٣", "\ud800", "\x00",
    "ccw", "9" * 5000, [], {}, [[]], {"": ""}, [1, "2", None], {"from": 0, "to": -1, "step": 0}, ["1"] * 3000,
]  # fmt: skip
TYPES = ["application/json"] * 12 + [
    "text/plain",
    "",
    "application/json; charset=utf-16",
    "multipart/form-data",
]


def questions() -> list[tuple[str, Any]]:
    """Every documented example of a request: its path and its body."""
    return [
        (path, example["value"])
        for path, operations in create_app().openapi()["paths"].items()
        for content in operations.get("post", {}).get("requestBody", {}).get("content", {}).values()
        for example in content.get("examples", {}).values()
    ]


def places(value: Any) -> Iterator[tuple[Any, Any]]:
    """Every container in a value, with each of its keys."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in list(items):
        yield value, key
        yield from places(inner)


def spoiled(body: Any, draw: random.Random) -> Any:
    """A body with one to three values replaced, removed, added or wrapped."""
    body = deepcopy(body)
    for most in (40, 2, 2)[: draw.randint(1, 3)]:  # some megabytes at most
        if not isinstance(body, dict | list) or not (found := list(places(body))):
            return deepcopy(draw.choice(ODD))
        container, key = draw.choice(found)
        act = draw.randrange(5)
        if act == 0:
            del container[key]
        elif act == 1 and isinstance(container, dict):
            name = draw.choice(["l1", "digits", "geometry", "a2x", "", "é", "__proto__"])
            container[name] = deepcopy(draw.choice(ODD))
        elif act == 2:
            container[key] = [container[key]] * draw.choice([1, 2, most])
        else:
            container[key] = deepcopy(draw.choice(ODD))
    return body


def torn(content: bytes, draw: random.Random) -> bytes:
    """Bytes with an end cut off, some of them changed, or much nesting."""
    if not content:
        return content
    at = draw.randrange(len(content))
    how: list[Callable[[], bytes]] = [
        lambda: content[:at],
        lambda: content[:at] + bytes(draw.randrange(256) for _ in range(3)) + content[at:],
        lambda: content[:at] + content,
        lambda: b"[" * draw.choice([40, 4000]) + content,
        lambda: b"\xef\xbb\xbf" + content,
    ]
    return draw.choice(how)()


LONG = [pytest.mark.long, pytest.mark.timeout(470)]


@pytest.mark.parametrize(
    ("seed", "count"),
    [(150, 150), *(pytest.param(seed, 2000, marks=LONG, id=f"20000-{seed}") for seed in range(10))],
)
def test_nonsense(valkey: EmbeddedValkey, monkeypatch: pytest.MonkeyPatch, seed: int, count: int) -> None:
    """Thousands of corrupted requests arrive. Each gets a valid answer, or a problem document that names the
    error; none is an internal error, and none takes a second of processor time.
    """
    monkeypatch.setenv(
        "RPR_CUSPS_MAX_BACKLOG_SECONDS", "1e9"
    )  # nobody works here, and whatever is valid is queued
    draw, known = random.Random(seed), questions()
    with (
        serving(Settings(redis_url=valkey.url)) as url,
        httpx.Client(base_url=url, timeout=PATIENCE) as client,
    ):
        slowest = (0.0, "")
        for _ in range(count):
            path, body = draw.choice(known)
            content = json.dumps(spoiled(body, draw)).encode("utf-8", "surrogatepass")
            if draw.random() < 0.3:
                content = torn(content, draw)
            headers = {"Content-Type": draw.choice(TYPES), "Prefer": "respond-async"}
            start = time.process_time()  # of client and service; waiting for others is not their fault
            answer = client.post(path, content=content, headers=headers)
            slowest = max(slowest, (time.process_time() - start, f"{answer.status_code} of POST {path}"))
            assert answer.status_code < 500, (path, content[:2000], answer.text)
            if answer.status_code >= 400:
                assert answer.headers["content-type"] == "application/problem+json", (path, content[:2000])
                assert answer.json()["detail"]
        print(f"the slowest answer took {1000 * slowest[0]:.0f} ms: {slowest[1]}")  # shown by `pytest -rP`
        assert slowest[0] < 1
        assert client.get("/healthz").status_code == 200
