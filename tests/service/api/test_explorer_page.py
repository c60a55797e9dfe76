"""The explorer as it is served; tests/browser has it in a browser."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

import httpx
import pytest

from rpr_solver import EXAMPLES
from service.api.routes.pages import FIRST_SLICES, WEB

ROOT = Path(__file__).parents[3]
MODULES = sorted(path.name for path in (WEB / "explorer").glob("*.js"))
LONGEST = 400


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


@pytest.mark.parametrize("name", MODULES)
def test_every_module_is_loaded_ahead_and_checked_again_each_time(idle: httpx.Client, name: str) -> None:
    assert f'<link rel="modulepreload" href="static/explorer/{name}">' in idle.get("/").text
    module = idle.get(f"/static/explorer/{name}")
    assert module.headers["content-type"].partition(";")[0] == "text/javascript"
    assert module.headers["cache-control"] == "no-cache"
    again = idle.get(f"/static/explorer/{name}", headers={"If-None-Match": module.headers["etag"]})
    assert (again.status_code, again.headers["cache-control"]) == (304, "no-cache")
    assert len(module.text.splitlines()) <= LONGEST


@pytest.mark.parametrize("name", MODULES)
def test_modules_import_only_each_other_and_the_drawing_library(name: str) -> None:
    text = (WEB / "explorer" / name).read_text(encoding="utf-8")
    imported = set(re.findall(r'from "(.+)";', text)) | set(
        re.findall(r'^import "(.+)";', text, re.MULTILINE)
    )
    library = {"../jsxgraph/jsxgraphcore.mjs"} if name == "board.js" else set()
    assert imported <= {f"./{module}" for module in MODULES} | library


@pytest.mark.parametrize("folder", [WEB / "jsxgraph", ROOT / "tests" / "browser" / "axe"])
def test_what_others_wrote_is_unchanged(folder: Path) -> None:
    sums = dict(
        re.findall(r"^\| ([\w.]+) \| ([0-9a-f]{64}) \|$", (folder / "SOURCE.md").read_text(), re.MULTILINE)
    )
    files = {path.name: path for path in folder.iterdir() if path.name != "SOURCE.md"}
    assert sums == {name: hashlib.sha256(path.read_bytes()).hexdigest() for name, path in files.items()}
    licence = next(path for name, path in files.items() if name.startswith("LICENSE"))
    assert re.search("free of charge|Mozilla Public License", licence.read_text(encoding="utf-8"))
