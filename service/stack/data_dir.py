"""The files of an embedded Valkey: its directories, private and for one server at a time, its socket, and its
append-only files: which commands are intact, and repair if that loses nothing.

The append-only files are a manifest, a base (a snapshot) and increments (commands). Valkey starts empty if
the manifest is missing, and overwrites the others; it ends if an increment is damaged. The program that would
repair it, `valkey-check-aof`, is not part of the package, and would cut off whatever follows the damage."""

from __future__ import annotations

import errno
import fcntl
import hashlib
import mmap
import os
import pwd
import re
import shutil
import signal
import stat
import sys
import tempfile
import time
from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path

from service.errors import EmbeddedError

_SOCKET_PATH_LIMIT = 103  # bytes; macOS allows 104 with the final zero, Linux 108
_ENDING_PATIENCE = 1.5  # seconds that a server has to end with its supervisor
_END_PATIENCE = 4.0  # seconds that it has once it is asked to
_OTHERS = 0o077
_HAS_PROC = sys.platform == "linux"


def default_data_dir() -> Path:
    """Returns the platform's directory for a user's application data."""
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Application Support" / "rpr-cusps"
    base = os.environ.get("XDG_DATA_HOME", "")
    return (Path(base) if Path(base).is_absolute() else Path.home() / ".local" / "share") / "rpr-cusps"


def make_private(data_dir: Path, say: Callable[[str], object]) -> None:
    """Create the directory, or close it to other users, with what an earlier server left in it.

    A volume of Kubernetes with an `fsGroup` stays as it is: it belongs to root, and only to our group beside.

    Raises:
        EmbeddedError: it belongs to another user, or something in it does.
    """
    data_dir.mkdir(parents=True, exist_ok=True, mode=0o700)
    info = data_dir.stat()
    if is_lent(info, os.geteuid(), {os.getegid(), *os.getgroups()}):
        _check_own(data_dir)
    elif info.st_uid != os.geteuid():
        raise EmbeddedError(
            f"the data directory {data_dir} belongs to {_user(info.st_uid)}, not to {_user(os.geteuid())}; "
            "choose another --data-dir, or one below it"
        )
    elif (mode := stat.S_IMODE(info.st_mode)) & _OTHERS:
        data_dir.chmod(0o700)
        say(f"the data directory {data_dir} was open to other users (mode {mode:03o}); now it is private")
    for path in _files(data_dir):
        _close_to_others(path)


def _files(data_dir: Path) -> list[Path]:
    return [*data_dir.glob("valkey.log*"), data_dir / DIRECTORY, *(data_dir / DIRECTORY).glob("*")]


def is_lent(info: os.stat_result, user: int, groups: Collection[int]) -> bool:
    """Whether a directory that belongs to root is writable for one of our groups, and for no other user.

    Others of that group cannot read our files, and cannot put theirs in place of ours without being noticed.
    """
    is_group_writable = info.st_mode & stat.S_IRWXG == stat.S_IRWXG and not info.st_mode & stat.S_IWOTH
    return user != 0 == info.st_uid and info.st_gid in groups and is_group_writable


def _check_own(data_dir: Path) -> None:
    for path in filter(os.path.lexists, _files(data_dir)):
        if (owner := path.lstat().st_uid) != os.geteuid():
            raise EmbeddedError(
                f"{path} belongs to {_user(owner)}, not to {_user(os.geteuid())}; choose another --data-dir"
            )


def _close_to_others(path: Path) -> None:
    try:
        info = path.lstat()
    except FileNotFoundError:
        return
    is_ours = info.st_uid == os.geteuid() and not stat.S_ISLNK(info.st_mode)
    if is_ours and info.st_mode & _OTHERS:
        path.chmod(stat.S_IMODE(info.st_mode) & ~_OTHERS)


def runtime_dir(data_dir: Path) -> Path:
    """Returns a short private directory for the socket, always the same one for a data directory."""
    name = f"rpr-cusps-{os.getuid()}-{hashlib.sha256(os.fsencode(data_dir)).hexdigest()[:12]}"
    for base in (os.environ.get("XDG_RUNTIME_DIR"), tempfile.gettempdir(), "/tmp"):
        if not base or len(os.fsencode(f"{base}/{name}/valkey.sock")) > _SOCKET_PATH_LIMIT:
            continue
        path = Path(base) / name
        try:
            path.mkdir(mode=0o700, exist_ok=True)
            info = path.lstat()
        except OSError:
            continue
        if stat.S_ISDIR(info.st_mode) and info.st_uid == os.getuid() and stat.S_IMODE(info.st_mode) == 0o700:
            return path
        return Path(tempfile.mkdtemp(prefix="rpr-cusps-", dir=base))
    raise EmbeddedError("no directory name is short enough for a unix socket; set TMPDIR to a shorter one")


