"""Scripts of documents for other systems: what they compute, what cannot be written, what is filled in."""

from __future__ import annotations

import json
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from typing import Any

import pytest

from rpr_solver import EXAMPLES, InputError, Manipulator, census, exact_str, export, table_document
from rpr_solver.exports.export import half_unit, problem_of
from tests.support.families import family
from tests.support.scripts import RATIONAL, table
from tests.support.shared import census_of


@pytest.mark.parametrize(
    ("document", "system", "field"),
    [
        (dict, "pari", "document"),
        (lambda: {"geometry": RATIONAL.to_json(), "fixed_leg": 1}, "pari", "document"),
        (lambda: table_document(family("congruent"), 5, digits=15), "pari", "document.slices[0]"),
        (lambda: table_document(RATIONAL, [0], digits=15), "pari", "document.slices[0]"),
        (lambda: census(family("congruent"), digits=15).to_json(), "pari", "document"),
        (lambda: table_document(RATIONAL, [3], digits=15), "mathematica", "system"),
        (lambda: table_document(RATIONAL, [2, 3], digits=15), "msolve", "document"),
        (lambda: census(RATIONAL, digits=15, start=2, stop=4).to_json(), "msolve", "document"),
    ],
    ids=["nothing", "half", "curve", "error", "census", "system", "two slices", "census for msolve"],
)
def test_what_cannot_be_exported_is_named(
    document: Callable[[], dict[str, Any]], system: str, field: str
) -> None:
    written = json.dumps(document())
    with pytest.raises(InputError) as caught:
        export(json.loads(written), system)
    assert [p.field for p in caught.value.problems] == [field]


def test_a_census_has_a_slice_in_each_interval_and_its_events() -> None:
    whole = census_of(EXAMPLES["zein-flat"])
    problem = problem_of(whole.to_json())
    assert [part.count for part in problem.slices] == list(whole.counts)
    ends = [Fraction(0), *(Fraction(t.length) for t in whole.transitions)]
    for part, (low, high) in zip(problem.slices, pairwise([*ends, 9 * ends[-1]]), strict=True):
        assert low < Fraction(part.length) < high
        assert Fraction(part.exact) == Fraction(part.length)
    assert len(problem.events) == sum(len(t.events) for t in whole.transitions)


def test_a_window_whose_ends_are_printed_alike_has_no_slice_and_is_named() -> None:
    near_similar = Manipulator(30, 0, "40.00001", 15, 25, 20)
    document = json.loads(json.dumps(census(near_similar, digits=15).to_json()))
    alike = [x for x in document["intervals"] if x["from"] == x["to"]]
    assert alike
    problem = problem_of(document)
    assert len(problem.slices) + len(problem.skipped) == len(document["intervals"])
    assert all(any(x["from"] in words for words in problem.skipped) for x in alike)


@pytest.mark.parametrize(("units", "skipped"), [(1, 1), (2, 0)])
def test_a_slice_keeps_half_a_unit_from_printed_transitions(units: int, skipped: int) -> None:
    document = json.loads(json.dumps(census(RATIONAL, digits=15, start=2, stop=4).to_json()))
    window, (first, second, *_) = document["intervals"][1], document["transitions"]
    near = Fraction(first["l1"]) + 2 * units * half_unit(first["l1"])
    window["to"] = second["l1"] = exact_str(near)
    assert len(problem_of(document).skipped) == skipped


def test_a_table_that_contradicts_itself_is_refused() -> None:
    document = table(EXAMPLES["zein-flat"], "3")
    document["slices"][0]["count"] = 5
    with pytest.raises(InputError, match="is 5, but 4 cusps are listed"):
        export(document, "pari")
