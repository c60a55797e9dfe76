"""Poses that are singular for every length, exactly."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, Manipulator, cusp_table
from rpr_solver.verify.angles import degenerate_lengths, lengths_at_limit
from rpr_solver.verify.core.intervals import degrees
from rpr_solver.verify.core.roots import square_root
from rpr_solver.verify.core.surds import Ring
from rpr_solver.verify.core.system import Surface, less
from rpr_solver.verify.landmarks import Event, Unclear
from rpr_solver.verify.permanent import permanent_poses
from tests.support.families import family
from tests.support.verified import geometry_of

NUMBERS = st.integers(-(10**12), 10**12)


@pytest.mark.parametrize("fixed", [1, 3])
def test_j_is_zero_for_every_length(fixed: int) -> None:
    surface = Surface(geometry_of(EXAMPLES["twelve-cusps"]), fixed)
    poses = permanent_poses(surface)
    assert len(poses) == 8
    for pose in poses:
        assert pose.in_length(surface.singular, 1) == []
        assert pose.in_length(surface.legs[0].squared, 0) != []
    assert degenerate_lengths(surface, 100) == []


@pytest.mark.parametrize(
    ("name", "leg", "lengths"),
    [
        ("flat base", 1, [10.246950765959598]),
        ("flat base", 2, []),
        ("right angles", 2, [4, 16]),
        ("similar, mirrored", 3, [20, 60]),
        ("isosceles", 3, [1.7189992364804816, 15.10833889301592]),
        ("folded flat platform", 1, [1]),
    ],
)
def test_lengths_at_which_they_are_degenerate(name: str, leg: int, lengths: list[float]) -> None:
    surface = Surface(geometry_of(family(name)), leg)
    found = sorted(float(x.length(surface).middle) for x in degenerate_lengths(surface, 100))
    assert found == pytest.approx(lengths, rel=1e-13)


@pytest.mark.parametrize(
    ("m", "kind"),
    [
        (Manipulator(-2, -1, -1, 2, 3, 1), "quadruple"),
        (Manipulator(8, 4, 3, 8, 8, 3, orientation="cw"), "quadruple"),
        (Manipulator(5, 9, -3, 5, 4, 3), "node"),
        (family("similar, mirrored"), "node"),
    ],
)
def test_cusps_tend_to_a_pose_from_both_sides_as_told(m: Manipulator, kind: str) -> None:
    surface = Surface(geometry_of(m), 3)
    [*found] = [x for x in degenerate_lengths(surface, 200) if isinstance(x, Event) and x.kind == kind]
    assert found
    for event in found:
        assert event.beside == (1, 1)
        pose = [float(degrees(x).middle) for x in event.pose]
        for off in (-1, 1):
            length = event.length(surface).middle * (1 + off * Fraction(1, 10**9))
            [table] = cusp_table(m, length, fixed_leg=3, digits=15)
            angles = [[float(x) for x in cusp.coordinates[:2]] for cusp in table.cusps]
            # the pose moves by the power 2/3 of the length at a node
            near = [
                all(abs((a - b + 180) % 360 - 180) < 0.01 for a, b in zip(x, pose, strict=True))
                for x in angles
            ]
            assert sum(near) == 1


@pytest.mark.parametrize(("a3x", "a3y", "d2", "d3"), [(7, 3, 6, 9), (-4, -1, 9, 4)])
def test_it_is_open_which_cusps_tend_to_a_pose_where_j_is_of_higher_order(
    a3x: int, a3y: int, d2: int, d3: int
) -> None:
    m = Manipulator(5, a3x, a3y, 5, d2, d3, orientation="cw" if a3x > 0 else "ccw")
    found = degenerate_lengths(Surface(geometry_of(m), 3), 100)
    assert [x.beside for x in found if isinstance(x, Event) and x.kind == "quadruple"] == [(0, 0)]


@pytest.mark.parametrize("name", ["similar", "congruent", "both flat"])
def test_nothing_is_claimed_where_they_are_not_isolated_or_always_degenerate(name: str) -> None:
    with pytest.raises(Unclear):
        degenerate_lengths(Surface(geometry_of(family(name)), 1), 100)


@pytest.mark.parametrize(("leg", "limit", "lengths"), [(0, 2, [1]), (0, 8, [9]), (1, 4, [1]), (0, 3, [])])
def test_a_limit_that_a_cusp_reaches_at_such_a_pose(leg: int, limit: int, lengths: list[float]) -> None:
    surface = Surface(geometry_of(family("folded flat platform")), 1)
    squared = less(surface.legs[leg].squared, Fraction(limit * surface.unit) ** 2)
    found = lengths_at_limit(surface, squared, 100)
    assert [float(x.length(surface).middle) for x in found] == pytest.approx(lengths)


@given(NUMBERS, NUMBERS, st.sampled_from([1, 2, 3, 15, 6]))
def test_the_root_of_a_square(a: int, b: int, radicand: int) -> None:
    ring = Ring(radicand)
    x = (a, 0 if radicand == 1 else b)
    root = square_root(ring, ring.times(x, x))
    assert root is not None
    assert ring.times(root, root) == ring.times(x, x)
    assert ring.sign(root) >= 0


@given(st.integers(1, 10**12))
def test_a_number_beside_a_square_has_no_root(a: int) -> None:
    assert square_root(Ring(1), (a * a + 1, 0)) is None
    assert square_root(Ring(2), (a * a, 1)) is None
