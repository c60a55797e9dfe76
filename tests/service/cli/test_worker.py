from __future__ import annotations

from pathlib import Path

from tests.support.cli_process import Run, run


def test_a_server_that_cannot_be_used() -> None:
    done = run("worker", "--redis-url", "redis://127.0.0.1:1", RPR_CUSPS_REDIS_PASSWORD_FILE="nothing")
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("rpr-cusps worker: cannot reach Redis: ")
    assert done.stderr.count("\n") == 1


def test_an_invalid_setting(run_here: Run, tmp_path: Path) -> None:
    done = run_here("worker", "--redis-url", f"unix://{tmp_path}/nothing.sock", RPR_CUSPS_DEADLINE="-1")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("rpr-cusps worker: RPR_CUSPS_DEADLINE: ")
