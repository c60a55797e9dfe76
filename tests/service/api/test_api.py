"""The service with a real queue and a real worker."""

from __future__ import annotations

import json
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import httpx
import pytest
from redis import Redis

from rpr_solver import EXAMPLES, cusp_table, exact_str, parse_exact
from service.api.app import create_app
from service.api.settings import Settings
from service.schemas.tables import CuspTableRequest
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.jobs import a_request
from tests.support.processes import PATIENCE, until
from tests.support.service_server import GEOMETRY, NO_WAIT, accepted, ended, serving_app
from worker.jobs.queue import JobQueue

Fresh = Callable[[], str]


EXAMPLE = {"geometry": GEOMETRY, **CuspTableRequest.examples["slice"][1]}


def post(client: httpx.Client, slices: object, wait: int | None = 20, **more: object) -> httpx.Response:
    headers = NO_WAIT if wait is None else {"Prefer": f"wait={wait}"}
    return client.post("/v1/cusp-tables", json={"geometry": GEOMETRY, "l1": slices, **more}, headers=headers)


def long_job(client: httpx.Client, fresh: Fresh) -> str:
    """A job of a few seconds, with slices that no other test requests."""
    first = parse_exact(fresh(), "l1")
    step = parse_exact("1/1000000", "step")
    slices = [exact_str(first + step * i) for i in range(1, 900)]
    answer = post(client, slices, wait=None, digits=300)
    assert answer.status_code == 202
    job_id: str = answer.json()["id"]
    return job_id


def test_an_unknown_table_is_a_job_that_leads_to_it(api: httpx.Client, fresh: Fresh) -> None:
    slices = [fresh(), fresh()]
    answer = post(api, slices, wait=None)
    assert answer.status_code == 202
    job = answer.json()
    assert answer.headers["location"] == job["links"]["self"] == f"/v1/jobs/{job['id']}"
    assert int(answer.headers["retry-after"]) >= 1
    assert job["progress"]["total"] == 2
    done = ended(api, job["id"])
    assert (done["status"], done["progress"]) == ("succeeded", {"done": 2, "total": 2})
    expected = [table.to_json() for table in cusp_table(EXAMPLES["innocenti"], slices)]
    assert api.get(job["links"]["result"]).json()["slices"] == expected


def test_a_known_table_is_answered_at_once_and_in_any_spelling(api: httpx.Client, fresh: Fresh) -> None:
    l1 = fresh()
    first = post(api, l1)
    again = api.post(
        "/v1/cusp-tables",
        content=f'{{"l1": [{l1}000], "geometry": {json.dumps({k: f"{v}e0" for k, v in GEOMETRY.items()})}}}',
        headers={"Content-Type": "application/json; charset=utf-8"},
    )
    assert (first.status_code, again.status_code) == (200, 200)
    assert again.json() == first.json()


def test_prefer_is_honoured_and_confirmed(api: httpx.Client, fresh: Fresh) -> None:
    def applied(seconds: int) -> str:
        """Of an answer that was not there before anybody waited."""
        return until(lambda: post(api, fresh(), wait=seconds).headers.get("preference-applied", ""))

    assert (applied(7), applied(10**9)) == ("wait=7", "wait=30")
    prefer = [("Prefer", "respond-async"), ("Prefer", "x=1")]
    answer = accepted(
        lambda: api.post("/v1/cusp-tables", json={"geometry": GEOMETRY, "l1": fresh()}, headers=prefer)
    )
    assert answer.headers["preference-applied"] == "respond-async"


def test_a_slice_without_an_answer_leaves_the_others_unaffected(api: httpx.Client, fresh: Fresh) -> None:
    answer = post(api, [0, fresh()])
    bad, good = answer.json()["slices"]
    assert answer.status_code == 200
    assert (bad["l1"], bad["error"]["type"]) == ("0", "input-error")
    assert "count" in good


@pytest.mark.parametrize("leg", [2])
def test_another_leg_can_be_fixed(api: httpx.Client, leg: int) -> None:
    body = {"geometry": GEOMETRY, f"l{leg}": 14.98, "fixed_leg": leg}
    answer = api.post("/v1/cusp-tables", json=body, headers={"Prefer": "wait=20"})
    [slice_] = answer.json()["slices"]
    assert slice_[f"l{leg}"] == "14.98"
    assert all(f"theta{leg}_deg" in cusp for cusp in slice_["cusps"])


def test_fewer_digits_are_served_from_more(api: httpx.Client, fresh: Fresh) -> None:
    l1 = fresh()
    post(api, l1, digits=60)
    answer = post(api, l1, wait=None, digits=20)
    assert (answer.status_code, answer.json()["digits"]) == (200, 20)


