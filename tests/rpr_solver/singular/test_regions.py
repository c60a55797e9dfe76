"""Regions: their numbers of poses are those of direct kinematics at any point."""

from __future__ import annotations

import json
from collections import Counter
from fractions import Fraction
from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from rpr_solver import EXAMPLES, Manipulator, census, poses, singular_curves, trace_slice, verify_document
from rpr_solver.errors import SolverError
from rpr_solver.model.fibre import Closure, fibre
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.singular.regions import number_of_poses
from tests.rpr_solver.long_run import manipulator as random_manipulator
from tests.support.families import FAMILIES, family
from tests.support.sampling import long, sample
from tests.support.shared import eliminant_of
from tests.support.singular import SLICES, manipulator, traced


@pytest.mark.parametrize(("name", "leg", "length"), SLICES)
def test_the_number_of_poses_is_that_of_direct_kinematics(name: str, leg: int, length: str) -> None:
    curves = traced(name, leg, length)
    assert [region.poses for region in curves.regions if not region.bounded] == [0]
    for region in curves.regions:
        lengths = list(region.point)
        lengths.insert(leg - 1, curves.length)
        assert poses(manipulator(name), *lengths, digits=15).count_with_multiplicity == region.poses


@pytest.mark.parametrize("exponent", [200, long(-200), -285])
def test_regions_in_any_unit_are_the_same(exponent: int) -> None:
    unit, m = Fraction(10) ** exponent, EXAMPLES["innocenti"]
    sides = (m.a2x, m.a3x, m.a3y, m.d1, m.d2, m.d3)
    curves = singular_curves(Manipulator(*(side * unit for side in sides)), Fraction("14.98") * unit)
    known = singular_curves(m, "14.98")
    assert [region.poses for region in curves.regions] == [region.poses for region in known.regions]
    for region, other in zip(curves.regions, known.regions, strict=True):
        (x, y), (p, q) = region.rings[0][0], other.rings[0][0]
        assert (x / float(unit), y / float(unit)) == pytest.approx((p, q), rel=1e-6)
        lengths = (curves.length, *region.point)
        assert poses(curves.manipulator, *lengths, digits=15).count_with_multiplicity == region.poses


def test_curves_that_are_a_point_of_doubles_have_no_regions() -> None:
    curves = singular_curves(EXAMPLES["innocenti"], Fraction(10) ** 20)
    with pytest.raises(SolverError, match="double precision"):
        _ = curves.regions


@pytest.mark.long
@given(st.sampled_from(sorted(EXAMPLES)), st.sampled_from((1, 2, 3)), st.integers(1, 400), st.data())
def test_regions_of_any_slice_at_any_point(name: str, leg: int, tenths: int, data: st.DataObject) -> None:
    curves = trace_slice(eliminant_of(EXAMPLES[name], leg), Fraction(tenths, 10))
    [region] = data.draw(st.lists(st.sampled_from(curves.regions), min_size=1, max_size=1))
    lengths = list(region.point)
    lengths.insert(leg - 1, curves.length)
    assert poses(EXAMPLES[name], *lengths, digits=15).count_with_multiplicity == region.poses


def test_poses_at_a_half_turn_are_counted() -> None:
    """The degree of the form of direct kinematics falls there, and its other roots are not all poses."""
    m = Manipulator(7, 1, 6, 5, 5, 6)  # a platform of height 4
    b1, b2, b3 = (Fraction(2), Fraction(3)), (Fraction(-3), Fraction(3)), (Fraction(-8, 5), Fraction(-9, 5))
    bases = ((0, 0), (7, 0), (1, 6))
    squares = [(x - u) ** 2 + (y - v) ** 2 for (x, y), (u, v) in zip((b1, b2, b3), bases, strict=True)]
    closure = Closure.of(SliceMap.of(m), squares)
    assert closure.sextic.degree == 5
    assert number_of_poses(closure.slice_map, squares) == len(fibre(closure, 15).poses)


