"""The directory of an embedded Valkey: private, or lent by root."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from service.errors import EmbeddedError
from service.stack.data_dir import is_lent, make_private

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
