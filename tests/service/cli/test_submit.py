"""`rpr-cusps submit`, and the commands that come back to a batch."""

from __future__ import annotations

import csv
import io
import json
import re
import signal
import subprocess
from pathlib import Path

import pytest

from rpr_solver import EXAMPLES
from tests.support.cli_process import ENVIRONMENT, Run, command
from tests.support.processes import PATIENCE, started
from worker.jobs.queue import JobQueue

ZEIN = EXAMPLES["zein-flat"].to_json()
TABLE = {"geometry": ZEIN, "l1": ["1.2345", "10.2345"], "digits": 15}


def lines(*items: object) -> str:
    return "".join(json.dumps(item) + "\n" for item in items)


def pose(l2: str, **more: str) -> dict[str, object]:
    request = {"geometry": ZEIN, "l1": "15", "l2": l2, "l3": "40", "digits": 15}
    return {"kind": "poses", "request": request, **more}


def test_answers_are_those_of_the_single_commands(run_here: Run, base_url: str) -> None:
    items = [{"kind": "cusp-table", "request": TABLE}, pose("61/2", id="ü")]
    done = run_here("submit", "-", "--url", base_url, stdin=lines(*items))
    assert (done.returncode, done.stderr) == (0, "")
    first, second = map(json.loads, done.stdout.splitlines())
    args = ("--digits", "15", "--format", "json")
    table = run_here("solve", "zein-flat", "--l1", "1.2345", "--l1", "10.2345", *args)
    table_of_poses = run_here("poses", "zein-flat", "--l1", "15", "--l2", "61/2", "--l3", "40", *args)
    assert [first["result"], second["result"]] == [json.loads(x.stdout) for x in (table, table_of_poses)]
    assert (first["index"], first["kind"], second["id"]) == (0, "cusp-table", "ü")


def test_csv_in_and_out(run_here: Run, base_url: str, tmp_path: Path) -> None:
    names = ["id", *ZEIN, "l1", "digits"]
    rows = [["one, two", *ZEIN.values(), "0;10", "15"], ["bad", *ZEIN.values(), "1", "5"]]
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
    assert body == [["0", "one, two", *row] for row in expected]
    assert last[:2] == ["1", "bad"]
    assert "items[1].request.digits: asks for 5 digits" in last[head.index("error")]


def test_csv_is_for_tables_of_one_leg(run_here: Run, base_url: str) -> None:
    other = {"geometry": ZEIN, "fixed_leg": 2, "l2": "17", "digits": 15}
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
    assert json.loads(run_here("status", *where).stdout)["status"] == "succeeded"
    assert json.loads(run_here("cancel", *where).stdout)["failed"] == 1
    again = run_here("submit", "-", "--as-done", "--url", base_url, "--key", "comes-back", stdin=stdin)
    assert sorted(again.stdout.splitlines()) == sorted(fetched.stdout.splitlines())
    rest = run_here("fetch", *where, "--no-wait", "--after", "1")
    assert rest.stdout == fetched.stdout.splitlines(keepends=True)[2]


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (("submit", "nowhere.json"), "FILE: 'nowhere.json' cannot be read (No such file or directory); give"),
        (("submit", "-"), "items: is empty; send at least one item"),
        (("fetch", "ba-0"), "There is no batch 'ba-0', or it has expired."),
        (("status", "ba-0"), "There is no batch 'ba-0', or it has expired."),
        (("cancel", "ba-0"), "There is no batch 'ba-0', or it has expired."),
        (
            ("fetch", "ba-0", "--format", "json"),
            "--format: json is one document; of a batch, give ndjson or csv",
        ),
        (
            ("fetch", "ct-0", "--no-wait"),
            "--no-wait: is for batches, whose ids begin with ba-; 'ct-0' is a job",
        ),
        (("fetch", "ct-0", "--after", "1"), "--after: is for batches"),
        (("submit", "-", "--callback-url", "https://example.com/"), "callback_url: webhooks are off here"),
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
