"""Machines whose legs share joints: poses against a sextic in mpmath, the lemma, and what is refused."""

import cmath
from collections.abc import Callable, Mapping
from fractions import Fraction
from math import radians
from random import Random
from typing import Any

import mpmath
import pytest

import rpr_solver
from rpr_solver import (
    EXAMPLES,
    InputError,
    Manipulator,
    Requirement,
    SolverError,
    assembly_modes,
    census,
    check,
    cusp_table,
    leg_poses,
    poses,
    singular_curves,
    table_document,
    verify_document,
)
from tests.support.sampling import long

PAIRS = ((0, 1), (1, 2), (0, 2))
NAMES = {(0, 1): "1 = {0}2", (1, 2): "2 = {0}3", (0, 2): "1 = {0}3"}
CLASSES = [
    *((pair, None) for pair in PAIRS),
    *((None, pair) for pair in PAIRS),
    *((first, second) for first in PAIRS for second in PAIRS if first != second),
]
"""Which joints of the base are one, and which of the platform."""
SOME = [shared if k in (0, 4, 7) else long(shared) for k, shared in enumerate(CLASSES)]
MACHINES = 60
DIGITS = 30

Pair = tuple[int, int] | None
Points = list[tuple[int, int]]


def corners(rng: Random, pair: Pair) -> Points:
    """Three points, of which two may be one."""
    points = [(rng.randint(-9, 9), rng.randint(-9, 9)) for _ in range(3)]
    if pair is not None:
        points[pair[1]] = points[pair[0]]
    return points if len(set(points)) == (3 if pair is None else 2) else corners(rng, pair)


def machine(number: int) -> tuple[Points, Points, list[Fraction]]:
    """Base, platform and lengths of the legs, from a pose with small coordinates."""
    rng = Random(number)
    base, platform = (corners(rng, pair) for pair in CLASSES[number % len(CLASSES)])
    turn = mpmath.expj(rng.uniform(0, 6))
    place = complex(rng.randint(-9, 9), rng.randint(-9, 9))
    legs = [abs(place + complex(*b) * turn - complex(*a)) for a, b in zip(base, platform, strict=True)]
    return base, platform, [Fraction(max(1, round(100 * float(leg))), 100) for leg in legs]


def by_sextic(base: Points, platform: Points, legs: list[Fraction]) -> list[Any]:
    """The turns of the platform and the places of B1 of all real poses, from the roots of a sextic."""
    a, b = ([mpmath.mpc(*point) for point in points] for points in (base, platform))
    s = [mpmath.mpf(leg.numerator) ** 2 / leg.denominator**2 for leg in legs]

    def linear(t: Any) -> tuple[Any, Any]:
        """Numerators and determinant of X = B1 − A1 at one half tangent."""
        z = (1 + 1j * t) / (1 - 1j * t)
        v2, v3 = (z * (b[k] - b[0]) - (a[k] - a[0]) for k in (1, 2))
        c2, c3 = ((s[k] - s[0] - abs(v) ** 2) / 2 for k, v in ((1, v2), (2, v3)))
        return 1j * (v2 * c3 - v3 * c2), (v2.conjugate() * v3).imag

    def sextic(t: Any) -> Any:
        numerator, determinant = linear(t)
        return (abs(numerator) ** 2 - s[0] * determinant**2) * (1 + t * t) ** 3

    places = [mpmath.mpf(k) / 2 for k in range(-3, 4)]
    table = mpmath.matrix([[t**k for k in range(7)] for t in places])
    found = list(mpmath.lu_solve(table, mpmath.matrix([sextic(t) for t in places])))
    while abs(found[-1]) < mpmath.mpf(10) ** -60:
        found.pop()
    roots = mpmath.polyroots(found[::-1], maxsteps=300, extraprec=400)
    real = [root.real for root in roots if abs(root.imag) < mpmath.mpf(10) ** -40]
    turns = [((1 + 1j * t) / (1 - 1j * t), *linear(t)) for t in real]
    return [(z, a[0] + numerator / determinant) for z, numerator, determinant in turns]


