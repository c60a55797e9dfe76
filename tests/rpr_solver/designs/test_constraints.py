"""Designs with constraints on loops and aspects: how far a geometry is from them, and their proofs."""

import json
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

from rpr_solver import EXAMPLES, InputError, Requirement, check, cusp_loop, design
from rpr_solver.designs import design as module
from rpr_solver.designs.design import kept_constraints
from rpr_solver.designs.goals import Profile, cost, document_of, is_met, shortfall
from rpr_solver.designs.plan import Constraints, Goal
from rpr_solver.designs.space import Space
from rpr_solver.paths.loops import loop_in_range
from rpr_solver.transitions.census import census

INNOCENTI = EXAMPLES["innocenti"]
LIMITS = {"l2": (8, 20), "l3": (8, 22)}
WISH = Requirement(start=20, stop=22, min_cusps=0, limits=LIMITS)
PROGRAM = """
import json, sys
from rpr_solver import Manipulator, Requirement, census, check, cusp_loop, margin
design = json.load(sys.stdin)
best, asked = design["best"], design["asked"]["requirement"]
geometry, wish = Manipulator.from_json(best["geometry"]), Requirement.from_json(asked)
report = check(geometry, wish, digits=15)
table = census(geometry, start=wish.start, stop=wish.stop, digits=15)
inside = Requirement.from_json(best["margin"]["asked"]["requirement"])
known = margin(geometry, requirement=inside, most_boxes=%d)
loop = best["constraints"]["loop"]
found = cusp_loop(geometry, loop["l1"], loop["cusp"], limits=wish.limits)
aspects = [min(table.aspects), max(table.aspects)]
print(json.dumps([report.to_json(), table.to_json(), known.to_json(), found.to_json(), aspects]))
"""
"""The proofs of a design, by a process that knows nothing of the search."""


def made_up(counts: str, aspects: str = "", **more: Any) -> Mapping[str, Any]:
    """A document with an interval of length 1 for each number of cusps, from 0 on."""
    parts = [{"from": str(k), "to": str(k + 1), "count": int(n)} for k, n in enumerate(counts)]
    for part, number in zip(parts, aspects, strict=False):
        part["aspects"] = None if number == "?" else int(number)
    return {"fixed_leg": 1, "degenerate": [], "intervals": parts, **more}


def short(document: Mapping[str, Any], **asked: Any) -> float:
    """The shortfall in the range from 1 to 3."""
    goal = Goal("least-change", Requirement(start=1, stop=3, min_cusps=0), Constraints(**asked))
    profile = Profile(Space.of(INNOCENTI, "5%"), INNOCENTI, document)
    assert is_met(profile, goal) == (shortfall(profile, goal) == 0)
    assert (cost(profile, goal, 0) >= 2) == (shortfall(profile, goal) > 0), "what misses them costs more"
    return shortfall(profile, goal)


def test_how_far_a_geometry_is_from_constraints() -> None:
    assert short(made_up("2002")) == 0
    assert short(made_up("2002"), loop="required") == 1, "outside the range"
    assert short(made_up("2022"), loop="required") == 0
    nearer, farther = (short(made_up("0000", missed=x), loop="required") for x in (0.1, 0.4))
    assert 1 < nearer < farther
    assert short(made_up("2002"), loop="excluded") == 0
    assert 0 < short(made_up("2022"), loop="excluded") < short(made_up("2042"), loop="excluded")
    assert short(made_up("0000", "9229"), max_aspects=2, min_aspects=2) == 0
    assert 0 < short(made_up("0000", "2322"), max_aspects=2) < short(made_up("0000", "2422"), max_aspects=2)
    assert short(made_up("0000", "2?22"), max_aspects=2) > 0, "what is not proved is not kept"
    assert short(made_up("0000", "2122"), min_aspects=2) > 0
    assert short(made_up("0000", slices=made_up("0000", "2322")["intervals"]), max_aspects=2) > 0


