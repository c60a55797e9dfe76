"""What a script is to compute: legs, turns, slices and events of a document."""

from fractions import Fraction
from itertools import pairwise

import pytest

from rpr_solver import EXAMPLES, InputError, export
from rpr_solver.exports.problem import problem_of
from tests.support.scripts import table
from tests.support.shared import census_of


def test_an_angle_of_180_degrees_is_no_infinite_tangent() -> None:
    document = table(EXAMPLES["innocenti"], "14.98")
    document["slices"][0]["cusps"][0]["theta1_deg"] = "180.00000000000000000"
    assert "TURNS = [[1, 0], [3/5, 4/5]]" in export(document, "pari")


def test_a_census_has_a_slice_in_each_interval_and_its_events() -> None:
    whole = census_of(EXAMPLES["zein-flat"])
    problem = problem_of(whole.to_json())
    assert [part.count for part in problem.slices] == list(whole.counts)
    ends = [Fraction(0), *(Fraction(t.length) for t in whole.transitions)]
    for part, (low, high) in zip(problem.slices, pairwise([*ends, 9 * ends[-1]]), strict=True):
        assert low < Fraction(part.length) < high
        assert Fraction(part.exact) == Fraction(part.length)
    assert len(problem.events) == sum(len(t.events) for t in whole.transitions)


def test_a_table_that_contradicts_itself_is_refused() -> None:
    document = table(EXAMPLES["zein-flat"], "3")
    document["slices"][0]["count"] = 5
    with pytest.raises(InputError, match="is 5, but 4 cusps are listed"):
        export(document, "pari")