@pytest.mark.parametrize("shared", CLASSES, ids=str)
def test_poses_are_those_of_a_sextic(shared: tuple[Pair, Pair]) -> None:
    kind = CLASSES.index(shared)
    with mpmath.workdps(90):
        for number in range(kind, MACHINES, len(CLASSES)):
            base, platform, legs = machine(number)
            manipulator = Manipulator(base={"points": base}, platform={"points": platform})
            table = poses(manipulator, *legs, digits=DIGITS)
            expected = by_sextic(base, platform, legs)
            assert table.count == len(expected)
            for pose in table.poses:
                phi = mpmath.radians(mpmath.mpf(str(pose.phi_deg)))
                origin = mpmath.mpc(mpmath.mpf(str(pose.x)), mpmath.mpf(str(pose.y)))
                b1 = origin + mpmath.expj(phi) * mpmath.mpc(*platform[0])
                apart = [abs(mpmath.expj(phi) - z) + abs(b1 - x) for z, x in expected]
                assert min(apart) < mpmath.mpf(10) ** -25


@pytest.mark.parametrize("shared", SOME, ids=str)
def test_the_joints_are_named_and_poses_are_verified(shared: tuple[Pair, Pair]) -> None:
    base, platform, legs = machine(CLASSES.index(shared))
    manipulator = Manipulator(base={"points": base}, platform={"points": platform})
    names = [
        f"{letter}{NAMES[pair].format(letter)}"
        for letter, pair in zip("AB", shared, strict=True)
        if pair is not None
    ]
    assert manipulator.geometry.shared_joints == " and ".join(names)
    table = poses(manipulator, *legs, digits=15)
    assert verify_document(table.to_json()).verdict == "verified"
    table.figure() if table.count else manipulator.figure()


BASE = {"points": [[0, 0], [0, 0], [6, 0]]}
PLATFORM = {"points": [[0, 0], [3, 0], [1, 2]]}


@pytest.mark.parametrize(
    ("legs", "multiplicities"),
    [
        # A1, B1 and B2 are on a line, and B3 is at the distance sqrt(13) from A1
        ((2, 5, 4), [2, 2]),
        # also B3 is on the line A1A3: with L3^2 = (6 - sqrt(13))^2 it is not rational, but 5^2 + 12^2 = 13^2
        ((4, 7, 5), [2, 2]),
        ((2, 2, 4), [1, 1]),
    ],
)
def test_multiplicities(legs: tuple[int, int, int], multiplicities: list[int]) -> None:
    table = poses(Manipulator(base=BASE, platform=PLATFORM), *legs, digits=15)
    assert [pose.multiplicity for pose in table.poses] == multiplicities


def test_four_poses_coalesce_where_both_singular_curves_cross() -> None:
    """B3 is at (5, 12) from A1 in the plane of the platform, 13 from it."""
    manipulator = Manipulator(base=BASE, platform={"points": [[0, 0], [3, 0], [3, 12]]})
    table = poses(manipulator, 2, 5, 7, digits=15)
    assert [pose.multiplicity for pose in table.poses] == [4]


@pytest.mark.parametrize(
    ("base", "platform", "legs"),
    [
        (BASE["points"], [[0, 0], [6, 0], [3, 4]], (5, 5, 6)),
        ([[0, 0], [6, 0], [0, 0]], [[0, 0], [3, 4], [6, 0]], (5, 6, 5)),
        ([[6, 0], [0, 0], [0, 0]], [[3, 4], [0, 0], [6, 0]], (6, 5, 5)),
        ([[0, 0], [6, 0], [3, 4]], BASE["points"], (5, 5, 6)),
        ([[3, 4], [0, 0], [6, 0]], [[6, 0], [0, 0], [0, 0]], (6, 5, 5)),
    ],
)
def test_where_a_platform_turns_with_all_legs_locked_the_other_poses_are_listed(
    base: object, platform: object, legs: tuple[int, int, int]
) -> None:
    """They are near to poses of neighbouring lengths, which are near to none else but those of the turn."""
    manipulator = Manipulator(base={"points": base}, platform={"points": platform})
    table = poses(manipulator, *legs, digits=15)
    [curve] = table.curves
    assert curve["alpha_deg"] == "any"
    assert [pose.multiplicity for pose in table.poses] == [1, 1]
    beside = poses(manipulator, *(leg + Fraction(1, 10**6) for leg in legs), digits=15)
    for pose in table.poses:
        near = [x for x in beside.poses if abs(float(x.alpha_deg) - float(pose.alpha_deg)) < 1e-3]
        assert [(round(float(x.b1_x), 3), round(float(x.b1_y), 3)) for x in near] == [
            (round(float(pose.b1_x), 3), round(float(pose.b1_y), 3))
        ]
    assert verify_document(table.to_json()).verdict != "refused"


