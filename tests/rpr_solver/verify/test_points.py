"""Printed poses, digit by digit."""

from __future__ import annotations

from fractions import Fraction

import pytest

from rpr_solver import EXAMPLES, ClaimStatus, Manipulator, cusp_table
from rpr_solver.verify.core.printed import Printed
from rpr_solver.verify.core.schema import POSE_KINDS
from rpr_solver.verify.core.system import System
from rpr_solver.verify.points import Point, Points
from tests.support.families import family
from tests.support.verified import geometry_of, typed


def system_of(manipulator: Manipulator, length: int) -> System:
    return System.of(geometry_of(manipulator), 1, Fraction(length))


FLAT = system_of(EXAMPLES["zein-flat"], 10)
CUSP = cusp_table(EXAMPLES["zein-flat"], 10, digits=20)[0].cusps[0].to_json()


def changed(text: str) -> str:
    """The text with another last digit."""
    return text[:-1] + str((int(text[-1]) + 1) % 10)


def test_a_cusp_and_each_of_its_digits() -> None:
    points = Points(FLAT)
    box, (status, reason) = points.cusp(Point.of(typed(CUSP), FLAT))
    assert box is not None
    assert (status, reason[-27:]) == (ClaimStatus.PROVED, "each printed digit is right")
    for name, text in CUSP.items():
        _, (status, reason) = points.cusp(Point.of(typed({**CUSP, name: changed(text)}), FLAT))
        assert (status, reason) == (ClaimStatus.REFUSED, f"a digit of {name} is wrong")
    away = Point.of(typed({**CUSP, "alpha_deg": "77.000000000000000000"}), FLAT)
    assert points.cusp(away)[1][0] is ClaimStatus.REFUSED


@pytest.mark.parametrize(("name", "length", "kind"), [("both flat", 3, "quadruple"), ("similar", 9, "node")])
def test_degenerate_poses(name: str, length: int, kind: str) -> None:
    [table] = cusp_table(family(name), length, digits=15)
    system, pose = system_of(family(name), length), dict(table.degenerate_points[0])
    assert pose["kind"] == kind
    points = Points(system)
    assert points.degenerate(kind, Point.of(typed(pose), system))[1][0] is ClaimStatus.CHECKED
    wrong = {**pose, "l2": changed(pose["l2"])}
    assert points.degenerate(kind, Point.of(typed(wrong), system))[1][0] is ClaimStatus.REFUSED
    if kind == "node":
        assert points.degenerate("lips", Point.of(typed(pose), system))[1][0] is ClaimStatus.REFUSED


def test_a_higher_pose_is_compared_within_its_digits() -> None:
    [table] = cusp_table(family("similar"), 25, digits=15)
    system = system_of(family("similar"), 25)
    [pose] = [dict(p) for p in table.degenerate_points if p["kind"] == "higher"]
    points = Points(system)
    assert points.degenerate("higher", Point.of(typed(pose), system))[1][0] is ClaimStatus.NOT_CHECKED
    for change in ({"l2": "20.1000000000000"}, {"theta1_deg": "53.2301023541560"}):
        wrong = Point.of(typed({**pose, **change}), system)
        assert points.degenerate("higher", wrong)[1][0] is ClaimStatus.REFUSED


def test_a_cusp_is_no_degenerate_pose_of_any_kind() -> None:
    points, cusp = Points(FLAT), Point.of(typed(CUSP), FLAT)
    for kind in POSE_KINDS:
        status, reason = points.degenerate(kind, cusp)[1]
        assert (status, reason[:12]) == (ClaimStatus.REFUSED, "it is a cusp")


def test_an_angle_that_is_0_exactly_or_nearly() -> None:
    system = System.of(geometry_of(Manipulator(5, 3, 4, 17, 10, 9)), 2, Fraction(5))
    [table] = cusp_table(Manipulator(5, 3, 4, 17, 10, 9), 5, fixed_leg=2, digits=15)
    [cusp] = [cusp.to_json() for cusp in table.cusps if cusp.to_json()["theta2_deg"] == "0"]
    points = Points(system)
    assert points.cusp(Point.of(typed(cusp), system))[1][0] is ClaimStatus.PROVED
    box, _ = points.cusp(Point.of(typed(CUSP), FLAT))
    assert box is not None
    for name in ("alpha_deg", "theta1_deg"):
        wrong = Points(FLAT).cusp(Point.of({**typed(CUSP), name: Printed.exact_zero()}, FLAT))
        assert wrong[1][0] is ClaimStatus.REFUSED
