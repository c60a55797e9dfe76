"""Singular curves of manipulators with roots: samples and special points by equations that know no ρ."""

import json
from pathlib import Path
from typing import Any

import mpmath as mp
import pytest

from rpr_solver import Manipulator, SingularCurves, aspects, poses, singular_curves
from tests.support.sampling import sample
from tests.support.triangle_oracle import Waves, corners_of

ROWS = json.loads((Path(__file__).parents[2] / "data" / "irrational.json").read_text())["rows"]
DIGITS = 25


@pytest.mark.parametrize("row", sample(ROWS, 0, 7, 14, 20))
def test_the_curves_of_manipulators_with_roots(row: dict[str, Any]) -> None:
    manipulator = Manipulator.from_json(row["geometry"])
    document = singular_curves(manipulator, row["l1"], digits=DIGITS).to_json()
    with mp.workdps(40):
        slice_ = _Slice(manipulator, row["l1"])
        strands = [strand for part in document["components"] for strand in part["strands"]]
        for strand in strands:
            columns = (strand[name] for name in ("alpha_deg", "theta1_deg", "l2", "l3"))
            for sample in list(zip(*columns, strict=True))[::7]:
                slice_.check(sample, 1e-6)
            for vertex in strand["vertices"]:
                point = tuple(vertex[name] for name in ("alpha_deg", "theta1_deg", "l2", "l3"))
                slice_.check(point, mp.mpf(10) ** (4 - DIGITS))
    kinds = [vertex["kind"] for strand in strands for vertex in strand["vertices"]]
    assert kinds.count("cusp") == row["count"]


class _Slice:
    def __init__(self, manipulator: Manipulator, length: str) -> None:
        self.base, self.platform = corners_of(manipulator.geometry)
        self.length = mp.mpf(length)
        self.waves = Waves.of(self.base, self.platform, self.length)
        self.size = max(abs(z) for z in (*self.base, *self.platform, self.length))

    def check(self, point: tuple[Any, ...], error: Any) -> None:
        """The pose is singular, and its free legs have these lengths."""
        alpha, theta = (mp.mpf(x) * mp.pi / 180 for x in point[:2])
        tip, turn = self.length * mp.expj(theta), mp.expj(alpha)
        for k, text in ((1, point[2]), (2, point[3])):
            leg = abs(tip + turn * self.platform[k] - self.base[k])
            assert abs(leg - mp.mpf(text)) < error * self.size
        assert abs(self.waves.system(alpha, theta, mp.exp)[0]) < error * self.size**4


@pytest.mark.parametrize("row", sample(ROWS[::5], 1))
def test_regions_count_poses(row: dict[str, Any]) -> None:
    manipulator = Manipulator.from_json(row["geometry"])
    curves: SingularCurves = singular_curves(manipulator, row["l1"])
    assert curves.regions
    for region in curves.regions:
        assert poses(manipulator, row["l1"], *region.point).count == region.poses


@pytest.mark.parametrize("row", sample(ROWS[2::7], 0))
def test_the_aspects_of_a_range_are_those_of_its_slices(row: dict[str, Any]) -> None:
    """Of a short range without a transition."""
    manipulator, length = Manipulator.from_json(row["geometry"]), row["l1"]
    of_slice = singular_curves(manipulator, length).aspects
    found = aspects(manipulator, length, f"{length}00001" if "." in length else f"{length}.00001")
    assert sorted(x.sign for x in found) == sorted(x.sign for x in of_slice)
