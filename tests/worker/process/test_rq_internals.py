"""The RQ internals in docs/worker.md are those that the code touches and that this RQ has."""

from __future__ import annotations

import ast
import inspect
import os
import re
import select
from datetime import UTC, datetime
from pathlib import Path

import pytest
import rq
from redis import Redis
from rq.job import Job
from rq.serializers import JSONSerializer
from rq.utils import import_attribute
from rq.worker import WorkerStatus
from rq.worker_registration import REDIS_WORKER_KEYS

from worker.process.worker import CuspWorker
from worker.settings import WorkerSettings

TEXT = (Path(__file__).parents[3] / "docs" / "worker.md").read_text(encoding="utf-8")
SECTION = TEXT[TEXT.index("## Which of RQ's internals are touched") :]

SIGNATURES = {
    "connection_timeout": "(self)",
    "_pubsub_exception_handler": "(self, exc, pubsub, pubsub_thread)",
    "get_current_job_id": "(self, pipeline)",
    "kill_horse": "(self, sig)",
    "request_stop": "(self, signum, frame)",
    "request_force_stop": "(self, signum, frame)",
    "unsubscribe": "(self)",
    "check_for_suspension": "(self, burst)",
    "subscribe": "(self)",
    "serialize": "(self)",
    "register_death": "(self)",
    "setup_work_horse_signals": "(self)",
    "get_state": "(self)",
    "set_state": "(self, state, pipeline)",
}


def documented(title: str) -> set[str]:
    """Returns the names in a paragraph of the section."""
    [paragraph] = [p for p in SECTION.split("\n\n") if p.startswith(title)]
    return set(re.findall(r"`([\w:]+)`", paragraph))


OVERRIDDEN = set(re.findall(r"^\| `(\w+)` \|", SECTION, re.MULTILINE))
CALLED = documented("Methods called")


@pytest.fixture
def pair(redis: Redis, settings: WorkerSettings) -> tuple[rq.Worker, CuspWorker]:
    """One of RQ's workers and one of ours."""
    return rq.Worker(["x"], connection=redis), CuspWorker(redis, settings)


@pytest.fixture(scope="module")
def touched() -> set[str]:
    """Every attribute of `self` in the class."""
    tree = ast.parse(inspect.getsource(CuspWorker))
    return {
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "self"
    }


def test_what_is_overridden() -> None:
    both = {name for name in vars(CuspWorker) if hasattr(rq.Worker, name)}
    assert both - {"__module__", "__doc__"} == OVERRIDDEN


def test_which_methods_are_called(touched: set[str]) -> None:
    methods = {name for name in touched if callable(getattr(rq.Worker, name, None))}
    assert methods - OVERRIDDEN == CALLED


def test_which_attributes_are_used(pair: tuple[rq.Worker, CuspWorker], touched: set[str]) -> None:
    theirs, _ = pair
    assert touched & vars(theirs).keys() == documented("Attributes")


def test_the_names_of_our_own_attributes_are_free(pair: tuple[rq.Worker, CuspWorker]) -> None:
    theirs, ours = pair
    assigned = set(re.findall(r"self\.(\w+)(?:, self\.\w+)* = ", inspect.getsource(CuspWorker.__init__)))
    assert not assigned & set(dir(theirs))
    assert vars(theirs).keys() <= vars(ours).keys()


def test_the_signatures_are_unchanged() -> None:
    assert set(SIGNATURES) == OVERRIDDEN - {"__init__"} | CALLED
    for name, signature in SIGNATURES.items():
        member = inspect.getattr_static(rq.Worker, name)
        function = member.fget if isinstance(member, property) else member
        assert f"({', '.join(inspect.signature(function).parameters)})" == signature, name


def test_what_is_read_of_an_rq_job(redis: Redis) -> None:
    queue = rq.Queue("NAME", connection=redis, serializer=JSONSerializer)
    queue.enqueue_call("some.task", kwargs={"index": 1}, job_id="ID", timeout=-1)
    job = Job("ID", connection=redis, serializer=JSONSerializer)
    job.restore(redis.hgetall(Job.key_for("ID")))
    assert (job.func_name, job.kwargs) == ("some.task", {"index": 1})
    assert import_attribute("os.getpid") is os.getpid
    assert documented("Of an RQ job") == {
        "Job",
        "restore",
        "key_for",
        "func_name",
        "kwargs",
        "import_attribute",
    }


def test_the_keys_are_unchanged(redis: Redis, pair: tuple[rq.Worker, CuspWorker]) -> None:
    theirs, ours = pair
    keys = {
        REDIS_WORKER_KEYS,
        theirs.key.replace(theirs.name, "NAME"),
        rq.Queue("NAME", connection=redis).key,
        Job("ID", connection=redis).key,
    }
    assert keys == documented("Keys")
    ours.birth_date = datetime.now(UTC)
    ours._register(WorkerStatus.IDLE)
    assert redis.smembers(REDIS_WORKER_KEYS) == {ours.key.encode()}
    assert redis.hget(ours.key, "pid") == str(os.getpid()).encode()


def test_the_stop_command_has_the_horse_of_its_job_ended(pair: tuple[rq.Worker, CuspWorker]) -> None:
    """The loop that supervises the horse looks for the job that is to be stopped, and is woken."""
    _, ours = pair

    def is_woken() -> bool:
        return bool(select.select([ours._wake_r], [], [], 0)[0])

    ours._current = "some-chunk"
    ours.handle_payload({"data": b'{"command": "stop-job", "job_id": "another"}'})
    assert (ours._stopped_job_id, is_woken()) == (None, False)
    ours.handle_payload({"data": b'{"command": "stop-job", "job_id": "some-chunk"}'})
    assert (ours._stopped_job_id, is_woken()) == ("some-chunk", True)
