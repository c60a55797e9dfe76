"""A rounded special machine: the first line of every form says what holds for the exact one."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import pytest

from service.cli.arguments import Found
from service.cli.check.ci_formats import github_annotations, junit_xml, sarif
from service.cli.check.reports import Outcome, page
from tests.service.cli.test_check_reports import BAD, GOOD, REQUIREMENT
from tests.support.cli_process import Run

ROUNDED = {
    "a2x": 10, "a3x": 5, "a3y": "8.660254037844386",
    "d1": "1.7320508075688772", "d2": "1.7320508075688772", "d3": "1.7320508075688772",
}  # fmt: skip
HARMLESS = {"a2x": 7, "a3x": 2, "a3y": 5, "d1": 3, "d2": "3.0006", "d3": 4}


@pytest.fixture
def machine(tmp_path: Path) -> str:
    """An equilateral platform in an equilateral base, with 16 digits."""
    file = tmp_path / "rounded.json"
    file.write_text(json.dumps(ROUNDED), encoding="utf-8")
    return str(file)


def is_told(line: str) -> bool:
    return "no slice has a cusp, and the assembly mode never changes" in line and '"sqrt(3)"' in line


@pytest.mark.parametrize(
    "command",
    [
        ("solve", "--l1", "5", "--digits", "15"),
        ("poses", "--l1", "5", "--l2", "6", "--l3", "7", "--digits", "15"),
    ],
)
def test_text_begins_with_it(run_here: Run, machine: str, command: tuple[str, ...]) -> None:
    name, *options = command
    done = run_here(name, machine, *options)
    first, second, *_ = done.stdout.splitlines()
    assert is_told(first)
    assert second.startswith("3-RPR manipulator")
    document = json.loads(run_here(name, machine, *options, "--format", "json").stdout)
    assert document["near"][0]["shape"] == "similar"


def test_forms_without_a_place_leave_it_to_stderr_or_to_the_head(run_here: Run, machine: str) -> None:
    options = ("--l1", "5", "--digits", "15")
    csv = run_here("solve", machine, *options, "--format", "csv")
    assert csv.stdout.splitlines()[0].startswith("l1,count,cusp")
    assert is_told(csv.stderr)
    lines = run_here("solve", machine, *options, "--format", "ndjson").stdout.splitlines()
    assert all(json.loads(line)["near"][0]["shape"] == "similar" for line in lines)
    assert is_told(run_here("solve", machine, *options, "--format", "latex").stdout.splitlines()[0])


def test_harmless_shapes_are_in_json_alone(run_here: Run, tmp_path: Path) -> None:
    file = tmp_path / "harmless.json"
    file.write_text(json.dumps(HARMLESS), encoding="utf-8")
    done = run_here("solve", str(file), "--l1", "5", "--digits", "15")
    assert done.stdout.startswith("3-RPR manipulator")
    answer = run_here("solve", str(file), "--l1", "5", "--digits", "15", "--format", "json")
    assert json.loads(answer.stdout)["near"][0]["shape"] == "isosceles"


SIMILAR = {
    "shape": "similar",
    "distance": "2.0e-17",
    "says": "no slice has a cusp, and the assembly mode never changes without a singularity",
    "spelling": {"base": {"equilateral": "10"}, "platform": {"equilateral": "sqrt(3)"}},
    "effect": "contradicts",
}
FAILED = Outcome("near.json", {**BAD.report, "near": [SIMILAR]}, line=2)
QUIET = Outcome("far.json", {**GOOD.report, "near": [{**SIMILAR, "effect": "harmless"}]}, line=2)


@pytest.mark.parametrize("outcome", [FAILED])
def test_reports_of_checks_begin_with_it(outcome: Outcome) -> None:
    outcomes = [GOOD, outcome, QUIET]
    [first] = page(outcomes, REQUIREMENT, Found(())).first
    assert is_told(first)
    annotation, *_ = github_annotations([outcome])
    assert annotation.startswith("::warning file=near.json")
    assert is_told(annotation)
    results = json.loads(sarif(outcomes))["runs"][0]["results"]
    assert results[0]["ruleId"] == "near-special-shape"
    assert is_told(results[0]["message"]["text"])
    assert results[0]["locations"][0]["physicalLocation"]["artifactLocation"]["uri"] == "near.json"
    cases = ElementTree.fromstring(junit_xml(outcomes)).findall(".//testcase")
    said = [[p.get("value") for p in case.findall(".//property[@name='near']")] for case in cases]
    assert [len(words) for words in said] == [0, 1, 0]
    assert is_told(str(said[1][0]))
    failure = cases[1].find("failure")
    assert failure is None or is_told(str(failure.text).splitlines()[0])
