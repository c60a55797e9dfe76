"""The explorer as it is served (tests/browser has it in a browser), and pages of others as clients."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest
from pydantic import ValidationError

from rpr_solver import EXAMPLES
from service.api.routes.pages import FIRST_SLICES, WEB
from service.api.settings import Settings
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import PATIENCE
from tests.support.service_server import GEOMETRY, serving

ROOT = Path(__file__).parents[3]
MODULES = sorted(path.name for path in (WEB / "explorer").glob("*.js"))
LATER = sorted(
    path.relative_to(WEB).as_posix() for name in ("space", "tabs") for path in (WEB / name).glob("*.js")
)
"""The modules that are loaded when somebody opens what they draw."""


def test_the_page_allows_nothing_inline_and_nothing_from_elsewhere(idle: httpx.Client) -> None:
    page = idle.get("/")
    assert page.headers["content-security-policy"] == (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )
    assert not re.search(r" on\w+=| style=|<style|<script>|javascript:", page.text)
    assert "$" not in page.text
    assert 'href="docs"' in page.text


def test_the_examples_are_those_of_the_solver(idle: httpx.Client) -> None:
    page = idle.get("/").text
    assert FIRST_SLICES.keys() == EXAMPLES.keys()
    for name, manipulator in EXAMPLES.items():
        text = ",".join(manipulator.to_json().values())
        assert f'<option value="{text}" data-l1="{FIRST_SLICES[name]}">{name}</option>' in page


def test_every_module_is_loaded_ahead_and_checked_again_each_time(idle: httpx.Client) -> None:
    page = idle.get("/").text
    for name in MODULES:
        assert f'<link rel="modulepreload" href="static/explorer/{name}">' in page
    name = MODULES[0]
    module = idle.get(f"/static/explorer/{name}")
    assert module.headers["content-type"].partition(";")[0] == "text/javascript"
    assert module.headers["cache-control"] == "no-cache"
    again = idle.get(f"/static/explorer/{name}", headers={"If-None-Match": module.headers["etag"]})
    assert (again.status_code, again.headers["cache-control"]) == (304, "no-cache")


@pytest.mark.parametrize("name", LATER)
def test_what_is_opened_later_is_loaded_only_then(idle: httpx.Client, name: str) -> None:
    page = idle.get("/").text
    assert f"static/{name}" not in page
    assert "three.min.mjs" not in page
    assert idle.get(f"/static/{name}").headers["cache-control"] == "no-cache"


def test_one_board_may_be_framed_by_pages_of_others(idle: httpx.Client, shared: httpx.Client) -> None:
    """By all, unless a setting names some; and no other page by any."""
    policies = [client.get("/embed").headers["content-security-policy"] for client in (idle, shared)]
    assert [policy.partition("frame-ancestors ")[2] for policy in policies] == ["*", PAGE]
    other = idle.get("/").headers["content-security-policy"]
    assert other.replace("'none'", "*") == policies[0].replace("'none'", "*")
    page = idle.get("/embed").text
    assert not re.search(r" on\w+=| style=|<style|<script>|javascript:", page)


@pytest.mark.parametrize("folder", [WEB / "jsxgraph", WEB / "three", ROOT / "tests" / "browser" / "axe"])
def test_what_others_wrote_is_unchanged(folder: Path) -> None:
    sums = dict(
        re.findall(r"^\| ([\w.]+) \| ([0-9a-f]{64}) \|$", (folder / "SOURCE.md").read_text(), re.MULTILINE)
    )
    files = {path.name: path for path in folder.iterdir() if path.name != "SOURCE.md"}
    assert sums == {name: hashlib.sha256(path.read_bytes()).hexdigest() for name, path in files.items()}
    licence = next(path for name, path in files.items() if name.startswith("LICENSE"))
    assert re.search("free of charge|Mozilla Public License", licence.read_text(encoding="utf-8"))


PAGE = "https://tools.example.com"
PREFLIGHT = {"Access-Control-Request-Method": "POST", "Access-Control-Request-Headers": "content-type,prefer"}
QUESTION = {"geometry": GEOMETRY, "l1": "6.0625", "digits": 15}


@pytest.fixture(scope="module")
def shared(valkey: EmbeddedValkey) -> Iterator[httpx.Client]:
    """A client of a service that one page may call."""
    settings = Settings(
        redis_url=f"{valkey.url}?db=1", cors_origins=f"https://other.example, {PAGE}", embed_origins=PAGE
    )
    with serving(settings) as url, httpx.Client(base_url=url, timeout=PATIENCE) as client:
        yield client


def test_a_page_whose_origin_is_allowed_may_ask(shared: httpx.Client) -> None:
    asked = shared.options("/v1/cusp-tables", headers={"Origin": PAGE, **PREFLIGHT})
    assert (asked.status_code, asked.headers["access-control-allow-origin"]) == (200, PAGE)
    answer = shared.post("/v1/cusp-tables", json=QUESTION, headers={"Origin": PAGE})
    assert answer.headers["access-control-allow-origin"] == PAGE
    assert "Location" in answer.headers["access-control-expose-headers"]
    where = {**GEOMETRY, "l1": "6.0625", "wait": 0}
    own = shared.get(
        "/v1/cusp-tables", params=where, headers={"Origin": PAGE, "Sec-Fetch-Site": "cross-site"}
    )
    assert own.status_code == 202


def test_other_pages_may_not(shared: httpx.Client, idle: httpx.Client) -> None:
    for client, page in ((shared, "https://evil.example"), (idle, PAGE)):
        asked = client.options("/v1/cusp-tables", headers={"Origin": page, **PREFLIGHT})
        assert asked.status_code >= 400
        assert "access-control-allow-origin" not in asked.headers


def test_an_origin_is_no_address() -> None:
    with pytest.raises(ValidationError, match="no origin; write one such as"):
        Settings(cors_origins=f"{PAGE}/page")


def test_a_geometry_may_name_its_schema(idle: httpx.Client) -> None:
    answer = idle.get("/schemas/geometry.json")
    schema = answer.json()
    assert schema["$id"] == str(answer.url)
    spellings = [
        spelling["properties"].keys() for spelling in schema["$defs"].values() if "properties" in spelling
    ]
    assert any({"$schema", "name", "unit", *GEOMETRY} <= members for members in spellings)
    beside = {"$schema": schema["$id"], "name": "Gripper", "unit": "mm"}
    named = {**QUESTION, "geometry": {**beside, **GEOMETRY}}
    ids = {idle.post("/v1/cusp-tables", json=body).json()["id"] for body in (QUESTION, named)}
    assert len(ids) == 1, "it is no part of the question"
    refused = idle.post("/v1/cusp-tables", json={**QUESTION, "geometry": {**GEOMETRY, "unit": 5}})
    assert (refused.status_code, refused.json()["detail"]) == (422, "geometry.unit: is 5; give a text")