def test_events_report_each_slice_and_end_with_the_job(api: httpx.Client, fresh: Fresh) -> None:
    slices = [fresh() for _ in range(5)]
    job_id = post(api, slices, wait=None).json()["id"]
    events = read_events(api, job_id)
    done = [data for _, name, data in events if name == "slice"]
    assert [data["l1"] for data in done] == [exact_str(parse_exact(x, "l1")) for x in slices]
    assert [data["progress"] for data in done] == [{"done": i, "total": 5} for i in range(1, 6)]
    assert all(data["slice"]["count"] == len(data["slice"]["cusps"]) for data in done)
    assert events[-1][1:][0] == "status"
    assert events[-1][2]["status"] == "succeeded"

    third = next(i for i, event in enumerate(events) if event[2].get("l1") == done[2]["l1"])
    assert read_events(api, job_id, last=events[third][0]) == events[third + 1 :]
    over = api.get(f"/v1/jobs/{job_id}/events", headers={"Last-Event-ID": events[-1][0]})
    assert over.status_code == 204


def read_events(client: httpx.Client, job_id: str, last: str | None = None) -> list[tuple[str, str, dict]]:  # type: ignore[type-arg]
    headers = {"Last-Event-ID": last} if last else {}
    with client.stream("GET", f"/v1/jobs/{job_id}/events", headers=headers) as stream:
        assert stream.headers["content-type"].startswith("text/event-stream")
        blocks = stream.read().decode().split("\n\n")
    events = []
    for block in blocks:
        fields = dict(line.split(": ", 1) for line in block.splitlines() if not line.startswith(":"))
        if "data" in fields:
            events.append((fields["id"], fields["event"], json.loads(fields["data"])))
    return events


def test_a_running_job_has_no_result_yet_and_can_be_canceled(api: httpx.Client, fresh: Fresh) -> None:
    job_id = long_job(api, fresh)
    early = api.get(f"/v1/jobs/{job_id}/result")
    assert (early.status_code, early.json()["type"]) == (409, "/problems/job-not-finished")
    assert "retry-after" in early.headers
    canceled = api.delete(f"/v1/jobs/{job_id}")
    assert (canceled.status_code, canceled.json()["status"]) == (200, "canceled")
    assert api.delete(f"/v1/jobs/{job_id}").json() == canceled.json()
    late = api.get(f"/v1/jobs/{job_id}/result")
    assert (late.status_code, late.json()["type"]) == (409, "/problems/job-canceled")


def test_without_keys_anybody_cancels_a_job(idle: httpx.Client, idle_queue: JobQueue, fresh: Fresh) -> None:
    """A client that waits for it hears of it."""
    l1 = fresh()
    with ThreadPoolExecutor(1) as pool:
        job_id = post(idle, l1, wait=None).json()["id"]
        waiting = pool.submit(post, idle, l1, wait=30)
        until(lambda: any(client["cmd"] == "xread" for client in idle_queue.redis.client_list()))
        assert idle.delete(f"/v1/jobs/{job_id}").json()["status"] == "canceled"
        answer = waiting.result()
    assert (answer.status_code, answer.json()["type"]) == (409, "/problems/job-canceled")


def test_the_operator_of_a_service_without_keys_ends_what_others_wait_for(
    idle: httpx.Client, fresh: Fresh
) -> None:
    """From the same computer, and not through a proxy, behind which anybody may be."""
    job = f"/v1/jobs/{post(idle, fresh(), wait=None).json()['id']}?force=true"
    for header in ("X-Forwarded-For", "Forwarded", "Via"):
        answer = idle.delete(job, headers={header: "192.0.2.7"})
        assert (answer.status_code, answer.json()["type"]) == (403, "/problems/forbidden")
    assert idle.delete(job).json()["status"] == "canceled"


def test_an_expired_result_is_gone(api: httpx.Client, redis: Redis, fresh: Fresh) -> None:
    l1 = fresh()
    job = post(api, l1, wait=None).json()
    ended(api, job["id"])
    queue = JobQueue(redis)
    _, request, _ = queue.records.request(job["id"])  # type: ignore[misc]
    redis.delete(*queue.store.slice_keys(request, request.parts))
    answer = api.get(job["links"]["result"])
    assert (answer.status_code, answer.json()["type"]) == (410, "/problems/result-expired")
    assert post(api, l1).status_code == 200


@pytest.mark.parametrize(
    ("kind", "status", "slug"),
    [
        ("timeout", 504, "job-timeout"),
        ("solver-error", 422, "job-solver-error"),
        ("something-new", 500, "job-failed"),
    ],
)
def test_a_failed_job_says_why(
    idle: httpx.Client, idle_queue: JobQueue, fresh: Fresh, kind: str, status: int, slug: str
) -> None:
    request = a_request(fresh())
    view = idle_queue.submit(request)
    idle_queue.records.fail(view.id, view.run, kind, "This is why.")
    answer = idle.get(f"/v1/jobs/{request.job_id}/result")
    problem = answer.json()
    assert (answer.status_code, problem["type"], problem["detail"]) == (
        status,
        f"/problems/{slug}",
        "This is why.",
    )
    assert idle.get(f"/v1/jobs/{request.job_id}").json()["error"] == {"type": kind, "detail": "This is why."}


