"""Each kind of pose at its normal form, in any coordinates, and at poses of manipulators."""

from collections.abc import Callable
from fractions import Fraction
from math import factorial

import pytest
from flint import fmpq, fmpq_mpoly, fmpq_mpoly_ctx
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf

from rpr_solver import EXAMPLES, Manipulator, PoseKind, cusp_table
from rpr_solver.exact.number_field import Algebraic, Field
from rpr_solver.model.jets import Jet, LocalMap, Pose
from rpr_solver.model.joint_points import classify
from rpr_solver.model.slice_map import SliceMap
from tests.support.sampling import sample
from tests.support.strategies import examples

X, Y = fmpq_mpoly_ctx.get(("x", "y"), "lex").gens()
RATIONALS = Field.rationals()
Function = Callable[[mpf, mpf], mpf]


def manipulator(*values: int | Fraction, orientation: str = "ccw") -> Manipulator:
    return Manipulator(*map(Fraction, values), orientation=orientation)


LIPS = manipulator(4, 0, Fraction(16, 3), 2, Fraction(4, 3), Fraction(10, 3))
NODE = manipulator(10, 10, 10, 3, 4, 5)


def pose(*entries: int | Fraction) -> Pose[Algebraic]:
    """cos α, sin α, cos θ, sin θ and L, all rational."""
    return Pose(*(RATIONALS(Fraction(x)) for x in (*entries, 1)))


MOVING = SliceMap.of(LIPS), pose(Fraction(4, 5), Fraction(3, 5), 0, 1, 6)
"""A pose that is singular at one (scaled) L only."""
STANDING = SliceMap.of(NODE), pose(-1, 0, 1, 0, 13)
"""A pose that is singular at every L."""

NORMAL_FORMS = [
    ("a regular pose", X, Y, MOVING, PoseKind.ORDINARY),
    ("a fold", X, Y**2, MOVING, PoseKind.ORDINARY),
    ("a cusp", X, Y**3 + X * Y, MOVING, PoseKind.CUSP),
    ("a swallowtail", X, Y**4 + X * Y, MOVING, PoseKind.SWALLOWTAIL),
    ("a butterfly", X, Y**5 + X * Y, MOVING, PoseKind.HIGHER),
    ("lips", X, Y**3 + X**2 * Y, MOVING, PoseKind.LIPS),
    ("beak to beak", X, Y**3 - X**2 * Y, MOVING, PoseKind.BEAK_TO_BEAK),
    ("lips at every L", X, Y**3 + X**2 * Y, STANDING, PoseKind.ISOLATED_POINT),
    ("beaks at every L", X, Y**3 - X**2 * Y, STANDING, PoseKind.NODE),
    ("beaks with the kernel along a branch", X, Y**4 - X * Y**2, MOVING, PoseKind.NODE),
    ("goose", X, Y**3 + X**3 * Y, MOVING, PoseKind.HIGHER),
    ("hyperbolic umbilic", X**2 - Y**2, X * Y, MOVING, PoseKind.QUADRUPLE),
    ("sharksfin", X**2 + X * Y**2, Y**2 + X**2 * Y, MOVING, PoseKind.QUADRUPLE),
    ("rank 0 with a common zero", X**2, X * Y, MOVING, PoseKind.HIGHER),
]


def jet(p: fmpq_mpoly) -> Jet[Algebraic]:
    """The partial derivatives at the origin."""
    return Jet.build(4, lambda i, j: RATIONALS(fmpq(p[i, j]) * factorial(i) * factorial(j)))


def invertible() -> st.SearchStrategy[tuple[int, ...]]:
    entries = st.tuples(*[st.integers(-3, 3)] * 4)
    return entries.filter(lambda m: m[0] * m[3] != m[1] * m[2])


@pytest.mark.parametrize(("name", "f", "g", "at", "kind"), NORMAL_FORMS)
@examples(25)
@given(source=invertible(), target=invertible())
def test_a_normal_form_in_any_coordinates(
    name: str,
    f: fmpq_mpoly,
    g: fmpq_mpoly,
    at: tuple[SliceMap, Pose[Algebraic]],
    kind: PoseKind,
    source: tuple[int, ...],
    target: tuple[int, ...],
) -> None:
    x, y = source[0] * X + source[1] * Y, source[2] * X + source[3] * Y
    f, g = f.compose(x, y), g.compose(x, y)
    local = LocalMap(*at, jet(target[0] * f + target[1] * g), jet(target[2] * f + target[3] * g))
    assert classify(local) is kind, name


