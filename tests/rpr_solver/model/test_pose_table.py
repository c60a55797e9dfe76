"""Direct kinematics: every pose of a joint vector, exactly counted."""

import math
from dataclasses import replace
from fractions import Fraction
from functools import cache

import mpmath as mp
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rpr_solver import (
    EXAMPLES,
    InputError,
    JointPoint,
    Manipulator,
    PlatformPose,
    PoseTable,
    cusp_table,
    poses,
    poses_of_squares,
)
from tests.support.article import number
from tests.support.article import pose as article_pose
from tests.support.newton import Slice
from tests.support.sampling import sample
from tests.support.strategies import examples, lengths, manipulators, rationals

Vector = tuple[Fraction, Fraction]
INNOCENTI = EXAMPLES["innocenti"]
HALF_TANGENTS = st.one_of(st.none(), rationals(-3, 3, (1, 2, 3, 5)))


def manipulator(*values: object) -> Manipulator:
    names = ("a2x", "a3x", "a3y", "d1", "d2", "d3", "orientation")
    return Manipulator.from_json(dict(zip(names, values, strict=True)))


def direction(half_tangent: Fraction | None) -> Vector:
    if half_tangent is None:
        return Fraction(-1), Fraction(0)
    t = half_tangent
    return (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)


@st.composite
def heronian(draw: st.DrawFn) -> Manipulator:
    """A manipulator whose platform has rational corners: rational half tangents at B1 and B2."""
    a, b = (draw(rationals(0, 2, (2, 3, 5)).filter(bool)) for _ in range(2))
    assume(a * b < 1)  # the third angle is positive
    (ca, sa), (cb, sb) = direction(a), direction(b)
    scale = draw(st.integers(1, 12))
    sides = (scale * (sa * cb + ca * sb), scale * sa, scale * sb)  # d1, d2, d3
    base = [draw(rationals(-12, 12, (1, 2))) for _ in range(3)]
    try:
        return Manipulator(*base, *sides, orientation=draw(st.sampled_from(["ccw", "cw"])))
    except InputError:
        assume(False)
        raise


def corners(m: Manipulator) -> list[Vector]:
    """The rational platform corners in the platform's frame."""
    p = (m.d1**2 + m.d3**2 - m.d2**2) / (2 * m.d1)
    square = m.d3**2 - p**2
    h = Fraction(math.isqrt(square.numerator), math.isqrt(square.denominator))
    assert h * h == square
    return [(Fraction(0), Fraction(0)), (m.d1, Fraction(0)), (p, h if m.orientation == "ccw" else -h)]


def legs(m: Manipulator, alpha: Vector, b1: Vector) -> list[Vector]:
    """The leg vectors of a pose."""
    (c, s), base = alpha, [(Fraction(0), Fraction(0)), (m.a2x, Fraction(0)), (m.a3x, m.a3y)]
    return [
        (b1[0] + c * x - s * y - ax, b1[1] + s * x + c * y - ay)
        for (x, y), (ax, ay) in zip(corners(m), base, strict=True)
    ]


def squares(vectors: list[Vector]) -> list[Fraction]:
    return [x * x + y * y for x, y in vectors]


def moment(m: Manipulator, vectors: list[Vector]) -> Fraction:
    """Zero where the three leg lines meet in a point (possibly at infinity)."""
    base = [(Fraction(0), Fraction(0)), (m.a2x, Fraction(0)), (m.a3x, m.a3y)]
    (a, b, c), (d, e, f), (g, h, i) = (
        (y, -x, ax * y - ay * x) for (x, y), (ax, ay) in zip(vectors, base, strict=True)
    )
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def at(table: PoseTable, alpha: Vector, b1: Vector) -> list[PlatformPose]:
    """The poses of a table at these coordinates."""
    degrees = math.degrees(math.atan2(alpha[1], alpha[0]))
    return [
        p
        for p in table.poses
        if abs((float(p.alpha_deg) - degrees + 180) % 360 - 180) < 1e-9
        and all(
            abs(float(x) - float(y)) < 1e-9 * (1 + abs(float(y)))
            for x, y in zip((p.b1_x, p.b1_y), b1, strict=True)
        )
    ]


