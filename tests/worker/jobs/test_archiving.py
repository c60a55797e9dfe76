"""Answers that move to the archive, and are read from there as before."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pytest
from redis import Redis

from tests.support.jobs import a_pose_table, a_request
from worker.answers.archive import Archive, ArchiveAwayError, archive_of
from worker.answers.kinds import known_answer
from worker.answers.layout import AWAY
from worker.answers.store import ResultStore, packed
from worker.answers.tables import StoredTable
from worker.jobs.archiving import Mover, keep_moving
from worker.jobs.installation import read_load
from worker.jobs.inventory import Inventory
from worker.settings import WorkerSettings

DAY = 86400
TABLE, DOCUMENT = a_request(*(f"{10 + i}" for i in range(30))), a_pose_table("14.98")


@pytest.fixture
def settings(tmp_path: Path) -> WorkerSettings:
    return WorkerSettings(archive_url=f"file://{tmp_path}/archive", beat_ttl=60)


@pytest.fixture
def store(redis: Redis, settings: WorkerSettings) -> ResultStore:
    """A store with a table of thirty slices and a document."""
    store = ResultStore(redis, settings)
    fill(store)
    return store


@pytest.fixture
def mover(store: ResultStore) -> Mover:
    return Mover(store.redis, store.settings, archive_of(store.settings))


def fill(store: ResultStore) -> None:
    store.put_slices(TABLE, {l1: slice_of(l1) for l1 in TABLE.parts})
    store.put_document(DOCUMENT, {"poses": [slice_of("14.98")]})


def slice_of(l1: str) -> dict[str, Any]:
    return {"l1": l1, "count": 0, "cusps": [], "pad": random.Random(l1).randbytes(400).hex()}


def table(store: ResultStore) -> StoredTable:
    answer = known_answer(TABLE, store)
    assert isinstance(answer, StoredTable)
    return answer


def in_archive(store: ResultStore) -> int:
    keys = [*store.slice_keys(TABLE, TABLE.parts), store.keys.document(DOCUMENT.content_hash)]
    return sum((value or b"")[:1] == AWAY for value in store.redis.mget(keys))


def objects(mover: Mover) -> list[Path]:
    assert mover.archive.folder is not None
    return sorted((mover.archive.folder / "objects").glob("*"))


def age(store: ResultStore, seconds: float) -> None:
    """Let everything seem to be so old."""
    for key in store.redis.keys("*"):
        if (left := store.redis.ttl(key)) > 0:
            store.redis.expire(key, int(left - seconds))


def test_answers_are_the_same_from_the_archive(store: ResultStore, mover: Mover) -> None:
    before, document = table(store), known_answer(DOCUMENT, store)
    texts = [text for batch in before.batches() for text in batch]
    used = store.redis.memory_usage(store.slice_keys(TABLE, ["10"])[0])
    assert mover.move(1, everything=True) == in_archive(store) == 31
    assert len(objects(mover)) == 1
    after = table(store)
    assert after.digest == before.digest, "the ETag"
    assert [text for batch in after.batches() for text in batch] == texts
    assert after.document() == before.document()
    assert known_answer(DOCUMENT, store) == document
    assert store.get_slices(TABLE) == {l1: slice_of(l1) for l1 in TABLE.parts}
    assert 2 * store.redis.memory_usage(store.slice_keys(TABLE, ["10"])[0]) < used
    assert mover.move(1, everything=True) == 0
    load = read_load(store.redis, store.settings).archive
    assert (load["moved"], load["objects"]) == (31, 1)


def test_a_short_answer_an_error_and_other_keys_stay(store: ResultStore, mover: Mover) -> None:
    request = a_request("1", "2")
    store.put_slices(request, {"1": {"l1": "1", "cusps": []}})
    error = {"l1": "2", "error": {"type": "solver-error", "detail": "x" * 1000}}
    store.redis.set(store.slice_keys(request, ["2"])[0], packed({**error, "pad": slice_of("2")}))
    store.redis.set("cusps:somebody", "x" * 1000)
    assert mover.move(1, everything=True) == 31


def test_what_is_young_and_small_stays(store: ResultStore, mover: Mover) -> None:
    assert mover.move(1) == 0
    age(store, store.settings.archive_after + 10)
    assert mover.move(1) == 0, "too few for an object"
    age(store, store.settings.archive_after)
    assert mover.move(1) == 31


def test_what_is_young_moves_if_redis_is_rather_full(mover: Mover, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Inventory, "memory", lambda _: (80, 100.0))
    assert mover.move(1) == 31


def test_an_answer_that_changes_meanwhile_gets_no_address(
    store: ResultStore, mover: Mover, monkeypatch: pytest.MonkeyPatch
) -> None:
    key, put = store.slice_keys(TABLE, ["10"])[0], Archive.put

    def put_late(self: Archive, results: list[tuple[bytes, bytes]]) -> Any:
        addresses = put(self, results)
        store.redis.set(key, packed(slice_of("other")), ex=100)
        store.redis.delete(store.slice_keys(TABLE, ["11"])[0])
        return addresses

    monkeypatch.setattr(Archive, "put", put_late)
    assert mover.move(1, everything=True) == 29
    assert store.get_slices(TABLE, ["10", "11"]) == {"10": slice_of("other")}


@pytest.mark.parametrize("at", ["obstore.put", "obstore.get", "worker.jobs.archiving.Mover._replace"])
def test_nothing_is_lost_if_the_move_ends_anywhere(
    store: ResultStore, mover: Mover, monkeypatch: pytest.MonkeyPatch, at: str
) -> None:
    class Killed(BaseException):
        pass

    def kill(*_: object, **__: object) -> None:
        raise Killed

    with monkeypatch.context() as patch:
        patch.setattr(at, kill)
        with pytest.raises(Killed):
            mover.move(1, everything=True)
    assert in_archive(store) == 0
    assert len(store.get_slices(TABLE)) == 30
    assert mover.move(1, everything=True) == 31
    left = len(objects(mover)) - 1
    assert mover.collect(older_than=-1) == left, "what was written for nothing"
    assert len(store.get_slices(TABLE)) == 30


def test_what_the_archive_lost_is_not_known_and_is_kept_when_it_is_computed_again(
    store: ResultStore, mover: Mover
) -> None:
    mover.move(1, everything=True)
    [path] = objects(mover)
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    assert known_answer(TABLE, store) is None
    assert len(store.get_slices(TABLE)) == 29
    path.unlink()
    assert store.get_document(DOCUMENT) is None
    assert store.get_slices(TABLE) == {}
    assert not store.redis.exists(*store.slice_keys(TABLE, TABLE.parts))
    assert not store.renew_document(DOCUMENT)
    assert read_load(store.redis, store.settings).archive["lost"] == 31
    store.put_slices(TABLE, {"10": slice_of("10")})
    assert store.get_slices(TABLE) == {"10": slice_of("10")}


def test_without_the_archive_an_answer_is_neither_known_nor_unknown_to_the_api(
    store: ResultStore, mover: Mover, settings: WorkerSettings
) -> None:
    mover.move(1, everything=True)
    with pytest.raises(ArchiveAwayError, match="is not set"):
        ResultStore(store.redis, WorkerSettings()).get_slices(TABLE)
    assert mover.archive.folder is not None
    mover.archive.folder.rename(mover.archive.folder.with_name("away"))
    with pytest.raises(ArchiveAwayError, match="folder is gone"):
        store.get_slices(TABLE)
    chunk = ResultStore(store.redis, settings, holder="a chunk")
    assert chunk.get_slices(TABLE) == {}, "it computes them"
    chunk.put_slices(TABLE, {"10": slice_of("10")})
    chunk.put_document(DOCUMENT, {"poses": [slice_of("14.98")]})
    assert store.get_slices(TABLE, ["10"]) == {"10": slice_of("10")}
    assert store.get_document(DOCUMENT) == {"poses": [slice_of("14.98")]}
    assert in_archive(store) == 29


def test_what_is_asked_for_again_lives_as_long_as_before(store: ResultStore, mover: Mover) -> None:
    mover.move(1, everything=True)
    key = store.slice_keys(TABLE, ["10"])[0]
    assert store.redis.ttl(key) > 364 * DAY
    store.renew_slices(TABLE, store.get_slices(TABLE))
    assert store.renew_document(DOCUMENT)
    assert store.redis.ttl(key) > 364 * DAY
    assert store.redis.ttl(store.keys.digits(TABLE.geometry_hash, 1)) > 364 * DAY


def test_objects_without_an_address_are_removed(store: ResultStore, mover: Mover) -> None:
    mover.move(1, everything=True)
    assert mover.collect(older_than=60) == mover.collect(older_than=-1) == 0
    store.redis.delete(*store.slice_keys(TABLE, TABLE.parts))
    assert mover.collect(older_than=-1) == 0, "the document is in it"
    store.redis.delete(store.keys.document(DOCUMENT.content_hash))
    assert mover.collect(older_than=-1) == 1
    assert objects(mover) == []


def test_an_archive_that_takes_nothing_leaves_all_in_redis(
    store: ResultStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    age(store, 2 * store.settings.archive_after + 10)

    def refuse(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("obstore.put", refuse)
    assert keep_moving(store.redis, store.settings, 1) is False
    assert in_archive(store) == 0
    assert read_load(store.redis, store.settings).archive == {"refused": 1}


def test_nothing_is_removed_from_redis_before_it_could_move(
    store: ResultStore, mover: Mover, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fullness(*more: float) -> None:
        full = iter([*more])
        monkeypatch.setattr(Inventory, "memory", lambda _: (next(full, 0.0), 100.0))

    fullness(200.0)
    assert mover.inventory.relieve() == 0
    assert Inventory(store.redis, WorkerSettings()).relieve() > 0, "without an archive"
    fill(store)  # again: of equal age, the document may have gone
    fullness(200.0, 200.0)
    assert mover.move(1) == 31
    fullness(200.0, 200.0, 200.0)
    assert mover.move(1) == 0
    assert in_archive(store) < 31, "now addresses go, too"


def test_a_redis_that_is_full_still_takes_addresses(store: ResultStore, mover: Mover) -> None:
    mover.move(1, everything=True)  # loads the script
    other = a_request("1")
    store.put_slices(other, {"1": slice_of("1")})
    store.redis.config_set("maxmemory", 1)
    try:
        assert keep_moving(store.redis, store.settings, 1)
    finally:
        store.redis.config_set("maxmemory", 0)
    assert (store.redis.get(store.slice_keys(other, ["1"])[0]) or b"")[:1] == AWAY