def test_beside_a_turn_two_poses_may_merge_or_be_none() -> None:
    platform = {"points": [[0, 0], [6, 0], [3, 4]]}
    tables = [
        poses(Manipulator(base={"sides": [0, x, x]}, platform=platform), 5, 5, x, digits=15) for x in (4, 1)
    ]
    assert [[pose.multiplicity for pose in table.poses] for table in tables] == [[2], []]


def test_lengths_along_which_the_platform_turns_are_refused() -> None:
    manipulator = Manipulator(base=BASE, platform={"points": [[0, 0], [6, 0], [3, 4]]})
    with pytest.raises(SolverError, match="the same along a curve of poses"):
        leg_poses(manipulator, {"l1": 5, "l2": 5}, digits=15)


@pytest.mark.parametrize("shared", SOME, ids=str)
def test_poses_along_each_leg(shared: tuple[Pair, Pair]) -> None:
    """Counts are those of direct kinematics on a grid, and a pose of each sign is in an aspect of its own."""
    base, platform, legs = machine(CLASSES.index(shared))
    manipulator = Manipulator(base={"points": base}, platform={"points": platform})
    for moving in (CLASSES.index(shared) % 3, (CLASSES.index(shared) + 1) % 3):
        held = {f"l{leg + 1}": legs[leg] for leg in range(3) if leg != moving}
        found = leg_poses(manipulator, held, digits=15)
        assert found.intervals[-1].count == 0
        for interval in found.intervals:
            assert interval.count in (0, 2, 4)
            assert sum(sign or 0 for sign in interval.signs) == 0
            assert None not in interval.aspects
            assert len(set(interval.aspects)) == interval.count
        for length in (2, 9, 16):
            inside = next(x for x in found.intervals if x.stop is None or Fraction(length) < Fraction(x.stop))
            lengths = {**held, f"l{moving + 1}": length}
            table = poses(manipulator, *(lengths[f"l{leg}"] for leg in (1, 2, 3)), digits=15)
            assert table.count == inside.count


@pytest.mark.parametrize("shared", SOME, ids=str)
def test_the_assembly_mode_never_changes(shared: tuple[Pair, Pair]) -> None:
    base, platform, legs = machine(CLASSES.index(shared))
    manipulator = Manipulator(base={"points": base}, platform={"points": platform})
    for leg in (1, 2, 3):
        answer = assembly_modes(manipulator, legs[0], fixed_leg=leg).to_json()
        assert answer["change"] == "impossible"
        assert answer["certificate"]["method"] == "shared-joints"
    assert assembly_modes(manipulator, between=(1, None)).change == "impossible"


SPELLINGS: list[dict[str, Any]] = [
    {"a2x": 0, "a3x": 10, "a3y": 0, "d1": 3, "d2": 4, "d3": 5},
    {"base": {"sides": [0, 10, 10]}, "platform": {"sides": [3, 4, 5]}},
    {"base": {"points": [[1, 1], [1, 1], [7, 9]]}, "platform": {"points": [[0, 0], [3, 0], [3, 4]]}},
]


def test_all_spellings_of_a_machine_have_one_hash() -> None:
    assert len({Manipulator.from_json(spelling).geometry_hash for spelling in SPELLINGS}) == 1
    irrational = Manipulator(base={"sides": [0, "sqrt(2)", "sqrt(2)"]}, platform={"sides": [1, 1, 0]})
    assert Manipulator.from_json(irrational.to_json()) == irrational
    assert irrational.geometry.shared_joints == "A1 = A2 and B1 = B3"
    assert poses(irrational, 1, 1, 1, digits=15).count == 4


