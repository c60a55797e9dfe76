"""Questions and answers as addresses: queries, pictures, and Content-Location."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from urllib.parse import urlencode
from xml.etree import ElementTree

import httpx
import pytest
from redis import Redis

from rpr_solver import EXAMPLES, singular_curves
from tests.service.api.test_documents_api import is_whole
from tests.support.service_server import GEOMETRY
from worker.jobs.queue import JobQueue

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
        ({"l1": 1, "wait": "long"}, "wait"),
        ({"l1": 1, "d1": 0}, "geometry.d3"),
        ({"l1": 1, "l1_from": 1, "l1_to": 2, "l1_step": 1}, "l1_from"),
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


SVG = "image/svg+xml"


def picture(**parameters: Any) -> str:
    return f"/v1/plots?{urlencode({**GEOMETRY, **parameters})}"


def test_a_picture_has_an_address_that_a_page_can_show(api: httpx.Client) -> None:
    here = picture(l1="14.98", wait=30)
    first = api.get(here, headers={"Accept": "image/avif,image/svg+xml,image/*,*/*;q=0.8"})
    assert (first.status_code, first.headers["content-type"]) == (200, SVG)
    assert first.text == singular_curves(EXAMPLES["innocenti"], "14.98").figure().svg()
    assert "immutable" in first.headers["cache-control"]
    assert "style-src 'unsafe-inline'" in first.headers["content-security-policy"]
    again = api.get(here, headers={"If-None-Match": first.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    stored = api.get(first.headers["content-location"], headers={"Accept": SVG})
    assert stored.content == first.content


def test_a_picture_is_a_document_too(api: httpx.Client) -> None:
    body = {"geometry": GEOMETRY, "plot": "mechanism", "l1": 14.98, "l2": 16, "l3": 20, "pose": 2}
    answer = api.post("/v1/plots", json=body)
    assert answer.status_code == 200
    document = answer.json()
    assert is_whole("Plot", document)
    assert document["title"] == "Pose 2 of 6 with these legs"
    assert ElementTree.fromstring(document["svg"]).attrib["role"] == "img"
    assert api.post("/v1/plots", json=body, headers={"Accept": SVG}).text == document["svg"]


@pytest.mark.parametrize(
    ("parameters", "field"),
    [
        ({}, "l1"),
        ({"l1": 27, "l2": 3}, "l2"),
        ({"l1": 27, "plot": "census"}, "l1"),
        ({"l1": 27, "cusp": 2}, "cusp"),
        ({"plot": "mechanism", "l1": 27, "l2": 3, "l3": 4, "pose": 7}, "pose"),
        ({"l1": 27, "unit": "<b>"}, "unit"),
    ],
)
def test_what_does_not_fit_is_named(idle: httpx.Client, parameters: dict[str, Any], field: str) -> None:
    answer = idle.get(picture(**parameters))
    assert answer.status_code == 422
    assert [error["field"] for error in answer.json()["errors"]] == [field]


def asked(api: httpx.Client, path: str, **question: Any) -> httpx.Response:
    answer = api.post(path, json={"geometry": GEOMETRY, "digits": 15, **question}, headers=WAIT)
    assert answer.status_code == 200, answer.text
    return answer


def test_an_answer_without_a_job_has_an_address(api: httpx.Client, fresh: Callable[[], str]) -> None:
    first, second = fresh(), fresh()
    for l1 in (first, second):
        asked(api, "/v1/cusp-tables", l1=l1)
    both = asked(api, "/v1/cusp-tables", l1=[second, first])
    address = both.headers["content-location"]
    assert api.get(address.removesuffix("/result")).status_code == 404, "no job was needed"
    assert api.get(address).content == both.content
    fewer = api.post("/v1/cusp-tables", json={"geometry": GEOMETRY, "l1": first, "digits": 15})
    assert api.get(fewer.headers["content-location"]).content == fewer.content


def test_an_address_ends_with_its_answer(api: httpx.Client, redis: Redis, fresh: Callable[[], str]) -> None:
    first, second = fresh(), fresh()
    for l1 in (first, second):
        asked(api, "/v1/cusp-tables", l1=l1)
    both = asked(api, "/v1/cusp-tables", l1=[first, second])
    address = both.headers["content-location"]
    key = JobQueue(redis).store.keys.question(address.split("/")[3])
    assert 0 < redis.ttl(key) <= JobQueue(redis).settings.result_ttl_seconds
    redis.delete(key)
    # in another form than the one that the API keeps for a minute
    assert api.get(address, headers={"Accept": "text/csv"}).status_code == 404


@pytest.mark.slow
def test_a_part_of_a_census_has_an_address(api: httpx.Client) -> None:
    asked(api, "/v1/censuses")
    part = asked(api, "/v1/censuses", range={"from": 27, "to": "30.0625"})
    again = api.get(part.headers["content-location"], headers={"If-None-Match": part.headers["etag"]})
    assert again.status_code == 304
