"""Workspaces: regions against the legs at random places, special orientations, exact digits."""

from __future__ import annotations

from fractions import Fraction
from math import pi

import numpy as np
import pytest

from rpr_solver import (
    EXAMPLES,
    ConicKind,
    InputError,
    Manipulator,
    leg_poses,
    workspace,
    workspace_csv,
    workspace_sweep,
)
from rpr_solver.figures.views import figure_of
from rpr_solver.figures.workspace import Plane
from tests.support.sampling import sample
from tests.support.workspace_places import by_regions, case, failures

M = EXAMPLES["innocenti"]
LIMITS = {"l1": (5, 30), "l2": (5, 25), "l3": (5, 25)}
SQUARE = Manipulator(
    base={"points": [[-4, 0], [4, 0], [0, 6]]}, platform={"points": [[-2, 0], [2, 0], [0, 2]]}
)


@pytest.mark.parametrize("number", sample(range(30), *range(12)))
def test_regions_agree_with_the_legs(number: int) -> None:
    manipulator, phi, limits = case(number, 1)
    assert failures(workspace(manipulator, phi, limits), 2000, number) == []


@pytest.mark.long
@pytest.mark.timeout(600)
@pytest.mark.parametrize("number", range(50))
def test_regions_agree_with_the_legs_at_many_places(number: int) -> None:
    manipulator, phi, limits = case(number, 2)
    assert failures(workspace(manipulator, phi, limits), 100_000, number) == []


EQUILATERAL = Manipulator(base={"equilateral": 10}, platform={"equilateral": 4})
RIGHT = Manipulator(6, 0, 8, 3, 5, 4)
FLAT = Manipulator(10, 4, 0, 5, 3, 2)


@pytest.mark.parametrize(
    ("manipulator", "phi", "kind"),
    [
        (M, 30, ConicKind.HYPERBOLA),
        (M, -75, ConicKind.ELLIPSE),
        (M, 0, ConicKind.CROSSING),
        (EQUILATERAL, "12.3", ConicKind.CIRCLE),
        (EQUILATERAL, 0, ConicKind.PLANE),
        (RIGHT, 180, ConicKind.PLANE),
        (FLAT, 30, ConicKind.LINE),
        (FLAT, 0, ConicKind.PLANE),
        (Manipulator(10, 0, 10, 5, 5, "5*sqrt(2)"), 0, ConicKind.PARALLEL),
    ],
)
def test_the_kind_of_the_conic_is_exact(manipulator: Manipulator, phi: object, kind: ConicKind) -> None:
    found = workspace(manipulator, phi, {"l1": (1, 9), "l2": (None, 12)})  # type: ignore[arg-type]
    assert found.conic is kind
    assert {region.sign for region in found.regions} <= ({0} if kind is ConicKind.PLANE else {1, -1})
    assert failures(found, 2000, 1) == []


@pytest.mark.parametrize(
    ("manipulator", "phi", "limits"),
    [
        (SQUARE, 0, {1: (1, 4), 2: (1, 4), 3: (None, 6)}),  # two circles and the conic in one vertex
        (SQUARE, 0, {1: (1, 5), 2: (1, 9), 3: (4, 5)}),  # circles that touch on the conic
        (SQUARE, 180, {1: (2, 6), 2: (2, 7), 3: (1, 8)}),
        (EQUILATERAL, 60, {1: (2, 9), 2: (2, 9), 3: (2, 9)}),
        (Manipulator(base={"equilateral": 10}, platform={"equilateral": 10}), 60, {1: (2, 15), 3: (2, 15)}),
        (Manipulator(base={"equilateral": 10}, platform={"equilateral": 10}), 0, {1: (2, 5), 2: (1, 5)}),
    ],
)
def test_curves_that_touch_or_coincide(
    manipulator: Manipulator, phi: int, limits: dict[int, tuple[int | None, int]]
) -> None:
    assert failures(workspace(manipulator, phi, limits, digits=40), 3000, 1) == []


def test_a_place_and_a_circle_without_others_beside_them() -> None:
    alone = workspace(SQUARE, 0, {"l1": (1, 2), "l2": (1, 2)})
    assert (alone.regions, alone.isolated) == ((), (1,))
    [vertex] = alone.vertices
    assert (vertex.x, vertex.y) == ("0", "0")
    congruent = Manipulator(base={"equilateral": 10}, platform={"equilateral": 10})
    [arc] = workspace(congruent, 0, {"l1": (2, 5), "l2": (5, 8)}).thin
    assert (arc.on, arc.start) == ("l1_max l2_min", None)


def test_the_area_of_an_annulus_is_right_to_all_digits() -> None:
    found = workspace(M, 10, {"l1": (3, 5)}, digits=15)
    assert sum(float(region.area) for region in found.regions) == pytest.approx(16 * pi, rel=1e-14)
    finer = workspace(M, 10, {"l1": (3, 5)}, digits=60)
    for one, other in zip(found.regions, finer.regions, strict=True):
        assert float(one.area) == float(f"{float(other.area):.15g}")


