"""Answers in an archive, and what is noticed there."""

from __future__ import annotations

import json
import threading
from pathlib import Path

import pytest

from tests.support.processes import PATIENCE
from tests.support.s3 import serving_s3
from worker.answers.archive import FOLDER, Archive, ArchiveAwayError, archive_of, index_of
from worker.answers.layout import Address, address_in, pack
from worker.settings import WorkerSettings

RESULTS = [
    (f"cusps:slice:{i}".encode(), pack(b'{"l1":"%d","cusps":[%d]}' % (i, i) * i)) for i in range(1, 40)
]
PACKED = [packed for _, packed in RESULTS]


@pytest.fixture
def archive(tmp_path: Path) -> Archive:
    return Archive(f"file://{tmp_path}/archive", timeout=PATIENCE)


def the_object(archive: Archive) -> Path:
    assert archive.folder is not None
    [path] = (archive.folder / FOLDER).iterdir()
    return path


def test_many_answers_are_in_one_object_and_each_is_read_alone(archive: Archive) -> None:
    addresses = archive.put(RESULTS)
    assert archive.read(addresses) == PACKED
    assert archive.read([addresses[7]]) == [PACKED[7]]
    path = the_object(archive)
    assert addresses[0].object.hex() == path.name
    assert [key for key, _, _ in index_of(path.read_bytes())] == [key.decode() for key, _ in RESULTS]
    assert archive.keys(addresses[0].object) == [key for key, _ in RESULTS]
    assert list(archive.names(older_than=-1)) == [addresses[0].object]
    assert list(archive.names(older_than=60)) == []


def test_an_address_is_written_and_read(archive: Archive) -> None:
    for address in archive.put(RESULTS):
        assert address_in(address.to_bytes()) == address
        assert len(address.to_bytes()) == 65


def test_equal_answers_are_in_different_objects(archive: Archive) -> None:
    """So that the removal of an old object does not remove a new one."""
    assert archive.put(RESULTS)[0].object != archive.put(RESULTS)[0].object


def test_what_is_lost_or_damaged_is_noticed(archive: Archive) -> None:
    addresses = archive.put(RESULTS)
    path, third = the_object(archive), addresses[2]
    whole = path.read_bytes()
    for position in range(third.offset, third.offset + third.size):
        path.write_bytes(whole[:position] + bytes([whole[position] ^ 1]) + whole[position + 1 :])
        found = archive.read(addresses[:5])
        assert found == [*PACKED[:2], None, *PACKED[3:5]], position
    path.write_bytes(whole[: third.offset + 3])
    assert archive.read(addresses[:2]) == PACKED[:2]
    assert archive.read([third]) == [None]
    assert archive.read([addresses[-1]]) == [None], "it would begin beyond the end"
    path.write_bytes(PACKED[0] * 100)
    assert archive.read([addresses[5]]) == [None], "another answer is not taken for it"
    path.unlink()
    assert archive.read(addresses[:2]) == [None, None]
    assert index_of(whole[:-1]) == index_of(b"") == []


def test_an_archive_that_is_away_is_no_loss(archive: Archive) -> None:
    addresses = archive.put(RESULTS)
    assert archive.folder is not None
    away = archive.folder.rename(archive.folder.with_name("away"))
    with pytest.raises(ArchiveAwayError, match="its folder is gone"):
        archive.read(addresses)
    away.rename(archive.folder)
    with pytest.raises(ArchiveAwayError, match="a moment ago"):
        archive.read(addresses)
    archive._next_question = 0.0
    assert archive.read(addresses) == PACKED


def test_what_is_read_back_differently_gets_no_address(
    archive: Archive, monkeypatch: pytest.MonkeyPatch
) -> None:
    import obstore

    put = obstore.put

    def shorten(store: object, path: str, content: bytes, **_: object) -> None:
        put(store, path, content[:-1])  # type: ignore[arg-type]

    monkeypatch.setattr("obstore.put", shorten)
    with pytest.raises(ArchiveAwayError, match="did not keep"):
        archive.put(RESULTS)


