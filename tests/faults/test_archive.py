"""An archive of answers that is away, slow, or has lost something"""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import httpx
import pytest
from redis import Redis

from service.api.settings import Settings
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import PATIENCE, Workers, until
from tests.support.service_server import GEOMETRY, serving
from worker.answers.archive import archive_of
from worker.answers.layout import AWAY
from worker.jobs.archiving import Mover
from worker.settings import WorkerSettings

TABLE = {"geometry": GEOMETRY, "l1": {"from": "10", "to": "30", "step": "1"}, "digits": 30}
POSES = {"geometry": GEOMETRY, "l1": "14.98", "l2": "16", "l3": "30"}
QUESTIONS = {"/v1/cusp-tables": TABLE, "/v1/poses": POSES}
WAIT = {"Prefer": "wait=30"}


@dataclass
class Service:
    """A service with an archive in a folder."""

    client: httpx.Client
    redis: Redis
    folder: Path

    def ask(self, path: str, body: object = None) -> httpx.Response:
        return self.client.post(path, json=body or QUESTIONS[path], headers=WAIT)

    def move(self) -> int:
        settings = WorkerSettings()
        return Mover(self.redis, settings, archive_of(settings)).move(5, everything=True)

    def addresses(self) -> int:
        keys = [*self.redis.keys("cusps:slice:*"), *self.redis.keys("cusps:document-*")]
        return sum((value or b"")[:1] == AWAY for value in self.redis.mget(keys)) if keys else 0


@pytest.fixture
def service(
    valkey: EmbeddedValkey, redis: Redis, workers: Workers, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Service]:
    folder = tmp_path / "archive"
    monkeypatch.setenv("RPR_CUSPS_ARCHIVE_URL", f"file://{folder}")
    workers.start(archive_url=f"file://{folder}")
    with (
        serving(Settings(redis_url=valkey.url, answer_cache_mb=0)) as url,
        httpx.Client(base_url=url, timeout=PATIENCE) as client,
    ):
        yield Service(client, redis, folder)


def test_answers_of_the_archive_are_right_or_unavailable(
    service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The archive is away, changes or loses its objects, or is slow. Answers that are in it are the same
    bytes as before, or 503 while it is away; what it lost is computed again. New questions are answered."""
    before = {path: service.ask(path) for path in QUESTIONS}
    assert {answer.status_code for answer in before.values()} == {200}
    assert service.move() == service.addresses() == 22

    def is_as_before(path: str) -> bool:
        answer = service.ask(path)
        same = [(x.content, x.headers["etag"]) for x in (answer, before[path])]
        return answer.status_code == 200 and same[0] == same[1]

    for path, answer in before.items():
        assert is_as_before(path)
        link, tag = answer.headers["content-location"], answer.headers["etag"]
        assert service.client.get(link).content == answer.content
        assert service.client.get(link, headers={"If-None-Match": tag}).status_code == 304
    assert service.addresses() == 22, "nothing was computed again"

    away = service.folder.rename(service.folder.with_name("away"))
    for path in QUESTIONS:
        refused = service.ask(path)
        assert (refused.status_code, refused.headers["retry-after"]) == (503, "2")
        assert "archive" in refused.json()["detail"]
    assert service.ask("/v1/poses", {**POSES, "l2": "17"}).status_code == 200, "a new question"
    away.rename(service.folder)
    for path in QUESTIONS:
        until(lambda path=path: service.ask(path).status_code == 200)  # type: ignore[misc]
        assert is_as_before(path)

    [object_] = (service.folder / "objects").iterdir()
    content = object_.read_bytes()
    object_.write_bytes(bytes(byte ^ 1 for byte in content[:9000]) + content[9000:])
    for path in QUESTIONS:
        assert is_as_before(path)
    assert 0 < service.addresses() < 22, "some were computed again"

    service.move()
    import obstore

    read = obstore.get_range

    def slowly(*args: object, **words: object) -> object:
        time.sleep(0.3)
        return read(*args, **words)  # type: ignore[call-overload]

    monkeypatch.setattr("obstore.get_range", slowly)
    assert all(is_as_before(path) for path in QUESTIONS)
    for path in (service.folder / "objects").iterdir():
        path.unlink()
    assert all(is_as_before(path) for path in QUESTIONS)
    assert service.addresses() == 1, "that of the new question, which nobody asked for again"


@pytest.mark.long
def test_a_worker_moves_answers_and_may_be_killed_at_any_time(
    valkey: EmbeddedValkey, redis: Redis, workers: Workers, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A worker and the process that moves its answers are killed, three times. Each answer is the same as
    before, and all move in the end."""
    settings = {"archive_url": f"file://{tmp_path}/archive", "archive_after": 0}
    monkeypatch.setenv("RPR_CUSPS_ARCHIVE_URL", str(settings["archive_url"]))
    with (
        serving(Settings(redis_url=valkey.url, answer_cache_mb=0)) as url,
        httpx.Client(base_url=url, timeout=PATIENCE) as client,
    ):
        service = Service(client, redis, tmp_path / "archive")
        workers.start(**settings)
        before = {path: service.ask(path) for path in QUESTIONS}
        for _ in range(3):
            until(lambda: (tmp_path / "archive" / "objects").exists())
            for process in workers.alive():
                os.kill(process.pid, signal.SIGKILL)
            assert all(service.ask(path).content == before[path].content for path in QUESTIONS)
            workers.start(**settings)
        until(lambda: service.addresses() == 22)
        assert all(service.ask(path).content == before[path].content for path in QUESTIONS)
