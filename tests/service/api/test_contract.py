"""The service keeps what openapi.yaml says: schemathesis makes requests from it, and follows its links.

The settings are in tests/data/schemathesis.toml. By hand, against a running service, for as long as you like:
`PYTHONPATH=. st --config-file tests/data/schemathesis.toml run URL/openapi.json -u URL --max-examples 1000`.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from service.api.settings import Settings
from service.schemas.limits import Limits
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import ROOT, environment, started
from tests.support.service_server import serving

CONFIG = ROOT / "tests" / "data" / "schemathesis.toml"
ST = Path(sys.executable).parent / "st"
LIMITS = Limits(
    max_cost_seconds=1, max_slices=20, max_samples=2, max_wait_seconds=2, max_batch_wait_seconds=2
)
"""Whatever is asked, little is computed."""


@pytest.fixture(scope="module")
def modest_url(valkey: EmbeddedValkey, worker: None) -> Iterator[str]:  # noqa: ARG001
    with serving(Settings(redis_url=valkey.url, limits=LIMITS)) as url:
        yield url


def compared(url: str, folder: Path, patience: float, *options: str) -> tuple[int, str]:
    """Returns the exit status and the report of a run."""
    command = [str(ST), "--config-file", str(CONFIG), "run", f"{url}/openapi.json", "-u", url, "--no-color"]
    report = folder / "report.txt"
    with (
        report.open("wb") as out,
        started([*command, *options], env=environment(), stdout=out, cwd=folder) as process,
    ):
        status = process.wait(patience)
    return status, report.read_text(encoding="utf-8")


SOME = "^/v1/(cusp-tables|verifications|batches|jobs|plot)"
"""Requests for one kind, and for all that follows; with `--long` those for all kinds."""


@pytest.mark.timeout(400)
def test_answers_are_as_the_contract_says(modest_url: str, tmp_path: Path) -> None:
    options = ("--phases=fuzzing,stateful", "--max-examples=1", f"--include-path-regex={SOME}")
    status, report = compared(modest_url, tmp_path, 380, *options)
    assert status == 0, report
    assert "✅  Stateful" in report


@pytest.mark.long
@pytest.mark.timeout(1800)
def test_many_more_answers_are_as_the_contract_says(modest_url: str, tmp_path: Path) -> None:
    status, report = compared(modest_url, tmp_path, 1700, "--max-examples=40")
    assert status == 0, report
