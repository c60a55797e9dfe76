"""Questions as addresses, and answers with JSON numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from urllib.parse import urlencode

import httpx
import pytest

from tests.support.service_server import GEOMETRY

WAIT = {"Prefer": "wait=30"}


def address(path: str, **parameters: Any) -> str:
    return f"{path}?{urlencode({**GEOMETRY, 'digits': 15, **parameters})}"


def test_a_table_has_an_address_that_a_spreadsheet_can_read(
    api: httpx.Client, fresh: Callable[[], str]
) -> None:
    l1 = fresh()
    here = address("/v1/cusp-tables", l1=f"{l1};14.98", format="csv", wait=30)
    first = api.get(here, headers={"Accept": "text/html"})
    assert (first.status_code, first.headers["content-type"].partition(";")[0]) == (200, "text/csv")
    posted = api.post(
        "/v1/cusp-tables",
        json={"geometry": GEOMETRY, "l1": [l1, "14.98"], "digits": 15},
        headers={"Accept": "text/csv"},
    )
    assert first.text == posted.text
    again = api.get(here, headers={"If-None-Match": first.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    assert "immutable" in first.headers["cache-control"]
    assert api.get(first.headers["content-location"]).content == first.content


def test_a_range_and_another_leg_are_named_as_in_batches(api: httpx.Client) -> None:
    here = address("/v1/cusp-tables", fixed_leg=2, l2_from=16, l2_to="16.5", l2_step="1/4", wait=30)
    assert [part["l2"] for part in api.get(here).json()["slices"]] == ["16", "16.25", "16.5"]


def test_without_waiting_an_address_gives_the_job(idle: httpx.Client) -> None:
    answer = idle.get(address("/v1/cusp-tables", l1="7.0625", wait=0))
    assert (answer.status_code, answer.headers["cache-control"]) == (202, "no-store")
    assert answer.headers["location"] == answer.json()["links"]["self"]


@pytest.mark.parametrize(
    ("parameters", "field"),
    [
        ({"l1": "x"}, "l1[0]"),
        ({"l1": 1, "colour": "red"}, "colour"),
        ({"l1": 1, "wait": "long"}, "wait"),
        ({"l1": 1, "format": "xls"}, "format"),
        ({"l1": 1, "numbers": "double"}, "numbers"),
        ({"l1": 1, "d1": 0}, "geometry.d1"),
        ({}, "l1"),
    ],
)
def test_a_bad_parameter_is_named(idle: httpx.Client, parameters: dict[str, Any], field: str) -> None:
    answer = idle.get(address("/v1/cusp-tables", **parameters))
    assert answer.status_code == 422
    assert [(error["field"], "pointer" in error) for error in answer.json()["errors"]] == [(field, False)]


def test_a_parameter_that_is_given_twice_is_refused(idle: httpx.Client) -> None:
    assert idle.get(address("/v1/cusp-tables", l1=1) + "&l1=2").status_code == 422


def test_pages_of_other_sites_start_nothing(idle: httpx.Client) -> None:
    answer = idle.get(address("/v1/cusp-tables", l1=2), headers={"Sec-Fetch-Site": "cross-site"})
    assert (answer.status_code, answer.json()["type"]) == (403, "/problems/forbidden")


def test_numbers_can_be_json_numbers(api: httpx.Client) -> None:
    question = {"geometry": {**GEOMETRY, "d1": "426/25"}, "l1": "14.98", "digits": 30}
    text = api.post("/v1/cusp-tables", json=question, headers=WAIT)
    numbers = api.post("/v1/cusp-tables?numbers=float", json=question, headers=WAIT)
    assert numbers.headers["content-type"] == "application/json; numbers=float"
    [exact], [rounded] = text.json()["slices"], numbers.json()["slices"]
    assert numbers.json()["geometry"]["d1"] == 17.04
    for cusp, plain in zip(exact["cusps"], rounded["cusps"], strict=True):
        assert plain == {name: float(value) for name, value in cusp.items()}
    assert rounded["certificate"] == exact["certificate"]
    assert numbers.json()["solver_version"] == text.json()["solver_version"]
    assert numbers.headers["etag"] != text.headers["etag"]
    assert api.get(numbers.headers["content-location"]).content == numbers.content


@pytest.mark.slow
def test_a_census_has_an_address(api: httpx.Client) -> None:
    here = address("/v1/censuses", l1_from=27, l1_to=30, wait=30)
    question = {"geometry": GEOMETRY, "digits": 15, "range": {"from": 27, "to": 30}}
    assert api.get(here).content == api.post("/v1/censuses", json=question, headers=WAIT).content
    assert api.get(f"{here}&format=csv").text.count("\n") > 1
    assert isinstance(api.get(f"{here}&numbers=float").json()["transitions"][0]["l1"], float)
