"""Loops round cusps, against a float model of the manipulator that knows nothing of their proofs.

The local algebra: the outer poses over nearly one joint vector, and J of the signs that it tells.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from random import Random
from typing import Any

import pytest
from flint import arb, ctx
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import (
    EXAMPLES,
    Eliminant,
    InputError,
    Manipulator,
    Path,
    SliceTable,
    SolverError,
    cusp_loop,
    poses,
    solve_slice,
)
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.paths import loops
from rpr_solver.paths.loops import CUSP_DIGITS, CuspFrame, loop_in_slice
from rpr_solver.paths.proofs import finished_route
from rpr_solver.paths.question import PathTerms
from rpr_solver.paths.routes import Angles, local_map
from tests.support.motions import Mover, angles_of, apart, arrives, turns
from tests.support.shared import eliminant_of
from tests.support.strategies import examples

FIRST = EXAMPLES["innocenti"]
TWINS = Manipulator("4.8", "4.8", 9, "4.8", 9, "10.2", orientation="cw")
TERMS = PathTerms.of(samples=2)
SLICES = [("innocenti", "27", 8), ("innocenti", "28.1", 10), ("fourteen-cusps", "5.96", 14)]


def slice_of(manipulator: Manipulator, length: str | Fraction, leg: int = 1) -> tuple[Eliminant, SliceTable]:
    eliminant = eliminant_of(manipulator, leg)
    return eliminant, solve_slice(eliminant, length, CUSP_DIGITS)


def check(path: Path, table: SliceTable, steps: int = 400) -> None:
    """Everything that a loop claims, in floats or by the exact direct kinematics."""
    assert path.cusp is not None
    found = poses(path.manipulator, *path.lengths, digits=path.digits).poses
    theta = f"theta{path.fixed_leg}_deg"
    for end in (path.start, path.stop):
        pose = found[end.number - 1].to_json()
        assert (end.alpha_deg, end.theta_deg, 1) == (pose["alpha_deg"], pose[theta], pose["multiplicity"])
    assert path.start.number != path.stop.number
    mover = Mover.of(path.manipulator, path.fixed_leg)
    dense = path.resampled(121)
    least = float(path.certificate["least_determinant"])
    for sample in dense.samples[::12]:
        length = float(sample.lengths[path.fixed_leg - 1])
        legs, determinant = (m(*angles_of(sample), length) for m in (mover.legs, mover.determinant))
        assert legs == pytest.approx([float(x) for x in sample.lengths], rel=1e-9)
        assert determinant == pytest.approx(float(sample.determinant), rel=1e-3, abs=1e-6)
        assert float(sample.determinant) * path.sign >= least > 0
    for number, cusp in enumerate(table.cusps, 1):
        first, second = (float(text) for text in cusp.coordinates[2:])
        expected = path.winding if number in (path.cusp, *path.twins) else 0
        assert turns(dense, (first, second)) == pytest.approx(expected, abs=1e-6)
    assert max(arrives(path, n) for n in (steps, 2 * steps)) < 1e-6
    assert arrives(path.reversed(), steps) < 1e-6


@pytest.mark.parametrize("cusp", [5])
def test_loop_goes_round_one_cusp_to_another_pose(cusp: int) -> None:
    eliminant, table = slice_of(FIRST, "27")
    loop = loop_in_slice(eliminant, table, cusp, TERMS)
    assert (loop.cusp, loop.winding) == (cusp, 1)
    check(loop, table)


@pytest.mark.parametrize("cusp", [1, pytest.param(5, marks=pytest.mark.long)])
def test_a_loop_goes_round_twin_cusps_and_names_them(cusp: int) -> None:
    """The cusps of congruent triangles share their leg lengths in pairs."""
    eliminant, table = slice_of(TWINS, "21.01")
    loop = loop_in_slice(eliminant, table, cusp, TERMS)
    [twin] = loop.twins
    assert table.cusps[twin - 1].coordinates[2:] == table.cusps[cusp - 1].coordinates[2:]
    assert (loop.to_json()["winding"], loop.to_json()["twins"]) == (1, [twin])
    assert (loop.reversed().winding, loop.reversed().twins) == (-1, (twin,))
    check(loop, table)


@pytest.mark.long
@pytest.mark.parametrize(("name", "length", "count"), SLICES)
def test_every_loop_is_what_it_claims(name: str, length: str, count: int) -> None:
    eliminant, table = slice_of(EXAMPLES[name], length)
    for cusp in range(1, count + 1):
        check(loop_in_slice(eliminant, table, cusp, TERMS), table)


@pytest.mark.long
def test_every_cusp_of_a_hundred_random_slices_has_a_loop() -> None:
    random, slices, loops = Random(11), 0, 0
    while slices < 100:
        values = [Fraction(random.randint(-300, 300), 10) for _ in range(3)]
        sides = [Fraction(random.randint(10, 400), 10) for _ in range(3)]
        try:
            manipulator = Manipulator(*values, *sides, orientation=random.choice(("ccw", "cw")))
            length, leg = Fraction(random.randint(10, 500), 10), random.choice((1, 2, 3))
            eliminant, table = slice_of(manipulator, length, leg)
        except (InputError, SolverError):
            continue
        slices += 1
        for cusp in range(1, table.count + 1):
            loop = loop_in_slice(eliminant, table, cusp, TERMS)
            assert loop.winding == 1
            check(loop, table)
            loops += 1
    assert loops > 200


@given(st.sampled_from([-350, -2, 1, 350]), st.integers(1, 8))
@examples(2)
def test_scaling_by_a_power_of_ten_scales_the_loop(power: int, cusp: int) -> None:
    factor = Fraction(10) ** power
    sizes = [factor * getattr(FIRST, name) for name in ("a2x", "a3x", "a3y", "d1", "d2", "d3")]
    loop, scaled = (
        loop_in_slice(*slice_of(manipulator, length), cusp, TERMS)
        for manipulator, length in ((FIRST, Fraction(27)), (Manipulator(*sizes), 27 * factor))
    )
    assert scaled.lengths == tuple(factor * length for length in loop.lengths)
    assert (scaled.sign, scaled.winding, scaled.start, scaled.stop) == (
        loop.sign,
        loop.winding,
        loop.start,
        loop.stop,
    )


def test_lengths_of_many_digits_have_a_loop() -> None:
    """Their squares, scaled to integers, are beyond the range of a double."""
    sides = Fraction("17.04") + Fraction(1, 10**160), FIRST.d2, FIRST.d3
    eliminant, table = slice_of(Manipulator(FIRST.a2x, FIRST.a3x, FIRST.a3y, *sides), "27")
    check(loop_in_slice(eliminant, table, 2, TERMS), table)


@given(st.integers(1, 8))
@examples(2)
def test_a_mirrored_manipulator_has_the_mirrored_loop(cusp: int) -> None:
    sizes = FIRST.to_dict() | {"a3y": -FIRST.a3y, "orientation": "cw"}
    loop = loop_in_slice(*slice_of(FIRST, "27"), cusp, TERMS)
    eliminant, table = slice_of(Manipulator(**sizes), "27")
    # the table is sorted by θ, which changes its sign
    mirrored = loop_in_slice(eliminant, table, 9 - cusp, TERMS)
    assert (mirrored.lengths, mirrored.sign, mirrored.winding) == (loop.lengths, loop.sign, loop.winding)
    for one, other in ((loop.start, mirrored.start), (loop.stop, mirrored.stop)):
        alpha, theta = angles_of(one)
        assert apart((-alpha, -theta), angles_of(other)) < 1e-12


@pytest.mark.parametrize("leg", [2, pytest.param(3, marks=pytest.mark.long)])
def test_any_leg_may_be_fixed(leg: int) -> None:
    eliminant, table = slice_of(FIRST, "20", leg)
    check(loop_in_slice(eliminant, table, 1, TERMS), table)


def test_a_cusp_is_named_by_its_number_or_its_letter() -> None:
    by_number, by_letter = (cusp_loop(FIRST, 27, cusp, samples=2) for cusp in (2, "b"))
    assert by_number == by_letter


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ({"cusp": 9}, "cusp"),
        ({"cusp": "I"}, "cusp"),
        ({"cusp": 0}, "cusp"),
        ({"length": 0}, "l1"),
        ({"samples": 1}, "samples"),
        ({"timing": "sine"}, "timing"),
        ({"duration": 0}, "duration"),
        ({"digits": 3}, "digits"),
        ({"fixed_leg": 4}, "fixed_leg"),
    ],
)
def test_each_argument_at_fault_is_named(arguments: dict[str, object], field: str) -> None:
    asked: dict[str, object] = {"manipulator": FIRST, "length": 27, "cusp": 1, **arguments}
    with pytest.raises(InputError) as caught:
        cusp_loop(**asked)  # type: ignore[arg-type]
    assert [problem.field for problem in caught.value.problems] == [field]


def test_far_longer_legs_than_sides_need_few_proofs(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first loop that is tried would take tens of thousands of pieces."""
    tried = []

    def counted(*arguments: Any) -> Any:
        tried.append(arguments)
        return finished_route(*arguments)

    monkeypatch.setattr(loops, "finished_route", counted)
    loop = cusp_loop(FIRST, "1e12", 1)
    assert loop.start.number != loop.stop.number
    assert 1 < len(tried) < 10