@given(heronian(), HALF_TANGENTS, rationals(-9, 9, (1, 2, 7)), rationals(-9, 9, (1, 2, 7)))
@examples(40)
def test_a_rational_pose_is_found_again(m: Manipulator, t: Fraction | None, x: Fraction, y: Fraction) -> None:
    vectors = legs(m, direction(t), (x, y))
    assume(all(squares(vectors)))
    table = poses_of_squares(m, *squares(vectors), digits=20)
    if not table.curves:
        assert table.count_with_multiplicity <= 6
        assert len(at(table, direction(t), (x, y))) == 1
        [pose] = at(table, direction(t), (x, y))
        assert (pose.multiplicity == 1) == (moment(m, vectors) != 0)
        assert (pose.b1_x == "0") == (x == 0)
        if y == 0:
            assert pose.theta1_deg in ("0", "180." + "0" * 17)
        for angle, (vx, vy) in zip((pose.theta1_deg, pose.theta2_deg, pose.theta3_deg), vectors, strict=True):
            assert abs(float(angle) - math.degrees(math.atan2(vy, vx))) % 360 < 1e-9


@given(heronian(), HALF_TANGENTS, rationals(-3, 3, (1, 2, 3)))
@examples(40)
def test_exact_multiplicities_on_the_singular_curve(m: Manipulator, t: Fraction | None, u: Fraction) -> None:
    """J is linear in L1, so every rational (alpha, theta1) has one rational singular slice."""
    alpha, theta = direction(t), direction(u)

    def pose_at(length: Fraction) -> list[Vector]:
        return legs(m, alpha, (length * theta[0], length * theta[1]))

    one, two = moment(m, pose_at(Fraction(1))), moment(m, pose_at(Fraction(2))) / 2
    assume(one != two)
    length = 1 + one / (one - two)
    vectors = pose_at(length)
    assert moment(m, vectors) == 0
    assume(all(squares(vectors)))
    table = poses_of_squares(m, *squares(vectors), digits=20)
    assume(not table.curves)
    [pose] = at(table, alpha, vectors[0])
    assert pose.multiplicity >= 2
    assert table.count_with_multiplicity <= 6
    local = Slice(m, float(length))  # a negative length turns theta by 180 deg
    x = (math.atan2(alpha[1], alpha[0]), math.atan2(theta[1], theta[0]))
    (_, e_f), _ = local.system(0, x)
    (_, e_g), _ = local.system(1, x)
    if max(abs(e_f), abs(e_g)) > 1e-6:
        assert pose.multiplicity == 2


@given(manipulators(), lengths(), lengths(), lengths())
@examples(40)
def test_every_pose_closes_and_complex_ones_come_in_pairs(
    m: Manipulator, l1: Fraction, l2: Fraction, l3: Fraction
) -> None:
    table = poses(m, l1, l2, l3, digits=40)
    factors = table.certificate["factors"]
    assert sum(f["degree"] * f["multiplicity"] for f in factors) == 6  # type: ignore[attr-defined]
    if table.certificate["method"] == "balls":
        assert table.count_with_multiplicity % 2 == 0
    with mp.workdps(50):
        for pose in table.poses:
            for vector, length, angle in zip(
                mp_legs(m, pose),
                (l1, l2, l3),
                (pose.theta1_deg, pose.theta2_deg, pose.theta3_deg),
                strict=True,
            ):
                size = mp.mpf(max(l1, l2, l3, m.d1, m.d3, abs(m.a2x)).numerator)
                assert abs(abs(vector) - number(length)) < mp.mpf(10) ** -34 * size
                assert (
                    abs(vector - number(length) * mp.expjpi(number(angle) / 180)) < mp.mpf(10) ** -30 * size
                )