def test_waiting_ends_when_the_time_is_over(idle: httpx.Client, fresh: Fresh) -> None:
    answer = post(idle, fresh(), wait=1)
    assert (answer.status_code, answer.json()["status"]) == (202, "queued")
    assert answer.headers["preference-applied"] == "wait=1"


def test_a_quiet_event_stream_is_kept_alive(idle: httpx.Client, fresh: Fresh) -> None:
    job_id = post(idle, fresh(), wait=None).json()["id"]
    with idle.stream("GET", f"/v1/jobs/{job_id}/events") as stream:
        for line in stream.iter_lines():
            if line == ": waiting":
                break
    assert idle.delete(f"/v1/jobs/{job_id}").json()["status"] == "canceled"


def test_readiness_needs_a_worker(api: httpx.Client, idle: httpx.Client) -> None:
    assert api.get("/readyz").json() == {"status": "ready", "workers": 1, "warnings": []}
    answer = idle.get("/readyz")
    assert (answer.status_code, answer.headers["retry-after"]) == (503, "2")
    assert (answer.json()["type"], answer.json()["title"]) == ("/problems/no-worker", "No worker is running")


def test_metrics_count_requests_and_show_the_queue(api: httpx.Client) -> None:
    api.get("/healthz")
    text = api.get("/metrics").text
    assert 'rpr_cusps_http_requests_total{method="GET",route="/healthz",status="200"}' in text
    assert "rpr_cusps_workers 1.0" in text
    assert "rpr_cusps_up 1.0" in text
    assert 'rpr_cusps_queue_depth{lane="small"} ' in text


def test_streams_end_when_the_server_does(valkey: EmbeddedValkey, fresh: Fresh) -> None:
    """An idle stream does not delay the shutdown of the service."""
    app = create_app(Settings(redis_url=f"{valkey.url}?db=1", keepalive_seconds=600))

    @app.post("/stop")
    async def stop() -> None:
        app.state.begin_shutdown()

    with serving_app(app) as url, httpx.Client(base_url=url) as client:
        job_id = post(client, fresh(), wait=None).json()["id"]
        with client.stream("GET", f"/v1/jobs/{job_id}/events", timeout=PATIENCE) as stream:
            lines = stream.iter_lines()
            while "queued" not in next(lines):
                pass
            httpx.post(f"{url}/stop")
            assert not any(line.startswith("data") for line in lines)
        client.delete(f"/v1/jobs/{job_id}")


def test_a_canceled_job_that_is_asked_for_again_is_a_new_run(idle: httpx.Client) -> None:
    body = {**EXAMPLE, "l1": "3.0625", "digits": 15}
    first = idle.post("/v1/cusp-tables", json=body).json()
    canceled = idle.delete(first["links"]["self"]).json()
    assert (canceled["status"], canceled["done"]) == ("canceled", True)
    assert canceled["started_at"] is None
    again = idle.post("/v1/cusp-tables", json=body).json()
    assert (again["id"], again["status"], again["done"]) == (first["id"], "queued", False)
    assert again["run"] != first["run"]


def test_an_event_names_the_length_by_its_leg(api: httpx.Client, fresh: Fresh) -> None:
    body = {"geometry": GEOMETRY, "fixed_leg": 2, "l2": fresh(), "digits": 15}
    job = api.post("/v1/cusp-tables", json=body, headers=NO_WAIT).json()
    ended(api, job["id"])
    [found] = [data for _, name, data in read_events(api, job["id"]) if name == "slice"]
    assert found["l2"] == found["slice"]["l2"] == body["l2"]
    assert "l1" not in found


def test_who_prefers_nothing_waits_briefly(api: httpx.Client, idle: httpx.Client, fresh: Fresh) -> None:
    body = {"geometry": GEOMETRY, "l1": fresh(), "digits": 15}
    assert idle.post("/v1/cusp-tables", json=body).status_code == 202
    accepted = api.post("/v1/cusp-tables", json=body, headers=NO_WAIT)
    assert accepted.headers.get("preference-applied") == "respond-async"
    ended(api, accepted.json()["id"])
    known = api.post("/v1/cusp-tables", json=body, headers={"Prefer": ""})
    assert (known.status_code, "preference-applied" in known.headers) == (200, False)


def test_a_replay_tells_the_states_as_they_were(api: httpx.Client, fresh: Callable[[], str]) -> None:
    body = {**EXAMPLE, "l1": fresh(), "digits": 15}
    job = api.post("/v1/cusp-tables", json=body, headers=NO_WAIT).json()
    end = ended(api, job["id"])
    queued, running, last = [data for _, name, data in read_events(api, job["id"]) if name == "status"]
    assert (queued["status"], queued["started_at"], queued["ended_at"]) == ("queued", None, None)
    assert (running["status"], running["started_at"]) == ("running", end["started_at"])
    assert running["ended_at"] is None
    assert "progress" not in queued | running
    assert last == end
