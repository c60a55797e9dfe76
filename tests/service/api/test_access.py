"""Who is let in: names of the service, keys and their scopes."""

from __future__ import annotations

import itertools
import re
import socket
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
from fastapi import APIRouter
from fastapi.routing import iter_route_contexts

from service.api.app import RateLimit, create_app
from service.api.caller import Admission, Caller, Rules
from service.api.keys import _MAX_AGE, KeyStore, make_key
from service.api.problems import ProblemError
from service.api.settings import KeyScope, Settings
from service.schemas.limits import Limits
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import PATIENCE, until
from tests.support.service_server import GEOMETRY, serving
from worker.connection import connect
from worker.jobs.quotas import Quotas
from worker.settings import WorkerSettings

QUESTION = {"geometry": GEOMETRY, "l1": 14.98}
A_JOB = "/v1/jobs/ct-0"


@pytest.fixture(scope="module")
def url(valkey: EmbeddedValkey) -> str:
    """A database without jobs and keys."""
    with connect(f"{valkey.url}?db=2") as client:
        client.flushdb()
    return f"{valkey.url}?db=2"


@pytest.fixture
def store(url: str) -> Iterator[KeyStore]:
    """The keys of the service; all are forgotten afterwards."""
    with connect(url) as client:
        yield KeyStore(client, "cusps")
        client.flushdb()


@pytest.fixture(scope="module")
def guarded_url(url: str) -> Iterator[str]:
    with serving(Settings(redis_url=url, require_keys="always", allowed_hosts="queue.example,*.lab")) as base:
        yield base


@pytest.fixture
def guarded(guarded_url: str) -> Iterator[httpx.Client]:
    """A client, without a key, of a service that asks for keys."""
    with httpx.Client(base_url=guarded_url, timeout=PATIENCE) as client:
        yield client


def bearer(store: KeyStore, scope: KeyScope = "submit", expires: float | None = None) -> dict[str, str]:
    """The header with a new key."""
    key, token = make_key(f"test-{time.monotonic_ns()}", scope, time.time(), expires)
    assert store.add(key, time.time())
    return {"Authorization": f"Bearer {token}"}


@pytest.mark.parametrize(
    "path", ["/", "/healthz", "/docs", "/openapi.json", "/openapi.yaml", "/problems/unauthorized"]
)
def test_what_is_open_to_all(guarded: httpx.Client, path: str) -> None:
    assert guarded.get(path).status_code == 200
    assert guarded.get("/readyz").status_code == 503  # there is no worker


@pytest.mark.parametrize(
    ("method", "path"),
    [("GET", A_JOB), ("GET", "/v1/limits"), ("POST", "/v1/censuses"), ("DELETE", A_JOB), ("GET", "/nothing")],
)
@pytest.mark.parametrize(
    "sent", [None, "Bearer", "Bearer rpr_", "Basic dTpw", f"Bearer rpr_{'a' * 8}_{'b' * 43}"]
)
def test_nobody_is_let_in_without_a_key(
    guarded: httpx.Client, method: str, path: str, sent: str | None
) -> None:
    answer = guarded.request(method, path, headers={} if sent is None else {"Authorization": sent})
    assert (answer.status_code, answer.json()["type"]) == (401, "/problems/unauthorized")
    assert answer.headers["www-authenticate"].startswith('Bearer realm="rpr-cusps"')
    assert ("invalid_token" in answer.headers["www-authenticate"]) == (sent is not None)


def test_a_key_does_what_its_scope_includes(guarded: httpx.Client, store: KeyStore) -> None:
    read, submit, admin = (bearer(store, scope) for scope in ("read", "submit", "admin"))

    def statuses(key: dict[str, str]) -> list[int]:
        return [
            guarded.get("/v1/limits", headers=key).status_code,
            guarded.post("/v1/cusp-tables", json=QUESTION, headers=key).status_code,
            guarded.get("/metrics", headers=key).status_code,
        ]

    assert statuses(read) == [200, 403, 403]
    assert statuses(submit) == [200, 202, 403]
    assert statuses(admin) == [200, 202, 200]
    refused = guarded.delete(A_JOB, headers=read)
    assert refused.json()["type"] == "/problems/forbidden"
    assert 'error="insufficient_scope", scope="submit"' in refused.headers["www-authenticate"]


