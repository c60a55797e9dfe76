"""Printed poses, digit by digit."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import pytest

from rpr_solver import EXAMPLES, ClaimStatus, InputError, Manipulator, cusp_table
from rpr_solver.verify.manipulator import Geometry
from rpr_solver.verify.points import Point, Points, read
from rpr_solver.verify.system import System
from tests.support.families import family


def system_of(manipulator: Manipulator, length: int) -> System:
    return System.of(Geometry.of(manipulator.identity_json()), 1, Fraction(length))


FLAT = system_of(EXAMPLES["zein-flat"], 10)
CUSP = cusp_table(EXAMPLES["zein-flat"], 10, digits=20)[0].cusps[0].to_json()


def changed(text: str) -> str:
    """The text with another last digit."""
    return text[:-1] + str((int(text[-1]) + 1) % 10)


def test_a_cusp_and_each_of_its_digits() -> None:
    points = Points(FLAT)
    box, (status, reason) = points.cusp(Point.of(CUSP, FLAT, "/cusps/0"))
    assert box is not None
    assert (status, reason[-27:]) == (ClaimStatus.PROVED, "each printed digit is right")
    for name, text in CUSP.items():
        _, (status, reason) = points.cusp(Point.of({**CUSP, name: changed(text)}, FLAT, "/cusps/0"))
        assert (status, reason) == (ClaimStatus.REFUSED, f"a digit of {name} is wrong")
    away = Point.of({**CUSP, "alpha_deg": "77.000000000000000000"}, FLAT, "/cusps/0")
    assert points.cusp(away)[1][0] is ClaimStatus.REFUSED


@pytest.mark.parametrize(("name", "length", "kind"), [("both flat", 3, "quadruple"), ("similar", 9, "node")])
def test_degenerate_poses(name: str, length: int, kind: str) -> None:
    [table] = cusp_table(family(name), length, digits=15)
    system, pose = system_of(family(name), length), dict(table.degenerate_points[0])
    assert pose["kind"] == kind
    points = Points(system)
    assert points.degenerate(kind, Point.of(pose, system, "/x"))[1][0] is ClaimStatus.CHECKED
    wrong = {**pose, "l2": changed(pose["l2"])}
    assert points.degenerate(kind, Point.of(wrong, system, "/x"))[1][0] is ClaimStatus.REFUSED
    if kind == "node":
        assert points.degenerate("lips", Point.of(pose, system, "/x"))[1][0] is ClaimStatus.REFUSED


def test_a_higher_pose_is_compared_within_its_digits() -> None:
    [table] = cusp_table(family("similar"), 25, digits=15)
    system = system_of(family("similar"), 25)
    [pose] = [dict(p) for p in table.degenerate_points if p["kind"] == "higher"]
    points = Points(system)
    assert points.degenerate("higher", Point.of(pose, system, "/x"))[1][0] is ClaimStatus.CHECKED
    for change in ({"l2": "20.1000000000000"}, {"theta1_deg": "53.2301023541560"}):
        wrong = Point.of({**pose, **change}, system, "/x")
        assert points.degenerate("higher", wrong)[1][0] is ClaimStatus.REFUSED


@pytest.mark.parametrize("points", [None, [1], [{}], [{**CUSP, "l3": 1.5}]])
def test_what_is_no_point_is_named(points: Any) -> None:
    with pytest.raises(InputError, match="/cusps"):
        read(points, FLAT, "/cusps")
