"""`serve`: the whole stack, started and stopped as by a user."""

from __future__ import annotations

import json
import os
import re
import signal
import socket
from pathlib import Path

import httpx
import pytest
from redis import Redis

from service.api.keys import KeyStore, make_key
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.jobs import a_request, ended
from tests.support.processes import PATIENCE, is_running, until
from tests.support.stack import failure, running
from worker.connection import connect
from worker.jobs.queue import JobQueue
from worker.settings import WorkerSettings


def test_from_nothing_to_an_answer_and_back(tmp_path: Path) -> None:
    with running(tmp_path, workers=2, in_full=True) as stack:
        assert re.fullmatch(
            r"rpr-cusps is ready at http://127\.0\.0\.1:\d+ "
            rf"\(2 workers, data in {re.escape(str(tmp_path))}\); Ctrl-C stops it\n",
            stack.announcement,
        )
        parts = stack.parts()
        assert len(parts) == 4  # Valkey, the API and two workers
        assert httpx.get(f"{stack.base}/healthz").status_code == 200
        body = {"geometry": dict(a_request("1").geometry), "l1": "14.98", "digits": 30}
        answer = httpx.post(
            f"{stack.base}/v1/cusp-tables", json=body, headers={"Prefer": "wait=30"}, timeout=PATIENCE
        )
        assert answer.status_code == 200, answer.text
        assert answer.json()["slices"][0]["count"] == 6
        stack.process.send_signal(signal.SIGINT)
        assert stack.process.wait(PATIENCE) == 0
        assert [pid for pid in parts if is_running(pid)] == []
        assert stack.complaints() == []
    assert not (tmp_path / "valkey.sock").exists()


@pytest.mark.long
def test_serve_says_that_keys_are_needed_and_how_to_undo_it(tmp_path: Path) -> None:
    with EmbeddedValkey(tmp_path) as valkey, connect(valkey.url) as redis:
        store = KeyStore(redis, WorkerSettings().key_prefix)
        key, _ = make_key("trial", "submit", 1.0)
        store.add(key, 1.0)
        store.revoke("trial", 2.0)
    with running(tmp_path) as stack:
        assert httpx.get(f"{stack.base}/v1/limits").status_code == 401
        stack.process.terminate()
        assert stack.process.wait(PATIENCE) == 0
        [said] = stack.complaints()
        assert "every client needs a key, since keys were created; there are 0 valid keys; --insecure" in said
    with running(tmp_path, require_keys="never") as stack:
        assert httpx.get(f"{stack.base}/v1/limits").status_code == 200


def test_every_line_is_an_object_if_asked_for(tmp_path: Path) -> None:
    """Also what the supervisor says, what befalls its children, and what uvicorn thinks of its clients."""
    told = []
    with running(tmp_path, log_format="json", log_level="info", access_log="all") as stack:
        told.append(stack.announcement)
        assert "rpr-cusps is ready at http://" in json.loads(stack.announcement)["message"]
        host, port = stack.base.removeprefix("http://").split(":")
        with socket.create_connection((host, int(port)), timeout=PATIENCE) as client:
            client.sendall(b"nonsense\r\n\r\n")
            assert client.recv(1 << 16).startswith(b"HTTP/1.1 400 ")
        worker = stack.part("worker.__main__")
        os.kill(worker, signal.SIGKILL)
        until(lambda: worker not in stack.parts() and len(stack.parts()) == 4)
        question = {"geometry": dict(a_request("1").geometry), "l1": "14.98", "digits": 15}
        httpx.post(
            f"{stack.base}/v1/cusp-tables", json=question, headers={"Prefer": "wait=30"}, timeout=PATIENCE
        )
        stack.process.send_signal(signal.SIGTERM)
        assert stack.process.wait(PATIENCE) == 0
        told += stack.complaints()
    lines = [json.loads(line) for line in told]
    assert all(line["time"] and line["level"] and line["logger"] and line["message"] for line in lines)
    messages = " ".join(line["message"] for line in lines)
    assert "starting another" in messages
    assert "/v1/cusp-tables" in messages


@pytest.mark.slow
def test_with_a_given_server(tmp_path: Path, valkey: EmbeddedValkey, redis: Redis) -> None:
    data = tmp_path / "unused"
    with running(data, url=valkey.url) as stack:
        assert "data in the given Redis" in stack.announcement
        done = ended(JobQueue(redis), JobQueue(redis).submit(a_request("1")).id)
        assert done.status == "succeeded"
        stack.process.terminate()
        assert stack.process.wait(PATIENCE) == 0
    assert valkey.is_alive()
    assert not data.exists()


def test_an_address_that_cannot_be_used(tmp_path: Path) -> None:
    assert "cannot reach Redis" in failure(tmp_path, url="nonsense://", status=2)


def test_an_invalid_setting(tmp_path: Path) -> None:
    wrong = [("deadline_seconds", -1), ("deadline_seconds", "inf"), ("result_ttl_seconds", "soon")]
    for name, value in wrong:
        message = failure(tmp_path, {name: value}, status=2)
        assert message.startswith(f"rpr-cusps serve: RPR_CUSPS_{name.upper()}: ")