def test_one_that_hangs_holds_a_few_threads(archive: Archive, monkeypatch: pytest.MonkeyPatch) -> None:
    addresses, go_on = archive.put(RESULTS[:1]), threading.Event()
    monkeypatch.setattr("obstore.get_range", lambda *_, **__: bytes(go_on.wait(30)))
    monkeypatch.setattr("worker.answers.archive._PATIENCE", 0.1)
    waiting = [threading.Thread(target=archive.read, args=(addresses,)) for _ in range(16)]
    for thread in waiting:
        thread.start()
    with pytest.raises(ArchiveAwayError, match="slow"):
        archive.read(addresses)
    go_on.set()
    for thread in waiting:
        thread.join()


@pytest.mark.parametrize(
    ("url", "said"),
    [("ftp://a", "no archive"), ("s3://", "no archive")],
)
def test_an_address_that_is_no_archive_is_refused(url: str, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        WorkerSettings(archive_url=url)


def test_an_archive_needs_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("worker.settings.find_spec", lambda _: None)
    with pytest.raises(ValueError, match=r"install -c constraints.txt .\.\[archive\]"):
        WorkerSettings(archive_url="s3://bucket")
    assert WorkerSettings().archive_url is None


def test_a_bucket_of_s3(monkeypatch: pytest.MonkeyPatch) -> None:
    with serving_s3() as server:
        for name, value in (("ACCESS_KEY_ID", "a"), ("SECRET_ACCESS_KEY", "b"), ("ENDPOINT_URL", server.url)):
            monkeypatch.setenv(f"AWS_{name}", value)
        monkeypatch.setenv("AWS_REGION", "us-east-1")
        archive = Archive("s3://answers/of/us", timeout=PATIENCE)
        addresses = archive.put(RESULTS)
        assert archive.read(addresses) == PACKED
        assert archive.keys(addresses[0].object) == [key for key, _ in RESULTS]
        assert list(archive.names(older_than=-5)) == [addresses[0].object]
        beyond = Address(addresses[0].measured, addresses[0].object, 1 << 20, 10)
        assert archive.read([beyond, addresses[1]]) == [None, PACKED[1]]
        [path] = server.objects
        assert path == f"answers/of/us/{FOLDER}/{addresses[0].object.hex()}"
        content, written = server.objects[path]
        server.objects[path] = content[: addresses[3].offset + 4], written
        assert archive.read(addresses[2:5]) == [PACKED[2], None, None]
        archive.remove(addresses[0].object)
        assert archive.read(addresses[:3]) == [None] * 3
        addresses = archive.put(RESULTS)
        server.is_out_of_order = True
        with pytest.raises(ArchiveAwayError):
            Archive("s3://answers/of/us", timeout=2).read(addresses)


@pytest.mark.parametrize("vendor", ["gs", "az"])
def test_buckets_of_google_and_azure(vendor: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Their addresses and credentials are understood; removal is not tried with Azure."""
    with serving_s3() as server:
        google = {"gcs_base_url": server.url, "disable_oauth": True, "client_email": "", "private_key": ""}
        for name, value in {
            "GOOGLE_SERVICE_ACCOUNT_KEY": json.dumps({**google, "private_key_id": ""}),
            "AZURE_STORAGE_ACCOUNT_NAME": "us",
            "AZURE_STORAGE_ACCOUNT_KEY": "a2V5",
            "AZURE_STORAGE_ENDPOINT": server.url,
        }.items():
            monkeypatch.setenv(name, value)
        url = WorkerSettings(archive_url=f"{vendor}://answers/of/us").archive_url
        assert url is not None
        archive = Archive(url, timeout=PATIENCE)
        addresses = archive.put(RESULTS)
        assert archive.read(addresses) == PACKED
        assert archive.keys(addresses[0].object) == [key for key, _ in RESULTS]
        [path] = server.objects
        assert path == f"answers/of/us/{FOLDER}/{addresses[0].object.hex()}"
        if vendor == "gs":
            archive.remove(addresses[0].object)
        server.objects.clear()
        assert archive.read(addresses[:3]) == [None] * 3
        server.is_out_of_order = True
        with pytest.raises(ArchiveAwayError):
            Archive(url, timeout=2).read(addresses)


def test_a_bucket_without_its_account_is_away(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("AZURE_STORAGE_ACCOUNT_NAME", raising=False)
    with pytest.raises(ArchiveAwayError, match=r"cannot be opened: .*Account must be specified"):
        archive_of(WorkerSettings(archive_url="az://answers"))
