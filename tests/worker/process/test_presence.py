"""A worker as RQ's own tools see it, and the commands that they send."""

from __future__ import annotations

import ast
import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import rq
import rq.suspension
from redis import Redis
from rq.command import send_command, send_shutdown_command
from rq.worker import WorkerStatus

import worker
import worker.__main__ as program
from rpr_solver import InputError
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.jobs import a_request, depth, ended
from tests.support.processes import PATIENCE, Workers, until
from worker.connection import SOCKET_TIMEOUT, connect
from worker.jobs.chunks import ChunkQueue
from worker.jobs.installation import Roster
from worker.jobs.plan import LANES
from worker.jobs.queue import JobQueue
from worker.process.presence import Commands, Presence
from worker.process.worker import WorkerError
from worker.settings import WorkerSettings


@pytest.fixture
def presence(redis: Redis, settings: WorkerSettings) -> Presence:
    queues = list(ChunkQueue(redis, settings).queues.values())
    return Presence(redis, settings, "some-worker", queues, is_light=False)


@pytest.fixture
def commands(redis: Redis, presence: Presence) -> Iterator[tuple[Commands, threading.Event]]:
    """What listens for commands, and what it wakes."""
    woken = threading.Event()
    listener = Commands(redis, presence.channel, woken.set)
    listener.listen()
    yield listener, woken
    listener.end()


def test_rq_lists_a_worker_while_it_beats(redis: Redis, presence: Presence) -> None:
    presence.beat(WorkerStatus.IDLE)
    for state in (WorkerStatus.BUSY, WorkerStatus.IDLE):
        redis.flushall()
        presence.beat(state)
        [listed] = rq.Worker.all(connection=redis)
        assert (listed.name, listed.pid, listed.get_state()) == ("some-worker", os.getpid(), state)
        assert len(listed.queue_names()) == len(LANES)
        assert 0 < redis.ttl(listed.key) <= 15
    presence.leave()
    assert rq.Worker.all(connection=redis) == []
    assert not [key for key in redis.keys("*") if b"some-worker" in key]


def test_workers_that_are_gone_leave_the_register(redis: Redis, presence: Presence) -> None:
    presence.beat(WorkerStatus.IDLE)
    redis.delete(*redis.keys("rq:worker:*"))
    presence.tidy()
    assert redis.keys("rq:workers*") == []


@pytest.mark.usefixtures("presence")
def test_the_register_does_not_change_how_long_redis_may_take(valkey: EmbeddedValkey) -> None:
    with connect(valkey.url) as redis:
        Presence(redis, WorkerSettings(), "another", [rq.Queue("x", connection=redis)], is_light=True)
        assert redis.connection_pool.connection_kwargs["socket_timeout"] == SOCKET_TIMEOUT


def test_a_stop_command_names_its_chunk(redis: Redis, commands: tuple[Commands, threading.Event]) -> None:
    listener, woken = commands
    send_command(redis, "another-worker", "stop-job", job_id="none")
    send_command(redis, "some-worker", "kill-horse")
    for chunk in ("first", "second"):
        send_command(redis, "some-worker", "stop-job", job_id=chunk)
    assert woken.wait(PATIENCE)
    stopped: set[str] = set()
    until(lambda: stopped.update(listener.stopped_chunks()) or len(stopped) == 2)
    assert stopped == {"first", "second"}
    assert listener.stopped_chunks() == set()


def test_the_shutdown_command_is_a_stop_signal(
    redis: Redis, commands: tuple[Commands, threading.Event]
) -> None:
    del commands
    came = threading.Event()
    before = signal.signal(signal.SIGINT, lambda *_: came.set())
    try:
        send_shutdown_command(redis, "some-worker")
        until(came.is_set)
    finally:
        signal.signal(signal.SIGINT, before)


def test_a_suspended_worker_takes_no_chunk(valkey: EmbeddedValkey, redis: Redis, tmp_path: Path) -> None:
    """`rq suspend` pauses the workers, which stay on the roster, and `rq resume` ends that."""
    workers = Workers(valkey.url, tmp_path / "log")
    try:
        process = workers.start(beat_interval=0.1)
        rq.suspension.suspend(redis)
        queue = JobQueue(redis)
        until(lambda: [each.get_state() for each in rq.Worker.all(connection=redis)] == ["suspended"])
        view = queue.submit(a_request("1"))
        [name] = Roster(redis, queue.settings).names()
        before = redis.zscore(queue.records.keys.workers, name)
        until(lambda: redis.zscore(queue.records.keys.workers, name) > before)  # it stays on the roster
        assert depth(queue) == 1
        rq.suspension.resume(redis)
        assert ended(queue, view.id).status == "succeeded"
        rq.suspension.suspend(redis)
        process.terminate()
        assert process.wait(PATIENCE) == 0
    finally:
        workers.stop()


def test_rq_info_shows_the_workers(valkey: EmbeddedValkey, presence: Presence) -> None:
    presence.beat(WorkerStatus.IDLE)
    command = [sys.executable, "-m", "rq.cli", "info", "--only-workers", "--url", valkey.url]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "some-worker" in done.stdout, done.stderr


def test_nothing_private_of_rq_is_touched() -> None:
    """In the modules that use RQ no class derives from one of its classes, and no private name is imported or
    read of anything but `self`.
    """
    users = 0
    for path in Path(worker.__file__).parent.rglob("*.py"):
        nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
        named = {
            alias.asname or alias.name
            for node in nodes
            if isinstance(node, ast.ImportFrom | ast.Import)
            for alias in node.names
            if (getattr(node, "module", None) or alias.name).split(".")[0] == "rq"
        }
        users += bool(named)
        bases = [ast.walk(base) for node in nodes if isinstance(node, ast.ClassDef) for base in node.bases]
        derived = {word.id for base in bases for word in base if isinstance(word, ast.Name)}
        private = {
            ast.unparse(node)
            for node in nodes
            if isinstance(node, ast.Attribute) and re.match("_[a-z]", node.attr) and named
            if ast.unparse(node.value) not in ("self", "os")
        }
        private |= {name for name in named if name.startswith("_")}
        assert (derived & named, private) == (set(), set()), path
    assert users > 2


def _failing(error: Exception) -> Callable[[], object]:
    def fail() -> None:
        raise error

    return fail


@pytest.mark.parametrize(
    ("run", "status", "said"),
    [
        (lambda: 0, 0, ""),
        (lambda: WorkerSettings(beat_ttl=-1), 2, "worker: RPR_CUSPS_BEAT_TTL"),
        (_failing(InputError.of("lanes", "names none")), 2, "worker: lanes: names none"),
        (_failing(WorkerError("lost the connection")), 1, "worker: lost the connection"),
    ],
    ids=["ended", "a wrong setting", "a lane that is none", "no connection"],
)
def test_the_status_says_how_it_ended(
    run: Callable[[], object],
    status: int,
    said: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(program, "run_worker", lambda *_, **__: run())
    monkeypatch.setattr(sys, "argv", ["worker", "--redis-url", "redis://127.0.0.1:9"])
    assert program.main() == status
    assert capsys.readouterr().err.startswith(said)


def test_it_needs_an_address(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.delenv("RPR_CUSPS_REDIS_URL", raising=False)
    monkeypatch.setattr(sys, "argv", ["worker"])
    with pytest.raises(SystemExit, match="2"):
        program.main()
    assert "no Redis URL: give --redis-url or set RPR_CUSPS_REDIS_URL" in capsys.readouterr().err
