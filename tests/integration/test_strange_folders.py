"""Commands in a folder of a stranger run nothing of it, and answer as elsewhere."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import pytest
import yaml

from rpr_solver import EXAMPLES
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.cli_process import ENVIRONMENT
from tests.support.hostile import put_modules
from tests.support.processes import PATIENCE, ROOT, started, until
from tests.support.sampling import long
from worker.connection import connect
from worker.process.processes import usable_cores

BIN = Path(sys.executable).parent
PROGRAM = str(BIN / "rpr-cusps")


@pytest.fixture(params=[False, long(True)], ids=["files", "packages"])
def mark(tmp_path: Path, request: pytest.FixtureRequest) -> Path:
    """The file in which modules of the folder leave their names; there are robots beside them."""
    folder = tmp_path / "strange"
    robots = folder / "robots"
    robots.mkdir(parents=True)
    for name in ("innocenti", "zein-flat"):
        (robots / f"{name}.json").write_text(json.dumps(EXAMPLES[name].to_json()))
    return put_modules(folder, packages=request.param)


def run(command: Sequence[str], folder: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    environment = {**ENVIRONMENT, "PATH": f"{BIN}:{ENVIRONMENT['PATH']}", **variables}
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=PATIENCE, check=False
    )


def test_the_modules_would_run(mark: Path) -> None:
    """In what Python itself starts they do."""
    run([sys.executable, "-m", "service", "--version"], mark.parent)
    assert mark.read_text()


CHECK = ("check", "robots", "--l1-range", "10:20", "--max-cusps", "4", "--digits", "15")


def test_a_check_as_a_hook(mark: Path) -> None:
    [hook] = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())
    robots = sorted(str(path.relative_to(mark.parent)) for path in mark.parent.glob("robots/*"))
    words = [hook["entry"], *CHECK[2:], "--jobs", "2", *robots]
    done = run(["bash", "-c", " ".join(words)], mark.parent)
    assert (done.returncode, done.stderr) == (1, "")
    assert "2 checked: 1 passed, 1 failed" in done.stdout
    assert not mark.exists()


def shell(scripts: Sequence[str], folder: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    """Runs the scripts of a job; what Python would install is not installed, but the program starts."""
    bin_ = folder.parent / "bin"
    bin_.mkdir()
    words = 'words=; while [ "$1" != install ]; do words="$words $1"; shift; done'
    (bin_ / "python").write_text(f"#!/bin/sh\n{words}\nexec {sys.executable} $words --version\n")
    (bin_ / "python").chmod(0o755)
    path = f"{bin_}:{BIN}:{ENVIRONMENT['PATH']}"
    return run(["bash", "-euo", "pipefail", "-c", "\n".join(scripts)], folder, PATH=path, **variables)


needs_pip = pytest.mark.skipif(find_spec("pip") is None, reason="needs pip")


@needs_pip
@pytest.mark.long
def test_a_job_on_github(mark: Path) -> None:
    _, install, check = yaml.safe_load((ROOT / "action.yml").read_text())["runs"]["steps"]
    inputs = {
        "GEOMETRIES": "robots",
        "REQUIREMENT": " ".join(CHECK[2:]),
        "JUNIT": "c.xml",
        "SARIF": "c.sarif",
    }
    assert inputs.keys() == check["env"].keys()
    done = shell([install["run"], check["run"]], mark.parent, GITHUB_ACTION_PATH=str(ROOT), **inputs)
    assert (done.returncode, done.stderr) == (1, "")
    assert done.stdout.startswith("pip ")
    assert "2 checked: 1 passed, 1 failed" in done.stdout
    assert not mark.exists()


@pytest.mark.long
@needs_pip
def test_a_job_on_gitlab(mark: Path) -> None:
    _, jobs = yaml.safe_load_all((ROOT / "templates/rpr-cusps-check.yml").read_text())
    [job] = jobs.values()
    scripts = [line for line in job["before_script"] if not line.startswith("git ")] + job["script"]
    given = {"geometries": "robots", "requirement": " ".join(CHECK[2:])}
    scripts = [re.sub(r"\$\[\[ inputs\.(\w+) \]\]", lambda name: given[name[1]], line) for line in scripts]
    done = shell(scripts, mark.parent)
    assert (done.returncode, done.stderr) == (1, "")
    assert done.stdout.startswith("pip ")
    assert "2 checked: 1 passed, 1 failed" in done.stdout
    assert not mark.exists()


@pytest.mark.skipif(usable_cores() == 1, reason="an atlas takes other processes where there are more cores")
@pytest.mark.long
def test_an_atlas(mark: Path, tmp_path: Path) -> None:
    target = tmp_path / "atlas.ndjson"
    done = run([PROGRAM, "atlas", "--count", "8", "-o", str(target)], mark.parent)
    assert (done.returncode, done.stderr) == (0, "")
    assert [json.loads(line)["index"] for line in target.read_text().splitlines()] == list(range(8))
    assert not mark.exists()


@pytest.mark.long
def test_the_whole_service(mark: Path) -> None:
    """A supervisor, the API, a worker and its work horse, and Valkey."""
    done = run([PROGRAM, "demo"], mark.parent)
    assert done.returncode == 0, done.stderr
    assert "L1 = 14.98: 6 cusps" in done.stdout
    assert not mark.exists()


@pytest.mark.long
def test_a_worker(mark: Path, valkey: EmbeddedValkey) -> None:
    command = [PROGRAM, "worker", "--redis-url", valkey.url]
    with connect(valkey.url) as client, started(command, cwd=mark.parent, env=ENVIRONMENT) as process:
        until(lambda: client.keys(f"rq:worker:*-{process.pid}-*"))
        process.terminate()
        process.wait(PATIENCE)
    assert not mark.exists()
