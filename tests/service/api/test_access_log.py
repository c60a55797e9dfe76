"""A log line for each request, and the id of the request in the lines of its job."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import httpx
import pytest

from service.api.settings import Settings
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import PATIENCE, environment, started, until
from tests.support.service_server import GEOMETRY, ended, serving


def request_id(name: str) -> dict[str, str]:
    return {"X-Request-ID": name}


def test_requests_and_their_jobs_are_logged_under_one_id(valkey: EmbeddedValkey, tmp_path: Path) -> None:
    log = tmp_path / "log"
    command = [sys.executable, "-m", "service", "serve", "--port", "0", "--workers", "1"]
    variables = environment(redis_url=f"{valkey.url}?db=9", log_format="json", log_level="INFO")
    options = {"env": variables, "stdout": subprocess.PIPE, "text": True}
    with log.open("wb") as stderr, started(command, stderr=stderr, **options) as stack:
        url = re.search(r"http://\S+", stack.stdout.readline())[0]
        with httpx.Client(base_url=url, timeout=PATIENCE) as client:
            body = {"geometry": GEOMETRY, "l1": "31.5"}
            headers = {**request_id("asked-1"), "Prefer": "respond-async"}
            response = client.post("/v1/cusp-tables", json=body, headers=headers)
            job_id = response.json()["id"]
            ended(client, job_id)
            client.get("/no%0A%1Bsuch", headers=request_id("asked-2"))

        def lines(name: str) -> list[dict[str, object]]:
            found = map(json.loads, log.read_text().splitlines())
            return [line for line in found if line.get("request_id") == name]

        until(lambda: any("chunk 0 (1 slices): done" in str(line["message"]) for line in lines("asked-1")))
        [access] = [line for line in lines("asked-1") if line["logger"] == "rpr_cusps.access"]
        assert access["method"] == "POST"
        assert access["path"] == "/v1/cusp-tables"
        assert access["status"] == response.status_code
        assert access["bytes"] == int(response.headers["content-length"])
        assert access["key"] == "-"
        assert 0 < float(str(access["duration_ms"])) < 1000 * PATIENCE
        [chunk] = [line for line in lines("asked-1") if "chunk" in str(line["message"])]
        assert chunk["job"] == job_id
        [odd] = until(lambda: lines("asked-2"))
        assert odd["path"] == "/no%0A%1Bsuch"


@pytest.mark.parametrize(("wanted", "statuses"), [("all", [200, 404]), ("errors", [404]), ("off", [])])
def test_which_requests_are_logged(
    wanted: str, statuses: list[int], caplog: pytest.LogCaptureFixture, valkey: EmbeddedValkey
) -> None:
    with serving(Settings(redis_url=valkey.url, access_log=wanted)) as url:
        for path in ("/healthz", "/none"):
            httpx.get(url + path)
    lines = [record.getMessage() for record in caplog.records if record.name == "rpr_cusps.access"]
    assert [int(re.fullmatch(r"- GET /\w+ (\d+) \d+ B [\d.]+ ms", line)[1]) for line in lines] == statuses
