"""`rpr-cusps check` as a build server runs it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from fractions import Fraction
from pathlib import Path
from xml.etree import ElementTree

import pytest

from rpr_solver import EXAMPLES, Manipulator, Requirement, check, cusp_table
from tests.support.cli_process import ENVIRONMENT, Run, command, run
from tests.support.processes import PATIENCE, descendants, is_running, started, until

MANY = ("--l1-range", "1:10", "--digits", "15")
RANGE = (*MANY, "--jobs", "1")
"""In this process: to start others takes longer than what they would do."""
ZEIN = json.dumps(EXAMPLES["zein-flat"].to_json())


@pytest.fixture
def designs(tmp_path: Path) -> Path:
    """A folder with two geometries, an invalid one, and another file."""
    folder = tmp_path / "designs"
    folder.mkdir()
    turned = json.dumps({**EXAMPLES["zein-flat"].to_json(), "orientation": "cw"})
    wrong = '{"a2x": 1, "a3x": 2}'
    for name, text in (("b.json", ZEIN), ("a.json", turned), ("c.json", wrong), ("notes.txt", "{")):
        (folder / name).write_text(text)
    return folder


def test_a_requirement_that_holds(run_here: Run) -> None:
    done = run_here("check", "zein-flat", *RANGE, "--max-cusps", "4", "--format", "json")
    assert (done.returncode, done.stderr) == (0, "1 checked: 1 passed, 0 failed\n")
    printed = json.loads(done.stdout)
    requirement = Requirement.from_json({"range": {"from": "1", "to": "10"}, "max_cusps": 4})
    assert printed["requirement"] == requirement.to_json()
    report = check(EXAMPLES["zein-flat"], requirement, digits=15).to_json()
    assert printed["checks"] == [{"source": "zein-flat", "passed": True, "report": report}]


def test_a_requirement_that_does_not_hold(run_here: Run) -> None:
    done = run_here("check", "zein-flat", *RANGE, "--max-cusps", "3")
    assert (done.returncode, done.stderr) == (1, "")
    assert "zein-flat: failed: 4 cusps at L1 = " in done.stdout
    assert "::error" not in done.stdout


CONGRUENT = '{"a2x": 30, "a3x": 0, "a3y": 40, "d1": 30, "d2": 50, "d3": 40}'


@pytest.mark.parametrize("what", [("--l1-range", "5:9", "--max-cusps", "0")])
def test_nothing_degenerate_passes_without_a_word(run_here: Run, what: tuple[str, ...]) -> None:
    allowed = run_here("check", "-", *what, "--github", stdin=CONGRUENT)
    assert (allowed.returncode, allowed.stderr) == (0, "")
    assert "standard input: passed, 0 cusps\n  degenerate: curve of degenerate poses " in allowed.stdout
    assert "::warning title=standard input%3A degenerate::curve of degenerate poses " in allowed.stdout
    refused = run_here("check", "-", *what, "--degenerate", "refused", stdin=CONGRUENT)
    assert (refused.returncode, refused.stderr) == (1, "")
    assert "failed: degenerate, which is refused: curve" in refused.stdout
    wrong = run_here("check", "-", *what, "--degenerate", "no", stdin=CONGRUENT)
    assert (wrong.returncode, wrong.stdout) == (2, "")
    said = "argument --degenerate: invalid choice: 'no'; choose from allowed, refused"
    assert wrong.stderr == f"rpr-cusps check: {said}; see rpr-cusps check --help\n"


def test_a_folder_in_parallel_with_all_reports(designs: Path) -> None:
    report = designs.parent / "report.xml"
    done = run("check", str(designs), *MANY, "--max-cusps", "4", "--jobs", "2", "--junit", str(report))
    assert done.returncode == 2
    assert done.stderr == ""
    assert done.stdout.count("c.json: bad input: ") == 1
    assert done.stdout.splitlines()[-1] == "3 checked: 2 passed, 0 failed, 1 bad; 3 files read"
    titles = [line for line in done.stdout.splitlines() if line.startswith(str(designs))]
    assert [Path(line.split(":")[0]).name for line in titles] == ["a.json", "b.json", "c.json"]
    cases = ElementTree.parse(report).findall("testsuite/testcase")
    assert [Path(case.get("name", "")).name for case in cases] == ["a.json", "b.json", "c.json"]
    assert [child.tag for case in cases for child in case] == ["error"]


def test_annotations_on_github_leave_the_json_whole(run_here: Run) -> None:
    args = ("check", "-", *RANGE, "--min-cusps", "3")
    shown = run_here(*args, "--github", stdin=ZEIN)
    assert shown.stdout.splitlines()[-1].startswith(
        "::error title=standard input%3A check failed::2 cusps at L1 = "
    )
    machine = run_here(*args, "--format", "json", stdin=ZEIN, GITHUB_ACTIONS="true")
    assert json.loads(machine.stdout)["passed"] is False
    assert machine.stderr.splitlines()[1].startswith("::error ")
    assert (shown.returncode, machine.returncode) == (1, 1)


@pytest.mark.parametrize(
    ("args", "said"),
    [
        ((), "--l1-range: is missing"),
        (("--l1-range", "1:2", "--max-cusps", "1", "--jobs", "0"), "--jobs: is 0"),
        (("--l1", "0", "--expect-cusps", "1"), "--l1: is 0; a leg length must be > 0"),
        (("--l1-range", "1:2", "--max-cusps", "1", "--expect-cusps", "1"), "give no other"),
    ],
)
def test_a_bad_option_is_one_line_and_status_2(run_here: Run, args: tuple[str, ...], said: str) -> None:
    done = run_here("check", "zein-flat", *args)
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr
    assert done.stderr.count("\n") == 1


def test_a_file_name_that_is_no_text(tmp_path: Path) -> None:
    (tmp_path / os.fsdecode(b"a\xff.json")).write_text(ZEIN)
    (tmp_path / os.fsdecode(b"b\xff.json")).write_text("{")
    (tmp_path / os.fsdecode(b"c\xff.json")).write_text("{}")
    report = tmp_path / "report.xml"
    done = run("check", str(tmp_path), *RANGE, "--max-cusps", "4", "--github", "--junit", str(report))
    assert done.returncode == 2
    assert "a\ufffd.json: passed" in done.stdout
    assert done.stdout.count("1 ignored without a geometry: ") == done.stdout.count("c\ufffd.json") == 1
    assert len(ElementTree.parse(report).findall("testsuite/testcase")) == 2


def test_single_slices(run_here: Run) -> None:
    args = ("check", "zein-flat", "--l1", "14.98", "--l1", "69/2", "--digits", "15")
    done = run_here(*args, "--expect-cusps", "4")
    assert (done.returncode, done.stderr) == (1, "")
    assert done.stdout.startswith("cusps at L1 = 14.98, 34.5: 4 expected\n")
    assert "zein-flat: failed: 8 cusps at L1 = 34.5, 4 expected; the first: alpha_deg = " in done.stdout
    done = run_here(*args[:4], "--expect-cusps", "4", "--format", "json")
    report = json.loads(done.stdout)["checks"][0]["report"]
    assert report["requirement"] == {
        "fixed_leg": 1,
        "l1": ["14.98"],
        "expect_cusps": 4,
        "degenerate": "allowed",
    }
    assert report["slices"] == [{"l1": "14.98", "count": 4}]
    assert (done.returncode, report["violations"]) == (0, [])


def test_reports_are_opened_before_the_work(run_here: Run, tmp_path: Path) -> None:
    missing = str(tmp_path / "none" / "report")
    for option in ("--junit", "--sarif"):
        done = run_here("check", "innocenti", "--l1-range", "1:50", "--max-cusps", "6", option, missing)
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr.startswith(f"rpr-cusps check: {option}: {missing!r} cannot be written")


def test_a_report_on_a_full_disk_is_one_line() -> None:
    done = run("check", "zein-flat", "--l1", "1", "--expect-cusps", "4", "--junit", "/dev/full")
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == "rpr-cusps check: cannot write to '/dev/full': No space left on device\n"


def test_a_fault_in_a_file_is_annotated_at_its_line(run_here: Run, tmp_path: Path) -> None:
    for name, text in {
        "a": '{"a2x": 1,\n"a3x": 1,\n"a3x": 1}',
        "b": ZEIN.replace('"d1": "', '\n"d1": "-'),
        "c": "{\n\n!}",
    }.items():
        (tmp_path / f"{name}.json").write_text(text)
    done = run_here("check", str(tmp_path), *RANGE, "--max-cusps", "4", "--github")
    found = [line.split(",")[:2] for line in done.stdout.splitlines() if line.startswith("::error")]
    lines = [(Path(file).name, line) for file, line in found]
    assert lines == [("a.json", "line=3"), ("b.json", "line=2"), ("c.json", "line=3")]
    assert done.stdout.count("a.json") == 2


def test_a_folder_without_a_geometry_is_bad_input(run_here: Run, tmp_path: Path) -> None:
    done = run_here("check", str(tmp_path), *RANGE, "--max-cusps", "4")
    assert (done.returncode, done.stdout) == (2, "")
    assert "has no *.json" in done.stderr
    (tmp_path / "package.json").write_text('{"name": "robots"}')
    done = run_here("check", str(tmp_path), "zein-flat", *RANGE, "--max-cusps", "4")
    assert (done.returncode, done.stdout) == (2, "")
    assert "has no geometry in its JSON files: " in done.stderr


OTHERS = {
    "package.json": '{"name": "robots", "version": "1.0.0"}',
    "place.json": '{"type": "Feature", "geometry": {"type": "Point", "coordinates": [1, 2]}}',
    "list.json": "[]",
    "tsconfig.json": '{"compilerOptions": {}, // as TypeScript has it\n}',
}
"""JSON that is no geometry, the last in the loose way of some programs."""


def test_a_folder_is_read_with_all_folders_in_it(run_here: Run, tmp_path: Path) -> None:
    """A violation in the lowest folder is found; what is no geometry is ignored, and named."""
    deep = tmp_path / "sub" / "deeper"
    deep.mkdir(parents=True)
    (tmp_path / ".hidden").mkdir()
    (deep / "loop").symlink_to(tmp_path)
    for path in (tmp_path / "top.json", deep / "bad.JSON", tmp_path / ".hidden" / "not-seen.json"):
        path.write_text(ZEIN)
    for name, text in OTHERS.items():
        (tmp_path / "sub" / name).write_text(text)
    done = run_here("check", str(tmp_path), *RANGE, "--max-cusps", "3")
    assert (done.returncode, done.stderr) == (1, "")
    titles = [Path(line.split(":")[0]).name for line in done.stdout.splitlines() if ": failed: " in line]
    assert titles == ["top.json", "bad.JSON"]
    last = done.stdout.splitlines()[-1]
    assert last.startswith("2 checked: 0 passed, 2 failed; 6 files read, 4 ignored without a geometry: ")
    assert [Path(name).name for name in last.partition("geometry: ")[2].split(", ")] == sorted(OTHERS)
    for name in OTHERS:
        named = run_here("check", str(tmp_path / "sub" / name), *RANGE, "--max-cusps", "4")
        assert (named.returncode, named.stdout.count("bad input")) == (2, 1)


def test_a_file_that_is_named_is_read_once(run_here: Run, tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(ZEIN)
    (tmp_path / "b.json").write_text("{}")
    args = ("check", str(tmp_path), f"{tmp_path}/./a.json", *RANGE, "--max-cusps", "4")
    done = run_here(*args, "--format", "json")
    assert (
        done.stderr
        == f"1 checked: 1 passed, 0 failed; 2 files read, 1 ignored without a geometry: {tmp_path}/b.json\n"
    )
    printed = json.loads(done.stdout)
    assert (len(printed["checks"]), printed["files"], printed["ignored"]) == (1, 2, [f"{tmp_path}/b.json"])
    done = run_here("check", str(tmp_path / "b.json"), *args[1:])
    assert (done.returncode, done.stdout.splitlines()[-1]) == (
        2,
        "2 checked: 1 passed, 0 failed, 1 bad; 2 files read",
    )


def test_files_without_a_geometry_are_ignored_where_they_are_named(run_here: Run, tmp_path: Path) -> None:
    names = []
    for name, text in {**OTHERS, "broken.json": '{"a2x": 1'}.items():
        (tmp_path / name).write_text(text)
        names.append(str(tmp_path / name))
    done = run_here("check", "--ignore-others", *names[:-1], *RANGE, "--max-cusps", "4")
    assert (done.returncode, done.stderr) == (0, "")
    assert "0 checked: 0 passed, 0 failed; 4 files read, 4 ignored without a geometry" in done.stdout
    done = run_here("check", "--ignore-others", *names, *RANGE, "--max-cusps", "4")
    assert done.returncode == 2
    assert "broken.json: bad input: " in done.stdout


def test_a_name_and_a_unit_are_in_every_report(run_here: Run, tmp_path: Path) -> None:
    named = {"name": "Gripper <2>", "unit": "mm", **EXAMPLES["zein-flat"].to_json()}
    (tmp_path / "a.json").write_text(json.dumps(named))
    beside = {"name": "Gripper <2>", "unit": "mm", "geometry": EXAMPLES["zein-flat"].to_json()}
    (tmp_path / "b.json").write_text(json.dumps(beside))
    report, log = tmp_path / "r.xml", tmp_path / "r.sarif"
    files = ("--junit", str(report), "--sarif", str(log))
    done = run_here("check", str(tmp_path), *RANGE, "--max-cusps", "3", *files, "--github")
    assert done.stdout.count(".json (Gripper <2>, mm): failed: ") == 2
    properties = [(x.get("name"), x.get("value")) for x in ElementTree.parse(report).iter("property")]
    assert properties == [("name", "Gripper <2>"), ("unit", "mm")] * 2
    results = json.loads(log.read_text())["runs"][0]["results"]
    assert all(".json (Gripper <2>, mm): " in result["message"]["text"] for result in results)
    assert len({result["partialFingerprints"]["geometryAndRequirement/v1"] for result in results}) == 2
    printed = json.loads(
        run_here("check", str(tmp_path), *RANGE, "--max-cusps", "3", "--format", "json").stdout
    )
    for part in printed["checks"]:
        assert (part["name"], part["unit"]) == ("Gripper <2>", "mm")
        assert part["report"]["geometry_hash"] == EXAMPLES["zein-flat"].geometry_hash
    (tmp_path / "a.json").write_text(json.dumps({**named, "name": "\x1b[31m red\n", "unit": ""}))
    done = run_here("check", str(tmp_path / "a.json"), *RANGE, "--max-cusps", "4")
    assert "a.json ([31m red): passed" in done.stdout
    (tmp_path / "a.json").write_text(json.dumps({**named, "name": 5}))
    done = run_here("check", str(tmp_path / "a.json"), *RANGE, "--max-cusps", "3")
    assert (done.returncode, "geometry.name: is 5; give a text" in done.stdout) == (2, True)


IN_TOLERANCE = ("--l1-range", "21:26", "--max-cusps", "6", "--digits", "15")


def test_a_tolerance_is_proved_or_refuted(run_here: Run, tmp_path: Path) -> None:
    """One proof, one counter-example; and the nominal failure of another geometry needs no search."""
    narrow = ("--l1-range", "23:24", *IN_TOLERANCE[2:])
    done = run_here("check", "innocenti", *narrow, "--tolerance", "0.001", "--format", "json")
    assert (done.returncode, done.stderr) == (0, "1 checked: 1 passed, 0 failed\n")
    printed = json.loads(done.stdout)
    assert printed["requirement"]["tolerance"] == dict.fromkeys(
        ("a2x", "a3x", "a3y", "d1", "d2", "d3"), "0.001"
    )
    assert printed["checks"][0]["report"]["margin"]["verdict"] == "proved"
    report, log = tmp_path / "r.xml", tmp_path / "r.sarif"
    files = ("--junit", str(report), "--sarif", str(log), "--jobs", "1")
    done = run_here("check", "innocenti", "zein-flat", *IN_TOLERANCE, "--tolerance", "0.2", *files)
    assert done.returncode == 1
    assert "2 checked: 0 passed, 2 failed" in done.stdout
    first, second = ElementTree.parse(report).iter("failure")
    assert (first.get("type"), second.get("type")) == ("tolerance", "requirement")
    result = json.loads(log.read_text())["runs"][0]["results"][0]
    example = result["properties"]["counterexample"]
    other = Manipulator.from_json(example["geometry"])
    sides = ("a2x", "a3x", "a3y", "d1", "d2", "d3")
    changes = [abs(getattr(other, g) - getattr(EXAMPLES["innocenti"], g)) for g in sides]
    assert max(changes) <= Fraction("0.2")
    [slice_] = cusp_table(other, example["l1"], digits=15)
    assert slice_.count == example["count"] > 6


@pytest.mark.parametrize("sides", [(15, 25, 20)], ids=["similar"])
def test_degenerate_families_are_open_within_any_tolerance(run_here: Run, sides: tuple[int, ...]) -> None:
    geometry = {"a2x": 30, "a3x": 0, "a3y": 40, **dict(zip(("d1", "d2", "d3"), sides, strict=True))}
    args = ("--l1-range", "10:20", "--max-cusps", "0", "--tolerance", "0.001", "--github")
    done = run_here("check", "-", *args, stdin=json.dumps(geometry))
    assert done.returncode == 1
    assert "standard input: open: neither proved nor refuted within the tolerance: degenerate" in done.stdout
    assert "title=standard input%3A check open::" in done.stdout


@pytest.mark.parametrize(
    ("tolerance", "said"),
    [
        ("d1=0", "--tolerance: are all 0, so that nothing changes; give one > 0"),
        ("b=1", "--tolerance.b: unknown field"),
    ],
)
def test_wrong_tolerances_are_named(run_here: Run, tolerance: str, said: str) -> None:
    done = run_here("check", "innocenti", *IN_TOLERANCE, "--tolerance", tolerance)
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr


def test_ctrl_c_ends_all_processes() -> None:
    with started(
        command("check", *["fourteen-cusps"] * 8, "--l1-range", "1:10", "--max-cusps", "4", "--jobs", "2"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=ENVIRONMENT,
    ) as process:
        until(lambda: len(descendants(process.pid)) >= 3)
        running = descendants(process.pid)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=PATIENCE)
    assert (process.returncode, out, err) == (130, b"", b"")
    until(lambda: not any(is_running(pid) for pid in running))


TRIANGLES = '{"base":\n{"points": [[1, 2], [4, 6], [1, 10]]},\n"platform":\n{"sides": [3, 4, 5]}}'


def test_files_with_triangles_are_found_and_faults_are_at_their_lines(run_here: Run, tmp_path: Path) -> None:
    (tmp_path / "drawn.json").write_text(TRIANGLES)
    (tmp_path / "wrong.json").write_text(TRIANGLES.replace("5", "9"))
    (tmp_path / "broken.json").write_text(TRIANGLES + "}")
    done = run_here("check", str(tmp_path), "--l1", "5", "--expect-cusps", "6", "--github")
    assert done.returncode == 2
    assert "drawn.json: passed" in done.stdout
    found = [line.split(",")[:2] for line in done.stdout.splitlines() if line.startswith("::error")]
    lines = {Path(file).name: line for file, line in found}
    assert lines == {"wrong.json": "line=4", "broken.json": "line=4"}