def mp_legs(m: Manipulator, pose: PlatformPose) -> list[mp.mpc]:
    a2x, a3x, a3y, d1, d2, d3 = (number(getattr(m, k)) for k in ("a2x", "a3x", "a3y", "d1", "d2", "d3"))
    p = (d1**2 + d3**2 - d2**2) / (2 * d1)
    h = mp.sqrt(abs(d3**2 - p**2)) * (1 if m.orientation == "ccw" else -1)
    b1, turn = mp.mpc(pose.b1_x, pose.b1_y), mp.expjpi(number(pose.alpha_deg) / 180)
    return [b1, b1 + d1 * turn - a2x, b1 + mp.mpc(p, h) * turn - mp.mpc(a3x, a3y)]


@given(manipulators(), lengths(), lengths(), lengths())
@examples(40)
def test_scale_and_mirror(m: Manipulator, l1: Fraction, l2: Fraction, l3: Fraction) -> None:
    table = poses(m, l1, l2, l3, digits=20)
    names, factor = ("a2x", "a3x", "a3y", "d1", "d2", "d3"), Fraction(22, 7)
    larger = replace(m, **{name: getattr(m, name) * factor for name in names})
    scaled = poses(larger, *(x * factor for x in (l1, l2, l3)), digits=20)
    assert pose_angles(scaled) == pose_angles(table)
    mirror = replace(m, a3y=-m.a3y, orientation="cw" if m.orientation == "ccw" else "ccw")
    mirrored = poses(mirror, l1, l2, l3, digits=20)
    assert sorted(p.multiplicity for p in mirrored.poses) == sorted(p.multiplicity for p in table.poses)
    assert sorted(p.b1_x for p in mirrored.poses) == sorted(p.b1_x for p in table.poses)


def pose_angles(table: PoseTable) -> list[tuple[str, str, int]]:
    return [(p.alpha_deg, p.theta1_deg, p.multiplicity) for p in table.poses]


SLICES = (
    ("innocenti", "14.98", 6),
    ("innocenti", "28.1", 10),
    ("zein-flat", "3", 4),
    ("fourteen-cusps", "5.96", 14),
)
CUSPS = sample([(name, l1, k) for name, l1, count in SLICES for k in range(count)], 0, 7, 17, 21, 30)


@cache
def solved(name: str, l1: str) -> tuple[JointPoint, ...]:
    return cusp_table(EXAMPLES[name], [l1], digits=90)[0].cusps


@pytest.mark.parametrize(("name", "l1", "k"), CUSPS)
def test_a_cusp_is_a_triple_root_of_the_sextic(name: str, l1: str, k: int) -> None:
    """Its coordinates are irrational: at their 90 digits, three roots lie within about 1e-30."""
    m, cusp = EXAMPLES[name], solved(name, l1)[k]
    table = poses(m, l1, Fraction(cusp.l2), Fraction(cusp.l3))
    polynomial = table.polynomial
    with mp.workdps(90):
        omega, t = mp.sqrt(polynomial.radicand), mp.tan(mp.radians(mp.mpf(cusp.alpha_deg)) / 2)
        coefficients = [a + omega * b for a, b in zip(polynomial.a, polynomial.b, strict=True)]
        derivatives = [
            abs(mp.fsum(math.comb(n, k) * c * t ** (n - k) for n, c in enumerate(coefficients) if n >= k))
            / mp.fsum(math.comb(n, k) * abs(c * t ** (n - k)) for n, c in enumerate(coefficients) if n >= k)
            for k in range(4)
        ]
    assert max(derivatives[:3]) < mp.mpf(10) ** -75
    assert derivatives[3] > mp.mpf(10) ** -12
    near = [p for p in table.poses if abs(float(p.alpha_deg) - float(cusp.alpha_deg)) < 1e-9]
    assert sum(p.multiplicity for p in near) in (1, 3)


