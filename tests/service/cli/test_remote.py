"""Commands that a service answers: the same output, its jobs, and Ctrl-C."""

from __future__ import annotations

import json
import re
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path

import httpx
import pytest

from rpr_solver import EXAMPLES
from service.client import Asked, ServiceClient, cusp_table
from service.schemas.tables import CuspTable
from tests.support.cli_process import ENVIRONMENT, Run, command
from tests.support.processes import PATIENCE, started, until
from worker.jobs.queue import JobQueue

ZEIN = EXAMPLES["zein-flat"]


@pytest.mark.parametrize(
    "args",
    [
        ("solve", "zein-flat", "--l1", "0", "--l1-range", "10:11:0.25", "--format", "csv"),
        ("solve", "zein-flat", "--l2", "17", "--format", "ndjson"),
        ("solve", "zein-flat", "--l1", "10"),
        ("census", "zein-flat", "--l1-range", "22:32", "--format", "csv"),
        ("curves", "zein-flat", "--l1-range", "3:3.2:0.1", "--format", "json"),
        ("poses", "zein-flat", "--l1", "15", "--l2", "61/2", "--l3", "40", "--format", "json"),
        ("paths", "zein-flat", "--l1", "10", "--cusp", "b", "--samples", "40"),
        ("singular", "zein-flat", "--l2", "10", "--tolerance", "0.02"),
        ("aspects", "zein-flat", "--l2-range", "10:"),
        ("check", "zein-flat", "--l1-range", "1:10", "--max-cusps", "3", "--format", "json"),
        ("check", "zein-flat", "--l1", "1", "--l1", "69/2", "--expect-cusps", "8", "--format", "json"),
    ],
    ids=lambda args: f"{args[0]}-{args[-1]}",
)
def test_a_service_gives_the_same_output(run_here: Run, base_url: str, args: tuple[str, ...]) -> None:
    there = run_here(*args, "--digits", "15", "--url", base_url)
    here = run_here(*args, "--digits", "15")
    assert (there.returncode, there.stdout, there.stderr) == (here.returncode, here.stdout, here.stderr)


def test_many_checks_by_a_service_with_a_bad_one(run_here: Run, base_url: str, tmp_path: Path) -> None:
    for number in range(10):
        geometry = {**ZEIN.to_json(), "d1": str(17 + number)} if number != 4 else {"a2x": 1, "a3x": 2}
        (tmp_path / f"{number}.json").write_text(json.dumps(geometry))
    args = ("check", str(tmp_path), "--l1", "12", "--expect-cusps", "4", "--digits", "15")
    there = run_here(*args, "--url", base_url, "--deadline", "300")
    assert there.returncode == 2
    assert there.stdout == run_here(*args, "--jobs", "1").stdout
    assert there.stdout.splitlines()[-1].startswith("10 checked: ")


def test_checks_end_at_once_if_there_is_no_service(run_here: Run) -> None:
    args = ("check", "zein-flat", "innocenti", "--l1", "12", "--expect-cusps", "4")
    done = run_here(*args, "--url", "http://127.0.0.1:1")
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (3, "", 1)


@pytest.mark.parametrize(
    "name", ["solve", "census", "curves", "check", "poses", "paths", "singular", "aspects"]
)
def test_a_deadline_needs_a_service(run_here: Run, name: str) -> None:
    options = {
        "check": ("--l1", "1", "--expect-cusps", "1"),
        "poses": ("--l1", "1", "--l2", "1", "--l3", "1"),
        "solve": ("--l1", "1"),
        "paths": ("--l1", "1"),
        "singular": ("--l1", "1"),
    }
    done = run_here(name, "innocenti", *options.get(name, ()), "--deadline", "5")
    assert (done.returncode, done.stdout) == (2, "")
    assert "--deadline: is for jobs of a service; give --url too" in done.stderr


def test_status_and_fetch(run_here: Run, base_url: str, fresh: Callable[[], str]) -> None:
    asked = cusp_table(ZEIN, [fresh(), fresh()], digits=15)
    with ServiceClient(base_url) as client:
        document = client.ask(asked).document
    job_id = asked.question.job_request().job_id
    where = (job_id, "--url", base_url)
    assert json.loads(run_here("status", *where).stdout)["status"] == "succeeded"
    assert json.loads(run_here("fetch", *where).stdout) == document
    lengths = [option for x in asked.question.content()["l1"] for option in ("--l1", x)]
    for form in ("csv", "ndjson"):
        here = run_here("solve", "zein-flat", *lengths, "--digits", "15", "--format", form)
        assert run_here("fetch", *where, "--format", form).stdout == here.stdout


def test_a_job_that_is_not_there(run_here: Run, idle_url: str) -> None:
    for name in ("status", "fetch", "cancel"):
        done = run_here(name, "ct-0", "--url", idle_url)
        assert (done.returncode, done.stdout) == (2, "")
        assert "There is no job 'ct-0'" in done.stderr


def waiting(idle_url: str, length: str) -> tuple[list[str], str]:
    """Returns a command that waits for a job without a worker, and the id of the job."""
    asked: Asked[CuspTable] = cusp_table(ZEIN, length, digits=15)
    args = ("solve", "zein-flat", "--l1", length, "--digits", "15", "--url", idle_url)
    return command(*args), asked.question.job_request().job_id


