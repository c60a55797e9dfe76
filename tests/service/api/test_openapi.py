"""openapi.yaml: complete, stable, and with examples that are as its schemas say."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import cache
from typing import Any

import httpx
import jsonschema_rs
import pytest
import yaml

from service.api.app import create_app
from service.api.contract.batches import POST_BODY
from service.api.problems import MEDIA_TYPE
from service.openapi_yaml import main
from service.schemas.answers import JSON, NDJSON
from service.schemas.registry import all_questions
from tests.support.contract import demands, known, parts, promises
from tests.support.processes import until


@cache
def described() -> dict[str, Any]:
    return create_app().openapi()


@pytest.fixture
def contract() -> dict[str, Any]:
    return described()


def test_the_service_has_it_as_yaml_too(idle: httpx.Client) -> None:
    as_yaml, as_json = idle.get("/openapi.yaml"), idle.get("/openapi.json")
    assert as_yaml.headers["content-type"].startswith("application/yaml")
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # thirty times as fast
    assert yaml.load(as_yaml.text, loader) == as_json.json()


def test_openapi_yaml_is_what_the_application_says(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--check"]) == 0, f"run `python -m service.openapi_yaml`:\n{capsys.readouterr().out}"


def test_every_reference_leads_somewhere(contract: dict[str, Any]) -> None:
    def references(value: Any) -> list[str]:
        if isinstance(value, dict):
            own = [value["$ref"]] if isinstance(value.get("$ref"), str) else []
            return own + [r for item in value.values() for r in references(item)]
        return [r for item in value for r in references(item)] if isinstance(value, list) else []

    every = references(contract)
    assert every
    for reference in every:
        target: Any = contract
        for part in reference.removeprefix("#/").split("/"):
            target = target[part]


def test_operations_are_documented_and_named_once(contract: dict[str, Any]) -> None:
    operations = [operation for path in contract["paths"].values() for operation in path.values()]
    names = [operation["operationId"] for operation in operations]
    assert len(set(names)) == len(names)
    for operation in operations:
        assert operation["summary"]
        assert operation["description"]
        for status, answer in operation["responses"].items():
            assert answer["description"]
            if status == "default":
                assert list(resolved(answer)["content"]) == [MEDIA_TYPE]


def test_what_was_promised_stays(contract: dict[str, Any]) -> None:
    kept = {line for line in known() if " must have " not in line}
    assert not kept - promises(contract), "within /v1 the contract only grows: see docs/http.md"


def test_requests_need_no_more_than_before(contract: dict[str, Any]) -> None:
    old = known()
    already = {line.partition(" has ")[0] for line in old if " has " in line}
    already |= {line.partition(" is called ")[0] for line in old if " is called " in line}
    more = {line for line in demands(contract) - old if line.partition(" must have ")[0] in already}
    assert not more, "within /v1 a request that was accepted stays so: see docs/http.md"


EXPENSIVE = {
    ("/v1/cusp-tables", "scan"),
    ("/v1/cusp-tables", "article"),
    ("/v1/censuses", "whole"),
    ("/v1/cusp-curves", "scan"),
    ("/v1/cusp-curves", "samples"),
    ("/v1/checks", "at_most"),
    ("/v1/checks", "tolerance"),
    ("/v1/censuses", "tolerance"),
    ("/v1/margins", "requirement"),
    ("/v1/designs", "loop"),
    ("/v1/designs", "range"),
    ("/v1/pose-connections", "limits"),
}
"""Examples that take a second or more: accepted and withdrawn each time, and answered with `--long`."""

WAIT = {"Prefer": "wait=30"}


def operations() -> Iterator[tuple[str, dict[str, Any]]]:
    """All operations, and what the service sends by itself, with their names."""
    for path, methods in described()["paths"].items():
        yield from ((f"{method} {path}", operation) for method, operation in methods.items())
    for name, hook in described()["webhooks"].items():
        yield name, hook["post"]


def resolved(part: dict[str, Any]) -> dict[str, Any]:
    """What a reference leads to."""
    if "$ref" not in part:
        return part
    target: Any = described()
    for name in part["$ref"].removeprefix("#/").split("/"):
        target = target[name]
    return dict(target)


def examples_of(part: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    if "example" in part:
        yield "example", part["example"]
    yield from ((name, example["value"]) for name, example in part.get("examples", {}).items())


def questions() -> list[Any]:
    """The examples of questions, read without making the contract."""
    named = [(op.path, name) for op in all_questions() for name in op.examples]
    bodies = POST_BODY["requestBody"]["content"].items()
    named += [("/v1/batches", name) for _, content in bodies for name, _ in examples_of(content)]
    marks = {case: [pytest.mark.long] if case in EXPENSIVE else [] for case in named}
    return [pytest.param(*case, id=" ".join(case), marks=marks[case]) for case in marks]


def asked() -> dict[tuple[str, str], list[tuple[str, Any]]]:
    """The examples of bodies in the contract: path and name → media types and bodies."""
    found: dict[tuple[str, str], list[tuple[str, Any]]] = {}
    for path, methods in described()["paths"].items():
        for operation in methods.values():
            for media_type, content in operation.get("requestBody", {}).get("content", {}).items():
                for name, body in examples_of(content):
                    found.setdefault((path, name), []).append((media_type, body))
    return found


def shown() -> Iterator[tuple[str, str, dict[str, Any], Any]]:
    """All examples but those of schemas: place, media type, schema, value."""
    for name, operation in operations():
        for parameter in map(resolved, operation.get("parameters", ())):
            for example, value in examples_of(parameter):
                yield f"{name}, {parameter['name']}, {example}", JSON, parameter["schema"], value
        answers = {status: resolved(answer) for status, answer in operation["responses"].items()}
        for part, body in {"body": operation.get("requestBody", {}), **answers}.items():
            for media_type, content in body.get("content", {}).items():
                for example, value in examples_of(content):
                    yield f"{name}, {part}, {media_type}, {example}", media_type, content["schema"], value


def in_schemas() -> Iterator[tuple[dict[str, Any], Any]]:
    """The examples of schemas, with their schemas."""
    for part in parts(described()["components"]["schemas"]):
        if isinstance(part.get("examples"), list):
            yield from ((part, example) for example in part["examples"])


def validator(schema: dict[str, Any]) -> jsonschema_rs.Draft202012Validator:
    return jsonschema_rs.Draft202012Validator({**schema, "components": described()["components"]})


def check(schema: dict[str, Any], value: Any) -> None:
    validator(schema).validate(value)


def answered(answer: httpx.Response) -> httpx.Response | None:
    assert answer.status_code in (200, 202), answer.text
    return answer if answer.status_code == 200 else None


@pytest.mark.parametrize(("path", "name"), questions())
def test_what_is_asked_is_answered(api: httpx.Client, path: str, name: str) -> None:
    answers = described()["paths"][path]["post"]["responses"]
    for media_type, body in asked()[path, name]:
        sent = {"Content-Type": media_type, **WAIT}
        content = body if isinstance(body, str) else json.dumps(body)
        answer = api.post(path, content=content, headers=sent)
        if "200" in answers:
            answer = until(lambda c=content, s=sent: answered(api.post(path, content=c, headers=s)))
        check(resolved(answers[str(answer.status_code)])["content"][JSON]["schema"], answer.json())
        if path == "/v1/batches":
            check_results(api, answer.json())


@pytest.mark.parametrize(("path", "name"), sorted(EXPENSIVE))
def test_what_takes_long_is_accepted(api: httpx.Client, path: str, name: str) -> None:
    [(_, body)] = asked()[path, name]
    answer = api.post(path, json=body, headers={"Prefer": "respond-async"})
    assert answer.status_code in (200, 202)
    if answer.status_code == 202:
        assert api.delete(answer.json()["links"]["self"]).status_code == 200


def check_results(api: httpx.Client, batch: dict[str, Any]) -> None:
    lines = until(lambda: all_of(api, batch))
    assert [line["status"] for line in lines] == ["succeeded"] * len(lines)
    for line in lines:
        check({"$ref": "#/components/schemas/BatchResult"}, line)


def all_of(api: httpx.Client, batch: dict[str, Any]) -> list[Any] | None:
    """The results of a batch once they are there."""
    lines = [json.loads(line) for line in api.get(batch["links"]["results"], headers=WAIT).text.splitlines()]
    return lines if len(lines) == batch["progress"]["total"] else None


def test_no_example_of_a_body_is_left_out() -> None:
    assert asked().keys() == {tuple(case.values) for case in questions()}


def test_what_is_shown_is_as_the_schema_says() -> None:
    faults = [f"{place}: {fault}" for place, *example in shown() for fault in faults_of(*example)]
    assert not faults, "\n".join(faults)


def faults_of(media_type: str, schema: dict[str, Any], value: Any) -> Iterator[str]:
    if media_type != NDJSON or "$ref" not in schema:
        values = [value]
    else:
        values = [json.loads(line) for line in value.splitlines()]
    for one in values:
        yield from (fault.message for fault in validator(schema).iter_errors(one))


def test_examples_of_schemas_are_as_they_say() -> None:
    found = list(in_schemas())
    assert len(found) > 5
    for schema, value in found:
        check(schema, value)
