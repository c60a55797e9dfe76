"""What an operator sets and sees: settings, the log of requests, and metrics."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import httpx
import pytest
from redis import Redis

from docs.reference import families
from service import __version__
from service.api.settings import Settings
from service.cli.serve import names
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.jobs import a_document, a_heavy_document, a_request
from tests.support.processes import PATIENCE, environment, started, until
from tests.support.service_server import GEOMETRY, ended, serving
from worker.connection import connect
from worker.jobs.attempts import Attempts
from worker.jobs.chunks import ChunkRef
from worker.jobs.installation import read_load
from worker.jobs.interruptions import Cause, Interruptions
from worker.jobs.plan import LANES
from worker.jobs.queue import JobQueue
from worker.settings import WorkerSettings


def test_the_environment_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RPR_CUSPS_MAX_SLICES", "7")
    monkeypatch.setenv("RPR_CUSPS_REDIS_URL", "redis://queue:1/2")
    settings = Settings()
    assert (settings.limits.max_slices, settings.redis_url) == (7, "redis://queue:1/2")


def test_the_version_is_that_of_the_project() -> None:
    project = tomllib.loads((Path(__file__).parents[3] / "pyproject.toml").read_text())
    assert project["project"]["version"] == __version__


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


@pytest.mark.parametrize(("wanted", "statuses"), [("all", [200, 404]), ("errors", [404])])
def test_which_requests_are_logged(
    wanted: str, statuses: list[int], caplog: pytest.LogCaptureFixture, valkey: EmbeddedValkey
) -> None:
    with serving(Settings(redis_url=valkey.url, access_log=wanted)) as url:
        for path in ("/healthz", "/none"):
            httpx.get(url + path)
    lines = [record.getMessage() for record in caplog.records if record.name == "rpr_cusps.access"]
    assert [int(re.fullmatch(r"- GET /\w+ (\d+) \d+ B [\d.]+ ms", line)[1]) for line in lines] == statuses


REFERENCE = Path(__file__).parents[3] / "docs" / "reference.md"
Values = dict[str, float]


@pytest.fixture
def queue(valkey: EmbeddedValkey) -> JobQueue:
    """The queue of a database that no worker serves."""
    client = connect(f"{valkey.url}?db=2")
    client.flushdb()
    return JobQueue(client, WorkerSettings())


@pytest.fixture
def url(valkey: EmbeddedValkey, queue: JobQueue) -> str:  # noqa: ARG001
    with serving(Settings(redis_url=f"{valkey.url}?db=2", keepalive_seconds=0.3)) as url:
        yield url


def scrape(url: str) -> Values:
    lines = httpx.get(f"{url}/metrics").text.splitlines()
    pairs = [line.rsplit(" ", 1) for line in lines if not line.startswith("#")]
    return {name: float(value) for name, value in pairs}


def begun(queue: JobQueue, *l1: str) -> ChunkRef:
    view = queue.submit(a_request(*l1))
    ref = ChunkRef(view.id, view.run, 0, 0)
    assert Attempts(queue.redis, queue.settings).start(ref, 0, len(l1) - 1)
    return ref


def test_every_metric_is_documented_and_every_documented_one_exists(url: str, queue: JobQueue) -> None:
    queue.records.fail(begun(queue, "1").job_id, "", "timeout", "too long")
    scrape(url)
    text = httpx.get(f"{url}/metrics").text
    types = dict(re.findall(r"^# TYPE (\S+) (\w+)$", text, re.MULTILINE))
    section = REFERENCE.read_text().partition("<!-- metrics -->")[2].partition("<!-- end of metrics -->")[0]
    documented = dict(re.findall(r"^\| `(\w+)` \| (\w+) \|", section, re.MULTILINE))
    assert types == documented


def test_the_queue_by_lane(url: str, queue: JobQueue) -> None:
    assert scrape(url)['rpr_cusps_queue_age_seconds{lane="small"}'] == 0
    first = queue.submit(a_request("1"))
    queue.submit(a_document())
    queue.submit(a_heavy_document())
    queue.redis.hset(queue.records.keys.job(first.id).record, "created", f"{queue.redis.time()[0] - 100}.5")
    values = scrape(url)
    assert values['rpr_cusps_queue_depth{lane="small"}'] == 2
    assert values['rpr_cusps_queue_depth{lane="heavy"}'] == 1
    assert 99 < values['rpr_cusps_queue_age_seconds{lane="small"}'] < 100 + PATIENCE
    assert 0 < values['rpr_cusps_queue_age_seconds{lane="heavy"}'] < PATIENCE
    assert values["rpr_cusps_jobs_active"] == 3


def test_ends_of_jobs(url: str, queue: JobQueue) -> None:
    ref = begun(queue, "1")
    record = queue.records.keys.job(ref.job_id).record
    now = queue.redis.time()[0]
    queue.redis.hset(record, mapping={"created": f"{now - 25}.0", "started": f"{now - 5}.0"})
    queue.records.fail(ref.job_id, ref.run, "timeout", "too long")
    queue.records.cancel(queue.submit(a_document()).id)
    values = scrape(url)
    assert values['rpr_cusps_jobs_ended_total{kind="cusp-table",status="failed"}'] == 1
    assert values['rpr_cusps_jobs_ended_total{kind="poses",status="canceled"}'] == 1
    assert values['rpr_cusps_job_failures_total{kind="cusp-table",reason="timeout"}'] == 1
    run = 'rpr_cusps_job_run_seconds_bucket{kind="cusp-table",le="%s"}'
    assert [values[run % le] for le in ("3", "100", "+Inf")] == [0, 1, 1]
    assert 5 <= values['rpr_cusps_job_run_seconds_sum{kind="cusp-table"}'] < 5 + PATIENCE
    assert values['rpr_cusps_job_wait_seconds_sum{kind="cusp-table"}'] == pytest.approx(20)
    assert values['rpr_cusps_job_wait_seconds_count{kind="poses"}'] == 1
    assert 'rpr_cusps_job_run_seconds_count{kind="poses"}' not in values, "it never ran"


def test_losses_and_workers(url: str, queue: JobQueue) -> None:
    Interruptions(queue.redis, queue.settings).happened(begun(queue, "1"), Cause("lost"))
    queue.redis.sadd(f"rq:workers:{queue.chunks.queues['small'].name}", "rq:worker:a", "rq:worker:dead")
    queue.redis.hset("rq:worker:a", "state", "idle")
    values = scrape(url)
    assert values['rpr_cusps_chunks_lost_total{what="worker"}'] == 1
    assert values['rpr_cusps_chunks_lost_total{what="horse"}'] == 0
    assert values["rpr_cusps_workers"] == 1


def test_followers_and_requests_in_flight(url: str, queue: JobQueue) -> None:
    job_id = queue.submit(a_request("1")).id
    assert scrape(url)["rpr_cusps_followers"] == 0
    with httpx.stream("GET", f"{url}/v1/jobs/{job_id}/events", timeout=PATIENCE) as stream:
        lines = stream.iter_lines()
        next(lines)
        values = scrape(url)
        assert values["rpr_cusps_followers"] == 1
        assert values["rpr_cusps_http_in_flight"] == 2, "the follower and the scrape"
    until(lambda: scrape(url)["rpr_cusps_followers"] == 0)


def commands(client: Redis) -> int:
    return int(client.info("stats")["total_commands_processed"])


def test_a_scrape_costs_as_little_with_more_jobs(tmp_path: Path) -> None:
    with EmbeddedValkey(tmp_path) as valkey, connect(valkey.url) as redis:  # where nobody else sends commands
        queue = JobQueue(redis, WorkerSettings())

        def cost_of_reading() -> int:
            before = commands(redis)
            read_load(redis, queue.settings)
            return commands(redis) - before - 1

        queue.submit(a_request("1"))
        queue.submit(a_request("1", "2", "3"))
        few = cost_of_reading()
        for i in range(50):
            queue.submit(a_request(str(i + 100)))
            queue.submit(a_request(str(i + 1), str(i + 2), str(i + 3)))
        assert cost_of_reading() == few <= 10 + 2 * len(LANES)


def test_the_guide_for_operators_names_metrics_and_settings_that_exist() -> None:
    text = (REFERENCE.parent / "operating.md").read_text()
    shown = {metric.name for group in families().values() for metric in group}
    assert set(re.findall(r"rpr_cusps_\w+", text)) <= shown
    of_the_build = {"RPR_CUSPS_COMMIT"}
    assert set(re.findall(r"RPR_CUSPS_[A-Z_]*[A-Z]", text)) <= names() | of_the_build
