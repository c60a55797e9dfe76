"""Pictures by HTTP: as documents, as SVG, and by an address that caches and pages can keep."""

from __future__ import annotations

from typing import Any
from urllib.parse import urlencode
from xml.etree import ElementTree

import httpx
import pytest

from rpr_solver import EXAMPLES, singular_curves
from tests.service.api.test_documents_api import is_whole
from tests.support.service_server import GEOMETRY

SVG = "image/svg+xml"


def address(**parameters: Any) -> str:
    return f"/v1/plot.svg?{urlencode({**GEOMETRY, **parameters})}"


def test_a_picture_has_an_address_that_a_page_can_show(api: httpx.Client) -> None:
    here = address(l1="14.98", wait=30)
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


@pytest.mark.parametrize("plot", ["torus", "loop", "mechanism"])
def test_every_view_of_a_slice(api: httpx.Client, plot: str) -> None:
    cusp = {} if plot == "torus" else {"cusp": "B"}
    answer = api.get(address(plot=plot, l1=27, wait=30, theme="dark", **cusp))
    assert answer.status_code == 200
    assert ("@keyframes" in answer.text) == (plot == "loop")
    assert "prefers-color-scheme" not in answer.text


@pytest.mark.parametrize(
    ("parameters", "field"),
    [
        ({}, "l1"),
        ({"l1": 27, "l2": 3}, "l2"),
        ({"l1": 27, "plot": "pie"}, "plot"),
        ({"l1": 27, "plot": "census"}, "l1"),
        ({"l1": 27, "theme": "red"}, "theme"),
        ({"l1": 27, "cusp": 2}, "cusp"),
        ({"plot": "mechanism", "l1": 27, "l2": 3}, "l3"),
        ({"plot": "mechanism", "l1": 27, "l2": 3, "l3": 4, "pose": 7}, "pose"),
        ({"plot": "loop", "l1": 27, "cusp": "?"}, "cusp"),
        ({"l1": 27, "format": "csv"}, "format"),
    ],
)
def test_what_does_not_fit_is_named(idle: httpx.Client, parameters: dict[str, Any], field: str) -> None:
    answer = idle.get(address(**parameters))
    assert answer.status_code == 422
    assert [error["field"] for error in answer.json()["errors"]] == [field]


def test_a_cusp_that_a_slice_lacks(api: httpx.Client) -> None:
    answer = api.get(address(plot="mechanism", l1=27, cusp="J", wait=30))
    assert (answer.status_code, answer.json()["type"]) == (422, "/problems/job-input-error")
    assert "cusp: is 10 (J); give 1 to 8" in answer.text
