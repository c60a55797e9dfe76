"""The outcomes of checks for other programs: JUnit XML, SARIF and annotations of GitHub."""

from __future__ import annotations

import hashlib
import json
import re
import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path, PurePath
from typing import Any
from urllib.parse import quote
from xml.etree import ElementTree

from service import __version__
from service.cli.check.reports import Outcome

SUITE = "rpr-cusps check"
SARIF_SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"
_NOT_XML = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


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
        _add_case(suite, outcome)
    suites = ElementTree.Element("testsuites")
    suites.append(suite)
    ElementTree.indent(suites)
    return ElementTree.tostring(suites, encoding="unicode", xml_declaration=True) + "\n"


def _add_case(suite: ElementTree.Element, outcome: Outcome) -> None:
    case = ElementTree.SubElement(
        suite, "testcase", classname=SUITE, name=_xml(outcome.source), time=f"{outcome.seconds:.3f}"
    )
    if outcome.is_file:
        case.set("file", _xml(outcome.source))
    if outcome.is_file and outcome.line is not None:
        case.set("line", str(outcome.line))
    near = [("near", outcome.near)] if outcome.near else []
    said = [*near, *outcome.notes.items(), *(("ignored-window", words) for words in outcome.ignored)]
    said += [("mode-change", words) for words in outcome.witness]
    said += [("degenerate", words) for words in outcome.degenerate]
    if said:
        properties = ElementTree.SubElement(case, "properties")
        for name, words in said:
            ElementTree.SubElement(properties, "property", name=name, value=_xml(words))
    if outcome.passed and outcome.error is None:
        return
    kind, tag = (
        (_rule(outcome), "failure") if outcome.error is None else (_xml(outcome.error["type"]), "error")
    )
    element = ElementTree.SubElement(case, tag, message=_xml(outcome.message), type=kind)
    rows = (" ".join(row) for row in outcome.rows(shorten=True))
    element.text = "\n".join([*(_xml(words) for _, words in near), *rows])


def sarif(outcomes: Sequence[Outcome]) -> str:
    """Returns SARIF 2.1.0 with a result for each geometry that does not pass, is degenerate, is near a
    special shape that contradicts its report, or has windows that are ignored."""
    rules = tomllib.loads(Path(__file__).with_name("rules.toml").read_text(encoding="utf-8"))
    described = [
        {
            "id": name,
            "shortDescription": {"text": rule["short"]},
            "help": {"text": rule["more"], "markdown": rule["more"]},
        }
        for name, rule in rules.items()
    ]
    driver = {"name": "rpr-cusps", "version": __version__, "rules": described}
    results = [_located(o, "near-special-shape", "warning", o.near) for o in outcomes if o.near]
    results += [_result(o) for o in outcomes if not o.passed]
    results += [_located(o, "degenerate", "warning", "; ".join(o.remarks)) for o in outcomes if o.remarks]
    results += [_located(o, "ignored-window", "note", "; ".join(o.ignored)) for o in outcomes if o.ignored]
    run = {"tool": {"driver": driver}, "results": results}
    return json.dumps({"$schema": SARIF_SCHEMA, "version": "2.1.0", "runs": [run]}, indent=2) + "\n"


def github_annotations(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """Yields a GitHub workflow command for each geometry that does not pass, is degenerate, or is near a
    special shape that contradicts its report, and for each window that is ignored."""
    for outcome in outcomes:
        if outcome.near:
            yield f"::warning {_where(outcome, 'near a special shape')}::{_data(outcome.near)}"
        for words in outcome.remarks:
            yield f"::warning {_where(outcome, 'degenerate')}::{_data(words)}"
        for words in outcome.ignored:
            yield f"::notice {_where(outcome, 'window ignored')}::{_data(words)}"
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
    parts = [PurePath(outcome.source).as_posix(), rule, outcome.report.get("requirement")]
    if outcome.margin:
        parts.append(outcome.margin["tolerance"])
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


def _xml(text: str) -> str:
    """Replace the characters that XML 1.0 excludes."""
    return _NOT_XML.sub("\ufffd", text)


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