@pytest.mark.parametrize(("name", "l1", "k"), CUSPS)
def test_beside_a_cusp_one_pose_and_three(name: str, l1: str, k: int) -> None:
    """Off the cusp across the kernel there are three neighbouring poses on one side, and one on the other."""
    m, cusp = EXAMPLES[name], solved(name, l1)[k]
    local = Slice(m, float(l1))
    at_cusp = math.radians(float(cusp.alpha_deg)), math.radians(float(cusp.theta1_deg))
    slopes = local.derivatives(0, at_cusp)
    size = math.hypot(slopes[1][0], slopes[0][1])
    counts = set()
    for step in (1e-8, -1e-8):
        with mp.workdps(50):
            alpha, theta = (
                mp.mpf(text) + mp.degrees(step * slope / size)
                for text, slope in zip(
                    (cusp.alpha_deg, cusp.theta1_deg), (slopes[1][0], slopes[0][1]), strict=True
                )
            )
            lengths = [Fraction(mp.nstr(x, 45)) for x in article_pose(m, l1, str(alpha), str(theta)).lengths]
            table = poses(m, l1, *lengths[1:], digits=15)
        counts.add(sum(abs(float(p.alpha_deg) - float(cusp.alpha_deg)) < 0.1 for p in table.poses))
    assert counts == {1, 3}


@pytest.mark.parametrize(("name", "l1", "k"), CUSPS)
def test_euler_savary(name: str, l1: str, k: int) -> None:
    """A3 is the centre of curvature of the path of B3 in the four-bar A1 B1 B2 A2."""
    m, cusp = EXAMPLES[name], solved(name, l1)[k]
    with mp.workdps(50):
        a2, a3 = number(m.a2x), mp.mpc(number(m.a3x), number(m.a3y))
        d1, d2, d3 = number(m.d1), number(m.d2), number(m.d3)
        p = (d1**2 + d3**2 - d2**2) / (2 * d1)
        h = mp.sqrt(d3**2 - p**2) * (1 if m.orientation == "ccw" else -1)
        turn = mp.expjpi(mp.mpf(cusp.alpha_deg) / 180)
        b1 = number(l1) * mp.expjpi(mp.mpf(cusp.theta1_deg) / 180)
        side, arm = d1 * turn, mp.mpc(p, h) * turn
        leg2 = b1 + side - a2

        def dot(x: mp.mpc, y: mp.mpc) -> mp.mpf:
            return (x * mp.conj(y)).real

        # d/dtheta1 of |leg 2|² = const, twice
        alpha1 = -dot(leg2, 1j * b1) / dot(leg2, 1j * side)
        velocity2 = 1j * b1 + alpha1 * 1j * side
        alpha2 = -(dot(velocity2, velocity2) + dot(leg2, -b1 - alpha1**2 * side)) / dot(leg2, 1j * side)
        velocity = 1j * b1 + alpha1 * 1j * arm
        acceleration = -b1 + alpha2 * 1j * arm - alpha1**2 * arm
        leg3 = b1 + arm - a3
        assert abs(dot(leg3, velocity)) < mp.mpf(10) ** -40 * abs(leg3) * abs(velocity)
        assert abs(dot(leg3, acceleration) + dot(velocity, velocity)) < mp.mpf(10) ** -40 * abs(leg3) * abs(
            acceleration
        )


FLAT = manipulator(20, 6, 0, 7, 9, 16, "ccw")


