"""What is given away: the wheel, installed by one `pip install` elsewhere, the sdist, and the citation."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tarfile
import tomllib
import venv
import zipfile
from email import message_from_bytes
from pathlib import Path

import httpx
import pytest
import yaml

from service.commit import note_of
from tests.support.processes import PATIENCE, ROOT, started
from tests.support.service_server import GEOMETRY

PACKAGES = ("rpr_solver", "worker", "service")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
DERIVED = shutil.ignore_patterns(
    ".git", ".venv", ".*_cache", ".hypothesis", "build", "dist", "*.egg-info", "__pycache__"
)
OUTSIDE = {
    **{name: value for name, value in os.environ.items() if not name.startswith(("RPR_CUSPS_", "PYTHON"))},
    "SOURCE_DATE_EPOCH": "1700000000",
    "PIP_DISABLE_PIP_VERSION_CHECK": "1",
}

long = pytest.mark.long


def run(*command: str | Path, cwd: Path) -> str:
    """What a command prints that must succeed, of itself and without this checkout on its path."""
    done = subprocess.run(
        [str(word) for word in command], cwd=cwd, env=OUTSIDE, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def built(folder: Path, *options: str) -> Path:
    """Builds a copy of this checkout; gives the folder with what came out."""
    copy, out = folder / "copy", folder / "out"
    shutil.copytree(ROOT, copy, ignore=DERIVED)
    run(sys.executable, "-m", "build", *options, "--outdir", out, copy, cwd=folder)
    return out


@pytest.fixture(scope="module")
def distributions(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("build", reason="needs the extra `dev`")
    return built(tmp_path_factory.mktemp("distributions"))


@pytest.fixture(scope="module")
def wheel(distributions: Path) -> Path:
    [path] = distributions.glob("*.whl")
    return path


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A new environment in which the wheel alone was installed; gives its programs."""
    folder = tmp_path_factory.mktemp("installed")
    venv.create(folder / "venv", with_pip=True)
    programs = folder / "venv" / "bin"
    run(programs / "pip", "install", "--quiet", "-c", ROOT / "constraints.txt", wheel, cwd=folder)
    return programs


def shipped_files() -> set[str]:
    return {
        path.relative_to(ROOT).as_posix()
        for package in PACKAGES
        for path in (ROOT / package).rglob("*")
        if path.is_file() and path.suffix != ".pyc"
    }


