"""The document of a path determines it: driven from the document alone, the path has all its samples.

Angles are continuous from row to row, however many turns a path makes.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from itertools import pairwise
from typing import Any

import pytest
from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st
from mpmath import mp

from rpr_solver import (
    EXAMPLES,
    Exact,
    Manipulator,
    Path,
    SolverError,
    cusp_loop,
    cusp_table,
    joint_path,
    poses,
)
from tests.support.replay import DIGITS, Replay, number, rounds_to
from tests.support.strategies import examples, lengths, manipulators

FIRST = EXAMPLES["innocenti"]
TURNING = Manipulator(4, -5, "1/1000000", 8, 8, 15, "cw")
"""A path of this one turns more than once."""

UNSHRUNK = (Phase.explicit, Phase.reuse, Phase.generate)
"""A path takes too long for failures to be made smaller."""


def check(document: Mapping[str, Any]) -> None:
    """Drives a path from its document, and compares all its samples and ends."""
    with mp.workdps(DIGITS):
        check_samples(document)
    leg, samples = document["fixed_leg"], document["samples"]
    angles = "alpha_deg", f"theta{leg}_deg"
    for before, after in pairwise(samples):
        assert Fraction(before["place"]) < Fraction(after["place"])
        assert all(abs(Fraction(before[name]) - Fraction(after[name])) < 180 for name in angles)
    turns = document["certificate"]["turns"]
    for end, sample in (("from", samples[0]), ("to", samples[-1])):
        for name, of_end in zip(angles, ("alpha", f"theta{leg}"), strict=True):
            apart = Fraction(sample[name]) - Fraction(document[end][name]) - 360 * turns[end][of_end]
            assert abs(apart) < Fraction(1, 10**9)
    assert turns["from"] == {"alpha": 0, f"theta{leg}": 0}


def check_samples(document: Mapping[str, Any]) -> None:
    replay, leg = Replay.of(document), document["fixed_leg"]
    angles = "alpha_deg", f"theta{leg}_deg"
    samples = document["samples"]
    for sample in samples:
        at = replay.at(Fraction(sample["place"]))
        shown = [sample[name] for name in (*angles, "l1", "l2", "l3")]
        for x, text in zip((*at[:2], *replay.legs(at)), shown, strict=True):
            assert rounds_to(x, text)
        determinant = replay.determinant(at) * document["sign"]
        assert rounds_to(abs(determinant), sample["determinant"].lstrip("-"))
        assert abs(determinant) >= number(document["certificate"]["least_determinant"])
    assert [samples[k]["place"] for k in (0, -1)] == ["0", str(len(replay.arcs))]


@pytest.mark.parametrize(
    ("manipulator", "legs", "ends"),
    [(TURNING, ("19.51", "28.8", "29.6"), (4, 1)), (FIRST, (27, 20, 20), (1, 2))],
)
def test_a_path_that_turns_and_its_reverse(
    manipulator: Manipulator, legs: tuple[Exact, Exact, Exact], ends: tuple[int, int]
) -> None:
    path = joint_path(manipulator, *legs, *ends)
    assert isinstance(path, Path)
    for one in (path, path.reversed(), path.resampled(7, timing="constant")):
        check(one.to_json())


def test_a_path_with_more_than_one_turn() -> None:
    path = joint_path(TURNING, "19.51", "28.8", "29.6", 4, 1)
    assert isinstance(path, Path)
    assert path.certificate["turns"]["to"] != {"alpha": 0, "theta1": 0}
    assert float(path.samples[-1].theta_deg) - float(path.stop.theta_deg) in (360, 720, -360, -720)


@given(manipulators(20, (1, 10)), lengths(40, (1, 10)), st.integers(1, 3), st.integers(1, 24))
@settings(examples(12), phases=UNSHRUNK)
def test_loops(m: Manipulator, length: Fraction, leg: int, cusp: int) -> None:
    try:
        [table] = cusp_table(m, length, digits=15, fixed_leg=leg)
        assume(table.count)
        loop = cusp_loop(m, length, 1 + cusp % table.count, fixed_leg=leg)
    except SolverError:
        assume(False)
    check(loop.to_json())


@given(manipulators(20, (1, 10)), st.tuples(*[lengths(30, (1, 10))] * 3), st.integers(1, 3), st.booleans())
@settings(examples(20), phases=UNSHRUNK)
def test_paths(m: Manipulator, legs: tuple[Fraction, Fraction, Fraction], leg: int, free: bool) -> None:
    length = legs[leg - 1]
    between = (length / 2, length * 2) if free else None
    try:
        numbers = [k for k, pose in enumerate(poses(m, *legs, digits=15).poses, 1) if pose.multiplicity == 1]
        assume(len(numbers) > 1)
        found = [
            joint_path(m, *legs, numbers[0], stop, between=between, fixed_leg=leg, digits=20)
            for stop in numbers[1:]
        ]
    except SolverError:
        assume(False)
    paths = [path for path in found if isinstance(path, Path)]
    assume(paths)
    check(paths[0].to_json())
