"""The API, when Redis hangs or refuses."""

from __future__ import annotations

import logging
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import httpx
import pytest
from redis import Redis
from redis.exceptions import RedisError

from service.api.settings import Settings
from service.stack.embedded_valkey import EmbeddedValkey, program
from tests.support.processes import PATIENCE, Workers, completed, environment, started, stopped, until
from tests.support.sampling import long
from tests.support.service_server import GEOMETRY, serving
from tests.support.stack import failure
from worker.connection import connect

KNOWN = {"geometry": GEOMETRY, "l1": "14.98", "l2": "15", "l3": "30"}
UNKNOWN = {"geometry": GEOMETRY, "l1": "3"}
TIMEOUT = 0.5


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[EmbeddedValkey]:
    """A server that the tests may stop."""
    with EmbeddedValkey(tmp_path_factory.mktemp("redis")) as server:
        yield server


@pytest.fixture(scope="module")
def worker(server: EmbeddedValkey, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workers]:
    workers = Workers(server.url, tmp_path_factory.mktemp("worker") / "log")
    workers.start()
    yield workers
    workers.stop()


@pytest.fixture(scope="module")
def api(server: EmbeddedValkey, worker: Workers) -> Iterator[httpx.Client]:  # noqa: ARG001
    """A client of a service that knows the answer to `KNOWN`."""
    settings = Settings(redis_url=server.url, redis_timeout_seconds=TIMEOUT, answer_cache_mb=0)
    with serving(settings) as url, httpx.Client(base_url=url, timeout=PATIENCE) as client:
        assert client.post("/v1/poses", json=KNOWN).status_code == 200
        yield client


@pytest.fixture
def admin(server: EmbeddedValkey) -> Iterator[Redis]:
    with connect(server.url) as client:
        client.ping()
        yield client


@pytest.fixture
def recovers(api: httpx.Client, worker: Workers) -> Callable[[], None]:
    """Asserts that the service gets ready again; else tells what became of its worker."""

    def look() -> None:
        try:
            until(lambda: api.get("/readyz").status_code == 200)
        except AssertionError:
            ends = [process.poll() for process in worker.processes]
            pytest.fail(f"{api.get('/readyz').text}\nworkers: {ends}\n{worker.log.read_text()}")

    return look


def assert_unavailable(answer: httpx.Response) -> None:
    assert answer.status_code == 503
    assert answer.json()["type"] == "/problems/unavailable"
    assert int(answer.headers["retry-after"]) >= 1


def test_redis_hangs(server: EmbeddedValkey, api: httpx.Client, recovers: Callable[[], None]) -> None:
    """Redis hangs (SIGSTOP). Requests that need it get 503 after one time-out, then at once; all others are
    served."""
    with stopped(server.pid), ThreadPoolExecutor(50) as pool:
        begin = time.monotonic()
        for answer in pool.map(lambda _: api.get("/v1/jobs/ct-0"), range(100)):
            assert_unavailable(answer)
        for path in ("/healthz", "/static/style.css", "/v1/limits"):
            assert api.get(path).status_code == 200
        assert api.post("/v1/poses", json={"geometry": 1}).status_code == 422
        for _ in range(30):
            assert_unavailable(api.post("/v1/poses", json=KNOWN))
        assert time.monotonic() - begin < 130 * TIMEOUT / 2
    recovers()
    assert api.post("/v1/poses", json=KNOWN).status_code == 200


def full_disk(redis: Redis, server: EmbeddedValkey) -> None:
    """Let a snapshot fail, as it does when the disk is full: its file cannot be put in place."""
    (server.data_dir / "dump.rdb").mkdir(exist_ok=True)
    redis.config_set("save", "3600 1")
    redis.bgsave()
    until(lambda: redis.info("persistence")["rdb_last_bgsave_status"] == "err")  # type: ignore[index]


def enough_room(redis: Redis) -> None:
    redis.config_set("save", "")


def full_memory(redis: Redis, _: EmbeddedValkey) -> None:
    redis.config_set("maxmemory", 1)


def enough_memory(redis: Redis) -> None:
    redis.config_set("maxmemory", 0)


def replica(redis: Redis, _: EmbeddedValkey) -> None:
    redis.replicaof("127.0.0.1", "1")


def primary(redis: Redis) -> None:
    redis.replicaof("NO", "ONE")


def no_permission(redis: Redis, _: EmbeddedValkey) -> None:
    redis.execute_command("ACL SETUSER default -set -evalsha -hset")  # type: ignore[no-untyped-call]


def permission(redis: Redis) -> None:
    redis.execute_command("ACL SETUSER default +@all")  # type: ignore[no-untyped-call]


