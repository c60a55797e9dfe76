"""A kind of document costs a function of the solver, a kind, a question and two lines; all else follows."""

from __future__ import annotations

import json
import sys
from typing import Any

import pytest

from rpr_solver import EXAMPLES
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import completed, environment
from tests.support.toy import perimeter
from tests.support.valkey import valkey

__all__ = ["valkey"]

M = EXAMPLES["zein-flat"]
PROGRAM = """
import sys
from tests.support import toy
toy.register()
from tests.support import toy_uses
toy_uses.run(sys.argv[1])
"""


@pytest.fixture(scope="module")
def done(valkey: EmbeddedValkey) -> dict[str, Any]:
    """What a process that has the toy kind can do with it."""
    command = [sys.executable, "-c", PROGRAM, f"{valkey.url}?db=7"]
    ran = completed(command, environment(), in_full=True)  # kinds are read when they are loaded
    assert ran.returncode == 0, ran.stderr
    answer: dict[str, Any] = json.loads(ran.stdout.splitlines()[-1])
    return answer


DOCUMENT = {
    **M.identity_json(),
    "copies": 3,
    "perimeter": perimeter(M, 3),
    "sides": [{"side": side, "length": str(getattr(M, side))} for side in ("d1", "d2", "d3")],
}


def test_over_http(done: dict[str, Any]) -> None:
    assert done["http"] == [200, DOCUMENT]
    assert done["again"]
    assert done["refused"] == [422, "/problems/job-input-error"]
    assert done["csv"] == f"copies,perimeter\n3,{DOCUMENT['perimeter']}\n"


def test_in_the_contract(done: dict[str, Any]) -> None:
    assert done["paths"] == ["post"]
    assert done["schema"]["description"] == "How many platforms there are."


def test_by_the_client_and_in_a_batch(done: dict[str, Any]) -> None:
    assert done["typed"] == perimeter(M, 4)
    assert done["items"] == [["3", "perimeter", "succeeded"], ["5", "perimeter", "succeeded"]]


def test_on_the_command_line(done: dict[str, Any]) -> None:
    assert done["here"] == done["there"]
    assert [done["here"][0], json.loads(done["here"][1])] == [0, DOCUMENT]
    status, table, _ = done["table"]
    assert status == 0
    assert perimeter(M, 1) in table
    assert all(side in table for side in ("d1", "d2", "d3"))
    assert done["as csv"] == [0, f"copies,perimeter\n1,{perimeter(M, 1)}\n", ""]
    status, out, said = done["none"]
    assert (status, out) == (2, "")
    assert "--copies: is 0; a platform has one perimeter at least" in said


def test_where_kinds_are_listed(done: dict[str, Any]) -> None:
    assert "--copies N" in done["help"][1]
    assert "how many platforms there are (default: 1)" in done["help"][1]
    assert "measure the platform" in done["commands"][1]
    assert "perimeters" in done["fetch"][1]
