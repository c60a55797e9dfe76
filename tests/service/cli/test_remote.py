"""Commands that a service answers: the same output, its jobs and batches, and Ctrl-C."""

from __future__ import annotations

import csv
import io
import json
import re
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from rpr_solver import EXAMPLES
from service.client import Asked, ServiceClient, cusp_table
from service.schemas.tables import CuspTable
from tests.support.cli_process import ENVIRONMENT, Run, command
from tests.support.processes import PATIENCE, started, until
from tests.support.service_server import looks
from worker.jobs.queue import JobQueue

ZEIN = EXAMPLES["zein-flat"]


@pytest.mark.parametrize(
    "args",
    [
        ("solve", "zein-flat", "--l1", "0", "--l1-range", "10:11:0.25", "--format", "csv"),
        ("solve", "zein-flat", "--l2", "17", "--format", "ndjson"),
        ("path", "zein-flat", "--l1", "10", "--cusp", "b", "--samples", "40"),
        ("check", "zein-flat", "--l1-range", "1:10", "--max-cusps", "3", "--format", "json"),
        ("check", "innocenti", "--l1", "27", "--expect-cusps", "8", "--tolerance", "d1=1e-4", "--json"),
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
    "name",
    ["solve", "check", "margin"],
)
def test_a_deadline_needs_a_service(run_here: Run, name: str) -> None:
    options = {
        "check": ("--l1", "1", "--expect-cusps", "1"),
        "poses": ("--l1", "1", "--l2", "1", "--l3", "1"),
        "solve": ("--l1", "1"),
        "path": ("--l1", "1"),
        "singular-curves": ("--l1", "1"),
        "assembly-modes": ("--l1", "1"),
        "pose-connections": ("--l1", "1", "--l2", "1", "--l3", "1"),
        "margin": ("--l1", "1"),
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
        columns = ["ID", "KIND", "STATUS", "CREATED", "STARTED", "ENDED", "ESTIMATE", "KEY"]
        assert title.split() == columns
        assert first.split()[:3] == [job.id, "cusp-table", "queued"]
        done = run_here("cancel", job.id, "--force", *where)
        assert json.loads(done.stdout)["status"] == "canceled"
        assert job.id not in run_here("jobs", *where).stdout
        found = json.loads(run_here("jobs", "--all", "--format", "json", *where).stdout)
        assert [item["status"] for item in found if item["id"] == job.id] == ["canceled"]


GEOMETRY = EXAMPLES["zein-flat"].to_json()
TABLE = {"geometry": GEOMETRY, "l1": ["1.2345", "10.2345"], "digits": 15}


def lines(*items: object) -> str:
    return "".join(json.dumps(item) + "\n" for item in items)


def pose(l2: str, **more: str) -> dict[str, object]:
    request = {"geometry": GEOMETRY, "l1": "15", "l2": l2, "l3": "40", "digits": 15}
    return {"kind": "poses", "request": request, **more}


def test_csv_in_and_out(run_here: Run, base_url: str, tmp_path: Path) -> None:
    names = ["id", *GEOMETRY, "l1", "digits"]
    rows = [["'=HYPERLINK(1), two", *GEOMETRY.values(), "0;10", "15"], ["bad", *GEOMETRY.values(), "1", "5"]]
    text = io.StringIO()
    csv.writer(text).writerows([names, *rows])
    path = tmp_path / "designs.csv"
    path.write_text(text.getvalue())
    done = run_here("submit", str(path), "--url", base_url, "--format", "csv")
    assert done.returncode == 1
    assert done.stderr == "rpr-cusps submit: 2 of 2 items have no complete answer; each says why\n"
    head, *body, last = csv.reader(io.StringIO(done.stdout))
    alone = run_here("solve", "zein-flat", "--l1", "0", "--l1", "10", "--digits", "15", "--format", "csv")
    columns, *expected = csv.reader(io.StringIO(alone.stdout))
    assert head == ["index", "id", *columns]
    assert body == [["0", "'=HYPERLINK(1), two", *row] for row in expected]
    assert last[:2] == ["1", "bad"]
    assert "items[1].request.digits: asks for 5 digits" in last[head.index("error")]


def test_csv_is_for_tables_of_one_leg(run_here: Run, base_url: str) -> None:
    other = {"geometry": GEOMETRY, "fixed_leg": 2, "l2": "17", "digits": 15}
    for item, message in (
        (pose("30"), "items[1] is poses"),
        ({"kind": "cusp-table", "request": other}, "items[1] fixes leg 2, those before it leg 1"),
    ):
        stdin = lines({"kind": "cusp-table", "request": TABLE}, item)
        done = run_here("submit", "-", "--url", base_url, "--format", "csv", stdin=stdin)
        assert (done.returncode, done.stderr.count("\n")) == (2, 1)
        assert message in done.stderr


def test_one_comes_back_to_a_batch(run_here: Run, base_url: str) -> None:
    stdin = lines(pose("30"), pose("31"), pose("-1"))
    done = run_here("submit", "-", "--no-wait", "--url", base_url, "--key", "comes-back", stdin=stdin)
    assert done.returncode == 0
    batch = done.stdout.strip()
    assert done.stderr == (
        f"rpr-cusps submit: 3 items; `rpr-cusps fetch {batch} --url {base_url}` prints their answers\n"
    )
    where = (batch, "--url", base_url)
    fetched = run_here("fetch", *where)
    assert (fetched.returncode, fetched.stdout.count("\n")) == (1, 3)
    assert json.loads(run_here("status", *where).stdout)["status"] == "completed"
    assert json.loads(run_here("cancel", *where).stdout)["failed"] == 1
    again = run_here("submit", "-", "--url", base_url, "--key", "comes-back", stdin=stdin)
    assert sorted(again.stdout.splitlines()) == sorted(fetched.stdout.splitlines())
    rest = run_here("fetch", *where, "--no-wait", "--after", "1")
    assert rest.stdout == fetched.stdout.splitlines(keepends=True)[2]


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (("submit", "nowhere.json"), "FILE: 'nowhere.json' cannot be read (No such file or directory); give"),
        (("fetch", "ba-0"), "There is no batch 'ba-0', or it has expired."),
        (
            ("fetch", "ba-0", "--format", "json"),
            "--format: json is one document; of a batch, give ndjson or csv",
        ),
        (("submit", "-", "--callback-url", "https://example.com/"), "callback_url: webhooks are disabled"),
    ],
    ids=lambda args: " ".join(args) if isinstance(args, tuple) else None,
)
def test_what_cannot_be_done(run_here: Run, idle_url: str, args: tuple[str, ...], message: str) -> None:
    done = run_here(*args, "--url", idle_url)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert message in done.stderr


def test_ctrl_c_cancels_the_batch_and_says_so(idle_url: str, idle_queue: JobQueue, tmp_path: Path) -> None:
    path = tmp_path / "batch.ndjson"
    path.write_text(lines(pose("-1"), pose("62"), pose("63")))
    pipe = subprocess.PIPE
    line = command("submit", str(path), "--url", idle_url)
    with started(line, env=ENVIRONMENT, stdout=pipe, stderr=pipe, text=True) as process:
        assert json.loads(process.stdout.readline())["status"] == "failed"
        process.send_signal(signal.SIGINT)
        assert process.wait(PATIENCE) == 130
        said = process.stderr.read()
        assert process.stdout.read() == ""
    found = re.fullmatch(
        r"rpr-cusps submit: batch (ba-\w+) is canceled; 1 of its 3 items are done; "
        rf"`rpr-cusps fetch (ba-\w+) --url {idle_url}` prints them\n",
        said,
    )
    assert found is not None, said
    job = idle_queue.get(found[1])
    assert job is not None
    assert (found[2], job.status) == (found[1], "canceled")
