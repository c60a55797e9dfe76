"""Results in an archive: a folder or a bucket, where many are packed into one object that never changes.

The name of an object is the SHA-256 of its content. It has the packed results one behind the other, then an
index with their keys, which makes it readable without Redis, and at the end the size of the index. Redis has
the address of each result, with the digest of its JSON: what is read is compared with that.
"""

from __future__ import annotations

import hashlib
import json
import os
import threading
import time
import zlib
from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import timedelta
from functools import cache
from pathlib import Path
from struct import Struct
from typing import TYPE_CHECKING, Any, cast
from urllib.parse import unquote, urlsplit

from redis.exceptions import ConnectionError as RedisConnectionError

from rpr_solver.errors import installing
from worker.answers.layout import Address

if TYPE_CHECKING:
    from worker.settings import WorkerSettings


FOLDER = "objects"
_TRAILER = Struct(">Q8s")
_MAGIC = b"rprcusp1"
_TIMEOUT = 5.0  # seconds for an answer of the archive: a bucket takes less than one
_READERS = 16  # threads that may wait for the archive; the others of a process answer from Redis
_PATIENCE = 1.0  # seconds to wait for a place among them
_GAP = 1 << 14  # bytes between two results up to which both are read at once
_PAUSE = 1.0  # seconds without a question to an archive that did not answer


class ArchiveAwayError(RedisConnectionError):
    """The archive does not answer, or takes no data; a part of the store is away, as when Redis is."""


class Archive:
    """The objects at one address; safe to share between threads.

    Args:
        url: a folder as `file:///path`, or `s3://`, `gs://` or `az://` with the name of a bucket.
        timeout: the longest time for one request, in seconds.
    """

    def __init__(self, url: str, timeout: float) -> None:
        from obstore.store import LocalStore, from_url

        parts = urlsplit(url)
        self.folder = Path(unquote(parts.path)) if parts.scheme == "file" else None
        if self.folder is not None:
            self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            self._store: Any = LocalStore(self.folder)
        else:
            limits: dict[str, Any] = {"timeout": f"{timeout} s", "connect_timeout": f"{timeout / 2} s"}
            retries: Any = {"max_retries": 2, "retry_timeout": timedelta(seconds=timeout)}
            options: Any = {**limits, "allow_http": True}  # if the operator names such an endpoint
            self._store = from_url(url, client_options=options, retry_config=retries)
        self._places = threading.BoundedSemaphore(_READERS)
        self._next_question = 0.0

    def read(self, addresses: Sequence[Address]) -> list[bytes | None]:
        """Returns packed results, or None for each that is lost or damaged.

        Raises:
            ArchiveAwayError: the archive does not answer.
        """
        by_object: defaultdict[bytes, list[int]] = defaultdict(list)
        for i, address in enumerate(addresses):
            by_object[address.object].append(i)
        found: list[bytes | None] = [None] * len(addresses)
        for name, positions in by_object.items():
            wanted = [addresses[i] for i in positions]
            for i, packed in zip(positions, self._parts(name, wanted), strict=True):
                if addresses[i].is_of(packed):
                    found[i] = packed
        return found

    def put(self, results: Sequence[tuple[bytes, bytes]]) -> list[Address]:
        """Write packed results with their keys as one object; returns where each is, once it was read back.

        Raises:
            ArchiveAwayError: the archive does not take it, or gives back something else.
        """
        import obstore

        content, offsets = _object_of(results)
        digest = hashlib.sha256(content).digest()
        with self._answering():
            obstore.put(self._store, _path(digest), content, use_multipart=False)
            self._sync(digest)
            kept = bytes(obstore.get(self._store, _path(digest)).bytes())
        if kept != content:
            raise ArchiveAwayError("the archive did not keep what was written")
        return [
            Address.of(packed, digest, offset) for (_, packed), offset in zip(results, offsets, strict=True)
        ]

    def names(self, older_than: float) -> Iterator[bytes]:
        """Yields the names of the objects that were written more than `older_than` seconds ago."""
        import obstore

        for page in obstore.list(self._store, FOLDER):
            for meta in page:
                if time.time() - meta["last_modified"].timestamp() > older_than:
                    yield bytes.fromhex(str(meta["path"]).rpartition("/")[2])

    def keys(self, name: bytes) -> list[bytes]:
        """Returns the keys of the results in an object, by its index; none if it is damaged."""
        import obstore

        with self._answering():
            content = bytes(obstore.get(self._store, _path(name)).bytes())
        return [key.encode() for key, _, _ in index_of(content)]

    def remove(self, name: bytes) -> None:
        """Remove an object."""
        import obstore

        with self._answering():
            obstore.delete(self._store, _path(name))

    def _parts(self, name: bytes, wanted: Sequence[Address]) -> list[bytes]:
        """Returns what is at some places of an object, shorter where that is; neighbours are read at once.

        (`obstore.get_ranges` would do so, but ends the thread where the object is shorter.)
        """
        parts = [b""] * len(wanted)
        for run in _runs(wanted):
            first = wanted[run[0]].offset
            content = self._range(name, first, max(wanted[i].end for i in run))
            for i in run:
                parts[i] = content[wanted[i].offset - first : wanted[i].end - first]
        return parts

    def _range(self, name: bytes, start: int, end: int) -> bytes:
        import obstore

        try:
            with self._answering():
                return bytes(obstore.get_range(self._store, _path(name), start=start, end=end))
        except FileNotFoundError:
            return b""
        except ArchiveAwayError:
            if self._is_shorter(name, end):
                return b""
            raise

    def _is_shorter(self, name: bytes, size: int) -> bool:
        """Whether an object lost its end: no range beyond it can be read."""
        import obstore

        try:
            self._next_question = 0.0
            with self._answering():
                return int(obstore.head(self._store, _path(name))["size"]) < size
        except FileNotFoundError:
            return True

    @contextmanager
    def _answering(self) -> Iterator[None]:
        """Turn what the archive does not answer into one error; an archive that hangs holds a few threads."""
        from obstore.exceptions import BaseError

        if time.monotonic() < self._next_question:
            raise ArchiveAwayError("the archive did not answer a moment ago, and is not tried again yet")
        if not self._places.acquire(timeout=_PATIENCE):
            raise ArchiveAwayError("the archive is slow, and no more threads wait for it")
        try:
            yield
        except FileNotFoundError:
            if self.folder is not None and not self.folder.is_dir():
                raise self._away("its folder is gone") from None
            raise
        except (BaseError, OSError) as error:
            raise self._away(str(error).partition("\n")[0]) from error
        finally:
            self._places.release()

    def _away(self, reason: str) -> ArchiveAwayError:
        self._next_question = time.monotonic() + _PAUSE
        return ArchiveAwayError(f"the archive does not answer ({reason})")

    def _sync(self, name: bytes) -> None:
        """Have the disk keep an object, before its address is given to anybody."""
        if self.folder is None:
            return
        path = self.folder / _path(name)
        for part in (path, path.parent):
            descriptor = os.open(part, os.O_RDONLY)
            try:
                os.fsync(descriptor)
            finally:
                os.close(descriptor)


