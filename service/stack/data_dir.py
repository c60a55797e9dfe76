"""The directory of an embedded Valkey: private, for one server at a time, with its socket."""

from __future__ import annotations

import errno
import fcntl
import hashlib
import os
import pwd
import stat
import sys
import tempfile
import time
from collections.abc import Callable, Collection
from pathlib import Path

from service.errors import EmbeddedError

_SOCKET_PATH_LIMIT = 103  # bytes; macOS allows 104 with the final zero, Linux 108
_ENDING_PATIENCE = 5.0  # seconds that a server has to end with its supervisor
_OTHERS = 0o077
APPEND_ONLY = "appendonlydir"
"""The folder of its append-only files."""


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
    return [*data_dir.glob("valkey.log*"), data_dir / APPEND_ONLY, *(data_dir / APPEND_ONLY).glob("*")]


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

    def __init__(self, data_dir: Path) -> None:
        """Lock the directory; waits a moment for a server that is about to end.

        Raises:
            EmbeddedError: the directory is in use, or its lock is not one of our files.
        """
        self.fd = _open(data_dir / "lock")
        try:
            self._lock(data_dir)
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

    def _lock(self, data_dir: Path) -> None:
        end = time.monotonic() + _ENDING_PATIENCE
        while True:
            try:
                fcntl.flock(self.fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return
            except BlockingIOError:
                owner, *server = os.pread(self.fd, 64, 0).decode(errors="replace").split() or ["?"]
                if _runs(owner) or time.monotonic() > end:
                    break
            time.sleep(0.05)
        by = f"process {owner}"
        if not _runs(owner) and server:
            by = f"process {server[0]}, the Valkey of a `serve` that has ended"
        raise EmbeddedError(
            f"the data directory {data_dir} is in use by {by}; stop that process or choose another --data-dir"
        )


def _runs(pid: str) -> bool:
    try:
        os.kill(int(pid), 0)
    except (ValueError, OverflowError, ProcessLookupError):
        return False
    except PermissionError:
        return True
    return True


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


def _user(uid: int) -> str:
    try:
        return f"the user {pwd.getpwuid(uid).pw_name}"
    except KeyError:
        return f"user {uid}"
