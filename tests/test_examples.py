"""The examples of CI, run as GitHub, GitLab and pre-commit would run them."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import jsonschema_rs
import pytest
import yaml

from tests.support.cli_process import ENVIRONMENT
from tests.support.processes import PATIENCE, ROOT
from tests.support.sampling import long, sample

EXPECTED = {"passing": 0, "failing": 1}
BIN = Path(sys.executable).parent


@pytest.fixture
def example(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """A copy of an example."""
    folder = tmp_path / request.param
    shutil.copytree(ROOT / "examples" / request.param, folder)
    return folder


def loaded(path: Path) -> Any:
    return yaml.safe_load(path.read_text(encoding="utf-8"))


def bash(script: str, folder: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(BIN), ENVIRONMENT["PATH"]])
    return subprocess.run(
        ["bash", "-euo", "pipefail", "-c", script],
        cwd=folder,
        env={**ENVIRONMENT, "PATH": path, **variables},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )


@pytest.mark.parametrize("example", sample(EXPECTED, 1), indirect=True)
def test_on_github(example: Path) -> None:
    [_, step, upload] = loaded(example / ".github/workflows/cusps.yml")["jobs"]["check"]["steps"]
    action = loaded(ROOT / "action.yml")
    given = {name: part.get("default") for name, part in action["inputs"].items()} | step["with"]
    assert given.keys() == action["inputs"].keys()
    check = action["runs"]["steps"][-1]
    variables = {
        name: given[re.fullmatch(r"\$\{\{ inputs\.(\S+) \}\}", value)[1]]  # type: ignore[index]
        for name, value in check["env"].items()
    }
    done = bash(check["run"], example, GITHUB_ACTIONS="true", **variables)
    assert (done.returncode, done.stderr) == (EXPECTED[example.name], "")
    annotations = [line for line in done.stdout.splitlines() if line.startswith("::error")]
    assert (upload["if"], upload["with"]["sarif_file"]) == ("always()", given["sarif"])
    cases = ElementTree.parse(example / given["junit"]).findall("testsuite/testcase")
    results = json.loads((example / given["sarif"]).read_text())["runs"][0]["results"]
    assert len(cases) == 2
    assert len(annotations) == len(results) == done.returncode
    if annotations:
        assert annotations[0].startswith(
            "::error file=robots/gripper.json,line=1,title=check failed::6 cusps"
        )
        [place] = results[0]["locations"]
        assert place["physicalLocation"]["artifactLocation"]["uri"] == "robots/gripper.json"


def gitlab_job(example: Path) -> dict[str, Any]:
    """The job of an example for GitLab, with its inputs in their places."""
    [include] = loaded(example / ".gitlab-ci.yml")["include"]
    name = include["component"].rpartition("/")[2].partition("@")[0]
    spec, jobs = (ROOT / "templates" / f"{name}.yml").read_text(encoding="utf-8").split("---\n")
    inputs = yaml.safe_load(spec)["spec"]["inputs"]
    given = {key: part.get("default") for key, part in inputs.items()} | include["inputs"]
    assert given.keys() == inputs.keys()
    for key, value in given.items():
        jobs = jobs.replace(f"$[[ inputs.{key} ]]", value)
    assert "$[[" not in jobs
    [job] = yaml.safe_load(jobs).values()
    return dict(job)


@pytest.mark.parametrize("example", [long("passing"), long("failing")], indirect=True)
def test_on_gitlab(example: Path) -> None:
    job = gitlab_job(example)
    done = bash("\n".join(job["script"]), example)
    assert (done.returncode, done.stderr) == (EXPECTED[example.name], "")
    assert (example / job["artifacts"]["reports"]["junit"]).is_file()


@pytest.mark.parametrize("example", EXPECTED, indirect=True)
def test_gitlab_asks_what_github_asks(example: Path) -> None:
    """The command alone, which the test above runs, too."""
    job = gitlab_job(example)
    recorded = "rpr-cusps() { printf '%s\\n' \"$@\"; }\n" + "\n".join(job["script"])
    [_, step, _] = loaded(example / ".github/workflows/cusps.yml")["jobs"]["check"]["steps"]
    report = job["artifacts"]["reports"]["junit"]
    asked = [*step["with"]["geometries"].split(), *step["with"]["requirement"].split()]
    assert bash(recorded, example).stdout.split("\n") == ["check", *asked, "--junit", report, ""]


@pytest.mark.parametrize("example", EXPECTED, indirect=True)
def test_gitlab_has_a_schema_for_it(example: Path) -> None:
    folder = pytest.importorskip("check_jsonschema", reason="needs the extra `dev`").__file__
    schema = loaded(Path(folder).parent / "builtin_schemas/vendor/gitlab-ci.json")
    validator = jsonschema_rs.validator_for(schema)
    job = gitlab_job(example)
    validator.validate(loaded(example / ".gitlab-ci.yml"))
    validator.validate({"job": job})
    assert not validator.is_valid({"job": {**job, "script": None}})


@pytest.mark.parametrize("example", [long("passing"), "failing"], indirect=True)
def test_with_pre_commit(example: Path) -> None:
    [repository] = loaded(example / ".pre-commit-config.yaml")["repos"]
    [hook] = repository["hooks"]
    [known] = [entry for entry in loaded(ROOT / ".pre-commit-hooks.yaml") if entry["id"] == hook["id"]]
    (example / "robots/package.json").write_text('{"name": "robots", "version": "1.0.0"}')
    files = [str(path.relative_to(example)) for path in sorted(example.rglob("*.json"))]
    chosen = [name for name in files if re.search(hook["files"], name)]
    script = " ".join([known["entry"], *hook["args"], *chosen])
    done = bash(script, example)
    assert done.returncode == EXPECTED[example.name]
    last = done.stdout.splitlines()[-1]
    assert last.startswith("2 checked: ")
    assert last.endswith("3 files read, 1 ignored without a geometry: robots/package.json")


def test_gitlab_installs_the_given_commit_with_its_constraints(tmp_path: Path) -> None:
    """All but the installation itself, whose command is recorded: no bare name is asked of a registry."""
    copy, bin_ = tmp_path / "copy", tmp_path / "bin"
    bin_.mkdir()
    (bin_ / "python").write_text('#!/bin/sh\necho "$@"\ncat "$7"\n')
    (bin_ / "python").chmod(0o755)
    git = f"git -C {copy} -c user.name=a -c user.email=a@example.com"
    made = (
        f"git init -q {copy} && echo first > {copy}/constraints.txt && {git} add . && {git} commit -qm first"
    )
    later = f"{git} rev-parse HEAD && echo second > {copy}/constraints.txt && {git} commit -qam second"
    commit = bash(f"{made} && {later}", tmp_path).stdout.strip()
    spec, jobs = yaml.safe_load_all((ROOT / "templates/rpr-cusps-check.yml").read_text(encoding="utf-8"))
    required = {name for name, part in spec["spec"]["inputs"].items() if "default" not in (part or {})}
    assert required == {"requirement", "repository", "ref"}
    script = "\n".join(jobs["rpr-cusps-check"]["before_script"]).replace(
        "/tmp/rpr-cusps", str(tmp_path / "got")
    )
    script = script.replace("$[[ inputs.repository ]]", copy.as_uri()).replace("$[[ inputs.ref ]]", commit)
    done = bash(f"PATH={bin_}:$PATH\n{script}", tmp_path)
    got = tmp_path / "got"
    assert done.stdout.splitlines() == [f"-P -m pip install --quiet -c {got}/constraints.txt {got}", "first"]
