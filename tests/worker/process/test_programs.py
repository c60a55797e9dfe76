"""Programs as child processes: in full, and forked from a process that has loaded them."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from service.stack import API
from tests.support.processes import completed, environment, is_running, until
from tests.support.sampling import long
from worker.process import programs
from worker.process.programs import COMPUTING, Program

ECHO = "tests.support.echo_program"
linux = pytest.mark.skipif(sys.platform != "linux", reason="only Linux has subreapers")


def told(pipe: int) -> dict[str, Any]:
    with os.fdopen(os.dup(pipe), "rb") as answers:
        line: dict[str, Any] = json.loads(answers.readline())
        return line


def echo(what: str, writes: int) -> Program:
    return Program(ECHO, [what], {**environment(), "RPR_WORD": "é 1"}, [writes])


@pytest.fixture
def pipe() -> Iterator[tuple[int, int]]:
    reads, writes = os.pipe()
    yield reads, writes
    os.close(reads)
    os.close(writes)


def test_a_program_in_full(pipe: tuple[int, int]) -> None:
    process = echo("3", pipe[1]).start()
    assert process.wait(60) == 3
    me = told(pipe[0])
    assert (me["pid"], me["session"], me["parent"]) == (process.pid, process.pid, os.getpid())
    assert me["word"] == "é 1"


def in_a_supervisor(body: str) -> list[Any]:
    """What a process of its own says that has a template: this one is not to adopt orphans for ever."""
    program = f"""
import json, os, signal, time
from tests.support.processes import until
from tests.worker.process.test_programs import ECHO, echo, told
from worker.process import reap_orphans
from worker.process.programs import Adopted, Template
reads, writes = os.pipe()
said, heard = [], []
template = Template([ECHO], said.append)
{textwrap.dedent(body)}
template.close()
print(json.dumps(heard))
"""
    done = completed([sys.executable, "-c", program], environment(), in_full=True)
    assert done.stderr == ""
    heard: list[Any] = json.loads(done.stdout)
    return heard


@linux
def test_a_forked_program_is_a_child_with_its_own_environment_and_session() -> None:
    for me, pid, mine, status, again in in_a_supervisor("""
        for what in ("3", "0"):
            process = template.start(echo(what, writes))
            assert isinstance(process, Adopted)
            heard.append((told(reads), process.pid, os.getpid(), process.wait(60), process.poll()))
    """):
        assert (me["pid"], me["session"], me["parent"]) == (pid, pid, mine)
        assert me["word"] == "é 1"
        assert me["path"]
        assert status == again in (3, 0)


@linux
def test_a_forked_program_that_is_killed() -> None:
    assert in_a_supervisor("""
        process = template.start(echo("sleep", writes))
        told(reads)
        heard.append(process.poll())
        process.kill()
        heard.append(process.wait(60))
        process.terminate()
    """) == [None, -signal.SIGKILL]


@linux
@pytest.mark.parametrize("number", [long("SIGKILL"), "SIGSTOP"])
def test_without_the_template_programs_are_started_in_full(number: str) -> None:
    """It is killed, or hangs. What it forked lives on."""
    assert in_a_supervisor(f"""
        template.start(echo("0", writes)).wait(60)  # perhaps before all is loaded
        told(reads)
        first = template.start(echo("sleep", writes))
        told(reads)
        [its] = template.processes()
        its.send_signal(signal.{number})
        second = template.start(echo("5", writes))
        heard += [isinstance(second, Adopted), second.wait(60), first.poll(), len(said), template.processes()]
        first.kill()
        heard.append(first.wait(60))
    """) == [False, 5, None, 1, [], -signal.SIGKILL]


@linux
def test_a_large_environment_is_passed_all_the_same() -> None:
    assert in_a_supervisor("""
        from dataclasses import replace
        program = echo("4", writes)
        long = {"LONG": "x" * 100_000, "MORE": "y" * 100_000}
        program = replace(program, environment={**program.environment, **long})
        heard += [template.start(program).wait(60), told(reads)["word"]]
    """) == [4, "é 1"]


@linux
def test_nothing_is_left_of_adopted_orphans() -> None:
    [child, status] = in_a_supervisor("""
        process = template.start(echo("orphan", writes))
        child = told(reads)["child"]
        until(lambda: reap_orphans({process.pid}) or process.poll() is not None)
        until(lambda: reap_orphans(set()) or not os.path.exists(f"/proc/{child}"))
        heard += [child, process.poll()]
    """)
    assert status == 0
    assert not is_running(child)


@linux
def test_the_template_ends_with_its_parent(tmp_path: Path) -> None:
    program = """
import os, signal
from worker.process.programs import Template
template = Template(["tests.support.echo_program"], print)
print(template.processes()[0].pid, flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""
    done = subprocess.run(
        [sys.executable, "-c", program], env=environment(), cwd=tmp_path.cwd(), capture_output=True, text=True
    )
    until(lambda: not is_running(int(done.stdout)))


def test_only_a_program_that_is_loaded_and_asked_for_is_forked_at_once() -> None:
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with ours, theirs:
        assert not programs._is_asked_for(theirs, API)
        ours.send(json.dumps([API, [], {}]).encode())
        asked = [programs._is_asked_for(theirs, name) for name in (API, COMPUTING, API)]
        assert asked == [True, False, True]
        assert theirs.recv(100).startswith(b'["service')
        ours.close()
        assert not programs._is_asked_for(theirs, API)
