from __future__ import annotations

from pathlib import Path

from tests.support.cli_process import Run, run


def test_a_worker_without_its_server_says_so(tmp_path: Path) -> None:
    done = run("worker", "--redis-url", f"unix://{tmp_path}/nothing.sock")
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("rpr-cusps worker: cannot reach Redis: ")
    assert done.stderr.count("\n") == 1


def test_an_invalid_setting(run_here: Run, tmp_path: Path) -> None:
    done = run_here("worker", "--redis-url", f"unix://{tmp_path}/nothing.sock", RPR_CUSPS_DEADLINE="-1")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("rpr-cusps worker: RPR_CUSPS_DEADLINE: ")
