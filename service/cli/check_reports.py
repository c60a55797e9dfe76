"""The outcomes of checks as text, JUnit XML and GitHub annotations."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

from rpr_solver import EXAMPLES
from service.cli.pages import Page, Section, counted, counted_range

SUITE = "rpr-cusps check"
_NOT_XML = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


@dataclass(frozen=True)
class Outcome:
    """The report on one geometry, or the error in its place.

    `error` has a type ("input-error", "solver-error", …) and a detail.
    """

    source: str
    report: Mapping[str, Any] | None = None
    error: Mapping[str, str] | None = None
    seconds: float = 0.0

    @property
    def passed(self) -> bool:
        """Whether the requirement is proved."""
        return self.report is not None and bool(self.report["passed"])

    @property
    def message(self) -> str:
        """One line on the failure: the first offending slice and its first cusp, or the error."""
        if self.error is not None:
            return " ".join(self.error["detail"].split())
        if self.report is None or self.passed:
            return ""
        first = self.report["violations"][0]
        leg = f"l{self.report['requirement']['fixed_leg']}"
        count = counted(first["count"], "cusp")
        text = f"{count} at {leg.upper()} = {first['example'][leg]}, {_demand(self.report['requirement'])}"
        if cusps := first["example"]["cusps"]:
            text += "; the first: " + ", ".join(f"{key} = {value}" for key, value in cusps[0].items())
        return text

    def to_json(self) -> dict[str, object]:
        """Returns the report, or the error, with the name of the geometry."""
        verdict = {"source": self.source, "passed": self.passed}
        return {**verdict, "report": self.report} if self.error is None else {**verdict, "error": self.error}


def document(outcomes: Sequence[Outcome], requirement: Mapping[str, Any]) -> dict[str, object]:
    """Returns all outcomes as one JSON document."""
    return {
        "passed": all(outcome.passed for outcome in outcomes),
        "requirement": requirement,
        "checks": [outcome.to_json() for outcome in outcomes],
    }


def page(outcomes: Sequence[Outcome], requirement: Mapping[str, Any]) -> Page:
    """Returns all outcomes as a page."""
    sections = []
    for outcome in outcomes:
        if outcome.passed:
            sections.append(Section(f"{outcome.source}: passed, {_span(outcome)}"))
            continue
        verdict = "failed" if outcome.error is None else "no answer"
        sections.append(
            Section(f"{outcome.source}: {verdict}: {outcome.message}", list(_rows(outcome)), failed=True)
        )
    return Page(_about(requirement), sections)


def junit_xml(outcomes: Sequence[Outcome]) -> str:
    """Returns JUnit XML with a test case per geometry."""
    suite = ElementTree.Element(
        "testsuite",
        name=SUITE,
        tests=str(len(outcomes)),
        failures=str(sum(not o.passed and o.error is None for o in outcomes)),
        errors=str(sum(o.error is not None for o in outcomes)),
        skipped="0",
        time=f"{sum(o.seconds for o in outcomes):.3f}",
    )
    for outcome in outcomes:
        case = ElementTree.SubElement(
            suite, "testcase", classname=SUITE, name=_xml(outcome.source), time=f"{outcome.seconds:.3f}"
        )
        if outcome.error is not None:
            kind, name = _xml(outcome.error["type"]), "error"
        elif not outcome.passed:
            kind, name = "requirement", "failure"
        else:
            continue
        element = ElementTree.SubElement(case, name, message=_xml(outcome.message), type=kind)
        element.text = "\n".join(" ".join(row) for row in _rows(outcome))
    suites = ElementTree.Element("testsuites")
    suites.append(suite)
    ElementTree.indent(suites)
    return ElementTree.tostring(suites, encoding="unicode", xml_declaration=True) + "\n"


def github_annotations(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """Yields a GitHub workflow command for each geometry that does not pass."""
    for outcome in outcomes:
        if outcome.passed:
            continue
        title = "check failed" if outcome.error is None else f"no answer ({outcome.error['type']})"
        if outcome.source == "-" or outcome.source in EXAMPLES:
            where = f"title={_property(f'{outcome.source}: {title}')}"
        else:
            where = f"file={_property(outcome.source)},title={_property(title)}"
        yield f"::error {where}::{_data(outcome.message)}"


def _demand(requirement: Mapping[str, Any]) -> str:
    bounds = {"at most": requirement["max_cusps"], "at least": requirement["min_cusps"]}
    demand = " and ".join(f"{words} {bound}" for words, bound in bounds.items() if bound is not None)
    return f"{demand} {'allowed' if requirement['min_cusps'] is None else 'required'}"


def _about(requirement: Mapping[str, Any]) -> str:
    ends, leg = requirement["range"], requirement["fixed_leg"]
    upper = "" if ends["to"] is None else f" up to {ends['to']}"
    limits = "".join(
        f", {key.upper()} within {bounds['min'] or 0}:{bounds['max'] or ''}"
        for key, bounds in requirement["limits"].items()
    )
    return f"cusps for L{leg} from {ends['from']}{upper}{limits}: {_demand(requirement)}"


def _span(outcome: Outcome) -> str:
    assert outcome.report is not None
    return counted_range(outcome.report["min_cusps_found"], outcome.report["max_cusps_found"], "cusp")


def _rows(outcome: Outcome) -> Iterator[list[str]]:
    if outcome.report is None:
        return
    yield ["from", "to", "cusps"]
    for part in outcome.report["violations"]:
        yield [part["from"], part["to"] or "∞", str(part["count"])]


def _xml(text: str) -> str:
    """Replace the characters that XML 1.0 excludes."""
    return _NOT_XML.sub("\ufffd", text)


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
