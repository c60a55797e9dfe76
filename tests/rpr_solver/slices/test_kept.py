"""Eliminants that are kept: the same answers, bounded, for several threads at once."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from fractions import Fraction

import pytest

from rpr_solver import EXAMPLES, InputError, Manipulator, cusp_table, eliminate, solve_slice
from rpr_solver.slices import kept
from rpr_solver.slices.eliminant import Eliminant
from rpr_solver.slices.kept import KeptEliminants

FIRST = EXAMPLES["innocenti"]


@pytest.fixture
def eliminated(monkeypatch: pytest.MonkeyPatch) -> list[tuple[Manipulator, int]]:
    """What is eliminated, in order."""
    done: list[tuple[Manipulator, int]] = []

    def noted(manipulator: Manipulator, fixed_leg: int) -> Eliminant:
        done.append((manipulator, fixed_leg))
        return eliminate(manipulator, fixed_leg)

    monkeypatch.setattr(kept, "eliminate", noted)
    return done


def test_a_loop_of_single_slices_eliminates_once(eliminated: list[object]) -> None:
    other = replace(FIRST, d1=FIRST.d1 + Fraction(1, 977))
    lengths = ["14.98", "27", "28.1", "34"]
    looped = [table for length in lengths for table in cusp_table(other, length, digits=15)]
    assert len(eliminated) == 1
    fresh = eliminate(other)
    assert looped == [solve_slice(fresh, length, 15) for length in lengths]


def test_geometry_orientation_and_leg_have_their_own(eliminated: list[object]) -> None:
    store = KeptEliminants()
    mirror = replace(FIRST, orientation="cw")
    for _ in range(2):
        for manipulator, leg in ((FIRST, 1), (FIRST, 2), (mirror, 1)):
            found = store.eliminant(manipulator, leg)
            assert (found.manipulator, found.slice_map.fixed_leg) == (manipulator, leg)
    assert len(eliminated) == len(store) == 3


def test_the_last_used_are_kept_within_the_bound(eliminated: list[object]) -> None:
    one = KeptEliminants()
    one.eliminant(FIRST, 1)
    store = KeptEliminants(most_bytes=int(2.5 * one._bytes))
    for leg in (1, 2, 1, 3, 1):
        store.eliminant(FIRST, leg)
        assert store._bytes <= store.most_bytes
    assert eliminated == [(FIRST, leg) for leg in (1, 1, 2, 3)]
    small = KeptEliminants(most_bytes=100)
    assert small.eliminant(FIRST, 1) == eliminate(FIRST)
    assert len(small) == 0


def test_what_one_caller_keeps_in_it_is_its_own() -> None:
    store = KeptEliminants()
    first = store.eliminant(FIRST, 1)
    first.kept["note"] = 1
    assert "note" not in store.eliminant(FIRST, 1).kept


def test_threads_get_the_same() -> None:
    store = KeptEliminants()
    expected = {leg: eliminate(FIRST, leg) for leg in (1, 2, 3)}
    with ThreadPoolExecutor(6) as pool:
        found = list(pool.map(lambda n: store.eliminant(FIRST, n % 3 + 1), range(60)))
    assert all(e == expected[n % 3 + 1] for n, e in enumerate(found))
    assert len(store) == 3


@pytest.mark.parametrize(
    ("manipulator", "leg", "field"), [({}, 1, "manipulator"), (FIRST, True, "fixed_leg")]
)
def test_wrong_arguments_are_named(manipulator: Manipulator, leg: int, field: str) -> None:
    with pytest.raises(InputError) as error:
        KeptEliminants().eliminant(manipulator, leg)
    assert [problem.field for problem in error.value.problems] == [field]
