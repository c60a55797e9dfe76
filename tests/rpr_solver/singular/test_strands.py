"""Strands use every arc once; at the ends of open strands are nodes."""

from __future__ import annotations

import pytest

from rpr_solver.singular.strands import UnionFind, components
from tests.support.singular import SLICES, swept


@pytest.mark.parametrize(("name", "leg", "length"), SLICES)
def test_every_arc_is_in_one_strand(name: str, leg: int, length: str) -> None:
    found = swept(name, leg, length)
    chains = [chain for part in components(found) for chain in part]
    steps = [(step.slab, step.arc) for chain in chains for step in chain.steps]
    assert sorted(steps) == [(k, arc) for k, slab in enumerate(found.slabs) for arc in range(len(slab.arcs))]
    for chain in chains:
        ends = [found.lines[line].meetings[cell] for line, cell in (chain.cells[0], chain.cells[-1])]
        if chain.closed:
            assert chain.cells[0] == chain.cells[-1]
        else:
            assert all(len(end.left) + len(end.right) != 2 for end in ends)


def test_classes_keep_the_order_of_things() -> None:
    joined = UnionFind("abcde")
    joined.join("d", "a")
    joined.join("e", "d")
    assert joined.classes() == [["a", "d", "e"], ["b"], ["c"]]