class DirectoryLock:
    """The lock on a data directory. The server inherits it, so it lasts until both processes have ended."""

    def __init__(self, data_dir: Path, say: Callable[[str], object]) -> None:
        """Lock the directory; waits for a server that is about to end, and ends one that was left behind.

        Raises:
            EmbeddedError: the directory is in use, or its lock is not one of our files.
        """
        self._data_dir, self._say = data_dir, say
        self.fd = _open(data_dir / "lock")
        try:
            self._lock()
        except BaseException:
            self.close()
            raise
        self.record(None)

    def record(self, server: int | None) -> None:
        """Note who holds the lock: this process, and the server that it started."""
        text = f"{os.getpid():<15}\n{'' if server is None else server:<15}\n"
        os.pwrite(self.fd, text.encode(), 0)  # the same length always: it needs no room on a full disk

    def close(self) -> None:
        """Leave the lock to the server, if one is running."""
        os.close(self.fd)

    def _lock(self) -> None:
        start = time.monotonic()
        asked = 0.0
        while not self._is_free():
            owner, server = self._holders()
            waited = time.monotonic() - start
            is_late = waited > _ENDING_PATIENCE
            if owner is not None or (is_late and (server is None or not _HAS_PROC)):
                raise EmbeddedError(self._in_use(owner, server))
            if is_late and server is not None and not asked:
                asked = time.monotonic()
                self._say(f"ending the Valkey of a supervisor that died (process {server})")
                os.kill(server, signal.SIGTERM)
                os.kill(server, signal.SIGCONT)  # if it is stopped, it does not hear the other signal
            elif asked and time.monotonic() - asked > _END_PATIENCE and server is not None:
                os.kill(server, signal.SIGKILL)
            time.sleep(0.05)

    def _is_free(self) -> bool:
        try:
            fcntl.flock(self.fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True

    def _holders(self) -> tuple[int | None, int | None]:
        """The recorded supervisor and server, if they still hold the lock."""
        words = os.pread(self.fd, 64, 0).decode(errors="replace").split()
        pids = [int(word) if word.isdigit() else 0 for word in (*words, "", "")[:2]]
        owner, server = (pid if pid > 0 and _holds(pid, self.fd) else None for pid in pids)
        return owner, server

    def _in_use(self, owner: int | None, server: int | None) -> str:
        by, advice = "a process that cannot be seen from here", "stop that process"
        if owner is not None:
            by = f"process {owner}"
        elif server is not None:
            by, advice = f"process {server}, a Valkey whose supervisor died", f"end it (kill -9 {server})"
        return f"the data directory {self._data_dir} is in use by {by}; {advice} or choose another --data-dir"


def _open(path: Path) -> int:
    try:
        fd = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o600)
    except OSError as error:
        if error.errno != errno.ELOOP:
            raise
        raise EmbeddedError(f"{path} is a symbolic link, which could point anywhere; remove it") from None
    info = os.fstat(fd)
    if not stat.S_ISREG(info.st_mode) or info.st_nlink != 1 or info.st_uid != os.geteuid():
        os.close(fd)
        raise EmbeddedError(f"{path} is not a file of this service; remove it")
    os.fchmod(fd, 0o600)
    return fd


def _holds(pid: int, fd: int) -> bool:
    """Whether a process has the file of our descriptor open too; without /proc, whether it runs at all."""
    try:
        if not _HAS_PROC:
            os.kill(pid, 0)
            return True
        files = [
            file for file in Path(f"/proc/{pid}/fd").iterdir() if (pid, file.name) != (os.getpid(), str(fd))
        ]
        return any(_is_same(file, os.fstat(fd)) for file in files)
    except (ProcessLookupError, FileNotFoundError):
        return False
    except PermissionError:
        return True


def _is_same(path: Path, info: os.stat_result) -> bool:
    try:
        return os.path.samestat(path.stat(), info)
    except OSError:
        return False


def _user(uid: int) -> str:
    try:
        return f"the user {pwd.getpwuid(uid).pw_name}"
    except KeyError:
        return f"user {uid}"


_ARRAY = re.compile(rb"\*([1-9]\d{0,8})\r\n")
_STRING = re.compile(rb"\$(\d{1,10})\r\n")
_REMARK = re.compile(rb"#[^\r\n]{0,1000}\r\n")
_COMMAND = re.compile(rb"\*[1-9]\d{0,8}\r\n\$\d{1,2}\r\n[A-Za-z]")


DIRECTORY = "appendonlydir"

_MANIFEST = "appendonly.aof.manifest"

_PART = re.compile(r"appendonly\.aof\.(\d+)\.(base|incr)\.(rdb|aof)")
_ENTRY = re.compile(r"file (\S+) seq \d+ type ([bi])")


@dataclass(frozen=True)
class Damage:
    """What follows the last intact command of a file."""

    start: int
    """Where the damage begins: after the last command, or before a transaction that is not complete."""
    size: int
    """The size of the file."""
    resumes: int | None
    """Where intact commands begin again, if they do."""


def damage_of(path: Path) -> Damage | None:
    """Returns the damage of a file, None if every command in it is intact."""
    with path.open("rb") as file:
        if os.fstat(file.fileno()).st_size == 0:
            return None  # and cannot be mapped
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
            return find_damage(data)


