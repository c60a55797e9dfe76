"""Batches by the clients, against a real service: submitted once, read however connections break."""

from __future__ import annotations

import csv
import io
import json
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import aclosing, contextmanager, suppress
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import anyio
import pytest

from rpr_solver import EXAMPLES, InputError
from service.client import (
    Answer,
    Asked,
    AsyncServiceClient,
    ItemResult,
    Job,
    ServiceClient,
    cusp_table,
    poses,
)
from service.client.bodies import Body
from service.errors import JobInterrupted, ServiceError
from tests.support.processes import PATIENCE, until
from worker.jobs.queue import JobQueue

Client = type[ServiceClient]
ZEIN = EXAMPLES["zein-flat"]


def questions(*l2: object) -> list[Asked[Any]]:
    """Questions that take milliseconds, with their lengths as names."""
    return [poses(ZEIN, 15, str(x), 40, digits=15).named(str(x)) for x in l2]


def table(length: object) -> Asked[Any]:
    return cusp_table(ZEIN, str(length), digits=15)


def test_results_are_the_answers_to_the_questions_alone(base_url: str) -> None:
    items = [table(10), *questions(30, "61/2")]
    seen: list[tuple[int, int]] = []
    with ServiceClient(base_url) as client:
        results = list(client.ask_all(iter(items), lambda *progress: seen.append(progress)))
        alone = [client.ask(asked) for asked in items]
    assert [(r.index, r.name, r.kind, r.status, r.problem) for r in results] == [
        (0, None, "cusp-table", "succeeded", None),
        (1, "30", "poses", "succeeded", None),
        (2, "61/2", "poses", "succeeded", None),
    ]
    answers = [r.answer for r in results if r.answer is not None]
    assert [a.content for a in answers] == [a.content for a in alone]
    assert [type(a.typed) for a in answers] == [asked.model for asked in items]
    assert seen == [(n, 3) for n in range(4)]


def test_the_asynchronous_client_reads_several_batches_at_once(base_url: str) -> None:
    found: dict[str, list[ItemResult]] = {}

    async def read(client: AsyncServiceClient, name: str) -> None:
        async with aclosing(client.ask_all(questions(31, 32, name))) as results:
            found[name] = [result async for result in results]

    async def main() -> None:
        async with AsyncServiceClient(base_url) as client:
            async with anyio.create_task_group() as group:
                for name in ("33", "34"):
                    group.start_soon(read, client, name)
            batch = await client.submit(questions(31, 32))
            assert (
                (await client.wait(batch.id)).status == (await client.batch(batch.id)).status == "completed"
            )
            partial = [r.line async for r in client.results(batch.id, wait=False, after=0)]
            assert len(partial) == 1

    anyio.run(main)
    for name, results in found.items():
        assert sorted(r.name or "" for r in results) == ["31", "32", name]
        assert {r.status for r in results} == {"succeeded"}
    assert [r.index for r in found["33"]] == [0, 1, 2]


def test_what_is_not_valid_is_a_problem_in_its_place(base_url: str) -> None:
    bad = {"kind": "poses", "request": {"geometry": ZEIN.to_json(), "l1": "1", "l2": "-1", "l3": "-2"}}
    with ServiceClient(base_url) as client:
        first, second, third = client.ask_all([table(11), bad, {"kind": "poem", "id": "ü"}])
    assert (first.status, second.status, third.status) == ("succeeded", "failed", "failed")
    assert second.answer is None
    assert second.problem is not None
    assert second.problem.type == "/problems/invalid-request"
    assert {"items[1].request.l2", "items[1].request.l3"} <= {e.field for e in second.problem.errors}
    assert (third.kind, third.name) == (None, "ü")