def test_a_slice_without_cusps_has_no_loop() -> None:
    with pytest.raises(InputError, match="no cusps"):
        cusp_loop(EXAMPLES["zein-flat"], "0.1", 1)


def gap(image: Callable[[Angles], Angles], frame: CuspFrame, s: float) -> float:
    """How far apart the images of the outer poses are, over their distance from the cusp's."""
    one, other, cusp = map(image, (frame.outer(arb(s)), frame.outer(arb(-s)), frame.cusp))
    apart, away = (((one[0] - x[0]) ** 2 + (one[1] - x[1]) ** 2).sqrt() for x in (other, cusp))
    return float(apart / away)


@pytest.mark.parametrize(("name", "length"), [("innocenti", "27"), ("fourteen-cusps", "5.96")])
def test_the_outer_poses_meet_and_the_inner_one_lies_across_the_curve(name: str, length: str) -> None:
    eliminant = eliminant_of(EXAMPLES[name])
    slice_map, table = eliminant.slice_map, solve_slice(eliminant, length, 40)
    s = 1e-6
    with ctx.workprec(160):
        scaled = ball_of(table.length * slice_map.scale)

        def image(angles: Angles) -> Angles:
            f, g = local_map(slice_map, scaled, angles, 0).squared_lengths()
            return f, g

        for cusp in table.cusps:
            alpha, theta = (arb(text) * arb.pi() / 180 for text in cusp.coordinates[:2])
            frame = CuspFrame.at(slice_map, scaled, (alpha, theta))
            # without β they would stay as far apart as they are from the cusp's
            assert gap(image, frame, s / 10) < gap(image, frame, s) / 5 < 1e-3
            back = frame.kappa * arb(s) ** 2
            inner = alpha - back * frame.normal[0], theta - back * frame.normal[1]
            for angles, sign in ((frame.outer(arb(s)), 1), (frame.outer(arb(-s)), 1), (inner, -1)):
                assert local_map(slice_map, scaled, angles, 2).singularity().value * frame.sign * sign > 0