@long
def test_the_wheel_holds_the_packages_and_nothing_else(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    information = {name for name in names if ".dist-info/" in name}
    assert names - information == shipped_files()


@long
def test_the_wheel_says_what_it_is(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        [name] = [name for name in archive.namelist() if name.endswith("METADATA")]
        said = message_from_bytes(archive.read(name))
    assert (said["Name"], said["Version"], said["License-Expression"]) == (
        "rpr-cusps",
        PROJECT["version"],
        "MIT",
    )
    assert said["License-File"] == "LICENSE"
    assert said["Description-Content-Type"] == "text/markdown"
    assert str(said.get_payload(decode=True), "utf-8").startswith("# rpr-cusps")
    assert not said.get_all("Project-URL"), "an address must be one that exists"


@long
def test_the_same_source_gives_the_same_wheel(wheel: Path, tmp_path: Path) -> None:
    [again] = built(tmp_path, "--wheel").glob("*.whl")
    assert again.read_bytes() == wheel.read_bytes()


@long
def test_a_commit_gives_one_wheel_that_names_it(tmp_path: Path) -> None:
    """Also by way of the sdist, at any time, and from any clone."""
    wheels = []
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        copy = tmp_path / name / "clone"
        run("git", "clone", "--quiet", ROOT, copy, cwd=tmp_path)
        for path in (copy / "service").glob("*.py"):
            os.utime(path, (0, 1_600_000_000 + len(wheels)))
        words = [sys.executable, "-m", "build", "--outdir", tmp_path / name, copy]
        environment = {key: value for key, value in OUTSIDE.items() if key != "SOURCE_DATE_EPOCH"}
        subprocess.run(words, cwd=tmp_path, env=environment, check=True, capture_output=True)
        wheels += (tmp_path / name).glob("*.whl")
    assert wheels[0].read_bytes() == wheels[1].read_bytes()
    with zipfile.ZipFile(wheels[0]) as archive:
        noted = archive.read("service/commit.txt").decode().split()
    assert noted == run("git", "log", "-1", "--format=%H %ct", cwd=ROOT).split()


def test_the_commit_is_that_of_the_build_or_of_the_checkout(tmp_path: Path) -> None:
    def git(*words: str) -> str:
        who = ("-c", "user.name=a", "-c", "user.email=a@example.com", "-c", "commit.gpgsign=false")
        return run("git", *who, *words, cwd=tmp_path).strip()

    (tmp_path / "service").mkdir()
    assert note_of(tmp_path) is None  # no checkout
    git("init", "--quiet")
    assert note_of(tmp_path) is None  # without a commit
    (tmp_path / "file").write_text("1")
    git("add", "file")
    git("commit", "--quiet", "-m", "One")
    known = git("log", "-1", "--format=%H %ct")
    assert note_of(tmp_path) == known
    git("tag", "v1")
    assert note_of(tmp_path) == known
    (tmp_path / "file").write_text("2")
    assert note_of(tmp_path) == known.replace(" ", "-dirty ")
    (tmp_path / "service" / "commit.txt").write_text("built\n")
    assert note_of(tmp_path) == "built"


@long
def test_the_sdist_holds_what_tests_and_pages_need(distributions: Path) -> None:
    [path] = distributions.glob("*.tar.gz")
    with tarfile.open(path) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    assert shipped_files() <= names
    assert {
        "openapi.yaml",
        "constraints.txt",
        "CITATION.cff",
        "docs/index.md",
        "tests/test_wheel.py",
    } <= names
    assert {"tests/data/golden.json", "examples/passing/.gitlab-ci.yml", "action.yml"} <= names
    assert not [name for name in names if "__pycache__" in name]


@long
@pytest.mark.timeout(400)
def test_the_demo_of_an_installed_wheel(installed: Path, tmp_path: Path) -> None:
    assert run(installed / "rpr-cusps", "--version", cwd=tmp_path).split()[-1] == PROJECT["version"]
    assert "L1 = 14.98: 6 cusps" in run(installed / "rpr-cusps", "demo", cwd=tmp_path)
    where = run(installed / "python", "-c", "import service; print(service.__file__)", cwd=tmp_path)
    assert Path(where.strip()).is_relative_to(installed.parent)


@long
@pytest.mark.timeout(400)
def test_the_service_of_an_installed_wheel(installed: Path, tmp_path: Path) -> None:
    serve = ["rpr-cusps", "serve", "--port", "0", "--workers", "1", "--data-dir", str(tmp_path / "data")]
    command = ["sh", "-c", 'cd "$0" && exec "$@"', str(tmp_path), f"{installed}/{serve[0]}", *serve[1:]]
    with started(command, env=OUTSIDE, stdout=subprocess.PIPE, text=True) as process:
        base = process.stdout.readline().split(" at ")[1].split()[0]
        with httpx.Client(base_url=base, timeout=PATIENCE) as client:
            for page in ("/", "/docs", "/problems", "/schemas/geometry.json", "/openapi.json"):
                assert client.get(page).status_code == 200, page
            question = {"geometry": GEOMETRY, "l1": "14.98", "digits": 20}
            answer = client.post("/v1/cusp-tables", json=question, headers={"Prefer": "wait=30"})
        assert answer.json()["slices"][0]["count"] == 6
        process.terminate()
        assert process.wait(PATIENCE) == 0


def test_the_citation_is_of_this_version() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert {"cff-version", "message", "title", "authors"} <= citation.keys()
    assert str(citation["version"]) == PROJECT["version"]
    assert (citation["license"], citation["title"]) == (PROJECT["license"], PROJECT["name"])
    assert citation["authors"] == PROJECT["authors"]
    assert citation["authors"][0]["name"] in (ROOT / "LICENSE").read_text(encoding="utf-8")
    assert citation["keywords"] == PROJECT["keywords"]
    [article] = citation["references"]
    assert article["title"] in (ROOT / "README.md").read_text(encoding="utf-8").replace("\n", " ")


@long
def test_the_citation_is_valid(tmp_path: Path) -> None:
    """By the checker of the format, in an environment of its own: it needs old libraries."""
    venv.create(tmp_path / "venv", with_pip=True)
    programs = tmp_path / "venv" / "bin"
    run(programs / "pip", "install", "--quiet", "cffconvert==2.0.0", cwd=tmp_path)
    assert "valid" in run(programs / "cffconvert", "--validate", "-i", ROOT / "CITATION.cff", cwd=tmp_path)
