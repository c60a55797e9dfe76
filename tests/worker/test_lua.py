"""The scripts of Redis: their heads name their keys and arguments, and a call must give each."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from redis import Redis

import worker
from worker.lua.scripts import Scripts, source

ROOT = Path(worker.__file__).parents[1]
FILES = sorted(path for package in ("worker", "service") for path in (ROOT / package).rglob("*.lua"))
NAMED = ("ending", "quotas")
"""Libraries that use names of the scripts that include them."""
LIBRARIES = {"accounts", "announcements", "ends", "jobs", "kept", "listing", "now", "slices", *NAMED}
SCRIPTS = [
    (path.stem, ".".join(path.relative_to(ROOT).parts[:-1])) for path in FILES if path.stem not in LIBRARIES
]


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A package of its own, for other scripts."""
    folder = tmp_path / "some_scripts"
    folder.mkdir()
    (folder / "__init__.py").touch()
    monkeypatch.syspath_prepend(tmp_path)
    yield folder
    sys.modules.pop("some_scripts", None)
    source.cache_clear()


@pytest.mark.parametrize(("name", "package"), SCRIPTS)
def test_redis_takes_every_script(redis: Redis, name: str, package: str) -> None:
    assert redis.script_load(source(name, package).text)


@pytest.mark.parametrize(("name", "package"), SCRIPTS)
def test_every_declared_name_is_used(name: str, package: str) -> None:
    script = source(name, package)
    body = script.text.split("-- args:")[-1]
    for shared in NAMED:
        if re.search(rf"^-- include:.*\b{shared}\b", script.text, re.MULTILINE):
            body += (ROOT / "worker" / "lua" / f"{shared}.lua").read_text()
    for declared in (*script.keys, *script.args):
        assert re.search(rf"\b{declared.removesuffix('...')}\b", body), declared


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"ttl": 1}, "the call of renew.lua lacks results"),
        ({"results": ["b"]}, "the call of renew.lua lacks ttl"),
        ({"results": ["b"], "ttl": 1, "tll": 1}, "the call of renew.lua has no use for tll"),
    ],
)
def test_a_missing_or_unknown_name_is_an_error(redis: Redis, given: dict[str, object], message: str) -> None:
    with pytest.raises(TypeError, match=f"^{re.escape(message)}$"):
        Scripts(redis)("renew", **given)
    assert redis.keys("*") == []


def test_names_stand_for_keys_and_arguments(redis: Redis, package: Path) -> None:
    """A list has whatever is left, also more than Lua puts on its stack."""
    (package / "told.lua").write_text(
        "-- include: more\n-- keys: first second\n-- keys: others...\n-- args: flag\n-- args: values...\n"
        "return {first, second, #others, others[2], flag, #values, twice(values[20000])}\n"
    )
    (package / "more.lua").write_text("-- include: now\nlocal function twice(x) return x .. x end\n")
    (package / "now.lua").write_text("local now = 1\n")
    run = Scripts(redis, "some_scripts")
    spaces = {"first": "1", "unused": "x"}, {"second": "2"}
    reply = run("told", *spaces, others=["3", "4"], flag=True, values=[str(n) for n in range(1, 20001)])
    assert reply == [b"1", b"2", 2, b"4", b"1", 20000, b"2000020000"]


@pytest.mark.parametrize(
    ("head", "message"),
    [
        ("-- keys: a b\n-- args: c b\n", "bad.lua declares a name twice"),
        ("-- keys: a... b\n", "bad.lua: 'a...' is no name, or a list that is not the last"),
    ],
)
def test_a_bad_head_is_refused(package: Path, head: str, message: str) -> None:
    (package / "bad.lua").write_text(head)
    with pytest.raises(ValueError, match=re.escape(message)):
        source("bad", "some_scripts")
