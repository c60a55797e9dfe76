"""The logs of the worker layer, and the clocks that it may read."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

from tests.support.processes import ROOT, completed, environment, started
from tests.support.sampling import sample

LINES = """
import logging, sys
from worker.logs import about, set_up
set_up("INFO", sys.argv[1], in_background=sys.argv[2] == "background")
with about(job="ct-1", request_id=""):
    logging.getLogger("a").info("two\\nlines of %s", "text")
    try:
        1 / 0
    except ZeroDivisionError:
        logging.getLogger("a").exception("failed", extra={"fields": {"status": 500}})
logging.getLogger("a").debug("not wanted")
"""

FLOOD = """
import logging, sys
from worker.logs import set_up
set_up("INFO", "text", in_background=True)
for i in range(30_000):
    logging.info("line %d %s", i, "x" * 100)
print("done", flush=True)
sys.stdin.readline()
logging.info("the last one")
"""


def logged(form: str, how: str) -> list[str]:
    words = [sys.executable, "-c", LINES, form, how]
    return subprocess.run(words, capture_output=True, text=True, check=True, cwd=ROOT).stderr.splitlines()


@pytest.mark.parametrize("how", ["background", "foreground"])
def test_a_line_of_text_has_time_level_and_subject(how: str) -> None:
    first, second, *traceback = logged("text", how)
    time, text = first.split(" ", 1)
    assert time[4] == time[7] == "-"
    assert time.endswith("Z")
    assert text == r"a INFO two\nlines of text job=ct-1"
    assert second.endswith(" a ERROR failed job=ct-1")
    assert traceback[-1] == "ZeroDivisionError: division by zero"


@pytest.mark.parametrize("how", ["background", "foreground"])
def test_a_line_of_json_has_all_in_fields(how: str) -> None:
    first, second = map(json.loads, logged("json", how))
    assert first.pop("time").endswith("Z")
    assert first == {"level": "INFO", "logger": "a", "message": "two\nlines of text", "job": "ct-1"}
    assert second["status"] == 500
    assert second["exception"].endswith("division by zero")


def test_nobody_waits_for_a_reader_of_the_log_that_hangs() -> None:
    pipe = subprocess.PIPE
    command = [sys.executable, "-c", FLOOD]
    with started(command, env=environment(), stdin=pipe, stdout=pipe, stderr=pipe, text=True) as process:
        assert process.stdout.readline() == "done\n", "it waits for its reader"
        lines: list[str] = []
        while not lines or not lines[-1].endswith(" line 9000 " + "x" * 100 + "\n"):
            lines.append(process.stderr.readline())
        process.stdin.write("\n")
        process.stdin.close()
        lines += process.stderr.readlines()
    assert len(lines) < 30_000
    dropped, last = lines[-2:]
    told = [int(line.split(" INFO ")[1].split()[0]) for line in lines if "log lines were dropped" in line]
    assert "log lines were dropped" in dropped
    assert sum(told) == 30_001 - (len(lines) - len(told))  # a busy machine drops some before the reader hangs
    assert last.endswith("the last one\n")


UNCAUGHT = """
import gc, logging, sys, threading, warnings
from worker.logs import log_uncaught
log_uncaught("rpr-cusps serve")
logging.getLogger("a").warning("nobody set up a log")
warnings.warn("a warning")
thread = threading.Thread(target=lambda: 1 / 0)
thread.start()
thread.join()
class Bad:
    def __del__(self):
        raise ValueError("in a destructor")
Bad()
gc.collect()
raise RuntimeError("two\\nlines")
"""


def test_what_nobody_catches_is_an_object_too() -> None:
    words, asked = [sys.executable, "-c", UNCAUGHT], {"RPR_CUSPS_LOG_FORMAT": "json"}
    program = subprocess.run(words, capture_output=True, text=True, cwd=ROOT, env={**os.environ, **asked})
    assert program.returncode == 1
    lines = [json.loads(line) for line in program.stderr.splitlines()]
    assert [line["level"] for line in lines] == ["WARNING", "WARNING", "CRITICAL", "CRITICAL", "CRITICAL"]
    assert [line.get("exception", "").splitlines()[-1:] for line in lines[2:]] == [
        ["ZeroDivisionError: division by zero"],
        ["ValueError: in a destructor"],
        ["lines"],
    ]


COMMANDS = {
    "no Redis": ["worker", "--redis-url", "rediss://127.0.0.1:1/0?ssl_cert_reqs=nonsense"],
    "a password on the command line": ["serve", "--redis-url", "redis://:x@127.0.0.1:1/0"],
    "an unknown option": ["serve", "--prot", "80"],
    "a port that is none": ["serve", "--port", "x"],
    "no address": ["worker"],
    "a host that is none": ["serve", "--host", "no.such.host.invalid", "--port", "0"],
    "a setting that is none": ["serve", "--port", "0"],
}


@pytest.mark.parametrize("name", sample(COMMANDS, 0, 2, 6))
def test_a_service_that_does_not_start_says_so_in_an_object(name: str) -> None:
    settings = {"RPR_CUSPS_LOG_FORMAT": "json", "RPR_CUSPS_NO_SETTING": "1"}
    if name == "a setting that is none":
        settings["RPR_CUSPS_MAX_SLICES"] = "many\nlines"
    words = [sys.executable, "-m", "service", *COMMANDS[name]]
    program = completed(words, {**environment(), **settings})
    assert program.returncode in (1, 2)
    lines = [json.loads(line) for line in (program.stdout + program.stderr).splitlines()]
    assert lines[-1]["level"] == "ERROR"
    assert lines[-1]["logger"] in ("rpr_cusps.serve", "rpr_cusps.worker")
    assert all(line["message"] for line in lines)
