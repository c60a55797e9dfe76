"""Poses of manipulators with roots, against a sextic in e^{iα} that knows no ρ."""

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath as mp
import pytest

from rpr_solver import Manipulator, PoseTable, poses
from rpr_solver.exact.rationals import parse_exact
from tests.support.sampling import sample
from tests.support.triangle_oracle import corners_of
from tests.support.triangle_oracle import poses as witness

ROWS = json.loads((Path(__file__).parents[2] / "data" / "irrational.json").read_text())["rows"]
DIGITS = 30


def rows() -> list[tuple[dict[str, Any], tuple[Fraction, Fraction, Fraction]]]:
    """Each geometry with the rounded legs of a pose, so that it has two at least."""
    found = []
    for row in ROWS:
        l1, cusp = parse_exact(row["l1"], "l1"), row["cusps"][0]
        legs = (parse_exact(cusp[name], name) * Fraction(101, 100) for name in ("l2", "l3"))
        found.append((row["geometry"], (l1, *(leg.limit_denominator(1000) for leg in legs))))
    return found  # type: ignore[return-value]


@pytest.mark.parametrize(("geometry", "legs"), sample(rows(), *range(0, 24, 3)))
def test_poses_of_manipulators_with_roots(geometry: dict[str, Any], legs: tuple[Fraction, ...]) -> None:
    manipulator = Manipulator.from_json(geometry)
    check(poses(manipulator, *legs, digits=DIGITS), manipulator, legs)


def check(table: PoseTable, manipulator: Manipulator, legs: tuple[Fraction, ...]) -> None:
    with mp.workdps(60):
        base, platform = corners_of(manipulator.geometry)
        known = witness(base, platform, [mp.mpf(leg.numerator) / leg.denominator for leg in legs])
        assert table.count == len(known)
        for pose, (alpha, theta) in zip(table.poses, known, strict=True):
            z, x = mp.expj(alpha), mp.mpf(legs[0].numerator) / legs[0].denominator * mp.expj(theta)
            ends = (x, *(x + platform[k] * z - base[k] for k in (1, 2)))
            angles = [alpha, *map(mp.arg, ends)]
            texts = [pose.alpha_deg, pose.theta1_deg, pose.theta2_deg, pose.theta3_deg]
            for text, angle in zip(texts, angles, strict=True):
                assert abs(mp.mpf(text) - mp.degrees(angle)) < mp.mpf(10) ** (4 - DIGITS)
            assert abs(mp.mpc(pose.b1_x, pose.b1_y) - x) < abs(x) * mp.mpf(10) ** (1 - DIGITS)


def test_congruent_triangles_move_in_parallel() -> None:
    """Equilateral in an equal one: with equal legs B1 may be anywhere on a circle, at α = 0."""
    manipulator = Manipulator(base={"equilateral": "sqrt(3)"}, platform={"equilateral": "sqrt(3)"})
    table = poses(manipulator, 2, 2, 2)
    assert [curve["alpha_deg"] for curve in table.curves] == ["0"]
    turned = poses(manipulator, 2, 2, "2.1")
    assert turned.curves == ()
    check(turned, manipulator, (Fraction(2), Fraction(2), Fraction(21, 10)))


def test_concentric_triangles_have_an_exact_pose() -> None:
    """Equilateral ones of one sense, with legs that are the difference of the radii."""
    manipulator = Manipulator(base={"equilateral": "4*sqrt(3)"}, platform={"equilateral": "sqrt(3)"})
    [pose] = [pose for pose in poses(manipulator, 3, 3, 3, digits=20).poses if pose.alpha_deg == "0"]
    assert (pose.theta1_deg, pose.theta2_deg) == ("30.000000000000000000", "150.00000000000000000")
