"""The embedded Valkey, its files and its directories."""

from __future__ import annotations

import os
import signal
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from service.errors import EmbeddedError
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import environment, is_running, started, until
from worker.connection import connect

HOLD = """
import sys, time
from pathlib import Path
from service.stack.embedded_valkey import EmbeddedValkey
server = EmbeddedValkey(Path(sys.argv[1])).start()
print(server.pid, flush=True)
time.sleep(60)
"""
KEYS = 50


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """A directory with the data of a server that was killed."""
    with EmbeddedValkey(tmp_path / "data") as server, connect(server.url) as redis:
        for i in range(KEYS):
            redis.set(f"key{i}", "value" * 10)
        os.kill(server.pid, signal.SIGKILL)
        until(lambda: not server.is_alive())
    return server.data_dir


def only(data: Path, pattern: str) -> Path:
    [path] = (data / "appendonlydir").glob(pattern)
    return path


def keys_of(data: Path, said: list[str] | None = None) -> int:
    """How many keys a server finds in a directory; what it says goes to `said`."""
    say = [].append if said is None else said.append
    with EmbeddedValkey(data, say) as server, connect(server.url) as redis:
        return int(redis.dbsize())


def refusal(data: Path) -> str:
    with pytest.raises(EmbeddedError) as caught:
        EmbeddedValkey(data).start()
    return str(caught.value)


CUT_ENDS: dict[str, Callable[[bytes], bytes]] = {
    "half a command": lambda content: content[:-7],
    "half a transaction": lambda content: content + b"*1\r\n$5\r\nMULTI\r\n*2\r\n$3\r\nDEL\r\n$4\r\nkey1\r\n",
}


@pytest.mark.parametrize("end", CUT_ENDS)
def test_a_cut_end_is_left_out(data: Path, end: str) -> None:
    """The append-only file ends with an incomplete command or half a transaction (power failure, full disk).
    The next start has all data before it."""
    file = only(data, "*.incr.aof")
    file.write_bytes(CUT_ENDS[end](file.read_bytes()))
    assert keys_of(data) == (KEYS - 1 if end == "half a command" else KEYS)


@pytest.mark.parametrize("where", [900, None])
def test_damaged_commands(data: Path, where: int | None) -> None:
    """The append-only file is damaged in the middle, or ends with zeros. The start is refused, because what
    follows would be lost; one line says what to do."""
    file = only(data, "*.incr.aof")
    content = file.read_bytes()
    at = len(content) if where is None else where
    file.write_bytes(content[:at] + bytes(30) + content[at + 30 :])
    assert "restore" in refusal(data)


def test_a_damaged_base(data: Path) -> None:
    """The snapshot under the append-only file is damaged. The start is refused, and one line says what to
    do."""
    file = only(data, "*.base.rdb")
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 0xFF
    file.write_bytes(content)
    assert "restore" in refusal(data)


@pytest.mark.parametrize("is_empty", [False, True])
def test_a_missing_manifest(data: Path, is_empty: bool) -> None:
    """The list of the append-only files is missing or empty. The start is refused and nothing is overwritten:
    Valkey would start empty. One line says what to do."""
    manifest = only(data, "*.manifest")
    manifest.unlink()
    if is_empty:
        manifest.touch()
    before = only(data, "*.incr.aof").read_bytes()
    assert "is missing or empty" in refusal(data)
    assert only(data, "*.incr.aof").read_bytes() == before


def test_an_open_directory_is_closed_to_others(data: Path) -> None:
    """The data directory and its files are readable by other users. They are made private, with one line."""
    paths = [data, *data.rglob("*")]
    for path in paths:
        path.chmod(0o755 if path.is_dir() else 0o644)
    said: list[str] = []
    assert keys_of(data, said) == KEYS
    assert not [path for path in data.rglob("*") if stat.S_IMODE(path.stat().st_mode) & 0o077]
    assert stat.S_IMODE(data.stat().st_mode) == 0o700
    assert len(said) == 1


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give a directory away")
def test_a_directory_of_another_user(tmp_path: Path) -> None:
    """The data directory belongs to another user. The start is refused with one line."""
    os.chown(tmp_path, 12345, -1)
    assert "belongs to user 12345" in refusal(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_lock_that_is_a_link(tmp_path: Path) -> None:
    """The lock in the data directory is a symbolic or hard link to another file. The start is refused with
    one line, and that file is unharmed."""
    target = tmp_path / "target"
    target.write_text("precious")
    data = tmp_path / "data"
    data.mkdir(mode=0o700)
    lock = data / "lock"
    lock.symlink_to(target)
    assert "is a symbolic link" in refusal(data)
    lock.unlink()
    lock.hardlink_to(target)
    assert "not a file of this service" in refusal(data)
    assert target.read_text() == "precious"


def test_a_stopped_server_of_a_dead_owner(data: Path) -> None:
    """Valkey is stopped by SIGSTOP and its supervisor killed, so that Valkey does not end with it. The
    next start is refused with one line that names it."""
    command = [sys.executable, "-c", HOLD, str(data)]
    with started(command, stdout=subprocess.PIPE, env=environment()) as owner:
        assert owner.stdout is not None
        left = int(owner.stdout.readline())
        os.kill(left, signal.SIGSTOP)
        owner.kill()
        owner.wait()
    assert f"in use by process {left}, the Valkey of a `serve` that has ended" in refusal(data)
    os.kill(left, signal.SIGKILL)
    assert keys_of(data) == KEYS


def test_the_server_is_killed(tmp_path: Path) -> None:
    """Valkey is killed and started again. All acknowledged data is there."""
    with EmbeddedValkey(tmp_path) as server, connect(server.url) as redis:
        redis.set("key", "value")
        redis.waitaof(1, 0, 5000)
        os.kill(server.pid, signal.SIGKILL)
        until(lambda: not server.is_alive())
        server.launch()
        assert redis.get("key") == b"value"


def test_the_server_ends_with_its_owner(tmp_path: Path) -> None:
    """The process that started Valkey is killed. Valkey ends, too, and the next start does not wait."""
    command = [sys.executable, "-c", HOLD, str(tmp_path)]
    with started(command, stdout=subprocess.PIPE, env=environment()) as owner:
        assert owner.stdout is not None
        pid = int(owner.stdout.readline())
        owner.kill()
    until(lambda: not is_running(pid))
    with EmbeddedValkey(tmp_path):  # although the lock and the socket's directory are left behind
        pass


def test_two_servers_for_one_directory(tmp_path: Path) -> None:
    """A second server is started on a data directory. It is refused with one line that names the process."""
    with EmbeddedValkey(tmp_path), pytest.raises(EmbeddedError, match=f"in use by process {os.getpid()};"):
        EmbeddedValkey(tmp_path).start()
    with EmbeddedValkey(tmp_path):
        pass
