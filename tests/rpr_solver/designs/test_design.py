"""Designs: the search is repeatable and keeps to its budget; what it finds is proved anew."""

import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cache
from typing import Any

import pytest

from rpr_solver import EXAMPLES, InputError, Manipulator, Requirement, SolverError, check, design
from rpr_solver.designs import design as module
from rpr_solver.designs import search
from rpr_solver.designs.design import examined
from rpr_solver.designs.goals import Profile, cost, windows
from rpr_solver.designs.plan import Goal, Plan
from rpr_solver.designs.programmes import proposals
from rpr_solver.designs.search import GENERATION, searched
from rpr_solver.designs.space import Space
from tests.support.sampling import long

INNOCENTI = EXAMPLES["innocenti"]
AT_MOST_4 = Requirement(start=5, stop=30, max_cusps=4)
AT_MOST_6 = Requirement(start=9, stop=12, max_cusps=6)


VERIFIER = """
import json, sys
from rpr_solver import verify_document
best = json.load(sys.stdin)["best"]
print(json.dumps([verify_document(best[name]).verdict for name in ("check", "margin")]))
"""
"""The independent checker, in a fresh process, on the proofs of the best geometry."""


@cache
def known(manipulator: Manipulator) -> Mapping[str, Any] | None:
    """What a search needs of a geometry."""
    return examined(manipulator, Goal("longest-range", AT_MOST_4))


def made_up(manipulator: Manipulator) -> dict[str, Any]:
    """A document as a census has it, of a geometry whose numbers of cusps are made up: cheap."""
    width = float(abs(manipulator.d1 - 18) + abs(manipulator.a2x - 15) + abs(manipulator.d2 - 17))
    ends = ["0", "5", f"{6 + width:.12f}", None]
    return {
        "fixed_leg": 1,
        "degenerate": [],
        "intervals": [
            {"from": a, "to": b, "count": n} for a, b, n in zip(ends[:3], ends[1:], (4, 8, 4), strict=True)
        ],
    }


def asked_in(seed: int, budget: int, objective: str = "longest-range") -> list[list[str]]:
    """The generations that a search asks for, by hash."""
    generations: list[list[str]] = []

    def examine(asked: Sequence[Manipulator]) -> list[dict[str, Any]]:
        generations.append([one.geometry_hash for one in asked])
        return [made_up(one) for one in asked]

    searched(Plan.of(INNOCENTI, objective, AT_MOST_4, vary="15%", budget=budget, seed=seed), examine)
    return generations


@pytest.mark.parametrize("objective", [long("longest-range"), long("least-change"), "most-cusps"])
def test_a_search_asks_the_same_again_within_its_budget(objective: str) -> None:
    first = asked_in(3, 50, objective)
    assert first == asked_in(3, 50, objective) != asked_in(4, 50, objective)
    assert sum(map(len, first)) <= 50
    assert max(map(len, first)) <= GENERATION
    hashes = [one for generation in first for one in generation]
    assert len(hashes) == len(set(hashes)), "no geometry is asked for twice"


def test_a_search_gets_better_with_values_alone() -> None:
    told: list[float] = []
    plan = Plan.of(INNOCENTI, "longest-range", AT_MOST_4, vary="15%", budget=120)
    outcome = searched(
        plan, lambda asked: [made_up(one) for one in asked], lambda one: told.append(one.value)
    )
    assert told == sorted(told)
    assert told[-1] == outcome.candidates[-1].value > 23
    assert outcome.censuses == 120


def test_what_fails_is_bad_and_the_search_goes_on() -> None:
    def examine(asked: Sequence[Manipulator]) -> list[dict[str, Any] | None]:
        return [made_up(one) if one == INNOCENTI or one.d1 > 17 else None for one in asked]

    plan = Plan.of(INNOCENTI, "longest-range", AT_MOST_4, vary="15%", budget=40)
    outcome = searched(plan, examine)
    assert outcome.censuses == 40
    assert all(one.manipulator.d1 > 17 for one in outcome.candidates)
    with pytest.raises(SolverError, match="the given geometry"):
        searched(plan, lambda asked: [None for _ in asked])


def test_a_search_for_margins_ends_when_all_geometries_are_known() -> None:
    def examine(asked: Sequence[Manipulator]) -> list[dict[str, Any]]:
        whole = {"from": "0", "to": None, "count": 4}
        return [{"fixed_leg": 1, "degenerate": [], "intervals": [whole]} for _ in asked]

    plan = Plan.of(INNOCENTI, "largest-margin", AT_MOST_4, vary={"d1": (17, "17.2")}, decimals=1)
    outcome = searched(plan, examine)
    assert outcome.stopped == "converged"
    assert outcome.censuses == 4  # with the given one