@pytest.mark.parametrize("form", ["array", "csv"])
def test_files(base_url: str, tmp_path: Path, form: str) -> None:
    geometries = [{**ZEIN.to_json(), "a3x": str(17 + n)} for n in (0, 1)]
    items = [{"kind": "cusp-table", "request": {"geometry": g, "l1": "12", "digits": 15}} for g in geometries]
    rows = io.StringIO()
    columns = ["a2x", "a3x", "a3y", "d1", "d2", "d3", "orientation", "l1", "digits"]
    writer = csv.DictWriter(rows, columns)
    writer.writeheader()
    writer.writerows({**g, "l1": "12", "digits": 15} for g in geometries)
    texts = {
        "array": json.dumps(items, indent=1),
        "object": json.dumps({"items": items}),
        "ndjson": "".join(json.dumps(item) + "\n" for item in items),
        "csv": rows.getvalue(),
    }
    path = tmp_path / "batch"
    path.write_text(texts[form], encoding="utf-8-sig")
    with ServiceClient(base_url) as client:
        batch = client.submit_file(path)
        by_stream = client.submit_file(io.BytesIO(texts[form].encode()))
        lines = [r.line for r in client.results(batch.id)]
        assert [r.line for r in client.results(by_stream.id)] == lines
        assert [json.loads(line)["result"]["geometry"]["a3x"] for line in lines] == ["17", "18"]


def test_a_file_that_cannot_be_read(base_url: str, tmp_path: Path) -> None:
    with ServiceClient(base_url) as client, pytest.raises(InputError, match="cannot be read"):
        client.submit_file(tmp_path)


class Cut:
    """A way to the service on which connections break: each closes after so many bytes of answers."""

    def __init__(self, url: str, *limits: int) -> None:
        self.target = urlsplit(url)
        self.limits = iter(limits)
        self.requests: list[bytes] = []

    def serve(self, listener: socket.socket) -> None:
        with suppress(OSError):
            while True:
                client, _ = listener.accept()
                limit = next(self.limits, None)
                threading.Thread(target=self.forward, args=(client, limit), daemon=True).start()

    def forward(self, client: socket.socket, limit: int | None) -> None:
        place = self.target.hostname or "", self.target.port or 0
        with suppress(OSError), client, socket.create_connection(place) as server:
            threading.Thread(target=self.copy, args=(client, server), daemon=True).start()
            left = limit
            while data := server.recv(1 << 16):
                client.sendall(data if left is None else data[:left])
                left = None if left is None else left - len(data)
                if left is not None and left <= 0:
                    client.shutdown(socket.SHUT_RDWR)
                    return

    def copy(self, client: socket.socket, server: socket.socket) -> None:
        with suppress(OSError):
            while data := client.recv(1 << 16):
                self.requests.append(data)
                server.sendall(data)
            server.shutdown(socket.SHUT_WR)


@contextmanager
def cut(url: str, *limits: int) -> Iterator[tuple[str, Cut]]:
    """Gives the address of such a way, whose first connections end after these numbers of bytes."""
    way = Cut(url, *limits)
    with socket.create_server(("127.0.0.1", 0)) as listener:
        thread = threading.Thread(target=way.serve, args=(listener,), daemon=True)
        thread.start()
        try:
            yield f"http://127.0.0.1:{listener.getsockname()[1]}", way
        finally:
            listener.shutdown(socket.SHUT_RDWR)
            thread.join(PATIENCE)


def batches_of(queue: JobQueue) -> set[bytes]:
    return set(queue.redis.keys("cusps:job*:ba-*"))  # type: ignore[arg-type]


def test_a_submission_whose_answer_is_lost_makes_one_batch(
    client_type: Client, idle_url: str, idle_queue: JobQueue
) -> None:
    before = batches_of(idle_queue)
    asked = iter(questions(50, 51))  # a generator cannot be sent again; what it gave can
    with cut(idle_url, 10, 10) as (url, way), client_type(url) as client:
        batch = client.submit(asked)
        assert batch.progress.total == 2
        sent = b"".join(way.requests).lower()
        assert sent.count(b"post /v1/batches ") == 3
        assert len({part[:36] for part in sent.split(b"idempotency-key: ")[1:]}) == 1
        client.cancel(batch.id)
    assert len({key.split(b":")[2] for key in batches_of(idle_queue) - before}) == 1


def test_a_key_of_ones_own_comes_back_to_the_same_batch(client_type: Client, idle_url: str) -> None:
    with client_type(idle_url) as client:
        first = client.submit(questions(52), key="design-7")
    with client_type(idle_url) as client:
        assert client.submit(questions(52), key="design-7").id == first.id
        with pytest.raises(ServiceError) as refused:
            client.submit(questions(53), key="design-7")
        assert (refused.value.problem, refused.value.is_input) == ("idempotency-key-reused", True)
        client.cancel(first.id)