@pytest.mark.parametrize("side", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_a_flat_manipulator_has_quadruple_poses(side: tuple[int, int]) -> None:
    turn, leg = side
    b1 = Fraction(3 * leg)
    table = poses(FLAT, 3, abs(b1 + 7 * turn - 20), abs(b1 + 16 * turn - 6), digits=20)
    [pose] = at(table, (Fraction(turn), Fraction(0)), (b1, Fraction(0)))
    assert pose.multiplicity == 4
    half_turn = "180." + "0" * 17
    assert pose.alpha_deg == ("0" if turn > 0 else half_turn)
    assert pose.theta1_deg == ("0" if leg > 0 else half_turn)


def test_a_rational_swallowtail() -> None:
    m = manipulator(2, -4, 4, 1, 4, 3, "cw")
    [slice_table] = cusp_table(m, [1], digits=40)
    [point] = slice_table.degenerate_points
    l2, l3 = (Fraction(Fraction(point[k]) ** 2).limit_denominator(10**6) for k in ("l2", "l3"))
    table = poses_of_squares(m, 1, l2, l3, digits=40)
    assert [p.multiplicity for p in table.poses if p.alpha_deg == point["alpha_deg"]] == [4]
    assert table.count_with_multiplicity in (4, 6)


def test_congruent_triangles_with_equal_legs_move_on_a_circle() -> None:
    for a2x, alpha in ((30, "0"), (-30, "180")):
        m = manipulator(a2x, 0, 40, 30, 50, 40, "ccw" if a2x > 0 else "cw")
        if a2x < 0:  # turned by half a turn, the platform must fit the base
            m = manipulator(a2x, 0, -40, 30, 50, 40, "ccw")
        table = poses(m, 5, 5, 5, digits=15)
        assert [curve["alpha_deg"] for curve in table.curves] == [alpha]
        assert table.curves[0]["kind"] == "curve"
        # unequal legs: a finite fibre, and no pose at that alpha
        other = poses(m, 5, 6, 7, digits=15)
        assert not other.curves
        assert alpha not in {p.alpha_deg for p in other.poses}


def test_mirrored_congruent_triangles_have_pairs_of_poses_with_one_alpha() -> None:
    """Each double root of the sextic is two different regular poses, or none."""
    m = manipulator(30, 0, 40, 30, 50, 40, "cw")
    table = poses(m, 35, 35, 35, digits=15)
    if not table.poses:
        table = poses(m, 25, 26, 27, digits=15)
    assert all(p.multiplicity == 1 for p in table.poses)
    assert table.count % 2 == 0
    assert table.count > 0
    for first, second in zip(table.poses[::2], table.poses[1::2], strict=True):
        assert first.alpha_deg == second.alpha_deg
        assert float(first.theta1_deg) < float(second.theta1_deg)


def test_no_pose_is_an_answer() -> None:
    table = poses(INNOCENTI, "14.98", "200", "1")
    assert table.to_json()["poses"] == []
    assert (table.count, table.count_with_multiplicity, table.curves) == (0, 0, ())


def test_digits_from_15_to_1000() -> None:
    long, short = (poses(INNOCENTI, "14.98", "15", "12", digits=d) for d in (1000, 15))
    for a, b in zip(long.poses, short.poses, strict=True):
        assert abs(Fraction(a.alpha_deg) - Fraction(b.alpha_deg)) <= abs(Fraction(a.alpha_deg)) / 10**14
    vectors = [mp.mpf(0)]
    with mp.workdps(1010):
        for pose in long.poses:
            vectors = [abs(v) for v in mp_legs(INNOCENTI, pose)]
            for length, exact in zip(vectors, ("14.98", "15", "12"), strict=True):
                assert abs(length - mp.mpf(exact)) < mp.mpf(10) ** -995


@pytest.mark.parametrize("exponent", [-30, 30])
def test_extreme_scales(exponent: int) -> None:
    factor = Fraction(10) ** exponent
    names = ("a2x", "a3x", "a3y", "d1", "d2", "d3")
    huge = replace(INNOCENTI, **{name: getattr(INNOCENTI, name) * factor for name in names})
    exact = [Fraction(x) for x in ("14.98", "15", "12")]
    assert pose_angles(poses(huge, *(x * factor for x in exact))) == pose_angles(poses(INNOCENTI, *exact))
