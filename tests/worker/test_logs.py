"""The form of log lines."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from tests.support.processes import ROOT, environment, started

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
    assert int(dropped.split(" INFO ")[1].split()[0]) == 30_002 - len(lines)
    assert last.endswith("the last one\n")