OTHER_METHODS = ("PUT", "PATCH", "DELETE", "OPTIONS", "TRACE", "get", "QUERY")


def test_a_key_that_reads_starts_nothing(
    guarded: httpx.Client, store: KeyStore, pytestconfig: pytest.Config
) -> None:
    """Not by any route of the application, whatever the method and however its address is written.

    Each time an address is written in one other way, and with `--long` in all.
    """
    query = {**{name: str(value) for name, value in GEOMETRY.items()}, "l1": "14.98", "wait": "0"}
    batch = {"items": [{"kind": "cusp-table", "request": QUESTION}]}
    read, submit = ({**bearer(store, scope), "Prefer": "respond-async"} for scope in ("read", "submit"))
    begun = set()

    def ask(key: dict[str, str], method: str, address: str) -> int:
        body = batch if address.startswith("/v1/batches") else QUESTION
        is_question = body is QUESTION
        params = {x: y for x, y in query.items() if is_question and ("censuses" not in address or x != "l1")}
        sent: dict[str, Any] = {} if method in ("GET", "HEAD") else {"json": body}
        return guarded.request(method, address, params=params, headers=key, **sent).status_code

    def jobs() -> list[bytes]:
        return list(store.redis.scan_iter("cusps:job*:events"))

    paths = {
        re.sub(r"{\w+}", "ct-0", route.path_format or "")
        for route in iter_route_contexts(create_app().routes)
    }
    for n, path in enumerate(sorted(paths)):
        others = (f"{path}%0A", f"{path}/", f"/{path}", path.replace(".", "%2E").replace("-", "%2d"))
        written = (path, *(others if pytestconfig.getoption("--long") else (others[n % len(others)],)))
        calls = {*itertools.product(("GET", "HEAD", "POST"), written), *((m, path) for m in OTHER_METHODS)}
        assert {ask(read, *call) for call in calls}.isdisjoint({202, 500}), path
        assert not jobs(), path
        begun |= {f"{method} {path}" for method in ("GET", "POST") if ask(submit, method, path) == 202}
        for name in jobs():
            store.redis.delete(name)
    assert {"GET /v1/plots", "GET /v1/cusp-tables", "GET /v1/censuses", "POST /v1/batches"} <= begun


def test_a_route_without_a_scope_is_not_served() -> None:
    async def endpoint() -> None:
        pass

    router = APIRouter()
    router.add_api_route("/v1/new", endpoint, methods=["GET"])
    with pytest.raises(LookupError, match=r"GET /v1/new has no scope"):
        Rules([*create_app().routes, *router.routes])


def test_what_may_not_compute_is_refused_where_work_is_admitted(store: KeyStore) -> None:
    caller = Caller("key:a", "a", "read")
    with pytest.raises(ProblemError, match="needs a key with scope submit"):
        Admission(caller, Quotas(store.redis, WorkerSettings()), Limits()).admit("ct-0", 1.0)


def test_a_key_with_another_secret_is_refused(guarded: httpx.Client, store: KeyStore) -> None:
    key = bearer(store)
    wrong = key["Authorization"][:-1] + ("a" if key["Authorization"][-1] != "a" else "b")
    assert guarded.get("/v1/limits", headers=key).status_code == 200
    assert guarded.get("/v1/limits", headers={"Authorization": wrong}).status_code == 401


def test_a_key_ends_with_its_time_or_when_it_is_revoked(guarded: httpx.Client, store: KeyStore) -> None:
    old = bearer(store, expires=time.time() - 1)
    assert guarded.get("/v1/limits", headers=old).status_code == 401
    new = bearer(store)
    assert guarded.get("/v1/limits", headers=new).status_code == 200
    [name] = [key.name for key in store.all().values() if key.state(time.time()) == "valid"]
    assert store.revoke(name, time.time()) is not None
    start = time.monotonic()
    until(lambda: guarded.get("/v1/limits", headers=new).status_code == 401)
    assert time.monotonic() - start < _MAX_AGE + PATIENCE / 2
    assert store.revoke(name, time.time()) is None
    assert len(store.last_uses()) == 1