def test_reading_goes_on_where_a_connection_broke(client_type: Client, base_url: str) -> None:
    with client_type(base_url) as client:
        batch = client.submit(questions(*range(10, 40)))
        whole = [r.line for r in client.results(batch.id)]
    half = sum(map(len, whole)) // 2
    # the state of the batch; half of the results, in a line; nothing at all; the rest
    with cut(base_url, half, 0) as (url, way), client_type(url) as client:
        results = list(client.results(batch.id))
    assert [r.index for r in results] == list(range(30))
    assert [r.line for r in results] == whole
    assert b"".join(way.requests).count(b"/results") >= 2


def test_a_batch_that_is_watched_is_canceled_with_its_reader(idle_url: str, idle_queue: JobQueue) -> None:
    async def main() -> str:
        async with AsyncServiceClient(idle_url) as client:
            batch = await client.submit(questions(54, 55))
            with anyio.move_on_after(0.5):
                async for _ in client.watch(batch):
                    pass
            return batch.id

    job = idle_queue.get(anyio.run(main))
    assert job is not None
    assert job.status == "canceled"
    with ServiceClient(idle_url) as client:
        bad = {"kind": "poses", "request": {}}
        batch = client.submit([bad, *questions(56)])
        watched = client.watch(batch)
        assert next(watched).status == "failed"
        watched.close()
        assert client.batch(batch.id).status == "canceled"
        assert [r.status for r in client.results(batch.id)] == ["failed", "canceled"]


def test_an_item_that_cannot_be_sent_is_named(
    client_type: Client, idle_url: str, idle_queue: JobQueue
) -> None:
    before = batches_of(idle_queue)
    late = poses(ZEIN, 1, 1, 1, deadline=5)
    with client_type(idle_url) as client:
        with pytest.raises(InputError, match=r"items\[1\]: has a deadline, which is not allowed in items"):
            client.submit([*questions(58), late])
        with pytest.raises(InputError, match=r"items\[0\]: cannot be written as JSON"):
            client.submit([{"kind": "poses", "request": {"l1": object()}}])
        with pytest.raises(ServiceError, match="items: is empty"):
            client.submit([])
        with pytest.raises(ServiceError, match="There is no batch 'ba-0'"):
            next(client.results("ba-0"))
    assert batches_of(idle_queue) == before


def test_a_source_that_failed_is_not_at_its_end() -> None:
    def pieces() -> Iterator[bytes]:
        yield b"{}"
        raise ConnectionError("gone")

    body = Body(pieces(), "text/plain")
    for _ in range(2):
        with pytest.raises(ConnectionError, match="gone"):
            list(body)
    body.close()


def test_a_question_that_is_begun(
    client_type: Client, idle_url: str, base_url: str, fresh: Callable[[], str]
) -> None:
    with client_type(idle_url) as client:
        job = client.begin(table("81.5"))
        assert isinstance(job, Job)
        assert client.job(job.id)["status"] == "queued"
        client.cancel(job.id)
        with pytest.raises(ServiceError, match="callback_url: webhooks are disabled"):
            client.begin(table("81.5"), callback_url="https://example.com/")
        with pytest.raises(ServiceError, match="callback_url: webhooks are disabled"):
            client.submit(questions(59), callback_url="https://example.com/?a&b")
    with client_type(base_url) as client:
        known = client.ask(table(fresh()))
        again = client.begin(table(known.typed.slices[0].l1))
        assert isinstance(again, Answer)
        assert again.content == known.content


def test_an_interrupt_while_it_is_submitted_says_so(idle_url: str) -> None:
    def items() -> Iterator[Asked[Any]]:
        yield from questions(60)
        raise KeyboardInterrupt

    with ServiceClient(idle_url) as client, pytest.raises(JobInterrupted, match="may not have been accepted"):
        client.submit(items(), key="broken-off")
    with ServiceClient(idle_url) as client:
        batch = until(lambda: client.submit(questions(60, 61), key="broken-off"))
        client.cancel(batch.id)