def test_signs_are_those_of_poses_along_a_leg() -> None:
    """The sign of J is that of slices of leg 1."""
    interval = next(x for x in leg_poses(M, {"l1": 17, "l3": 15}, 10, 20, digits=15).intervals if x.count)
    for pose, sign in zip(interval.poses, interval.signs, strict=True):
        found = workspace(M, pose.alpha_deg, {"l1": (16, 18)})
        place = np.array([[float(pose.b1_x), float(pose.b1_y)]])
        assert by_regions(found.to_json(), place)[1].tolist() == [sign]


def test_points_give_places_in_their_frame_and_in_the_articles() -> None:
    base, platform = [[1, 2], [4, 6], [-3, 5]], [[1, 1], [2, 1], [0, 3]]
    placed = Manipulator(base={"points": base}, platform={"points": platform})
    found = workspace(placed, 20, {"l1": (2, 6), "l2": (2, 6), "l3": (2, 6)}, digits=30)
    bare = workspace(
        Manipulator.from_json(placed.to_json()), found.alpha_deg, {"l1": (2, 6), "l2": (2, 6), "l3": (2, 6)}
    )
    assert [float(x.area) for x in found.regions] == pytest.approx([float(x.area) for x in bare.regions])
    own = sorted((float(x), float(y)) for x, y in (vertex.b1 or ("0", "0") for vertex in found.vertices))
    assert own == [pytest.approx(p) for p in sorted((float(v.x), float(v.y)) for v in bare.vertices)]
    assert found.to_json()["points"]["base"] == [["1", "2"], ["4", "6"], ["-3", "5"]]


def test_a_sweep_has_the_numbers_of_each_orientation() -> None:
    swept = workspace_sweep(M, -60, 60, "24.5", LIMITS)
    assert [row.phi for row in swept.orientations] == [Fraction(-60) + k * Fraction("24.5") for k in range(5)]
    for row in swept.orientations:
        found = workspace(M, row.phi, LIMITS)
        assert (row.conic, row.areas) == (found.conic, found.areas)
        assert sum(row.counts.values()) == len(found.regions)
    table = workspace_csv(swept.to_json()).splitlines()
    assert table[0].startswith("phi_deg,conic,positive_regions,positive")
    assert len(table) == 6


@pytest.mark.parametrize(
    ("phi", "limits", "field"),
    [
        ("x", LIMITS, "phi"),
        (1000, LIMITS, "phi"),
        (0, {"l1": (3, None)}, "limits"),
        (0, {}, "limits"),
        (0, {"l1": (3, 2)}, "limits.l1.max"),
    ],
)
def test_what_is_wrong_is_named(phi: object, limits: dict[str, tuple[int, int | None]], field: str) -> None:
    with pytest.raises(InputError) as caught:
        workspace(M, phi, limits)  # type: ignore[arg-type]
    assert caught.value.problems[0].field == field


@pytest.mark.parametrize(("step", "field"), [(0, "step"), ("1/100", "step")])
def test_a_sweep_of_too_many_orientations_is_refused(step: object, field: str) -> None:
    with pytest.raises(InputError) as caught:
        workspace_sweep(M, 0, 90, step, LIMITS)  # type: ignore[arg-type]
    assert caught.value.problems[0].field == field


@pytest.mark.parametrize(
    ("manipulator", "phi", "limits"),
    [
        (M, 30, LIMITS),
        (M, 0, LIMITS),
        (EQUILATERAL, 30, {"l1": (2, 9), "l2": (2, 9), "l3": (2, 9)}),
        (EQUILATERAL, 30, {"l1": (None, 40)}),  # the conic is whole
        (EQUILATERAL, 0, {"l1": (2, 9)}),
        (SQUARE, 0, {"l1": (1, 2), "l2": (1, 2)}),
        (
            Manipulator(base={"equilateral": 10}, platform={"equilateral": 10}),
            0,
            {"l1": (2, 5), "l2": (5, 8)},
        ),
    ],
)
def test_every_workspace_has_a_picture_with_its_arcs_where_they_are(
    manipulator: Manipulator, phi: int, limits: dict[str, tuple[int | None, int]]
) -> None:
    """Arcs as they are drawn keep the limits, and the conic's have J = 0."""
    document = workspace(manipulator, phi, limits).to_json()
    assert figure_of(document).svg().startswith("<svg")
    a, b, c, d, e, f = (float(x) for x in document["conic"]["coefficients"].values())
    plane = Plane(document)
    for region, loops in zip(document["regions"], plane.loops, strict=True):
        for arcs, lines in zip(region["boundary"], loops, strict=True):
            for arc, line in zip(arcs, lines, strict=True):
                x, y = line.T
                if arc["on"] == "singular":
                    value = a * x * x + b * x * y + c * y * y + d * x + e * y + f
                    size = abs(a) + abs(b) + abs(c) + abs(d) + abs(e) + abs(f)
                    assert abs(value).max() < 1e-9 * size * (1 + abs(line).max() ** 2)
                for leg, (low, high) in limits.items():
                    foot, head = (ring[int(leg[1]) - 1] for ring in plane.machine)
                    length = abs(x + 1j * y + head - foot)
                    assert length.max() < high * (1 + 1e-9)
                    assert length.min() > (low or 0) * (1 - 1e-9)


def test_a_sweep_has_a_picture() -> None:
    assert workspace_sweep(M, -60, 60, 30, LIMITS).figure().svg().startswith("<svg")
