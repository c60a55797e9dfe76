"""Documents of triangles with irrational lengths are verified from the squares of their sides."""

from __future__ import annotations

from typing import Any

import pytest

from rpr_solver import Manipulator, poses, table_document, verify_document
from rpr_solver.verify.claims import Verdict


@pytest.mark.parametrize(
    ("geometry", "question"),
    [
        ({"base": {"equilateral": 10}, "platform": {"sides": [6, 7, 5]}}, "table"),
        ({"base": {"points": [[0, 0], [0, 3], [2, 1]]}, "platform": {"circumradius": 2}}, "poses"),
        ({"base": {"equilateral": 10}, "platform": {"points": [[0, 0], [0, 6], ["2*sqrt(6)", 1]]}}, "table"),
    ],
)
def test_documents_of_irrational_triangles_are_verified(geometry: Any, question: str) -> None:
    manipulator = Manipulator.from_json(geometry)
    document = (
        table_document(manipulator, 5, digits=15)
        if question == "table"
        else poses(manipulator, 2, "2.5", 3, digits=15).to_json()
    )
    assert verify_document(document)
    numbers = [*document["geometry"]["platform"]]
    wrong = {**document["geometry"], "platform": [numbers[0], numbers[2], numbers[1]]}
    if wrong != document["geometry"]:
        assert verify_document({**document, "geometry": wrong}).verdict is Verdict.REFUSED
