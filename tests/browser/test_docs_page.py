"""The page of the HTTP API in a browser."""

from __future__ import annotations

import json
import re
import shutil
import sys
from collections.abc import Callable
from typing import Any

import httpx
import pytest

from tests.browser.test_explorer import expect
from tests.support.processes import completed, environment

Open = Callable[..., Any]
Inspect = Callable[[Any, str], None]
PROGRAMS = {
    "curl": ("sh", "-c"),
    "Python": (sys.executable, "-c"),
    "JavaScript": ("node", "--input-type=module", "-e"),
}


def call(page: Any, name: str) -> Any:
    """A call that a link opens."""
    page.evaluate("name => { location.hash = name; }", name)
    opened = page.locator(f"#{name}")
    expect(opened.locator(".body")).to_be_visible()
    return opened


def test_every_call_of_the_contract_is_shown(base_url: str, open_page: Open) -> None:
    contract = httpx.get(f"{base_url}/openapi.json").json()
    page = open_page(f"{base_url}/docs")
    expect(page.locator("#calls")).to_have_attribute("aria-busy", "false")
    places = [*contract["paths"].values(), *contract["webhooks"].values()]
    names = {operation["operationId"] for place in places for operation in place.values()}
    assert {block.get_attribute("id") for block in page.locator(".call").all()} == names
    for name in sorted(names):
        call(page, name)  # what fails within is an error of the page
    page.get_by_role("searchbox").fill("singular-curves")
    expect(page.locator("nav li:visible")).to_have_count(1)


@pytest.mark.parametrize("language", PROGRAMS)
def test_a_request_runs_as_it_is_printed(base_url: str, open_page: Open, language: str) -> None:
    if shutil.which(PROGRAMS[language][0]) is None:
        pytest.skip(f"needs {PROGRAMS[language][0]}")
    block = call(open_page(f"{base_url}/docs"), "post_poses")
    body = {
        "geometry": {"base": {"equilateral": 10}, "platform": {"sides": [6, 7, 5]}},
        "l1": "7",
        "l2": 8,
        "l3": 9,
    }
    block.get_by_label("Body").fill(json.dumps({**body, "digits": 20, "deadline_seconds": None}))
    block.get_by_role("tab", name=language).click()
    program = [*PROGRAMS[language], block.locator("[role=tablist] + pre").text_content()]
    printed = completed(program, environment(), in_full=True).stdout
    document = json.loads(printed[printed.index("{") :])
    block.get_by_role("button", name="Send").click()
    shown = block.locator("h3:has-text(' s') + pre")
    expect(shown).to_contain_text('"poses"')
    assert json.loads(shown.text_content().partition("\n\n")[2]) == document
    assert document["digits"] == 20


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_can_be_read_by_everybody(base_url: str, open_page: Open, inspect: Inspect, scheme: str) -> None:
    page = open_page(f"{base_url}/docs", color_scheme=scheme)
    call(page, "post_cusp_table")
    colour = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert (max(map(int, re.findall(r"\d+", colour))) < 64) == (scheme == "dark")
    inspect(page, f"api-{scheme}")


def test_it_fits_a_phone(base_url: str, open_page: Open) -> None:
    page = open_page(f"{base_url}/docs", viewport={"width": 390, "height": 800})
    call(page, "post_path")
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
