"""The closed schemas: what the solver writes is read, by the member that tells the kind."""

from __future__ import annotations

import pytest

from rpr_solver import InputError
from rpr_solver.verify.core.schema import kind_of, read_document
from tests.rpr_solver.verify.forgeries import base


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("table", "cusp-table"),
        ("full table", "cusp-table"),
        ("poses", "poses"),
        ("census", "census"),
        ("full census", "census"),
        ("full curves", "cusp-curves"),
        ("limits", "check"),
    ],
)
def test_every_kind_is_read(name: str, kind: str) -> None:
    document = base(name)
    assert kind_of(document) == read_document(document).kind == kind
    for member in document:
        if member not in ("degenerate", "certificate"):
            with pytest.raises(InputError):
                read_document({k: x for k, x in document.items() if k != member})
        with pytest.raises(InputError):
            read_document({**document, member: {"x": 1}})


@pytest.mark.parametrize(
    ("member", "name"),
    [("samples", "a path"), ("checks", "a list of reports of checks"), ("verdict", "a verification")],
)
def test_other_documents_are_named(member: str, name: str) -> None:
    with pytest.raises(
        InputError, match=f"is, {name}, of no kind that can be verified; known are cusp-table"
    ):
        kind_of({member: []})
