"""Cusp tables of several slices."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from functools import cache
from typing import Any

import pytest

from rpr_solver import (
    EXAMPLES,
    ClaimStatus,
    InputError,
    Manipulator,
    cusp_table,
    table_document,
    verify_document,
)
from rpr_solver.verify.core.surds import Ring
from rpr_solver.verify.tables import proportional
from tests.support.families import family
from tests.support.sampling import long


def test_every_slice_is_verified_in_turn() -> None:
    document = table_document(EXAMPLES["zein-flat"], [10, 0, "34.5"], digits=15, fixed_leg=2)
    steps: list[tuple[int, int]] = []
    verification = verify_document(document, progress=lambda *step: steps.append(step))
    assert verification.accepted
    assert steps == [(0, 3), (1, 3), (2, 3), (3, 3)]
    assert [claim.at for claim in verification.open] == ["/slices/1"]


@pytest.mark.parametrize("change", [{"slices": 1}, {"slices": [1]}, {"fixed_leg": 4}, {"digits": 3}])
def test_what_is_no_table_is_named(change: dict[str, object]) -> None:
    document = {**table_document(EXAMPLES["zein-flat"], 10, digits=15), **change}
    with pytest.raises(InputError) as error:
        verify_document(document)
    assert error.value.problems[0].field.split("/")[1] == next(iter(change))


Change = Callable[[dict[str, Any]], object]


def refused(manipulator: Manipulator, part: dict[str, Any]) -> list[str]:
    document = table_document(manipulator, [], digits=15)
    claims = verify_document({**document, "slices": [part]}).refused
    return [claim.at.removeprefix("/slices/0/") for claim in claims]


def slice_of(manipulator: Manipulator, length: object) -> dict[str, Any]:
    return deepcopy(_solved(manipulator, length))


@cache
def _solved(manipulator: Manipulator, length: object) -> dict[str, Any]:
    [table] = cusp_table(manipulator, length, digits=15)  # type: ignore[arg-type]
    return table.to_json()


FLAT = EXAMPLES["zein-flat"]


@pytest.mark.parametrize(
    ("change", "where"),
    [
        (lambda part: part["certificate"].update(method="guess"), []),
        (lambda part: part["cusps"].pop(), ["count"]),
        (lambda part: (part["cusps"].pop(), part.update(count=3)), ["count"]),
        (
            lambda part: (part["cusps"].insert(1, part["cusps"][0]), part.update(count=5)),
            ["cusps/1", "count"],
        ),
        (lambda part: part["cusps"].reverse(), ["cusps"]),
        (lambda part: part["cusps"][0].update(l2="26.2233542007524"), ["cusps/0", "count"]),
        (lambda part: part["certificate"]["factors"].pop(), ["certificate/factors"]),
        (lambda part: part["certificate"].update(real_roots=6), ["certificate/real_roots"]),
        (lambda part: part["certificate"].update(eliminant_degree=22), ["certificate/eliminant_degree"]),
        (lambda part: part.update(l1="10.001"), ["cusps/0", "cusps/1", "cusps/2", "cusps/3", "count"]),
    ],
)
def test_a_wrong_member_is_named(change: Change, where: list[str]) -> None:
    part = slice_of(FLAT, 10)
    change(part)
    assert refused(FLAT, part) == where


@pytest.mark.parametrize("name", [long("similar"), "both flat", long("congruent")])
def test_a_missing_degenerate_pose_is_noticed(name: str) -> None:
    part = slice_of(family(name), 9)
    assert refused(family(name), part) == []
    lost = part["degenerate_points"].pop()
    assert refused(family(name), part) == ["count"]
    part["degenerate_points"].append({**lost, "kind": "node", "theta1_deg": "12.3456789012345"})
    assert refused(family(name), part)


def test_a_curve_of_degenerate_poses_is_proved() -> None:
    part = slice_of(family("congruent"), 5)
    [curve] = [p for p in part["degenerate_points"] if p["kind"] == "curve"]
    part["degenerate_points"].remove(curve)
    assert refused(family("congruent"), part) == ["count"]
    ordinary = slice_of(FLAT, 10)
    ordinary["degenerate_points"].append(curve)
    assert refused(FLAT, ordinary) == ["degenerate_points/0"]


def test_what_cannot_be_read_is_named() -> None:
    for change in ({"l1": "x"}, {"l1": "-1"}, {"cusps": None}, {"degenerate_points": [1]}):
        with pytest.raises(InputError) as error:
            refused(FLAT, {**slice_of(FLAT, 10), **change})
        assert next(iter(change)) in error.value.problems[0].field


@cache
def the_document() -> dict[str, Any]:
    return table_document(EXAMPLES["zein-flat"], 10, digits=15, certificate="full")


AT = "/slices/0/certificate/full/"


@pytest.mark.parametrize(
    ("change", "where"),
    [
        (lambda full: full, []),
        (lambda full: full["polynomial"]["coefficients"].__setitem__(3, "7"), ["polynomial"]),
        (lambda full: full["squarefree"].update(prime="1000005"), ["squarefree"]),
        (lambda full: full["real_roots"].pop(), ["real_roots"]),
        (lambda full: full["real_roots"][0].update(upper="0"), ["real_roots"]),
        (lambda full: full["real_roots"][1].update(multiplicity=2), ["real_roots"]),
        (lambda full: full["boxes"][0]["l2"].update(radius="1e-30"), ["boxes"]),
        (lambda full: full["boxes"].pop(), ["boxes"]),
    ],
)
def test_a_wrong_part_is_named(change: Callable[[dict[str, Any]], object], where: list[str]) -> None:
    document = deepcopy(the_document())
    change(document["slices"][0]["certificate"]["full"])
    assert [claim.at.removeprefix(AT) for claim in verify_document(document).refused] == where


def test_degenerate_slices_and_an_irrational_height() -> None:
    for manipulator in (family("both flat"), family("isosceles, irrational")):
        document = table_document(manipulator, 3, digits=15, certificate="full")
        verification = verify_document(document)
        assert verification.accepted
        full = [claim for claim in verification.claims if claim.at.startswith(AT)]
        assert len(full) >= 3
        assert {claim.status for claim in full} == {ClaimStatus.PROVED}


def test_multiples() -> None:
    ring = Ring(3)
    form = [(1, 1), (0, 0), (2, -1)]
    turned = [ring.times(x, (2, 5)) for x in form]
    assert proportional(ring, turned, form)
    assert not proportional(ring, [*turned[:2], (1, 0)], form)
    assert not proportional(ring, [(0, 0)] * 3, form)
    assert proportional(ring, [], [])
