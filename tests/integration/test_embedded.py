from __future__ import annotations

import shutil
import stat
import sys
from pathlib import Path

import pytest

from service.errors import EmbeddedError
from service.stack import embedded_valkey
from service.stack.data_dir import default_data_dir
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import is_running
from worker.connection import connect
from worker.process.processes import usable_memory


def test_private_durable_and_without_a_port(tmp_path: Path) -> None:
    data = tmp_path / "data"
    with EmbeddedValkey(data) as server, connect(server.url) as redis:
        pid = server.pid
        socket = Path(server.url.removeprefix("unix://"))
        assert stat.S_IMODE(socket.parent.stat().st_mode) == 0o700
        assert stat.S_IMODE(data.stat().st_mode) == 0o700
        config = redis.config_get("*")
        assert (config["port"], config["appendonly"], config["appendfsync"]) == ("0", "yes", "everysec")
        assert (config["maxmemory-policy"], config["save"]) == ("noeviction", "")
        redis.set("key", "value")
    assert not is_running(pid)
    assert not socket.parent.exists()
    assert server.log_file.exists()
    with EmbeddedValkey(data) as server, connect(server.url) as redis:
        assert redis.get("key") == b"value"


def test_its_memory_is_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By a quarter of what the computer or container has, or by the setting."""
    for megabytes, bound in ((None, usable_memory() // 4), (100, 100 << 20)):
        if megabytes is not None:
            monkeypatch.setenv("RPR_CUSPS_STORE_MAX_MB", str(megabytes))
        with EmbeddedValkey(tmp_path) as server, connect(server.url) as redis:
            assert redis.info("memory")["maxmemory"] == bound
    monkeypatch.setattr(embedded_valkey, "usable_memory", lambda: 10 << 20)
    monkeypatch.delenv("RPR_CUSPS_STORE_MAX_MB")
    assert embedded_valkey.store_bytes() == 64 << 20, "less would be no use"


def test_a_long_path_is_accepted(tmp_path: Path) -> None:
    data = tmp_path / ("x" * 120)
    with EmbeddedValkey(data) as server, connect(server.url) as redis:
        assert redis.ping()


def test_an_unusable_directory_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(EmbeddedError, match=r"cannot use the data directory .*file"):
        EmbeddedValkey(tmp_path / "file").start()


def test_default_data_directory(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("XDG_DATA_HOME", raising=False)
    assert default_data_dir() == tmp_path / ".local" / "share" / "rpr-cusps"
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "xdg"))
    assert default_data_dir() == tmp_path / "xdg" / "rpr-cusps"
    monkeypatch.setenv("XDG_DATA_HOME", "relative")  # the specification says to ignore it
    assert default_data_dir() == tmp_path / ".local" / "share" / "rpr-cusps"
    monkeypatch.setattr(sys, "platform", "darwin")
    assert default_data_dir() == tmp_path / "Library" / "Application Support" / "rpr-cusps"


def test_a_copy_of_the_data_directory_is_a_backup(tmp_path: Path) -> None:
    with EmbeddedValkey(tmp_path / "data") as server, connect(server.url) as client:
        client.set("kept", "1")
        shutil.copytree(tmp_path / "data", tmp_path / "copy", ignore=shutil.ignore_patterns("lock"))
        client.set("later", "1")
    with EmbeddedValkey(tmp_path / "copy") as server, connect(server.url) as client:
        assert client.keys() == [b"kept"]