def test_a_job_is_ended_by_those_who_asked_for_it(guarded: httpx.Client, store: KeyStore) -> None:
    one, two, admin = bearer(store), bearer(store), bearer(store, "admin")

    def asked(key: dict[str, str]) -> str:
        job = guarded.post("/v1/cusp-tables", json=QUESTION, headers=key).json()
        return str(job["links"]["self"])

    def after_delete(key: dict[str, str], query: str = "") -> str:
        return str(guarded.delete(job + query, headers=key).json()["status"])

    job = asked(one)
    assert asked(two) == job
    assert [after_delete(key) for key in (one, one, admin)] == ["queued"] * 3
    assert after_delete(two) == "canceled"
    assert asked(one) == job
    assert guarded.delete(f"{job}?force=true", headers=two).status_code == 403
    assert after_delete(admin, "?force=true") == "canceled"


def test_a_client_that_disconnects_withdraws_nothing(guarded: httpx.Client, store: KeyStore) -> None:
    key = {**bearer(store), "Prefer": "wait=3"}

    def disconnect() -> str:
        """Ask, and be gone while the service waits for the job."""
        with socket.create_connection((guarded.base_url.host, guarded.base_url.port)) as client:
            request = guarded.build_request("POST", "/v1/cusp-tables", json=QUESTION, headers=key)
            head = "".join(f"{name}: {value}\r\n" for name, value in request.headers.items())
            client.sendall(f"POST /v1/cusp-tables HTTP/1.1\r\n{head}\r\n".encode() + request.content)
            until(jobs)
        [job] = jobs()
        return job

    def jobs() -> list[str]:
        return [name.decode().split(":")[2] for name in store.redis.scan_iter("cusps:job*:events")]

    def status() -> str:
        return str(guarded.get(f"/v1/jobs/{job_id}", headers=key).json()["status"])

    job_id = disconnect()
    assert status() == "queued"
    assert guarded.delete(f"/v1/jobs/{job_id}", headers=key).json()["status"] == "canceled"


def test_no_secret_is_kept(guarded: httpx.Client, store: KeyStore) -> None:
    key = bearer(store)
    guarded.post("/v1/cusp-tables", json=QUESTION, headers=key)
    secret = key["Authorization"].rpartition("_")[2].encode()
    for name in store.redis.scan_iter():
        assert secret not in (store.redis.dump(name) or b"")


def test_the_first_key_closes_a_local_service(url: str, store: KeyStore) -> None:
    with serving(Settings(redis_url=url)) as base, httpx.Client(base_url=base, timeout=PATIENCE) as client:
        assert client.get("/metrics").status_code == 200
        assert client.get("/metrics", headers={"Authorization": "Bearer of-a-proxy"}).status_code == 200
        key = bearer(store, "admin")
        assert client.get("/metrics", headers=key).status_code == 200
        until(lambda: client.get("/metrics").status_code == 401)
        [known] = store.all().values()
        store.revoke(known.id, time.time())
        until(lambda: client.get("/metrics", headers=key).status_code == 401)
        assert client.get("/metrics").status_code == 401  # the last key does not open it again


def test_no_one_is_let_in_while_it_is_not_known_whether_there_are_keys(tmp_path: Path) -> None:
    with serving(Settings(redis_url=f"unix://{tmp_path}/none.sock")) as base:
        answer = httpx.get(f"{base}/v1/limits")
        assert (answer.status_code, answer.json()["type"]) == (503, "/problems/unavailable")
        assert httpx.get(f"{base}/healthz").status_code == 200


@pytest.fixture
def limited(url: str, store: KeyStore) -> Iterator[httpx.Client]:  # noqa: ARG001
    """A client, without a key, of a service with small limits that lets everyone in."""
    limits = Limits(max_requests_per_minute=5, max_active_jobs=1)
    with (
        serving(Settings(redis_url=url, require_keys="never", limits=limits)) as base,
        httpx.Client(base_url=base, timeout=PATIENCE) as client,
    ):
        yield client


