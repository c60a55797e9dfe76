"""The public answers: components, documents, refusals."""

from __future__ import annotations

import pytest

from rpr_solver import EXAMPLES, InputError, Manipulator, cusp_table, singular_curves, trace_slice
from tests.support.reference import CASES
from tests.support.shared import eliminant_of
from tests.support.singular import traced


@pytest.mark.quick
@pytest.mark.parametrize(
    ("name", "leg", "length", "turns"),
    [
        ("innocenti", 1, "14.98", [(0, 0)]),
        ("innocenti", 1, "27", [(0, 1), (0, -1), (0, 0)]),
        ("fourteen-cusps", 1, "5.96", [(-1, 0), (0, 0), (1, 0)]),
    ],
)
def test_components_and_their_turns(name: str, leg: int, length: str, turns: list[tuple[int, int]]) -> None:
    curves = traced(name, leg, length)
    assert sorted(s.turns for part in curves.components for s in part.strands) == sorted(turns)


@pytest.mark.parametrize(
    ("field", "arguments"),
    [
        ("tolerance", {"tolerance": 0}),
        ("tolerance", {"tolerance": "1"}),
        ("digits", {"digits": 3}),
        ("fixed_leg", {"fixed_leg": 4}),
    ],
)
def test_bad_arguments_are_named(field: str, arguments: dict[str, object]) -> None:
    with pytest.raises(InputError) as caught:
        singular_curves(EXAMPLES["innocenti"], 10, **arguments)  # type: ignore[arg-type]
    assert [problem.field for problem in caught.value.problems] == [field]


def test_a_length_that_is_not_positive_is_named() -> None:
    with pytest.raises(InputError, match="l2: is 0"):
        singular_curves(EXAMPLES["innocenti"], 0, fixed_leg=2)


@pytest.mark.parametrize(
    ("case", "reference"),
    [
        pytest.param(
            case["geometry"], s, id=f"{case['name']}-{s['l1']}", marks=[pytest.mark.long] if k % 15 else []
        )
        for k, (case, s) in enumerate((case, s) for case in CASES for s in case["slices"])
    ],
)
def test_every_cusp_of_the_reference_is_a_vertex(case: dict[str, str], reference: dict[str, object]) -> None:
    curves = trace_slice(eliminant_of(Manipulator.from_json(case)), str(reference["l1"]))
    cusps = [vertex for vertex in curves.vertices if vertex.kind == "cusp"]
    assert sorted(vertex.cusp or 0 for vertex in cusps) == list(range(1, int(str(reference["count"])) + 1))


def test_more_digits_are_those_of_the_cusp_table() -> None:
    curves = singular_curves(EXAMPLES["zein-flat"], 34, digits=40)
    [table] = cusp_table(EXAMPLES["zein-flat"], 34, digits=40)
    assert {v.point for v in curves.vertices if v.kind == "cusp"} == set(table.cusps)