POSES = [
    (PoseKind.CUSP, EXAMPLES["innocenti"], "14.98"),
    (PoseKind.SWALLOWTAIL, manipulator(2, -4, 4, 1, 4, 3, orientation="cw"), "1"),
    (PoseKind.LIPS, LIPS, "2"),
    (
        PoseKind.BEAK_TO_BEAK,
        manipulator(5, Fraction(40, 11), Fraction(-45, 44), 1, Fraction(3, 16), Fraction(13, 16)),
        "3",
    ),
    (PoseKind.NODE, NODE, "13"),
    (PoseKind.QUADRUPLE, manipulator(8, 4, 3, 6, 5, 5), "14/5"),
    (PoseKind.HIGHER, manipulator(30, 0, 40, 15, 25, 20), "25"),
]


@pytest.mark.parametrize(("kind", "m", "length"), sample(POSES, 0, 2, 3, 4, 5, 6))
def test_a_pose_of_a_manipulator(kind: PoseKind, m: Manipulator, length: str) -> None:
    [table] = cusp_table(m, [length], digits=70)
    points = [c.to_json() for c in table.cusps] if kind is PoseKind.CUSP else table.degenerate_points
    angles = [(p["alpha_deg"], p["theta1_deg"]) for p in points if p.get("kind", "cusp") == kind]
    assert angles
    with mp.workdps(60):
        for alpha, theta in angles[:2]:
            check_by_differences(
                kind, *squared_legs(m, number(Fraction(length))), radians(alpha), radians(theta)
            )


def number(x: Fraction) -> mpf:
    return mpf(x.numerator) / x.denominator


def radians(degrees: str) -> mpf:
    return mpf(degrees) * mp.pi / 180


def squared_legs(m: Manipulator, length: mpf) -> tuple[Function, Function]:
    """L2² and L3² as functions of α and θ1, independently of the solver."""
    p = (m.d1**2 + m.d3**2 - m.d2**2) / (2 * m.d1)
    h = mp.sqrt(number(m.d3**2 - p**2)) * (1 if m.orientation == "ccw" else -1)

    def square(x: mpf, y: mpf, ax: Fraction, ay: Fraction) -> Function:
        def value(a: mpf, t: mpf) -> mpf:
            along = length * mp.cos(t) + x * mp.cos(a) - y * mp.sin(a) - number(ax)
            across = length * mp.sin(t) + x * mp.sin(a) + y * mp.cos(a) - number(ay)
            return along**2 + across**2

        return value

    return square(number(m.d1), mpf(0), m.a2x, Fraction(0)), square(number(p), h, m.a3x, m.a3y)


def check_by_differences(kind: PoseKind, f: Function, g: Function, *at: mpf) -> None:
    """The conditions of a kind by nested difference quotients."""

    def gradient(function: Function, *place: mpf) -> tuple[mpf, mpf]:
        return mp.diff(function, place, (1, 0)), mp.diff(function, place, (0, 1))

    def along_f(function: Function) -> Function:
        def value(*place: mpf) -> mpf:
            (fa, ft), (a, t) = gradient(f, *place), gradient(function, *place)
            return fa * t - ft * a

        return value

    def zero(*values: mpf) -> bool:
        large = max(map(abs, values))
        assert not 1e-20 < large < 1e-6
        return bool(large <= 1e-20)

    if zero(*gradient(f, *at)):
        f, g = g, f
    j = along_f(g)
    e = along_f(j)
    second = along_f(e)
    assert zero(j(*at), e(*at))
    if kind in (PoseKind.CUSP, PoseKind.SWALLOWTAIL):
        assert not zero(*gradient(j, *at))
        assert zero(second(*at)) == (kind is PoseKind.SWALLOWTAIL)
        assert kind is PoseKind.CUSP or not zero(along_f(second)(*at))
    elif kind is PoseKind.QUADRUPLE:
        assert zero(*gradient(f, *at), *gradient(g, *at))
    elif kind in (PoseKind.LIPS, PoseKind.BEAK_TO_BEAK, PoseKind.NODE):
        aa, ab, bb = (mp.diff(j, at, order) for order in ((2, 0), (1, 1), (0, 2)))
        assert zero(*gradient(j, *at))
        assert (aa * bb > ab**2) == (kind is PoseKind.LIPS)
        assert kind is PoseKind.NODE or not zero(second(*at))
