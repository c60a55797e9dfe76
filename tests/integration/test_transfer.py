"""The store as a file: between the embedded Valkey and an older Redis, both ways."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest
from redis import Redis
from redis.exceptions import RedisError

from service.stack.embedded_valkey import EmbeddedValkey
from service.stack.transfer import TransferError, export_store, import_store
from tests.support.jobs import a_document, a_request, ended, submit_batch, table_of
from tests.support.processes import Workers, completed, environment, started, until
from worker.answers.kinds import Item
from worker.connection import connect
from worker.jobs.queue import JobQueue
from worker.settings import WorkerSettings

REDIS = shutil.which("redis-server")
OWN = WorkerSettings()


@contextmanager
def debian_redis(folder: Path) -> Iterator[str]:
    """The system's Redis on an empty directory; gives its address."""
    folder.mkdir()
    options = ("--port", "0", "--unixsocket", f"{folder}/s", "--dir", str(folder), "--save", "")
    with started([REDIS or "", *options], stdout=subprocess.DEVNULL):
        with connect(f"unix://{folder}/s") as redis:
            until(lambda: _answers(redis))
        yield f"unix://{folder}/s"


def _answers(redis: Redis) -> bool:
    try:
        return bool(redis.ping())
    except RedisError:
        return False


def content(redis: Redis) -> dict[bytes, Any]:
    """All keys with their values and what is left of their lifetimes, to some seconds."""
    read: dict[bytes, Callable[[bytes], Any]] = {
        b"string": redis.get,
        b"list": lambda key: redis.lrange(key, 0, -1),
        b"set": redis.smembers,
        b"hash": redis.hgetall,
        b"zset": lambda key: redis.zrange(key, 0, -1, withscores=True),
        b"stream": redis.xrange,
    }
    keys: list[bytes] = redis.keys()
    kept = {key: redis.pttl(key) for key in keys if key not in (b"rq:queues", b"rq:workers")}
    lasting = {key: left for key, left in kept.items() if left == -1 or left > 60_000}
    return {
        key: (read[redis.type(key)](key), left if left == -1 else pytest.approx(left, abs=30_000))
        for key, left in lasting.items()
        if not key.startswith(b"rq:worker:")
    }


def store(*words: str) -> str:
    done = completed([sys.executable, "-m", "service", "store", *words], environment())
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


@pytest.mark.skipif(REDIS is None, reason="needs redis-server of the system")
def test_from_the_embedded_server_to_an_older_one_and_back(tmp_path: Path) -> None:
    data, file, again = tmp_path / "data", tmp_path / "first", tmp_path / "second"
    with ExitStack() as stack:
        server = stack.enter_context(EmbeddedValkey(data))
        queue = JobQueue(stack.enter_context(connect(server.url)))
        workers = Workers(server.url, tmp_path / "log")
        workers.start()
        done = ended(queue, queue.submit(a_request("1", "2")).id)
        table = table_of(queue, done.id)
        workers.stop()
        waiting = [queue.submit(a_request(str(n), "27")).id for n in range(30, 33)]
        batch = submit_batch(queue, [Item(request=a_document()), Item(request=a_request("29"))])
        queue.redis.set("cusps:long", b"\r\n\0\xff" * 300_000)
        queue.redis.rpush("cusps:list", *range(1200))
        queue.redis.zadd("cusps:scores", {"a": 0.1, "b": 1732278153.123456, "c": float("inf")})
        until(lambda: not queue.redis.keys("cusps:sweep-lock:*"))  # it lasts a second longer than the worker
        before = content(queue.redis)
    assert store("export", str(file), "--data-dir", str(data)).startswith(f"wrote {len(before)} keys to ")
    assert file.stat().st_mode & 0o777 == 0o600

    with debian_redis(tmp_path / "debian") as url:
        store("import", str(file), "--redis-url", url)
        with connect(url) as redis:
            assert str(redis.info("server")["redis_version"]) < "9"
            assert content(redis) == before
        store("export", str(again), "--redis-url", url)
        with connect(url) as redis:
            queue = JobQueue(redis)
            assert table_of(queue, done.id) == table
            workers = Workers(url, tmp_path / "log")
            workers.start()
            assert [ended(queue, job_id).status for job_id in (*waiting, batch.id)] == ["succeeded"] * 4
            workers.stop()

    store("import", str(again), "--data-dir", str(tmp_path / "other"))
    with EmbeddedValkey(tmp_path / "other") as server, connect(server.url) as redis:
        assert content(redis) == before


@pytest.fixture
def exported(redis: Redis, tmp_path: Path) -> Path:
    """A file with a job that waits, and an empty server."""
    JobQueue(redis).submit(a_request("1", "2"))
    export_store(redis, OWN, tmp_path / "file")
    redis.flushall()
    return tmp_path / "file"


def test_a_file_that_is_not_whole_changes_nothing(redis: Redis, exported: Path) -> None:
    text = exported.read_bytes()
    middle = text.index(b"queued")
    swapped = text[:middle] + b"QUEUED" + text[middle + 6 :]
    foreign = text.replace(b"cusps:job", b"other:job")
    for damaged in (b"", text[:-1], text[: len(text) // 2], text + b"x", swapped, foreign, text[100:], b"{}"):
        exported.write_bytes(damaged)
        with pytest.raises(TransferError, match=r"damaged|ends early|not a file of rpr-cusps"):
            import_store(redis, OWN, exported)
        assert redis.dbsize() == 0
    exported.write_bytes(text)
    with pytest.raises(TransferError, match="RPR_CUSPS_KEY_PREFIX=cusps, not ours"):
        import_store(redis, WorkerSettings(key_prefix="ours"), exported)
    assert import_store(redis, OWN, exported).keys == redis.dbsize()
    with pytest.raises(TransferError, match="import into an empty one"):
        import_store(redis, OWN, exported)


def test_an_import_that_was_cut_off_is_begun_anew(redis: Redis, exported: Path) -> None:
    import_store(redis, OWN, exported)
    whole = content(redis)
    redis.set("cusps:import", 1)
    redis.rpush("rq:queue:cusps-6", "half")
    with pytest.raises(TransferError, match="import the file again"):
        export_store(redis, OWN, exported.with_name("second"))
    import_store(redis, OWN, exported)
    assert content(redis) == whole


def test_while_others_use_the_store_nothing_is_moved(
    redis: Redis, valkey: EmbeddedValkey, exported: Path
) -> None:
    with connect(valkey.url) as other:
        other.ping()
        with pytest.raises(TransferError, match="cannot be exported while 1 other client is connected"):
            export_store(redis, OWN, exported.with_name("second"))
        with pytest.raises(TransferError, match="cannot be imported while 1 other client is connected"):
            import_store(redis, OWN, exported)
    with pytest.raises(TransferError, match="exists already"):
        export_store(redis, OWN, exported)
    assert sorted(exported.parent.iterdir()) == [exported]


def test_a_server_without_room_says_so(redis: Redis, exported: Path) -> None:
    redis.config_set("maxmemory", 1)
    try:
        with pytest.raises((TransferError, RedisError), match=r"OOM|maxmemory"):
            import_store(redis, OWN, exported)
    finally:
        redis.config_set("maxmemory", 0)
    assert import_store(redis, OWN, exported).keys > 0
