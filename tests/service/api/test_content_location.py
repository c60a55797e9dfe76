"""Every answer to a question has an address."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import httpx
import pytest
from redis import Redis

from tests.support.service_server import GEOMETRY
from worker.jobs.queue import JobQueue

WAIT = {"Prefer": "wait=30"}


def asked(api: httpx.Client, path: str, **question: Any) -> httpx.Response:
    answer = api.post(path, json={"geometry": GEOMETRY, "digits": 15, **question}, headers=WAIT)
    assert answer.status_code == 200, answer.text
    return answer


def test_the_address_of_an_answer_gives_it_again(api: httpx.Client, fresh: Callable[[], str]) -> None:
    l1 = fresh()
    computed, known = (asked(api, "/v1/cusp-tables", l1=l1) for _ in range(2))
    address = computed.headers["content-location"]
    assert known.headers["content-location"] == address
    again = api.get(address)
    assert again.content == computed.content
    assert again.headers["etag"] == computed.headers["etag"]
    same = api.get(address, headers={"If-None-Match": computed.headers["etag"]})
    assert (same.status_code, same.content) == (304, b"")
    assert api.get(address, headers={"Accept": "text/csv"}).text.startswith("l1,")


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
    assert 0 < redis.ttl(key) <= JobQueue(redis).settings.job_ttl
    redis.delete(key)
    assert api.get(address).status_code == 404


@pytest.mark.slow
def test_a_part_of_a_census_has_an_address(api: httpx.Client) -> None:
    asked(api, "/v1/censuses")
    part = asked(api, "/v1/censuses", range={"from": 27, "to": "30.0625"})
    again = api.get(part.headers["content-location"], headers={"If-None-Match": part.headers["etag"]})
    assert again.status_code == 304
