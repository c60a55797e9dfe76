"""All that an installation keeps in Redis as one file, which any version of Redis or Valkey can take.

The file is a list of commands in the protocol of Redis (`SET`, `HSET`, …), so it depends on no server's own
format. It begins with a line about itself and ends with its checksum. Lifetimes are points in time.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any, BinaryIO, cast

from redis import Redis
from redis.exceptions import RedisError

from service.errors import StackError
from worker.answers import in_groups
from worker.jobs import queue_name
from worker.jobs.installation import Versions
from worker.jobs.plan import LANES
from worker.settings import WorkerSettings

_FORMAT = 1
_TITLE, _END = b"rpr-cusps store", b"rpr-cusps end of store"
_PAGE = 500  # elements of a key that are read or written together
_SENT_AT_ONCE = 1 << 20  # bytes
_SHORT = 4096  # bytes of a string that is read with others
_LOOKS, _PAUSE = 5, 0.3
_LONGEST = 512 << 20  # bytes of one text, the most that Redis takes

_WRITES = frozenset({b"SET", b"RPUSH", b"SADD", b"HSET", b"ZADD", b"XADD", b"XSETID", b"PEXPIREAT"})

Command = Sequence[bytes]


class TransferError(StackError):
    """The store cannot be written to a file, or read from one; the message is for the user."""


@dataclass(frozen=True)
class Moved:
    """What was moved: the keys, and the bytes of the file."""

    keys: int
    size: int


def export_store(redis: Redis, settings: WorkerSettings, path: Path) -> Moved:
    """Write all keys of an installation to a new file that only its owner can read.

    Raises:
        TransferError: the service is running, so that no moment is the same for all keys; or the file cannot
            be written.
    """
    _check_alone(redis, "exported")
    if redis.exists(_mark(settings)):
        raise TransferError("an import into this Redis was interrupted; import the file again")
    partial = path.with_name(f"{path.name}.partial")
    try:
        if path.exists():
            raise TransferError(f"{path} exists already; choose another name")
        partial.unlink(missing_ok=True)  # of an export that was cut off
        fd = os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        try:
            with os.fdopen(fd, "wb") as file:
                moved = _write(file, redis, settings)
                file.flush()
                os.fsync(file.fileno())
            _check_alone(redis, "exported")
            partial.rename(path)
        finally:
            partial.unlink(missing_ok=True)
    except OSError as error:
        raise TransferError(f"cannot write {path}: {error.strerror or error}") from error
    return moved


def import_store(redis: Redis, settings: WorkerSettings, path: Path) -> Moved:
    """Write all keys of a file to a Redis in which the installation has none.

    The file is read twice: whole, before anything is written, and to be written. An import that was cut off
    is begun anew.

    Raises:
        TransferError: the file is damaged, or of another kind or installation; or there are keys already.
    """
    try:
        with path.open("rb") as file:
            checked = _read(file, settings, lambda _: None)
            _check_alone(redis, "imported")
            mark = _mark(settings)
            if redis.exists(mark):
                _remove(redis, settings, mark)
            elif next(_keys(redis, settings), None) is not None:
                there = f"keys of an installation ({settings.key_prefix}:…)"
                raise TransferError(f"this Redis has {there}; import into an empty one")
            redis.set(mark, checked.keys)
            file.seek(0)
            sender = _Sender(redis)
            _read(file, settings, sender.add)
            sender.flush()
            redis.delete(mark)
    except OSError as error:
        raise TransferError(f"cannot read {path}: {error.strerror or error}") from error
    return checked


def _mark(settings: WorkerSettings) -> str:
    """The key that exists while an import is incomplete."""
    return f"{settings.key_prefix}:import"


def _check_alone(redis: Redis, what: str) -> None:
    """Refuse while others use the database: what they write meanwhile would be there in part.

    Raises:
        TransferError: there are others.
    """
    looks = 1
    while (others := _others(redis)) and looks < _LOOKS:  # a health check, for example, is gone at once
        time.sleep(_PAUSE)
        looks += 1
    if others:
        raise TransferError(
            f"the store cannot be {what} while {others} other client{'s are' if others > 1 else ' is'} "
            "connected to it; stop the service (API and workers) first"
        )


def _others(redis: Redis) -> int:
    """Returns the number of other clients of this database, without replicas."""
    clients = cast("list[dict[str, Any]]", redis.client_list())
    own = redis.client_id()
    database = str(redis.connection_pool.connection_kwargs.get("db") or 0)
    return sum(
        int(client["id"]) != own and client["db"] == database and not set(client["flags"]) & set("MS")
        for client in clients
    )


# -- writing -----------------------------------------------------------------------------------------


def _write(file: BinaryIO, redis: Redis, settings: WorkerSettings) -> Moved:
    digest, size, count = hashlib.sha256(), 0, 0

    def put(command: Command) -> None:
        nonlocal size
        data = _packed(command)
        digest.update(data)
        size += file.write(data)

    head = {"format": _FORMAT, "prefix": settings.key_prefix, "queue": settings.queue_name}
    put((b"ECHO", _TITLE + b" " + json.dumps(head).encode()))
    for keys in _groups(_keys(redis, settings)):
        with redis.pipeline(transaction=False) as pipe:
            for key in keys:
                pipe.type(key)
                pipe.pexpiretime(key)
                pipe.getrange(key, 0, _SHORT - 1)  # an error if it is no string
            replies = pipe.execute(raise_on_error=False)
        for key, kind, expires, start in zip(keys, *(replies[i::3] for i in range(3)), strict=True):
            if isinstance(kind, RedisError):
                raise kind
            is_there = False
            for command in _commands(redis, key, kind, start):
                put(command)
                is_there = True
            if is_there:
                count += 1
                if expires > 0:
                    put((b"PEXPIREAT", key, b"%d" % expires))
    tail = {"keys": count, "sha256": digest.hexdigest()}
    size += file.write(_packed((b"ECHO", _END + b" " + json.dumps(tail).encode())))
    return Moved(count, size)


def _keys(redis: Redis, settings: WorkerSettings) -> Iterator[bytes]:
    """Yields the keys of an installation, and the queues of RQ with what is in them."""
    seen: set[bytes] = set()  # a scan may find a key twice
    prefix = _escaped(settings.key_prefix)
    for key in cast("Iterator[bytes]", redis.scan_iter(match=f"{prefix}:*", count=1000)):
        if (short := hashlib.blake2b(key, digest_size=12).digest()) not in seen:
            seen.add(short)
            yield key
    for name in _queues(redis, settings):
        if redis.exists(name):
            yield name
            for ids in _pages(redis, name):
                yield from (b"rq:job:" + rq_id for rq_id in ids)


def _queues(redis: Redis, settings: WorkerSettings) -> Iterator[bytes]:
    for version in (settings.solver_version, *Versions(redis, settings).others()):
        for lane in LANES:
            yield f"rq:queue:{queue_name(lane, settings.of_version(version))}".encode()


def _commands(redis: Redis, key: bytes, kind: bytes, start: bytes) -> Iterator[Command]:
    """Yields the commands that create a key, a bounded part at a time; none if the key no longer exists.

    `start`: the first bytes of a string, all if they are few.

    Raises:
        TransferError: its type is not that of any of our keys.
    """
    if kind == b"string":
        value = start if len(start) < _SHORT else cast("bytes | None", redis.get(key))
        if value is not None:
            yield b"SET", key, value
    elif kind == b"stream":
        yield from _entries(redis, key)
    elif kind in _PARTS:
        command, parts_of = _PARTS[kind]
        for group in parts_of(redis, key):
            yield command, key, *group
    elif kind != b"none":
        raise TransferError(f"{key!r} has the type {kind.decode()}, which cannot be exported")


def _entries(redis: Redis, key: bytes) -> Iterator[Command]:
    start = "-"
    while page := cast("list[tuple[bytes, dict[bytes, bytes]]]", redis.xrange(key, start, count=_PAGE)):
        for entry, fields in page:
            yield b"XADD", key, entry, *(part for field in fields.items() for part in field)
        start = f"({page[-1][0].decode()}"
    if start != "-":
        yield b"XSETID", key, cast("dict[str, bytes]", redis.xinfo_stream(key))["last-generated-id"]


def _pages(redis: Redis, key: bytes) -> Iterator[list[bytes]]:
    first = 0
    while page := cast("list[bytes]", redis.lrange(key, first, first + _PAGE - 1)):
        yield page
        first += _PAGE


def _groups(items: Iterable[Any]) -> Iterator[list[Any]]:
    group: list[Any] = []
    for item in items:
        group.append(item)
        if len(group) == _PAGE:
            yield group
            group = []
    if group:
        yield group


def _hash_parts(redis: Redis, key: bytes) -> Iterator[Iterable[bytes]]:
    for fields in _groups(redis.hscan_iter(key, count=_PAGE)):
        yield chain.from_iterable(fields)


def _sorted_set_parts(redis: Redis, key: bytes) -> Iterator[Iterable[bytes]]:
    for pairs in _groups(redis.zscan_iter(key, count=_PAGE, score_cast_func=bytes)):
        yield (part for member, score in pairs for part in (score, member))


_PARTS: Mapping[bytes, tuple[bytes, Callable[[Redis, bytes], Iterator[Iterable[bytes]]]]] = {
    b"list": (b"RPUSH", _pages),
    b"set": (b"SADD", lambda redis, key: _groups(redis.sscan_iter(key, count=_PAGE))),
    b"hash": (b"HSET", _hash_parts),
    b"zset": (b"ZADD", _sorted_set_parts),
}
"""Type of a key → the command that adds to it, and its contents in groups of bounded size."""


def _packed(command: Command) -> bytes:
    parts = (b"$%d\r\n%b\r\n" % (len(part), part) for part in command)
    return b"*%d\r\n" % len(command) + b"".join(parts)


def _escaped(text: str) -> str:
    """Returns a text as a pattern of keys that stands for itself."""
    return "".join(f"\\{letter}" if letter in "*?[]^\\" else letter for letter in text)


# -- reading -----------------------------------------------------------------------------------------


def _read(file: BinaryIO, settings: WorkerSettings, take: Callable[[Command], object]) -> Moved:
    """Read a file to its end, and hand on each command that writes.

    Raises:
        TransferError: it is not such a file, or incomplete.
    """
    digest, size = hashlib.sha256(), 0
    head = _next(file)
    about = _remark(head, _TITLE)
    if about is None or about.get("format") != _FORMAT:
        raise TransferError("this is not a file of rpr-cusps store export, or it is from a newer release")
    for name, own in (("prefix", settings.key_prefix), ("queue", settings.queue_name)):
        if about.get(name) != own:
            variable = {"prefix": "RPR_CUSPS_KEY_PREFIX", "queue": "RPR_CUSPS_QUEUE_NAME"}[name]
            raise TransferError(
                f"the file is from an installation with {variable}={about.get(name)}, not {own}"
            )
    command, keys = head, set()
    while (end := _remark(command, _END)) is None:
        if command is not head:
            if not _is_ours(command, settings):
                raise TransferError(f"the file is damaged, or was changed, at byte {size}")
            keys.add(hashlib.blake2b(command[1], digest_size=12).digest())
            take(command)
        data = _packed(command)
        digest.update(data)
        size += len(data)
        command = _next(file)
        if not command:
            raise TransferError(f"the file ends early at byte {size}, or damaged there")
    if end != {"keys": len(keys), "sha256": digest.hexdigest()} or file.read(1):
        raise TransferError("the file is damaged, or was changed: its checksum differs")
    return Moved(len(keys), size + len(_packed(command)))


def _next(file: BinaryIO) -> Command:
    """Returns the next command, empty if there is none or it is incomplete."""
    count = _number(file, b"*", 1 << 20)
    parts: list[bytes] = []
    for _ in range(count or 0):
        length = _number(file, b"$", _LONGEST)
        if length is None:
            return ()
        parts.append(file.read(length))
        if len(parts[-1]) != length or file.read(2) != b"\r\n":
            return ()
    return parts


def _number(file: BinaryIO, sign: bytes, most: int) -> int | None:
    line = file.readline(16)
    digits = line[1:-2]
    is_whole = line[:1] == sign and line[-2:] == b"\r\n" and digits.isdigit()
    return int(digits) if is_whole and int(digits) <= most else None


def _remark(command: Command, title: bytes) -> dict[str, Any] | None:
    if len(command) != 2 or command[0] != b"ECHO" or not command[1].startswith(title + b" "):
        return None
    with suppress(ValueError):
        about = json.loads(command[1][len(title) :])
        if isinstance(about, dict):
            return about
    return None


def _is_ours(command: Command, settings: WorkerSettings) -> bool:
    """Whether a command does nothing but write to a key of the installation."""
    if len(command) < 3 or command[0] not in _WRITES or (command[0] == b"SET" and len(command) != 3):
        return False
    queues = f"rq:queue:{settings.queue_name}-"
    return command[1].startswith((f"{settings.key_prefix}:".encode(), queues.encode(), b"rq:job:"))


class _Sender:
    """Sends commands, many at a time, and has Redis confirm each."""

    def __init__(self, redis: Redis) -> None:
        self._redis = redis
        self._commands: list[Command] = []
        self._size = 0

    def add(self, command: Command) -> None:
        """Send a command, at once or with the next ones."""
        self._commands.append(command)
        self._size += sum(map(len, command))
        if self._size >= _SENT_AT_ONCE:
            self.flush()

    def flush(self) -> None:
        """Send what is left."""
        try:
            with self._redis.pipeline(transaction=False) as pipe:
                for command in self._commands:
                    pipe.execute_command(*command)  # type: ignore[no-untyped-call]
                pipe.execute()
        except RedisError as error:
            reason = str(error).rpartition("caused error: ")[2]  # redis-py quotes the command before it
            raise TransferError(
                f"Redis did not accept all data ({reason}); fix that and import again"
            ) from error
        self._commands, self._size = [], 0


def _remove(redis: Redis, settings: WorkerSettings, mark: str) -> None:
    """Remove what an import that was cut off has written, its mark last."""
    keys = [key for key in _keys(redis, settings) if key != mark.encode()]
    for group in in_groups(keys, _PAGE):
        redis.unlink(*group)