def test_a_key_has_an_allowance_of_requests(limited: httpx.Client, store: KeyStore) -> None:
    one, two = bearer(store), bearer(store)
    answers = [limited.get("/v1/limits", headers=one) for _ in range(6)]
    assert [answer.status_code for answer in answers] == [200] * 5 + [429]
    assert {answer.headers["ratelimit-policy"] for answer in answers} == {'"requests";q=5;w=60'}
    left = [int(re.match(r'"requests";r=(\d+);t=\d+$', a.headers["ratelimit"])[1]) for a in answers]  # type: ignore[index]
    assert left == [4, 3, 2, 1, 0, 0]
    problem = answers[-1].json()
    assert (problem["type"], problem["limit"]) == (
        "/problems/too-many-requests",
        {"name": "max_requests_per_minute", "value": 5},
    )
    assert 1 <= int(answers[-1].headers["retry-after"]) <= 12
    assert limited.get("/v1/limits", headers=two).status_code == 200
    assert limited.get("/healthz", headers=one).status_code == 200


def test_the_allowance_refills(store: KeyStore) -> None:
    rate = RateLimit(store.redis, "cusps", 6000)
    first = rate.take("key:a")
    assert (first.is_over, first.left) == (False, 5999)
    few = RateLimit(store.redis, "cusps", 600)
    while not (last := few.take("key:b")).is_over:
        pass
    assert 0 < last.retry_s <= 0.1
    time.sleep(last.retry_s + 0.01)
    assert not few.take("key:b").is_over


def test_without_a_key_the_address_counts_but_not_that_of_this_computer(limited: httpx.Client) -> None:
    """A proxy on this computer says whose request it is."""
    far = {"X-Forwarded-For": "192.0.2.9"}
    assert [limited.get("/v1/limits", headers=far).status_code for _ in range(6)] == [200] * 5 + [429]
    here = [limited.get("/v1/limits") for _ in range(6)]
    assert {answer.status_code for answer in here} == {200}
    assert "ratelimit" not in here[0].headers


def test_a_key_has_a_number_of_jobs(limited: httpx.Client, store: KeyStore) -> None:
    key = bearer(store)
    first = limited.post("/v1/cusp-tables", json=QUESTION, headers=key)
    second = limited.post("/v1/cusp-tables", json={**QUESTION, "l1": 15}, headers=key)
    assert (first.status_code, second.status_code) == (202, 429)
    assert second.json()["limit"] == {"name": "max_active_jobs", "value": 1}
    assert "withdraw" in second.json()["detail"]
    assert limited.delete(first.json()["links"]["self"], headers=key).json()["status"] == "canceled"
    assert limited.post("/v1/cusp-tables", json={**QUESTION, "l1": 15}, headers=key).status_code == 202


@pytest.mark.parametrize(
    ("host", "status"),
    [
        ("127.0.0.1:8000", 200),
        ("[::1]:8000", 200),
        ("192.0.2.7", 200),
        ("localhost", 200),
        ("Queue.Example:80", 200),
        ("rig.lab", 200),
        ("lab", 421),
        ("evil.example", 421),
        ("queue.example.evil.example", 421),
        ("127.0.0.1.evil.example", 421),
        ("localhost:80:80", 421),
        ("", 421),
    ],
)
def test_the_service_answers_to_its_names_only(guarded: httpx.Client, host: str, status: int) -> None:
    answer = guarded.get("/healthz", headers={"Host": host})
    assert answer.status_code == status
    if status == 421:
        assert answer.json()["type"] == "/problems/unknown-host"
        assert "RPR_CUSPS_ALLOWED_HOSTS" in answer.json()["detail"]


def test_any_name_if_the_operator_says_so(url: str) -> None:
    with serving(Settings(redis_url=url, allowed_hosts="*")) as base:
        assert httpx.get(f"{base}/healthz", headers={"Host": "any.example"}).status_code == 200
