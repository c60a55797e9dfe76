"""Slices as objects of a document, errors in their own entries."""

from fractions import Fraction

from rpr_solver import EXAMPLES, Unproved, eliminate, slice_json, solve_slice, table_document, table_json
from rpr_solver.slices.answers import slices_json
from rpr_solver.slices.cusp_table import SliceTable

INNOCENTI = EXAMPLES["innocenti"]


def test_a_slice_is_its_table_or_its_error() -> None:
    eliminant = eliminate(INNOCENTI, 2)
    assert slice_json(eliminant, Fraction(9), 15) == solve_slice(eliminant, Fraction(9), 15).to_json()
    bad = slice_json(eliminant, Fraction(-9, 2), 15)
    assert bad.keys() == {"l2", "error"}
    assert bad["l2"] == "-4.5"
    assert bad["error"]["type"] == "input-error"  # type: ignore[index]


def test_one_bad_slice_does_not_spoil_the_others() -> None:
    steps: list[tuple[int, int]] = []
    lengths = [Fraction(9), Fraction(0), Fraction(20)]
    document = table_document(
        INNOCENTI, lengths, fixed_leg=3, digits=15, progress=lambda *step: steps.append(step)
    )
    eliminant = eliminate(INNOCENTI, 3)
    slices = [slice_json(eliminant, length, 15) for length in lengths]
    assert ["error" in item for item in slices] == [False, True, False]
    assert document == table_json(INNOCENTI, 3, 15, slices)
    assert list(document) == ["geometry", "geometry_hash", "fixed_leg", "digits", "solver_version", "slices"]
    assert steps == [(0, 3), (1, 3), (2, 3), (3, 3)]


def test_what_is_unproved_is_a_solver_error_in_its_place() -> None:
    def refuse(length: Fraction) -> SliceTable:
        raise Unproved(f"nothing is known of {length}")

    [item] = slices_json(refuse, [Fraction(1, 3)], 1, lambda *_: None)
    error = {"type": "solver-error", "detail": "nothing is known of 1/3"}
    assert item == {"l1": "1/3", "error": error}
