"""A full certificate of curves: chains join all that is to be joined, and the rest of the document stays."""

from __future__ import annotations

from itertools import pairwise

import pytest

from rpr_solver import EXAMPLES, CuspCurves, InputError
from tests.support.shared import curves_of

FLAT = EXAMPLES["zein-flat"]


def test_each_pair_of_neighbours_and_each_end_in_the_range_has_a_chain() -> None:
    part = curves_of(FLAT, 1, 30).part(26, "26.5", lengths=["26.1", "26.3", "26.4"])
    document = part.to_json(certificate="full")
    chains = document["certificate"]["full"]["chains"]
    assert all(chain["tubes"] for chain in chains)
    found = [{(chain[side]["curve"], chain[side]["l1"]) for side in ("from", "to")} for chain in chains]
    lengths = {curve["name"]: [point["l1"] for point in curve["points"]] for curve in document["curves"]}
    neighbours = [{(name, a), (name, b)} for name, xs in lengths.items() for a, b in pairwise(xs)]
    turns = [
        {(curve["name"], lengths[curve["name"]][place]), (joined, lengths[joined][place])}
        for curve in document["curves"]
        for side, place in (("from", 0), ("to", -1))
        if (joined := curve[side]["joins"]) in lengths and 26 < float(curve[side]["l1"]) < 26.5
        if curve["name"] < joined
    ]
    assert len(turns) > 1
    assert sorted(map(sorted, found)) == sorted(map(sorted, neighbours + turns))
    del document["certificate"]
    assert document == part.to_json()


def test_documents_with_a_certificate_are_read() -> None:
    part = curves_of(FLAT, 1, 30).part(1, "1.1", lengths=[1])
    assert CuspCurves.from_json(part.to_json(certificate="full")) == part
    with pytest.raises(InputError, match="certificate"):
        part.to_json(certificate="long")
