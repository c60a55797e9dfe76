"""Cusp tables of several slices."""

from __future__ import annotations

import pytest

from rpr_solver import EXAMPLES, InputError, table_document, verify_document


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