@pytest.mark.parametrize(
    ("geometry", "field", "reason"),
    [
        ({"base": BASE, "platform": {"sides": [0, 4, 4]}}, "geometry.platform", "legs 1 and 2 are one"),
        ({"base": {"points": [[1, 1]] * 3}, "platform": PLATFORM}, "geometry.base", "are one point"),
        ({"base": BASE, "platform": {"sides": [0, 0, 0]}}, "geometry.platform", "no orientation"),
        ({"base": BASE, "platform": {"sides": [0, 4, 5]}}, "geometry.platform.sides[2]", "triangle inequal"),
        ({**SPELLINGS[0], "a3y": 1}, "geometry.a2x", "leads through A3"),
        ({**SPELLINGS[0], "a3x": -10}, "geometry.a2x", "leads through A3"),
        ({**SPELLINGS[0], "a3x": 0}, "geometry", "are one point"),
        ({**SPELLINGS[0], "d1": -1}, "geometry.d1", "must be > 0"),
    ],
)
def test_what_is_no_such_machine_is_refused(geometry: dict[str, Any], field: str, reason: str) -> None:
    with pytest.raises(InputError, match=reason) as error:
        Manipulator.from_json(geometry)
    assert [problem.field for problem in error.value.problems] == [field]


@pytest.mark.parametrize("shared", SOME, ids=str)
def test_no_slice_has_cusps_and_all_nodes_are_listed(shared: tuple[Pair, Pair]) -> None:
    base, platform, _ = machine(CLASSES.index(shared))
    manipulator = Manipulator(base={"points": base}, platform={"points": platform})
    found = 0
    for leg in (1, 2, 3):
        tables = cusp_table(manipulator, [1, 20, 60], digits=30, fixed_leg=leg)
        degenerate = census(manipulator, fixed_leg=leg, digits=15).degenerate
        for table in tables:
            assert table.count == 0
            kinds = [point["kind"] for point in table.degenerate_points]
            length = table.length
            expected = sum(
                part.count or 0
                for part in degenerate
                if Fraction(part.start) < length and (part.stop is None or length < Fraction(part.stop))
            )
            assert kinds == [kinds[0]] * expected if kinds else not expected
            for point in table.degenerate_points:
                found += 1
                check_node(manipulator, leg, float(length), point)
    assert found


def check_node(manipulator: Manipulator, leg: int, length: float, point: Mapping[str, str]) -> None:
    """By floats: the lengths of the legs are those of the pose, and J and its gradient vanish."""
    a2x, a3x, a3y, d1, d2, d3 = manipulator.doubles()
    base = [0, complex(a2x), complex(a3x, a3y)]
    x = (d1**2 + d3**2 - d2**2) / (2 * d1) if d1 else d3
    height = max(d3**2 - x**2, 0) ** 0.5 * (-1 if manipulator.orientation == "cw" else 1)
    platform = [0, complex(d1), complex(x, height)]
    free = [k for k in (1, 2, 3) if k != leg]

    def squares(alpha: float, theta: float) -> list[float]:
        held = cmath.rect(length, theta)
        return [
            abs(
                held
                + cmath.rect(1, alpha) * (platform[k - 1] - platform[leg - 1])
                - base[k - 1]
                + base[leg - 1]
            )
            ** 2
            for k in free
        ]

    def singularity(alpha: float, theta: float) -> float:
        h = 1e-4
        (f1, g1), (f0, g0) = squares(alpha + h, theta), squares(alpha - h, theta)
        (f3, g3), (f2, g2) = squares(alpha, theta + h), squares(alpha, theta - h)
        return ((f1 - f0) * (g3 - g2) - (f3 - f2) * (g1 - g0)) / (4 * h * h)

    alpha, theta = (radians(float(point[name])) for name in ("alpha_deg", f"theta{leg}_deg"))
    for k, square in zip(free, squares(alpha, theta), strict=True):
        assert float(point[f"l{k}"]) ** 2 == pytest.approx(square, rel=1e-9, abs=1e-9)
    size = max(map(abs, (*base, *platform, length))) ** 4
    steps = [(0.0, 0.0), (1e-4, 0.0), (0.0, 1e-4)]
    assert all(abs(singularity(alpha + x, theta + y)) < 1e-6 * size for x, y in steps)


