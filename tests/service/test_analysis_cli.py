"""The commands that need no service."""

from __future__ import annotations

import json

import pytest
from cli_process import run

from rpr_solver import EXAMPLES, poses

LEGS = ("--l1", "14.98", "--l2", "15", "--l3", "30")


def test_poses_as_json_and_as_text() -> None:
    done = run("poses", "innocenti", *LEGS, "--digits", "20", "--format", "json")
    assert (done.returncode, done.stderr) == (0, "")
    expected = poses(EXAMPLES["innocenti"], "14.98", 15, 30, digits=20).to_json()
    assert json.loads(done.stdout) == expected
    lines = run("poses", "innocenti", *LEGS, "--digits", "20").stdout.splitlines()
    assert lines[2] == "L1 = 14.98, L2 = 15, L3 = 30: 2 poses"
    assert lines[4].split()[:2] == [expected["poses"][0]["alpha_deg"], expected["poses"][0]["theta1_deg"]]  # type: ignore[index]


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("poses", "innocenti", "--l1", "1"), "--l2, --l3"),
        (("poses", "innocenti", "--l1", "x", "--l2", "1", "--l3", "1"), "--l1: 'x' is not a finite number"),
        (("poses", "innocenti", "--l1", "0", "--l2", "1", "--l3", "1"), "l1: is 0; a leg length must be > 0"),
        (("poses", "nope", *LEGS), "one of innocenti"),
        (("poses", "innocenti", *LEGS, "--digits", "9"), "min_digits is 15"),
    ],
)
def test_bad_input_is_one_line_and_status_2(args: tuple[str, ...], said: str) -> None:
    done = run(*args)
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr
    assert done.stderr.count("\n") == 1