@pytest.mark.parametrize(
    ("refuse", "accept"),
    [
        pytest.param(full_disk, enough_room, id="MISCONF", marks=pytest.mark.long),
        pytest.param(full_memory, enough_memory, id="OOM"),
        pytest.param(replica, primary, id="READONLY"),
        pytest.param(no_permission, permission, id="NOPERM", marks=pytest.mark.long),
    ],
)
def test_redis_takes_no_data(
    server: EmbeddedValkey,
    api: httpx.Client,
    worker: Workers,
    admin: Redis,
    caplog: pytest.LogCaptureFixture,
    recovers: Callable[[], None],
    refuse: Callable[[Redis, EmbeddedValkey], None],
    accept: Callable[[Redis], None],
) -> None:
    """Redis accepts no data: disk full, memory full, a replica, or no permission. New questions get 503, one
    log line gives the reason, `/readyz` is 503 without details, and known answers are served.
    """
    # A sweeper would make room where memory is full, and remove the known answer.
    sweepers = worker.processes if refuse is full_memory else []
    with ExitStack() as stack:
        for process in sweepers:
            stack.enter_context(stopped(process.pid))
        stack.callback(accept, admin)
        refuse(admin, server)
        with caplog.at_level(logging.WARNING, "rpr_cusps.service"):
            for _ in range(5):
                assert_unavailable(api.post("/v1/cusp-tables", json=UNKNOWN))
            ready = api.get("/readyz")
        assert_unavailable(ready)
        assert "cannot be reached or accepts no more data" in ready.json()["detail"]
        assert api.post("/v1/poses", json=KNOWN).status_code == 200
    told = [record for record in caplog.records if record.name == "rpr_cusps.service"]
    assert 1 <= len(told) <= 2
    assert all("Redis cannot be used" in record.message and not record.exc_info for record in told)
    recovers()


UNFIT = {
    "cluster": (["--cluster-enabled", "yes"], "a node of a Redis Cluster"),
    "sentinel": (["--sentinel"], "a Sentinel, which keeps no data"),
    "replica": (
        ["--replicaof", "127.0.0.1 1"],
        "a replica, which takes no data; give the address of its primary",
    ),
}


@contextmanager
def unfit(kind: str, which: str, directory: Path) -> Iterator[str]:
    """A server of this kind; gives its address."""
    path = str(program()) if which == "embedded" else shutil.which(which)
    if path is None:
        pytest.skip(f"there is no {which} on this computer")
    with socket.create_server(("127.0.0.1", 0)) as one, socket.create_server(("127.0.0.1", 0)) as two:
        port, bus = (free.getsockname()[1] for free in (one, two))
    (directory / "server.conf").write_text(f"port {port}\ndir {directory}\nbind 127.0.0.1\n")
    options = [*UNFIT[kind][0], *(["--cluster-port", str(bus)] if kind == "cluster" else [])]
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": directory}
    url = f"redis://127.0.0.1:{port}"
    with started([path, str(directory / "server.conf"), *options], **silent), connect(url) as client:

        def answers() -> bool:
            with suppress(RedisError):
                return bool(client.ping())
            return False

        until(answers)
        yield url


@pytest.mark.parametrize("which", ["embedded", long("redis-server")])
@pytest.mark.parametrize("kind", UNFIT)
def test_a_server_that_cannot_keep_a_queue(tmp_path: Path, kind: str, which: str) -> None:
    """The URL is that of a node of a cluster, of a Sentinel, or of a replica. `serve` and the workers refuse
    it at their start, in one line; a running API answers 503, also at `/readyz`.
    """
    with unfit(kind, which, tmp_path) as url:
        reason = UNFIT[kind][1]
        assert reason in failure(tmp_path / "data", url=url)
        command = [sys.executable, "-m", "service", "worker", "--redis-url", url]
        done = completed(command, environment())
        assert done.returncode == 1
        assert done.stderr.startswith("rpr-cusps worker: cannot use this Redis: it is ")
        assert reason in done.stderr
        assert done.stderr.count("\n") == 1
        with serving(Settings(redis_url=url)) as here, httpx.Client(base_url=here, timeout=PATIENCE) as api:
            assert_unavailable(api.get("/readyz"))
            assert_unavailable(api.post("/v1/poses", json=KNOWN))


def test_redis_forgets_its_clients(api: httpx.Client, admin: Redis, recovers: Callable[[], None]) -> None:
    """Redis requires a password that the service does not have. All requests get 503; the service recovers
    when Redis does."""
    admin.config_set("requirepass", "other")
    try:
        admin.client_kill_filter(_type="normal", skipme=True)
        assert_unavailable(api.post("/v1/poses", json=KNOWN))
        assert_unavailable(api.get("/readyz"))
    finally:
        admin.config_set("requirepass", "")
    recovers()


def test_redis_may_evict(
    server: EmbeddedValkey, admin: Redis, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Redis is set to evict keys. The API and the workers warn at their start, and `/readyz` says so."""
    workers = Workers(server.url, tmp_path / "log")
    admin.config_set("maxmemory-policy", "allkeys-lru")
    try:
        workers.start()
        with serving(Settings(redis_url=server.url)) as url, httpx.Client(base_url=url) as client:
            until(lambda: "allkeys-lru" in caplog.text)
            [warning] = client.get("/readyz").json()["warnings"]
            assert "set maxmemory-policy noeviction" in warning
        assert "allkeys-lru" in workers.log.read_text()
    finally:
        admin.config_set("maxmemory-policy", "noeviction")
        workers.stop()


@pytest.mark.long
def test_redis_hangs_under_a_worker(
    server: EmbeddedValkey, worker: Workers, api: httpx.Client, recovers: Callable[[], None]
) -> None:
    """Redis hangs for longer than a worker waits. The worker logs it within seconds, and continues
    afterwards."""
    with stopped(server.pid):
        begin = time.monotonic()
        until(lambda: "cannot work (TimeoutError" in worker.log.read_text())
        assert time.monotonic() - begin < 30
    recovers()
    assert api.post("/v1/poses", json={**KNOWN, "l1": "15"}).status_code == 200