def test_a_line_of_poses_with_one_joint_vector() -> None:
    """With L3 = |A1A3| = 6 and B3 at A1 = A2, the platform turns about A1."""
    manipulator = Manipulator(base=BASE, platform=PLATFORM)
    [table] = cusp_table(manipulator, 6, digits=15, fixed_leg=3)
    curves = [point["equation"] for point in table.degenerate_points if point["kind"] == "curve"]
    assert curves == ["theta3 = 180 deg"]
    [curve] = [part for part in census(manipulator, fixed_leg=3).degenerate if part.kind == "curve"]
    assert (curve.start, curve.stop, curve.equation) == ("6." + "0" * 89, "6." + "0" * 89, curves[0])
    [rest] = census(manipulator, fixed_leg=3, start="6.1", stop=7, digits=15).degenerate
    assert (rest.kind, rest.start, rest.stop, rest.count) == ("node", "6.1", "7", 2)


def test_a_check_counts_no_cusps() -> None:
    manipulator = Manipulator(base=BASE, platform=PLATFORM)
    asked = {"start": 1, "stop": 9, "limits": {"l2": (2, 8)}, "mode_change": "excluded"}
    report = check(manipulator, Requirement(**asked, max_cusps=0), digits=15)
    assert report.passed
    assert [(x.start, x.stop, x.count, x.example) for x in report.intervals] == [("1", "9", 0, 5)]
    assert not check(manipulator, Requirement(**asked, min_cusps=1), digits=15).passed
    assert not check(manipulator, Requirement(start=1, max_cusps=0, degenerate="refused"), digits=15).passed


@pytest.mark.parametrize("shared", SOME, ids=str)
def test_singular_curves_of_the_legs_without_whole_lines(shared: tuple[Pair, Pair]) -> None:
    """Nodes are those of the table, and every region has the number of poses of direct kinematics."""
    base, platform, legs = machine(CLASSES.index(shared))
    manipulator = Manipulator(base={"points": base}, platform={"points": platform})
    first, second = ({1, 2, 3} if pair is None else {k + 1 for k in pair} for pair in shared)
    drawn = first - (second if shared[1] else set())
    for leg in {1, 2, 3} - drawn:
        with pytest.raises(InputError, match="fixed_leg"):
            singular_curves(manipulator, legs[leg - 1], fixed_leg=leg)
    for leg in drawn:
        curves = singular_curves(manipulator, legs[leg - 1], fixed_leg=leg)
        assert len(curves.aspects) == 4
        for region in curves.regions:
            free = map(str, region.point)
            lengths = [legs[leg - 1] if k == leg else next(free) for k in (1, 2, 3)]
            assert poses(manipulator, *lengths, digits=15).count == region.poses


REFUSED: dict[str, Callable[[Manipulator], object]] = {
    "margin": lambda m: rpr_solver.margin(m, 3),
    "design": lambda m: rpr_solver.design(m, "longest-range", Requirement(start=1, stop=2, max_cusps=0)),
    "export": lambda m: rpr_solver.export(table_document(m, 3, digits=15), "sympy"),
    "cusp curves": rpr_solver.cusp_curves,
    "aspects": lambda m: rpr_solver.aspects(m, 1, 2),
    "connections": lambda m: rpr_solver.pose_connections(m, 4, 5, 6),
    "path": lambda m: rpr_solver.joint_path(m, 4, 5, 6, 1, 2),
}


@pytest.mark.parametrize("name", REFUSED)
def test_other_questions_are_refused_with_the_reason(name: str) -> None:
    with pytest.raises(InputError, match="A1 = A2, a joint that two legs share"):
        REFUSED[name](Manipulator(base=BASE, platform=PLATFORM))


def test_near_a_machine_with_a_shared_joint_nothing_is_special() -> None:
    assert "near" not in Manipulator(base=BASE, platform={"equilateral": 6}).identity_json()
    assert EXAMPLES["innocenti"].geometry.shared_joints == ""
