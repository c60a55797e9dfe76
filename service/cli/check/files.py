"""The outcomes of checks for other programs: JUnit XML, SARIF and GitHub annotations."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator, Sequence
from pathlib import PurePath
from typing import Any
from urllib.parse import quote
from xml.etree import ElementTree

from service import __version__
from service.cli.check.reports import Outcome

SUITE = "rpr-cusps check"
SARIF_SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"
_NOT_XML = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_RULES = {
    "requirement": (
        "The manipulator violates the requirement.",
        "In at least one slice it has more or fewer cusps than the requirement allows, or it is degenerate "
        "where that is refused. This is proved. `rpr-cusps census FILE` shows the number for all lengths.",
    ),
    "tolerance": (
        "A manipulator within the tolerance violates the requirement.",
        "The given lengths satisfy the requirement, but lengths that close to them do not: the "
        "counter-example is an exact geometry. `rpr-cusps margin FILE` shows how far lengths may be off.",
    ),
    "open": (
        "It is open whether every manipulator within the tolerance satisfies the requirement.",
        "Neither a proof nor a counter-example was found; the message says why. A smaller tolerance, or a "
        "range without transitions, may be proved.",
    ),
    "degenerate": (
        "The manipulator is degenerate, which the requirement allows.",
        "Poses of every slice of an interval, or along a whole curve of one, are degenerate, as for flat, "
        "similar or congruent triangles. `--degenerate refused` makes this a failure.",
    ),
    "input-error": (
        "The file is not a geometry.",
        "A geometry is a JSON object with a2x, a3x, a3y, d1, d2, d3 and, if the platform runs clockwise, "
        "`orientation`. The message names each member at fault.",
    ),
    "no-answer": (
        "The requirement could not be decided.",
        "The requirement is neither proved nor refuted; the message says why.",
    ),
}
"""Rule → what it says in short, and what to know about it."""


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
        if outcome.is_file:
            case.set("file", _xml(outcome.source))
        if outcome.is_file and outcome.line is not None:
            case.set("line", str(outcome.line))
        said = [*outcome.notes.items(), *(("degenerate", words) for words in outcome.degenerate)]
        if said:
            properties = ElementTree.SubElement(case, "properties")
            for name, words in said:
                ElementTree.SubElement(properties, "property", name=name, value=_xml(words))
        if outcome.error is not None:
            kind, tag = _xml(outcome.error["type"]), "error"
        elif not outcome.passed:
            kind, tag = _rule(outcome), "failure"
        else:
            continue
        element = ElementTree.SubElement(case, tag, message=_xml(outcome.message), type=kind)
        element.text = "\n".join(" ".join(row) for row in outcome.rows(shorten=True))
    suites = ElementTree.Element("testsuites")
    suites.append(suite)
    ElementTree.indent(suites)
    return ElementTree.tostring(suites, encoding="unicode", xml_declaration=True) + "\n"


def sarif(outcomes: Sequence[Outcome]) -> str:
    """Returns SARIF 2.1.0 with a result for each geometry that does not pass, or is degenerate."""
    driver = {
        "name": "rpr-cusps",
        "version": __version__,
        "rules": [
            {"id": name, "shortDescription": {"text": short}, "help": {"text": more, "markdown": more}}
            for name, (short, more) in _RULES.items()
        ],
    }
    results = [_result(o) for o in outcomes if not o.passed]
    results += [_remark(o) for o in outcomes if o.remarks]
    run = {"tool": {"driver": driver}, "results": results}
    return json.dumps({"$schema": SARIF_SCHEMA, "version": "2.1.0", "runs": [run]}, indent=2) + "\n"


def github_annotations(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """Yields a GitHub workflow command for each geometry that does not pass, or is degenerate."""
    for outcome in outcomes:
        for words in outcome.remarks:
            yield f"::warning {_where(outcome, 'degenerate')}::{_data(words)}"
        if outcome.passed:
            continue
        title = (
            f"check {outcome.verdict}"
            if outcome.error is None
            else f"{outcome.verdict} ({outcome.error['type']})"
        )
        yield f"::error {_where(outcome, title)}::{_data(outcome.message)}"


def _where(outcome: Outcome, title: str) -> str:
    """The properties of a workflow command: the file and line, if there is one, and a title."""
    if not outcome.is_file:
        return f"title={_property(f'{outcome.name}: {title}')}"
    line = "" if outcome.line is None else f"line={outcome.line},"
    return f"file={_property(outcome.source)},{line}title={_property(title)}"


def _result(outcome: Outcome) -> dict[str, Any]:
    result = _located(outcome, _rule(outcome), "error", outcome.message)
    if outcome.counterexample is not None:
        result["properties"] = {"counterexample": outcome.counterexample}
    return result


def _rule(outcome: Outcome) -> str:
    if outcome.error is not None:
        return "input-error" if outcome.is_bad else "no-answer"
    if outcome.is_open:
        return "open"
    return "requirement" if outcome.counterexample is None else "tolerance"


def _remark(outcome: Outcome) -> dict[str, Any]:
    return _located(outcome, "degenerate", "warning", "; ".join(outcome.remarks))


def _located(outcome: Outcome, rule: str, level: str, message: str) -> dict[str, Any]:
    place: dict[str, Any] = {"artifactLocation": {"uri": quote(PurePath(outcome.source).as_posix())}}
    if outcome.line is not None:
        place["region"] = {"startLine": outcome.line}
    located = {"locations": [{"physicalLocation": place}]} if outcome.is_file else {}
    text = f"{outcome.name}: {message}"
    return {
        "ruleId": rule,
        "level": level,
        "message": {"text": text},
        **located,
        "partialFingerprints": {"geometryAndRequirement/v1": _fingerprint(outcome, rule)},
    }


def _fingerprint(outcome: Outcome, rule: str) -> str:
    """Returns a fingerprint of one result for one file and requirement, independent of its numbers."""
    requirement = None if outcome.report is None else outcome.report["requirement"]
    parts = [PurePath(outcome.source).as_posix(), rule, requirement]
    if outcome.report is not None and "margin" in outcome.report:
        parts.append(outcome.report["margin"]["tolerance"])
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


def _xml(text: str) -> str:
    """Replace the characters that XML 1.0 excludes."""
    return _NOT_XML.sub("\ufffd", text)


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
