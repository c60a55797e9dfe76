"""The files of an embedded Valkey: private, locked, and repaired if that loses nothing."""

from __future__ import annotations

import os
import random
import re
import stat
import subprocess
from pathlib import Path

import pytest

from service.errors import EmbeddedError
from service.stack.data_dir import Damage, damage_of, find_damage, is_lent, make_private
from service.stack.embedded_valkey import program

pytestmark = pytest.mark.quick

USER, GROUP = 12345, 2000


def directory(mode: int, owner: int = 0, group: int = GROUP) -> os.stat_result:
    return os.stat_result((stat.S_IFDIR | mode, 1, 1, 2, owner, group, 0, 0, 0, 0))


@pytest.mark.parametrize("mode", [0o2775, 0o2770, 0o775])
def test_a_directory_of_root_and_our_group_is_lent(mode: int) -> None:
    assert is_lent(directory(mode), USER, {USER, GROUP})


@pytest.mark.parametrize(
    ("info", "user"),
    [
        (directory(0o2777), USER),
        (directory(0o2755), USER),
        (directory(0o2775, owner=54321), USER),
        (directory(0o2775, group=3000), USER),
        (directory(0o2775, owner=USER), USER),
        (directory(0o2775), 0),
    ],
    ids=["all may write", "we may not", "not root's", "not our group", "ours", "we are root"],
)
def test_no_other_directory_is(info: os.stat_result, user: int) -> None:
    assert not is_lent(info, user, {GROUP})


@pytest.mark.skipif(os.geteuid() != 0, reason="only root has directories of root's")
def test_what_is_in_it_must_be_ours(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    os.chown(tmp_path, 0, GROUP)
    tmp_path.chmod(0o2775)
    kept = tmp_path / "appendonlydir"
    kept.mkdir(mode=0o2770)
    os.chown(kept, USER, GROUP)
    monkeypatch.setattr(os, "geteuid", lambda: USER)
    monkeypatch.setattr(os, "getgroups", lambda: [GROUP])
    said: list[str] = []
    make_private(tmp_path, said.append)
    assert (said, stat.S_IMODE(tmp_path.stat().st_mode)) == ([], 0o2775)
    assert not kept.stat().st_mode & 0o077
    os.chown(kept, 54321, GROUP)
    with pytest.raises(EmbeddedError, match=r"appendonlydir belongs to user 54321, not to user 12345"):
        make_private(tmp_path, said.append)


def command(*words: str) -> bytes:
    return b"*%d\r\n" % len(words) + b"".join(b"$%d\r\n%b\r\n" % (len(w), w.encode()) for w in words)


SET = command("SET", "key", "a value\r\nof two lines")
TRANSACTION = command("multi") + SET + command("DEL", "key") + command("Exec")
INTACT = command("SELECT", "0") + SET + TRANSACTION + command("PEXPIRE", "key", "5")


def intact_by_valkey(path: Path) -> int:
    """How far `valkey-check-aof` finds a file intact; the server is that program under another name."""
    words = ["valkey-check-aof", str(path)]
    done = subprocess.run(words, executable=program(), capture_output=True, text=True, check=False)
    if done.returncode == 0:
        return path.stat().st_size
    match = re.search(r"ok_up_to=(\d+)", done.stdout)
    assert match is not None, done.stdout
    return int(match[1])


def intact_by_us(path: Path) -> int:
    damage = damage_of(path)
    return path.stat().st_size if damage is None else damage.start


def damaged(case: int) -> bytes:
    """A file that is cut, ends with what a disk may leave there, or has a wrong byte."""
    chance = random.Random(case)
    kind = case % 4
    if kind == 0:
        return INTACT[: chance.randrange(1, len(INTACT))]
    if kind == 1:
        return INTACT[: chance.randrange(1, len(INTACT))] + bytes(chance.choice([1, 4096]))
    if kind == 2:
        return INTACT + chance.randbytes(chance.randrange(1, 50))
    place = chance.randrange(len(INTACT))
    return INTACT[:place] + bytes([INTACT[place] ^ chance.choice([1, 64])]) + INTACT[place + 1 :]


@pytest.mark.parametrize("first", range(0, 80, 20))
def test_damage_begins_where_valkey_finds_it(tmp_path: Path, first: int) -> None:
    path = tmp_path / "file.aof"
    for case in range(first, first + 20):
        path.write_bytes(damaged(case))
        assert intact_by_us(path) == intact_by_valkey(path), (case, path.read_bytes())


def test_an_intact_file() -> None:
    assert find_damage(INTACT) is None
    assert find_damage(b"#TS:1700000000\r\n" + INTACT) is None


def test_an_empty_file(tmp_path: Path) -> None:
    (tmp_path / "file.aof").touch()
    assert damage_of(tmp_path / "file.aof") is None


@pytest.mark.parametrize(
    "rest", [b"\0" * 4096, b"*2\r\n$3\r\nDE", command("MULTI") + SET, b"*3\r\n$3\r\nSET\r\n$9\r\n"]
)
def test_a_damaged_end(rest: bytes) -> None:
    size = len(INTACT)
    assert find_damage(INTACT + rest) == Damage(size, size + len(rest), None)


@pytest.mark.parametrize(
    "hole", [b"\0" * 20, b"*3\r\n$3\r\nSET\r\n$900\r\nkey\r\n", b"garbage\r\n", SET[:-3]]
)
def test_damage_before_intact_commands(hole: bytes) -> None:
    size = len(INTACT)
    data = INTACT + hole + TRANSACTION
    assert find_damage(data) == Damage(size, len(data), size + len(hole))
