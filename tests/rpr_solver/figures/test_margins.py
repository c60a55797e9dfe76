"""Sensitivities and margins as pictures: every transition and length, estimates between, what is proved."""

from math import inf
from typing import Any

import pytest

from rpr_solver import InputError
from rpr_solver.figures.margins import first_order, lengths_to_prove, margin_figure, sensitivities_figure
from rpr_solver.figures.views import figure_of
from tests.support.pictures import GEOMETRY, check, sheet_of, words
from tests.support.sampling import sample

LENGTHS = ("a2x", "a3x", "a3y", "d1", "d2", "d3")
ALL = {"from": "0", "to": None}


def event(kind: str, *slopes: str | None) -> dict[str, Any]:
    if not slopes:
        return {"kind": kind, "sensitivity": None, "singular": True}
    return {"kind": kind, "sensitivity": dict(zip(LENGTHS, slopes, strict=True))}


def transition(length: str, before: int, after: int, *events: dict[str, Any]) -> dict[str, Any]:
    kind = events[0]["kind"] if events else "unclassified"
    return {"l1": length, "kind": kind, "count_before": before, "count_after": after, "events": [*events]}


def document(*transitions: dict[str, Any]) -> dict[str, Any]:
    ends = ["0", *(t["l1"] for t in transitions), None]
    counts = [0, *(t["count_after"] for t in transitions)]
    intervals = [{"from": a, "to": b, "count": n} for a, b, n in zip(ends, ends[1:], counts, strict=False)]
    head = {"geometry": GEOMETRY, "fixed_leg": 1, "range": ALL}
    return {**head, "transitions": [*transitions], "intervals": intervals}


FIRST = transition("2", 0, 2, event("swallowtail", "-0.5", "2.25", "0.125", "1", "-1e-7", None))
SECOND = transition("5", 2, 0, event("lips", "1", "-1", "1", "-1", "0.5", "-0.5"))
NODE = transition("5.5", 0, 0, event("node"))
PAIR = transition("9", 0, 4, event("beak-to-beak", *"100000"), event("beak-to-beak", *"010000"))
BARE = transition("12", 4, 2)
WHOLE = document(FIRST, SECOND, NODE, PAIR, BARE)
SLOPES = [str((-1) ** k * 10.0 ** (k % 7 - 3)) for k in range(45)]
MANY = document(*(transition(str(k), 0, 2, event("lips", *[SLOPES[k]] * 6)) for k in range(1, 45)))
MARGINS = [
    {
        "fixed_leg": 1,
        "asked": {"l1": "3.5"},
        "proved": "0.25",
        "counterexample": {"radius": "0.31", "geometry": GEOMETRY},
    },
    {"fixed_leg": 1, "asked": {"l1": "7"}, "proved": None, "counterexample": None},
]
CASES = {"all kinds": WHOLE, "none": document(), "many": MANY, "one": document(FIRST)}


@pytest.mark.parametrize("name", sample(CASES, 0, 1))
def test_pictures(name: str) -> None:
    check(sensitivities_figure(CASES[name]))
    check(margin_figure(CASES[name], ALL, []))


def test_pictures_of_a_range_with_what_is_proved() -> None:
    check(margin_figure(WHOLE, {"from": "1", "to": "8"}, MARGINS))
    figure = margin_figure(WHOLE, {"from": "3", "to": "4"}, MARGINS[:1])
    check(figure)
    assert "proved 0.25 at L1 = 3.5" in figure.description
    [ax] = sheet_of(figure).axes
    marked = [tuple(line.get_xydata()[0]) for line in ax.lines if len(line.get_xdata()) == 1]
    assert {(3.5, 0.25), (3.5, 0.31)} <= set(marked)


def test_the_estimate_is_that_of_the_nearest_transition_that_changes_the_number() -> None:
    sums = {"FIRST": 0.5 + 2.25 + 0.125 + 1 + 1e-7, "SECOND": 5}
    assert first_order(WHOLE, 3) == pytest.approx(min(1 / sums["FIRST"], 2 / sums["SECOND"], 6))
    assert first_order(WHOLE, 5.5) == pytest.approx(0.5 / 5)  # the node changes no number
    assert first_order(WHOLE, 9) == 0
    assert first_order(document(), 3) == first_order(document(NODE), 5.5) == inf


def test_lengths_to_prove_lie_in_windows_of_the_range() -> None:
    chosen = lengths_to_prove(WHOLE, ALL, 4)
    assert len(chosen) == 4
    assert all(float(x) not in (2, 5, 5.5, 9, 12) for x in chosen)
    [only] = lengths_to_prove(WHOLE, {"from": "5.6", "to": "8"}, 4)
    assert 5.6 < float(only) < 8


def test_what_is_degenerate_throughout_has_no_margin() -> None:
    node = {"kind": "node", "from": "0", "to": None, "count": 2}
    flat = {**WHOLE, "degenerate": [node]}
    assert lengths_to_prove(flat, ALL, 4) == []
    figure = margin_figure(flat, ALL, [])
    check(figure)
    assert "degenerate throughout: the margin is 0" in words(figure)
    assert "The margin is 0 at every L1. Degenerate: " in figure.description


def test_a_census_has_two_views() -> None:
    assert figure_of(WHOLE, view="sensitivities").title.startswith("How L1 of each transition moves")
    assert figure_of(WHOLE).title.startswith("Number of cusps")
    with pytest.raises(InputError, match="view: is 'torus'; give counts or sensitivities"):
        figure_of(WHOLE, view="torus")