@pytest.mark.parametrize("length", ["28.09489447887742122", "30.94691403425117"])
def test_right_beside_a_transition_there_are_no_spurious_regions(length: str) -> None:
    curves = trace_slice(eliminant_of(EXAMPLES["innocenti"]), length)
    assert {vertex.cusp for vertex in curves.vertices if vertex.cusp} == set(range(1, curves.table.count + 1))
    assert len(curves.regions) <= 6


NARROW = {
    "10^-3 beside a beak-to-beak": (
        Manipulator(5, -2, -3, 8, 6, 9, orientation="cw"),
        *(3, "4.95808295303036485943", 11, 0),
    ),
    "10^-4 beside a beak-to-beak": (
        Manipulator("26.109", "21.111", "-18.248", "10.542", "18.268", "27.662", orientation="cw"),
        *(3, "68.28188638377627335716", 3, 0),
    ),
    "10^-5 beside a beak-to-beak, large": (
        Manipulator(-2142, -26269, 20310, 21060, 12518, 22828),
        *(3, "19582.39604464578442435123098035608028701338412135166826923861836", 5, 0),
    ),
    "10^-7 beside a beak-to-beak": (Manipulator(5, 6, 9, 9, 10, 5), 1, "8.58468946344460836337", 8, 0),
    "10^-6 beside a swallowtail": (
        Manipulator(-3, -2, -12, 11, 7, 6, orientation="cw"),
        *(1, "2.58886917172127833855", 4, 1),
    ),
    "10^-7 beside a swallowtail": (
        Manipulator("-20.225", "-6.507", "3.058", "5.675", "16.986", "15.156", orientation="cw"),
        *(2, "20.54519110871447149294", 6, 1),
    ),
    "10^-30 beside a beak-to-beak, an arc 10^-14 radians long": (
        Manipulator(3, 4, 2, 3, 4, 4, orientation="cw"),
        *(1, "6.2824853926873722344531788245208399909834102844", 4, 1),
    ),
    "10^-30 beside a beak-to-beak, another cusp 10^-5 away": (
        Manipulator(-4, -1, 2, 1, 4, 3),
        *(1, "3.63069446132371990319681575644559507099", 4, 1),
    ),
    "10^-30 beside two beak-to-beaks, without a cusp": (
        Manipulator(6, 3, 7, 8, 5, 5),
        *(3, "11.5841954340128135453159906845959768328", 9, 0),
    ),
    "10^-28 beside a beak-to-beak, a corner near": (
        Manipulator(-2, -2, 6, 7, 7, 11),
        *(2, "8.04326253298355862018603741577813321698", 6, 1),
    ),
    "10^-38 beside a swallowtail, a node near": (
        Manipulator(4, -7, -11, 10, 10, 10, orientation="cw"),
        *(1, "13.9808297675108979982418600644697915057", 7, 1),
    ),
    "the tip of a cusp 10^-5 beyond another curve": (Manipulator(-3, 0, 4, 13, 15, 4), 1, "9.5", 8, 0),
}
"""Slices in which parts of the curve nearly touch: leg, length, the numbers of regions and of thin ones."""


@pytest.mark.parametrize("name", sample(NARROW, 3, 5, 8, 11))
def test_regions_between_curves_that_nearly_touch_are_listed_once(name: str) -> None:
    m, leg, length, number, thin = NARROW[name]
    curves = singular_curves(m, length, fixed_leg=leg, digits=60)
    assert (len(curves.regions), curves.thin_regions) == (number, thin)
    assert len({region.point for region in curves.regions}) == number
    assert not verify_document(json.loads(json.dumps(curves.to_json()))).refused


