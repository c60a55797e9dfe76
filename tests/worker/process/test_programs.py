"""Programs as child processes."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from typing import Any

import pytest

from tests.support.processes import environment
from worker.process.programs import Program

ECHO = "tests.support.echo_program"


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


def test_a_program_has_its_own_environment_and_session(pipe: tuple[int, int]) -> None:
    process = echo("3", pipe[1]).start()
    assert process.wait(60) == 3
    me = told(pipe[0])
    assert (me["pid"], me["session"], me["parent"]) == (process.pid, process.pid, os.getpid())
    assert me["word"] == "é 1"