def _runs(wanted: Sequence[Address]) -> Iterator[list[int]]:
    """Yields the positions of places that are near each other."""
    run: list[int] = []
    for i in sorted(range(len(wanted)), key=lambda i: wanted[i].offset):
        if run and wanted[i].offset - wanted[run[-1]].end > _GAP:
            yield run
            run = []
        run.append(i)
    yield run


def _path(name: bytes) -> str:
    return f"{FOLDER}/{name.hex()}"


def _object_of(results: Sequence[tuple[bytes, bytes]]) -> tuple[bytes, list[int]]:
    """Returns an object, and from where in it each result is; the time makes any two objects different."""
    offsets, end = [], 0
    for _, packed in results:
        offsets.append(end)
        end += len(packed)
    entries = [
        (key.decode(), offset, len(packed)) for (key, packed), offset in zip(results, offsets, strict=True)
    ]
    index = zlib.compress(json.dumps({"created": time.time_ns(), "results": entries}).encode())
    return b"".join([*(packed for _, packed in results), index, _TRAILER.pack(len(index), _MAGIC)]), offsets


def index_of(content: bytes) -> list[tuple[str, int, int]]:
    """Returns the key, the first byte and the size of each result in an object; nothing if it is damaged."""
    try:
        size, _ = _TRAILER.unpack(content[-_TRAILER.size :].rjust(_TRAILER.size, b"\0"))
        index = content[-_TRAILER.size - size : -_TRAILER.size]
        return cast("list[tuple[str, int, int]]", json.loads(zlib.decompress(index))["results"])
    except (ValueError, KeyError, zlib.error):
        return []


@cache
def _opened(url: str, process: int) -> Archive:
    del process  # no thread of the library survives a fork
    return Archive(url, _TIMEOUT)


def archive_of(settings: WorkerSettings) -> Archive:
    """Returns the archive of an installation.

    Raises:
        ArchiveAwayError: there is none, or it cannot be opened.
    """
    if settings.archive_url is None:
        raise ArchiveAwayError("an answer is in an archive, and RPR_CUSPS_ARCHIVE_URL is not set")
    try:
        return _opened(settings.archive_url, os.getpid())
    except ImportError as error:
        raise ArchiveAwayError(f"obstore is missing; {installing('archive')}") from error
    except Exception as error:
        raise ArchiveAwayError(f"the archive cannot be opened: {error}") from error