@pytest.mark.parametrize(
    ("m", "leg", "length"),
    [
        (Manipulator(20, 6, 0, 7, 9, 16), 1, 4),
        (Manipulator(20, 6, 0, 7, 9, 16), 3, 5),
        (Manipulator(6, 3, 4, 6, 5, 5, orientation="cw"), 1, 4),
    ],
)
def test_slivers_between_curves_that_coincide_are_no_regions(m: Manipulator, leg: int, length: int) -> None:
    assert singular_curves(m, length, fixed_leg=leg).thin_regions == 0


@pytest.mark.parametrize(
    ("name", "leg", "length", "expected"),
    [
        ("congruent, mirrored", 3, "14.82", [6, 6, 4, 2, 2, 0, 0]),
        ("congruent, mirrored", 2, "30.41", [6, 4, 4, 2, 2, 0]),
        ("right angles", 3, "13.19", [6, 4, 4, 4, 4, 2, 2, 0]),
        ("right angles", 2, "12.33", [6, 4, 4, 2, 2, 0]),
    ],
)
def test_regions_that_touch_where_two_poses_close_a_leg_are_apart(
    name: str, leg: int, length: str, expected: list[int]
) -> None:
    regions = trace_slice(eliminant_of(family(name), leg), length).regions
    assert [region.poses for region in regions] == expected


@pytest.mark.long
@pytest.mark.parametrize("number", range(60))
def test_no_region_is_joined_through_a_neck_of_rounding(number: int) -> None:
    """Where a ring comes next to a point of its own, it is at one point: of a crossing or a junction."""
    draw, names = Random(f"necks {number}"), list(FAMILIES)
    name = names[number % len(names)]
    length = Fraction(draw.randint(20, 100 * max(abs(x) for x in FAMILIES[name][:6])), 100)
    curves = trace_slice(eliminant_of(family(name), draw.choice((1, 2, 3))), length)
    for ring in (ring for region in curves.regions for ring in region.rings):
        points = np.array(ring[:-1])
        size = np.ptp(points, axis=0).max()
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(np.array(ring), axis=0).T))])
        for i, j in cKDTree(points).query_pairs(1e-9 * size):
            apart = abs(along[j] - along[i])
            near = min(apart, along[-1] - apart) < 1e-3 * size
            assert near or (points[i] == points[j]).all()


def test_a_region_narrower_than_the_tolerance_is_counted_and_listed_when_drawn_finer() -> None:
    m = Manipulator(12, -6, -7, 2, 4, 5)
    coarse, fine = (singular_curves(m, "11.4", fixed_leg=3, tolerance=x) for x in ("0.001", "0.00001"))
    assert (coarse.thin_regions, fine.thin_regions) == (1, 0)
    assert len(fine.regions) == len(coarse.regions) + 1


def shape_of(m: Manipulator, leg: int, length: Fraction) -> tuple[object, ...]:
    """What does not change between two transitions: regions, aspects, strands and special points."""
    curves = singular_curves(m, length, fixed_leg=leg, digits=60)
    strands = [part.strands for part in curves.components]
    kinds = Counter(point.kind for part in strands for strand in part for _, point in strand.vertices)
    signs = Counter(aspect.sign for aspect in curves.aspects)
    return len(curves.regions) + curves.thin_regions, signs, sorted(map(len, strands)), kinds


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize(
    "number", [pytest.param(n, marks=[pytest.mark.long] if n else []) for n in range(90)]
)
def test_curves_beside_a_transition_do_not_depend_on_how_near_it_is(number: int, side: int) -> None:
    draw = Random(f"beside transitions {number}")
    m, leg = random_manipulator(draw), draw.choice([1, 2, 3])
    lengths = [Fraction(row.length) for row in census(m, digits=90, fixed_leg=leg).transitions]
    if not lengths:
        return
    place = draw.choice(lengths)
    room = min((side * (x - place) for x in lengths if side * (x - place) > 0), default=place)
    if room < place / 10**5:  # another transition is too near for a comparison
        return
    near, far = (shape_of(m, leg, place * (1 + side * Fraction(1, 10**power))) for power in (30, 6))
    assert near == far