@pytest.mark.parametrize("objective", ["longest-range", "most-cusps"])
def test_a_geometry_that_misses_constraints_is_worse_than_one_that_keeps_them(objective: str) -> None:
    wish = Requirement(start=1, stop=3, max_cusps=8)
    goal = Goal(objective, wish, Constraints("required"))
    space = Space.of(INNOCENTI, "5%")
    kept, missed = (cost(Profile(space, INNOCENTI, made_up(x)), goal, 0) for x in ("0920", "0000"))
    assert kept < missed
    free = replace(goal, constraints=Constraints())
    assert cost(Profile(space, INNOCENTI, made_up("0000")), free, 0) < missed


def test_a_candidate_has_what_the_constraints_need() -> None:
    asked = Constraints("required", max_aspects=2)
    document = document_of(INNOCENTI, Goal("least-change", WISH, asked))
    table = census(INNOCENTI, start=20, stop=22, digits=15)
    assert document["slices"] == table.to_json()["intervals"]
    assert document["max_cusps_found"] == 0
    assert document["missed"] * 20.84 == pytest.approx(0.52440, abs=1e-4)
    wider = Requirement(start=20, stop=22, min_cusps=0, limits={"l2": (8, None)})
    found = document_of(INNOCENTI, Goal("least-change", wider, Constraints("required")))
    assert found["max_cusps_found"] > 0
    assert not {"missed", "slices"} & found.keys()


def test_loops_are_proved_or_excluded_by_the_counts() -> None:
    report = check(INNOCENTI, Requirement(start=26, stop=27, min_cusps=0, limits={"l2": (8, 20)}), digits=15)
    loop = loop_in_range(report)
    assert loop is not None
    assert 26 < loop.lengths[0] < 27
    assert all(8 <= Fraction(sample.lengths[1]) <= 20 for sample in loop.samples)
    assert loop == cusp_loop(INNOCENTI, loop.lengths[0], loop.cusp or 0, limits={"l2": (8, 20)})
    table = census(INNOCENTI, start=26, stop=27, digits=15)
    assert kept_constraints(Constraints("required"), report, table).met
    assert not kept_constraints(Constraints("excluded"), report, table).met
    none = check(INNOCENTI, WISH, digits=15)
    table = census(INNOCENTI, start=20, stop=22, digits=15)
    assert loop_in_range(none) is None
    assert not kept_constraints(Constraints("required"), none, table).met
    assert kept_constraints(Constraints("excluded"), none, table).met
    numbers = [x for x in table.aspects if x is not None]
    kept = kept_constraints(Constraints(max_aspects=max(numbers) - 1), none, table)
    assert (kept.met, kept.aspects) == (False, (min(numbers), max(numbers)))


@pytest.mark.long
def test_what_is_found_is_proved_by_a_fresh_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Census, check, margin, loop and aspects of the best geometry; it takes seven CPU-seconds."""
    monkeypatch.setattr(module, "_BOXES", 2000)
    found = design(
        INNOCENTI, "least-change", WISH, vary="10%", decimals=2, budget=2, loop="required", max_aspects=2
    )
    assert found.met
    answer = found.to_json()
    best = answer["best"]
    assert best["geometry"] != INNOCENTI.to_json()
    assert not answer["start"]["met"]
    command = [sys.executable, "-c", PROGRAM % 2000]
    fresh = subprocess.run(command, input=json.dumps(answer), capture_output=True, text=True, check=True)
    kept = best["constraints"]
    aspects = [kept["min_aspects_found"], kept["max_aspects_found"]]
    assert json.loads(fresh.stdout) == [best["check"], best["census"], best["margin"], kept["loop"], aspects]


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"loop": "wanted"}, "loop"),
        ({"min_aspects": 0}, "min_aspects"),
        ({"max_aspects": 1.5}, "max_aspects"),
        ({"min_aspects": 3, "max_aspects": 2}, "max_aspects"),
    ],
)
def test_what_is_wrong_is_named(options: dict[str, Any], field: str) -> None:
    with pytest.raises(InputError) as caught:
        design(INNOCENTI, "least-change", WISH, **options)
    assert [problem.field for problem in caught.value.problems] == [field]
