"""The identities of the eliminants, at random places."""

from __future__ import annotations

from random import Random

import pytest

from rpr_solver import EXAMPLES, census
from rpr_solver.verify.core.schema import read_document
from rpr_solver.verify.full import form_of
from rpr_solver.verify.specialisations import Identity, Place, agree, resultant
from rpr_solver.verify.surface import Surface
from tests.support.families import family
from tests.support.verified import geometry_of


def test_a_resultant_with_formal_degrees() -> None:
    # (t − 2)(t − 3) and (t − 5), as forms of degree 2: the second one has a zero at infinity
    assert resultant([6, -5, 1], [-5, 1, 0], 101) == (5 - 2) * (5 - 3) % 101
    assert resultant([6, -5, 1], [-2, 1], 101) == 0


@pytest.mark.parametrize(("n", "identity"), [(0, Place.swallowtails), (1, Place.critical)])
def test_eliminants_are_right_or_refused(n: int, identity: Identity) -> None:
    document = census(EXAMPLES["innocenti"], digits=15, start=31, fixed_leg=3, certificate="full").to_json()
    surface = Surface.of(geometry_of(EXAMPLES["innocenti"]), 3)
    form = form_of(
        surface.ring, read_document(document).members["certificate"]["full"]["systems"][n]["polynomial"]
    )
    assert form is not None
    assert any(b for _, b in form)
    assert agree(surface, form, identity, Random(1), 2) is True
    form[3] = form[3][0], form[3][1] + 1
    assert agree(surface, form, identity, Random(1), 2) is False


def test_shared_angles_leave_nothing_to_compare() -> None:
    surface = Surface.of(geometry_of(family("right angles")), 1)
    assert agree(surface, [(1, 0)] * 33, Place.swallowtails, Random(1), 1) is None