def find_damage(data: bytes | mmap.mmap) -> Damage | None:
    """Returns the damage in the content of a file.

    >>> find_damage(b"*1\\r\\n$4\\r\\nPING\\r\\n*1\\r\\n$4\\r\\nPI")
    Damage(start=14, size=24, resumes=None)
    """
    size, position, start = len(data), 0, 0
    is_transaction = False
    while position < size and (step := _command(data, position)) is not None:
        end, name = step
        if name == (b"MULTI" if is_transaction else b"EXEC"):
            break
        position, is_transaction = end, name == b"MULTI" or (is_transaction and name != b"EXEC")
        if not is_transaction:
            start = position
    if start == size:
        return None
    resumes = None if position == size else _resumption(data, position)
    return Damage(start, size, resumes)


def _command(data: bytes | mmap.mmap, position: int) -> tuple[int, bytes] | None:
    """Returns the end and the name of the command that begins at a position; None if it is not intact."""
    if remark := _REMARK.match(data, position):
        return remark.end(), b""
    if (array := _ARRAY.match(data, position)) is None:
        return None
    name, end = b"", array.end()
    for index in range(int(array[1])):
        if (string := _STRING.match(data, end)) is None:
            return None
        end = string.end() + int(string[1])
        if data[end : end + 2] != b"\r\n":
            return None
        if index == 0:
            name = data[string.end() : end].upper()
        end += 2
    return end, name


def _resumption(data: bytes | mmap.mmap, position: int) -> int | None:
    """Returns where the first intact command after a position begins."""
    starts = (match.start() for match in _COMMAND.finditer(data, position + 1))
    return next((start for start in starts if _command(data, start) is not None), None)


def check_manifest(data_dir: Path, say: Callable[[str], object]) -> None:
    """Write a missing manifest again if the files leave no doubt about it.

    Raises:
        EmbeddedError: they leave doubt.
    """
    directory = data_dir / DIRECTORY
    manifest = directory / _MANIFEST
    parts = [match for path in directory.glob("*") if (match := _PART.fullmatch(path.name))]
    if not parts or (manifest.exists() and manifest.stat().st_size > 0):
        return
    kinds = sorted(match[2] for match in parts)
    if kinds != ["base", "incr"]:
        names = ", ".join(sorted(match[0] for match in parts))
        raise EmbeddedError(
            f"{manifest} is missing, and its content cannot be inferred from the files beside it ({names}); "
            f"restore {directory} from a backup, or move it away to start empty"
        )
    lines = [f"file {match[0]} seq {int(match[1])} type {match[2][0]}\n" for match in parts]
    _write(manifest, "".join(sorted(lines, key=lambda line: line.endswith("i\n"))))
    say(f"{manifest} was missing; wrote it again from the files beside it")


def repair(data_dir: Path, say: Callable[[str], object]) -> None:
    """Cut off a damaged end of the last increment, if there is one, and keep a copy.

    Raises:
        EmbeddedError: the damage is elsewhere, so intact commands would get lost.
    """
    increments = _increments(data_dir / DIRECTORY)
    for path in increments:
        damage = damage_of(path)
        if damage is None:
            continue
        if damage.resumes is not None or path != increments[-1]:
            raise EmbeddedError(_what_to_do(path, damage, is_last=path == increments[-1]))
        copy = _copy(path, data_dir)
        with path.open("r+b") as file:
            file.truncate(damage.start)
            os.fsync(file.fileno())
        say(
            f"cut {damage.size - damage.start} damaged bytes off the end of {path}; {copy} is the file before"
        )


def _what_to_do(path: Path, damage: Damage, *, is_last: bool) -> str:
    follows = (
        f"intact commands follow from byte {damage.resumes} on" if damage.resumes else "other files follow"
    )
    cut = f"; or keep only what precedes it: cp {path} {path}.bak && truncate -s {damage.start} {path}"
    return (
        f"{path} is damaged at byte {damage.start}, and {follows}; restore {path.parent} from a backup"
        f"{cut if is_last else ''}; or move {path.parent} away to start empty"
    )


def _increments(directory: Path) -> list[Path]:
    """The increments, in the order of the manifest."""
    try:
        manifest = (directory / _MANIFEST).read_text(encoding="utf-8", errors="replace")
    except FileNotFoundError:
        return []
    entries = (_ENTRY.match(line) for line in manifest.splitlines())
    paths = [directory / entry[1] for entry in entries if entry is not None and entry[2] == "i"]
    return [path for path in paths if path.is_file()]


def _copy(path: Path, data_dir: Path) -> Path:
    copy = data_dir / f"{path.name}.{time.strftime('%Y%m%dT%H%M%S')}.damaged"
    shutil.copyfile(path, copy)
    copy.chmod(0o600)
    with copy.open("rb") as file:
        os.fsync(file.fileno())
    return copy


def _write(path: Path, text: str) -> None:
    """Write a file atomically."""
    draft = path.with_suffix(".draft")
    with draft.open("w", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    draft.chmod(0o600)
    draft.replace(path)
