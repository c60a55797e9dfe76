"""Scripts of documents for other systems: what cannot be written is named."""

import json
from collections.abc import Callable
from typing import Any

import pytest

from rpr_solver import InputError, census, export, table_document
from tests.support.families import family
from tests.support.scripts import RATIONAL


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
