"""The outcome of checks as text, JUnit XML and GitHub annotations."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from typing import Any
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import exact_str
from service.cli.arguments import Found
from service.cli.check.ci_formats import github_annotations, junit_xml, sarif
from service.cli.check.reports import Outcome, apart, page

pytestmark = pytest.mark.quick

REQUIREMENT: dict[str, Any] = {
    "fixed_leg": 2,
    "range": {"from": "1", "to": None},
    "max_cusps": 2,
    "min_cusps": None,
    "limits": {"l1": {"min": "5", "max": None}},
}
NOTHING = Found(())
CUSP = {"alpha_deg": "1.5", "theta2_deg": "-2.5", "l1": "3.5", "l3": "4.5"}
VIOLATION = {"from": "7", "to": None, "count": 4, "example": {"l2": "8", "cusps": [CUSP] * 4}}
FAILED_REPORT = {
    "requirement": REQUIREMENT,
    "passed": False,
    "max_cusps_found": 4,
    "min_cusps_found": 0,
    "violations": [VIOLATION],
}
PASSED_REPORT = {**FAILED_REPORT, "passed": True, "max_cusps_found": 0, "violations": []}

GOOD = Outcome("good.json", PASSED_REPORT, seconds=0.25)
BAD = Outcome("a/bad.json", FAILED_REPORT, seconds=0.5, line=7)
FAULTY = Outcome("b d.json", error={"type": "input-error", "detail": "no"}, line=3)
CURVE = {"kind": "curve", "from": "1", "to": None, "equation": "alpha = 0 deg"}
ODD = Outcome("odd.json", {**PASSED_REPORT, "degenerate": [CURVE]}, line=2)
SAID = "curve of degenerate poses in every slice for L2 from 1: alpha = 0 deg"
LOST = Outcome("lost.json", error={"type": "solver-error", "detail": "two\nlines"})


def test_junit_has_a_case_for_each_geometry() -> None:
    suite = ElementTree.fromstring(junit_xml([GOOD, BAD, LOST])).find("testsuite")
    assert suite is not None
    assert (suite.get("tests"), suite.get("failures"), suite.get("errors")) == ("3", "1", "1")
    good, bad, lost = suite.findall("testcase")
    assert (good.get("name"), good.get("time"), len(good)) == ("good.json", "0.250", 0)
    assert [child.tag for child in (*bad, *lost)] == ["failure", "error"]
    assert bad[0].get("message") == BAD.message
    assert bad[0].text == "from to cusps\n7 ∞ 4"


def test_sarif_has_a_result_for_each_geometry_that_does_not_pass() -> None:
    log = json.loads(sarif([GOOD, BAD, LOST, FAULTY]))
    [run] = log["runs"]
    assert log["version"] == "2.1.0"
    rules = {rule["id"] for rule in run["tool"]["driver"]["rules"]}
    assert [result["ruleId"] for result in run["results"]] == ["requirement", "no-answer", "input-error"]
    assert {result["ruleId"] for result in run["results"]} <= rules
    places = [result["locations"][0]["physicalLocation"] for result in run["results"]]
    assert places[0] == {"artifactLocation": {"uri": "a/bad.json"}, "region": {"startLine": 7}}
    assert places[2] == {"artifactLocation": {"uri": "b%20d.json"}, "region": {"startLine": 3}}
    assert run["results"][0]["message"]["text"] == f"a/bad.json: {BAD.message}"


NARROW = ("10", "10.9056632492710", "10.9056666270906", "14.5792206267995", "14.5792206353915", "20")


def test_numbers_are_readable_and_tell_narrow_windows_apart() -> None:
    """Each transition is written alike in all rows, and the example lies in its window."""
    violations = [
        {"from": a, "to": b, "count": 6, "example": {"l2": a, "cusps": []}} for a, b in pairwise(NARROW)
    ]
    case = ElementTree.fromstring(junit_xml([Outcome("a.json", {**FAILED_REPORT, "violations": violations})]))
    [failure] = case.iter("failure")
    assert (failure.text or "").splitlines()[1:] == [
        "10 10.9056632 6",
        "10.9056632 10.9056666 6",
        "10.9056666 14.579220627 6",
        "14.579220627 14.579220635 6",
        "14.579220635 20 6",
    ]
    example = {**violations[1], "example": {"l2": "10.90566412345", "cusps": []}}
    assert "6 cusps at L2 = 10.905664," in Outcome("a", {**FAILED_REPORT, "violations": [example]}).message


def test_junit_has_the_clearance_of_a_change_of_mode() -> None:
    witness = {"l1": "27", "l2": "29", "l3": "29.8", "from": 4, "to": 3}
    witness |= {"path": {"clearance": {"asked": "0.5", "proved": "43.976", "bound": None}}}
    found = {"change": "possible", "witness": witness, "reason": None, "certificate": {}}
    asked = {"mode_change": "required", "clearance": "0.5", "max_cusps": None, "min_cusps": None}
    report = {**FAILED_REPORT, "violations": [], "mode_change": found}
    for change, passed in (("required", True), ("excluded", False)):
        requirement = {**FAILED_REPORT["requirement"], **asked, "mode_change": change}
        outcome = Outcome("a.json", {**report, "passed": passed, "requirement": requirement})
        suite = ElementTree.fromstring(junit_xml([outcome]))
        assert len(list(suite.iter("failure"))) == (not passed)
        text = ElementTree.tostring(suite, encoding="unicode")
        assert "43.976" in text


@given(st.fractions(0, 10**4), st.fractions(0, 10**4))
def test_the_shown_ends_of_an_interval_show_its_width(a: Fraction, b: Fraction) -> None:
    low, high = sorted((exact_str(a), exact_str(b)), key=Fraction)
    shown = [Fraction(end or "0") for end in apart(low, high)]
    width = Fraction(high) - Fraction(low)
    assert abs(shown[1] - shown[0] - width) <= width / 10


def test_sarif_says_what_to_know_about_each_rule_and_knows_a_complaint_again() -> None:
    run = json.loads(sarif([BAD, FAULTY, LOST]))["runs"][0]
    assert all(rule["help"]["text"] for rule in run["tool"]["driver"]["rules"])

    def prints(*outcomes: Outcome) -> list[str]:
        results = json.loads(sarif(outcomes))["runs"][0]["results"]
        return [result["partialFingerprints"]["geometryAndRequirement/v1"] for result in results]

    other = {**FAILED_REPORT, "violations": [{**VIOLATION, "count": 6}]}
    assert prints(BAD) == prints(replace(BAD, report=other, line=9))
    stricter = {**FAILED_REPORT, "requirement": {**REQUIREMENT, "max_cusps": 1}}
    assert len({*prints(BAD, FAULTY, LOST), *prints(replace(BAD, report=stricter))}) == 4


def test_what_is_degenerate_is_said_although_it_passes() -> None:
    [section] = page([ODD], REQUIREMENT, NOTHING).sections
    assert (section.title, section.notes, section.failed) == (
        "odd.json: passed, 0 cusps", [f"degenerate: {SAID}"], False
    )  # fmt: skip
    case = ElementTree.fromstring(junit_xml([ODD])).find("testsuite/testcase")
    assert case is not None
    assert [(x.tag, x.get("name"), x.get("value")) for x in case.iter("property")] == [
        ("property", "degenerate", SAID)
    ]
    assert [child.tag for child in case] == ["properties"]
    [line] = github_annotations([ODD])
    assert line == f"::warning file=odd.json,line=2,title=degenerate::{SAID}"
    [result] = json.loads(sarif([ODD]))["runs"][0]["results"]
    assert (result["ruleId"], result["level"]) == ("degenerate", "warning")
    assert result["message"]["text"] == f"odd.json: {SAID}"


@given(st.text(), st.text())
def test_any_text_survives_as_an_annotation(source: str, detail: str) -> None:
    [line] = github_annotations([Outcome(source, error={"type": "input-error", "detail": detail})])
    assert "\n" not in line
    assert "\r" not in line
    match = re.fullmatch(r"::error (?:file=([^,:]*),)?title=([^,:]*)::(.*)", line, re.DOTALL)
    assert match is not None
    decoded = match[1] and match[1].replace("%0D", "\r").replace("%0A", "\n").replace("%3A", ":")
    if decoded:
        assert decoded.replace("%2C", ",").replace("%25", "%") == source
    assert match[3].replace("%25", "%") == " ".join(detail.split())


@given(st.text(), st.text())
def test_any_text_is_well_formed_xml(source: str, detail: str) -> None:
    document = junit_xml([Outcome(source, error={"type": "input-error", "detail": detail})])
    case = ElementTree.fromstring(document.encode()).find("testsuite/testcase")
    assert case is not None
    assert len(case.get("name", "")) == len(source)


MARGIN: dict[str, Any] = {
    "tolerance": {"a2x": "0.05", "a3x": "0", "a3y": "0", "d1": "0.1", "d2": "0", "d3": "0"},
    "reason": None,
    "validity": "8",
    "first_order": None,
    "certificate": None,
}
OTHER = {"a2x": "16.05", "a3x": "0", "a3y": "10", "d1": "17.14", "d2": "5", "d3": "6", "orientation": "ccw"}
EXAMPLE = {"radius": "1", "geometry": OTHER, "l2": "8.125", "count": 4}
OFF = Outcome(
    "off.json",
    {
        **PASSED_REPORT,
        "passed": False,
        "margin": {**MARGIN, "verdict": "refuted", "counterexample": EXAMPLE},
    },
    line=4,
)


def test_a_counter_example_is_in_every_report() -> None:
    said = (
        "4 cusps at L2 = 8.125 within the tolerance, for "
        "a2x = 16.05, a3x = 0, a3y = 10, d1 = 17.14, d2 = 5, d3 = 6; at most 2 allowed"
    )
    assert (OFF.verdict, OFF.message, OFF.passed) == ("failed", said, False)
    [section] = page([OFF], {**REQUIREMENT, "tolerance": MARGIN["tolerance"]}, NOTHING).sections
    assert section.rows == [[*OTHER], [*OTHER.values()]]
    [failure] = ElementTree.fromstring(junit_xml([OFF])).iter("failure")
    assert (failure.get("type"), failure.get("message")) == ("tolerance", said)
    assert failure.text == f"{' '.join(OTHER)}\n{' '.join(OTHER.values())}"
    run = json.loads(sarif([OFF]))["runs"][0]
    [result] = run["results"]
    assert (result["ruleId"], result["level"]) == ("tolerance", "error")
    assert result["properties"] == {"counterexample": EXAMPLE}
    assert {"tolerance", "open"} <= {rule["id"] for rule in run["tool"]["driver"]["rules"]}
    assert list(github_annotations([OFF])) == [f"::error file=off.json,line=4,title=check failed::{said}"]
