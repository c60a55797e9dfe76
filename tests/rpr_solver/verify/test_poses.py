"""Tables of poses: right ones are accepted, wrong ones refused."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import pairwise

import pytest
from mpmath import mp

from rpr_solver import (
    EXAMPLES,
    InputError,
    Manipulator,
    PoseTable,
    poses,
    poses_of_squares,
    verify_document,
)
from rpr_solver.verify.poses import Closure
from tests.support.families import family
from tests.support.mutations import OF_POSES
from tests.support.sampling import long
from tests.support.verified import accepted, accepted_but_no_mutation, geometry_of, random_documents


def _fold(m: Manipulator, l1: int, theta: str) -> tuple[Fraction, Fraction]:
    """L2 and L3, to many digits, of a pose with J = 0 at an angle of leg 1 in radians."""
    with mp.workdps(150):
        corner = mp.expj(mp.mpf(theta)) * l1
        foot = mp.mpf(int(m.d1**2 + m.d3**2 - m.d2**2)) / (2 * int(m.d1))
        platform = mp.mpf(int(m.d1)), mp.mpc(foot, mp.sqrt(int(m.d3) ** 2 - foot**2))
        base = mp.mpc(int(m.a2x)), mp.mpc(int(m.a3x), int(m.a3y))

        def legs(alpha: mp.mpf) -> list[mp.mpc]:
            return [corner + b * mp.expj(alpha) - a for a, b in zip(base, platform, strict=True)]

        def j(alpha: mp.mpf) -> mp.mpf:
            slopes = [
                (mp.im(w * mp.conj(b * mp.expj(alpha))), mp.im(w * mp.conj(corner)))
                for w, b in zip(legs(alpha), platform, strict=True)
            ]
            return slopes[0][0] * slopes[1][1] - slopes[0][1] * slopes[1][0]

        steps = [mp.mpf(n) / 20 for n in range(126)]
        low, high = next((a, b) for a, b in pairwise(steps) if j(a) * j(b) < 0)
        root = mp.findroot(j, (low, high), solver="anderson", tol=mp.mpf(10) ** -280)
        second, third = (Fraction(mp.nstr(abs(w), 140)) for w in legs(root))
        return second, third


CURVE = {"kind": "curve", "alpha_deg": "0", "description": ""}


@pytest.mark.parametrize(
    ("name", "lengths"),
    [
        ("flat base", (5, 5, 5)),
        ("both flat", (3, 10, 13)),
        ("congruent", (5, 5, 5)),
        ("congruent, mirrored", (8, 8, 9)),
        ("d1 = a2x", (8, 8, 9)),
        ("isosceles", (7, "9.5", 11)),
    ],
)
def test_degenerate_joint_vectors_are_accepted(name: str, lengths: tuple[int, int, int]) -> None:
    document = poses(family(name), *lengths, digits=20).to_json()
    accepted(document)
    assert not verify_document({**document, "curves": [] if document["curves"] else [CURVE]}).accepted


def test_no_pose_is_where_the_legs_leave_any_direction_but_no_length() -> None:
    document = poses(family("congruent"), 12, "10.4", "20.5", digits=15).to_json()
    assert any(factor["multiplicity"] == 2 for factor in document["certificate"]["factors"])
    assert accepted(document).established


@pytest.mark.parametrize(
    ("m", "lengths"),
    [
        (Manipulator(-4, 8, 0, 4, 8, 4), (2, 6, 14)),  # all on one line, the linear equations dependent
        (Manipulator(-3, -8, -3, 3, 3, 3), (3, 3, 7)),  # dependent at α = 180°, where B1 has two places
        (Manipulator(-3, -3, 4, 3, 4, 5), ("3.5", "2.5", "2.5")),
    ],
)
def test_a_number_is_0_exactly_where_the_linear_equations_are_dependent(
    m: Manipulator, lengths: tuple[int | str, int | str, int | str]
) -> None:
    document = poses(m, *lengths, digits=15).to_json()
    assert verify_document(document).established
    dependent = [pose for pose in document["poses"] if pose["alpha_deg"] in ("0", "180.000000000000")]
    zeros = [(pose, name) for pose in dependent for name in pose if name != "alpha_deg" and pose[name] == "0"]
    assert zeros
    for pose, name in zeros:
        pose[name] = "1.00000000000000e-60"
        assert not verify_document(document).accepted
        pose[name] = "0"


def test_irrational_lengths_and_mutations() -> None:
    accepted(poses_of_squares(EXAMPLES["innocenti"], 225, 200, 900, digits=15).to_json())
    document = poses(EXAMPLES["innocenti"], "14.98", 15, 12, digits=15).to_json()
    accepted_but_no_mutation(document, OF_POSES, 6, seed=3)


@pytest.mark.parametrize("exponent", [long(20), pytest.param(40, marks=pytest.mark.slow), long(100)])
def test_two_poses_beside_a_fold_are_printed_alike(exponent: int) -> None:
    m = Manipulator(10, 3, 7, 13, 14, 15)
    length = _fold(m, 5, "0.3")
    found = 0
    for side in (1, -1):
        third = length[1] * (1 + side * Fraction(1, 10**exponent))
        document = poses(m, 5, length[0], third, digits=15).to_json()
        verification = accepted(document)
        assert verification.established
        texts = [pose["alpha_deg"] for pose in document["poses"]]
        if len(set(texts)) < len(texts):
            found += 1
            document["poses"].pop()
            assert not verify_document(document).accepted
    assert found == (exponent > 30)


@pytest.mark.parametrize("change", [{"l1": "sqrt(x)"}, {"l2": "-1"}, {"poses": [1]}, {"certificate": 1}])
def test_what_is_no_table_of_poses_is_bad_input(change: dict[str, object]) -> None:
    document = poses(EXAMPLES["zein-flat"], 20, 20, 20, digits=15).to_json()
    with pytest.raises(InputError):
        verify_document({**document, **change})


@pytest.mark.long
@pytest.mark.timeout(480)
def test_random_joint_vectors() -> None:
    def table(m: Manipulator, _: int, rng: random.Random) -> PoseTable:
        lengths = [Fraction(rng.randint(5, 200), rng.choice([1, 10])) for _ in range(3)]
        return poses(m, *lengths, digits=rng.choice([15, 40]))

    for n, document in random_documents(7, 100, table, degenerate_every=4):
        accepted_but_no_mutation(document, OF_POSES, 6, n)


def closure_of(name: str, *lengths: int) -> Closure:
    manipulator = EXAMPLES[name] if name in EXAMPLES else family(name)
    first, second, third = (Fraction(length) ** 2 for length in lengths)
    return Closure.of(geometry_of(manipulator), (first, second, third))


def test_the_polynomial_of_the_solver() -> None:
    mine = closure_of("zein-flat", 20, 20, 20).sextic
    theirs = poses(EXAMPLES["zein-flat"], 20, 20, 20, digits=15).polynomial
    assert [a * theirs.a[0] for a, _ in mine] == [mine[0][0] * a for a in theirs.a]
    assert not any(b for _, b in mine)


def test_multiplicities_and_a_root_at_180_degrees() -> None:
    assert {k: len(p) - 1 for k, p in closure_of("both flat", 3, 10, 13).parts.items()} == {1: 2, 4: 1}
    turned = closure_of("congruent", 5, 5, 5)
    assert sum(k * (len(p) - 1) for k, p in turned.parts.items()) == 6
