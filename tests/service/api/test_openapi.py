from __future__ import annotations

from pathlib import Path
from typing import Any

import httpx
import pytest
import yaml

from service.api.app import create_app
from service.api.problems import MEDIA_TYPE
from service.openapi_yaml import FILE, main
from tests.support.contract import demands, known, promises


@pytest.fixture(scope="module")
def contract() -> dict[str, Any]:
    return create_app().openapi()


def test_the_service_has_it_as_yaml_too(idle: httpx.Client) -> None:
    as_yaml, as_json = idle.get("/openapi.yaml"), idle.get("/openapi.json")
    assert as_yaml.headers["content-type"].startswith("application/yaml")
    assert yaml.safe_load(as_yaml.text) == as_json.json()


def test_openapi_yaml_is_what_the_application_says(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--check"]) == 0, f"run `python -m service.openapi_yaml`:\n{capsys.readouterr().out}"


def test_a_difference_is_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    changed = tmp_path / "openapi.yaml"
    changed.write_text(FILE.read_text().replace("14.98", "15"))
    assert main(["--check", "--file", str(changed)]) == 1
    assert "l1: 14.98" in capsys.readouterr().out


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
            if int(status) >= 400:
                assert list(answer["content"]) == [MEDIA_TYPE]


def test_links_lead_to_operations(contract: dict[str, Any]) -> None:
    names = {operation["operationId"] for path in contract["paths"].values() for operation in path.values()}
    links = contract["paths"]["/v1/cusp-tables"]["post"]["responses"]["202"]["links"]
    assert {link["operationId"] for link in links.values()} <= names


def test_it_says_which_openapi_it_is(contract: dict[str, Any]) -> None:
    assert contract["openapi"].startswith("3.1.")
    assert "HTTPValidationError" not in contract["components"]["schemas"]


def test_what_was_promised_stays(contract: dict[str, Any]) -> None:
    kept = {line for line in known() if " must have " not in line}
    assert not kept - promises(contract), "within /v1 the contract only grows: see docs/http.md"


def test_requests_need_no_more_than_before(contract: dict[str, Any]) -> None:
    old = known()
    already = {line.partition(" has ")[0] for line in old if " has " in line}
    already |= {line.partition(" is called ")[0] for line in old if " is called " in line}
    more = {line for line in demands(contract) - old if line.partition(" must have ")[0] in already}
    assert not more, "within /v1 a request that was accepted stays so: see docs/http.md"