def test_linear_programmes_lengthen_the_range() -> None:
    space, goal = Space.of(INNOCENTI, "15%"), Goal("longest-range", AT_MOST_4)
    document = known(INNOCENTI)
    assert document is not None
    start = Profile(space, INNOCENTI, document)
    best = next(proposals(start, goal, 0.1))
    manipulator = space.manipulator(list(best))
    assert manipulator is not None
    found = known(manipulator)
    assert found is not None
    assert (
        cost(Profile(space, manipulator, found), goal, 0)
        < cost(start, goal, 0)
        == pytest.approx(0.946914, 1e-5)
    )


def test_a_design_with_no_windows_but_narrow_ones_is_met() -> None:
    document = known(INNOCENTI)
    assert document is not None
    profile = Profile(Space.of(INNOCENTI, "5%"), INNOCENTI, document)
    assert len(windows(profile, Goal("least-change", AT_MOST_6))) == 3
    wish = AT_MOST_6.ignoring(Fraction(1, 1000))
    assert windows(profile, Goal("least-change", wish)) == []
    found = design(INNOCENTI, "least-change", wish, vary="5%", budget=2)
    assert found.met
    assert found.outcome.candidates[-1].met
    assert found.margin is not None
    assert found.margin.proved
    answer = found.to_json()["best"]
    assert [window["counts"] for window in answer["check"]["ignored_windows"]] == [[8], [8], [8]]
    assert set(answer["change"].values()) == {"0"}


@pytest.mark.parametrize(("width", "most"), [("0", 10), ("0.01", 10), ("0.02", 8), ("2", 6), ("11", 0)])
def test_the_most_cusps_are_those_of_a_window_that_is_wide_enough(width: str, most: int) -> None:
    wish = Requirement(start=21, stop=31, min_cusps=0, ignore_windows=width)
    near = {"d1": ("17.04", "17.0400001")}
    assert design(INNOCENTI, "most-cusps", wish, vary=near, decimals=7, budget=2).value == str(most)


def test_the_longest_range_goes_on_over_windows_that_are_ignored(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_BOXES", 2000)
    values = {}
    for width in ("0", "0.001"):
        wish = Requirement(start=10, stop=15, max_cusps=6, ignore_windows=width)
        values[width] = Fraction(design(INNOCENTI, "longest-range", wish, vary="0.1%", budget=2).value)
    assert values["0"] < 4 < values["0.001"] == 5


def test_the_answer_is_proved_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_BOXES", 2000)
    calls: list[tuple[int, int]] = []
    wish = Requirement(start=29, stop=30, max_cusps=6)
    found = design(INNOCENTI, "longest-range", wish, vary="5%", budget=2, progress=lambda *n: calls.append(n))
    assert calls == [(1, 2), (2, 2)]
    report = check(found.best, wish, digits=15)
    longest = max(Fraction(x.stop or 0) - Fraction(x.start) for x in report.intervals if x.count <= 6)
    assert Fraction(found.value) >= longest
    assert found.margin is not None
    command = [sys.executable, "-c", VERIFIER]
    answer = json.dumps(found.to_json())
    fresh = subprocess.run(command, input=answer, capture_output=True, text=True, check=True)
    assert json.loads(fresh.stdout) == ["verified", "verified"]
    assert 29 <= Fraction(found.margin.asked["requirement"]["range"]["from"]) < 30


def test_what_is_missing_is_named_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "find_spec", lambda name: None if name == "cma" else True)
    with pytest.raises(SolverError, match=r"a search needs cma; .* '\.\[design\]'"):
        design(INNOCENTI, "longest-range", AT_MOST_4)


@pytest.mark.parametrize(
    ("objective", "requirement", "options", "field"),
    [
        ("shortest", AT_MOST_4, {}, "objective"),
        ("longest-range", Requirement(max_cusps=4), {}, "requirement.range"),
        ("longest-range", None, {}, "requirement"),
        ("least-change", AT_MOST_4, {"budget": 1}, "budget"),
        ("least-change", AT_MOST_4, {"seed": -1}, "seed"),
    ],
)
def test_what_is_wrong_is_named(
    objective: str, requirement: Requirement | None, options: dict[str, Any], field: str
) -> None:
    with pytest.raises(InputError) as caught:
        design(INNOCENTI, objective, requirement, **options)
    assert [problem.field for problem in caught.value.problems] == [field]