def test_ctrl_c_cancels_the_job_and_says_so(idle_url: str, idle_queue: JobQueue) -> None:
    until(lambda: not awaited(idle_queue))
    line, job_id = waiting(idle_url, "79.25")
    with started([*line, "--format", "csv"], env=ENVIRONMENT, stderr=subprocess.PIPE, text=True) as process:
        until(lambda: idle_queue.get(job_id))
        # the events are followed: the client knows its job
        until(lambda: awaited(idle_queue))
        process.send_signal(signal.SIGINT)
        assert process.wait(PATIENCE) == 130
        assert process.stderr.read() == f"rpr-cusps solve: job {job_id} is canceled\n"
    job = idle_queue.get(job_id)
    assert job is not None
    assert job.status == "canceled"


def test_ctrl_c_at_any_moment_names_the_job(idle_url: str, idle_queue: JobQueue) -> None:
    line, job_id = waiting(idle_url, "79.375")
    with started(line, env=ENVIRONMENT, stderr=subprocess.PIPE, text=True) as process:
        until(lambda: idle_queue.get(job_id))
        process.send_signal(signal.SIGINT)
        assert process.wait(PATIENCE) == 130
        assert process.stderr.read().startswith(f"rpr-cusps solve: job {job_id} ")


def test_ctrl_c_says_how_to_come_back_to_a_job_that_others_wait_for(
    idle_url: str, idle_queue: JobQueue
) -> None:
    until(lambda: not awaited(idle_queue))
    line, job_id = waiting(idle_url, "79.5")
    with ServiceClient(idle_url) as client:
        other = cusp_table(ZEIN, "79.5", digits=15).question.body()
        httpx.post(f"{idle_url}/v1/cusp-tables", json=other).raise_for_status()
        with started(
            [*line, "--format", "csv"], env=ENVIRONMENT, stderr=subprocess.PIPE, text=True
        ) as process:
            until(lambda: awaited(idle_queue))
            process.send_signal(signal.SIGINT)
            assert process.wait(PATIENCE) == 130
            back = f"`rpr-cusps fetch {job_id} --url {idle_url}` comes back to it"
            assert process.stderr.read() == f"rpr-cusps solve: job {job_id} goes on; {back}\n"
        assert client.job(job_id)["status"] == "queued"
        assert client.cancel(job_id)["status"] == "canceled"


def awaited(queue: JobQueue) -> bool:
    """Whether someone follows the events of a job."""
    return any(client["cmd"] == "xread" and "b" in client["flags"] for client in queue.redis.client_list())


def test_cancel(run_here: Run, idle_url: str, idle_queue: JobQueue) -> None:
    line, job_id = waiting(idle_url, "79.75")
    with started(line, env=ENVIRONMENT, stderr=subprocess.PIPE, text=True) as process:
        until(lambda: idle_queue.get(job_id))
        until(
            lambda: json.loads(run_here("cancel", job_id, "--url", idle_url).stdout)["status"] == "canceled"
        )
        assert process.wait(PATIENCE) == 2
        assert "was canceled" in process.stderr.read()


def looks(url: str) -> float:
    """Returns how often clients have looked at jobs."""
    metrics = httpx.get(f"{url}/metrics").text
    found = re.search(r'method="GET",route="/v1/jobs/\{job_id\}",status="200"\} (\S+)', metrics)
    return float(found[1]) if found else 0.0


def test_ctrl_c_withdraws_all_checks(idle_url: str, idle_queue: JobQueue) -> None:
    requirement = ("--l1", "80.5", "--expect-cusps", "4", "--digits", "15", "--url", idle_url)
    jobs = [
        cusp_table(EXAMPLES[name], "80.5", digits=15).question.job_request().job_id
        for name in ("zein-flat", "innocenti")
    ]
    line = command("check", "zein-flat", "innocenti", *requirement)
    before = looks(idle_url)
    with started(line, env=ENVIRONMENT, stderr=subprocess.PIPE, text=True) as process:
        until(lambda: all(map(idle_queue.get, jobs)))
        until(lambda: looks(idle_url) >= before + 8)  # so both jobs are known to the client
        process.send_signal(signal.SIGINT)
        assert process.wait(PATIENCE) == 130
        assert process.stderr.read() == ""
    assert {job.status for job in map(idle_queue.get, jobs) if job is not None} == {"canceled"}


def test_jobs(run_here: Run, idle_url: str) -> None:
    asked = cusp_table(ZEIN, "79.8125", digits=15)
    with ServiceClient(idle_url) as client:
        job = client.begin(asked)
        where = ("--url", idle_url)
        title, first, *_ = run_here("jobs", *where, "--limit", "1").stdout.splitlines()
        columns = ["ID", "KIND", "STATUS", "CREATED", "ESTIMATE", "RUNS", "OVERRUNS", "KEY"]
        assert title.split() == columns
        assert first.split()[:3] == [job.id, "cusp-table", "queued"]
        done = run_here("cancel", job.id, "--force", *where)
        assert json.loads(done.stdout)["status"] == "canceled"
        assert job.id not in run_here("jobs", *where).stdout
        found = json.loads(run_here("jobs", "--all", "--format", "json", *where).stdout)
        assert [item["status"] for item in found if item["id"] == job.id] == ["canceled"]
