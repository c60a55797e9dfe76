"""Tables of poses: right ones are accepted, wrong ones refused."""

from __future__ import annotations

import random
from fractions import Fraction

import pytest

from rpr_solver import (
    EXAMPLES,
    InputError,
    Manipulator,
    PoseTable,
    poses,
    poses_of_squares,
    verify_document,
)
from tests.support.families import family
from tests.support.mutations import OF_POSES
from tests.support.verified import accepted, accepted_but_no_mutation, random_documents


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
    assert not verify_document(
        {**document, "curves": [] if document["curves"] else [{"alpha_deg": "0"}]}
    ).accepted


def test_irrational_lengths_and_mutations() -> None:
    accepted(poses_of_squares(EXAMPLES["innocenti"], 225, 200, 900, digits=15).to_json())
    document = poses(EXAMPLES["innocenti"], "14.98", 15, 12, digits=15).to_json()
    accepted_but_no_mutation(document, OF_POSES, 6, seed=3)


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
