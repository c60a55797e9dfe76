"""The expectation that single slices have a given number of cusps, as a requirement of `check`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import rpr_solver
from rpr_solver import Manipulator, exact_str
from rpr_solver.contract import document_head
from rpr_solver.transitions.requirement import ALLOWED, REFUSED


@dataclass(frozen=True)
class Expectation:
    """So many cusps in each of these slices.

    Attributes:
        fixed_leg: the leg whose length is fixed.
        lengths: its lengths.
        count: the number of cusps.
        degenerate: "refused" if the slices may have no degenerate points, else "allowed".
    """

    fixed_leg: int
    lengths: tuple[Fraction, ...]
    count: int
    degenerate: str = ALLOWED

    def to_json(self) -> dict[str, Any]:
        """Returns the expectation as the document of a check has it."""
        lengths = list(map(exact_str, self.lengths))
        slices = {"fixed_leg": self.fixed_leg, f"l{self.fixed_leg}": lengths}
        return {**slices, "expect_cusps": self.count, "degenerate": self.degenerate}

    def check(
        self, manipulator: Manipulator, digits: int, progress: rpr_solver.Progress | None = None
    ) -> dict[str, Any]:
        """Returns the report on a manipulator.

        Raises:
            SolverError: a slice could not be decided.
        """
        eliminant = rpr_solver.eliminate(manipulator, self.fixed_leg)
        tables = []
        for done, length in enumerate(self.lengths):
            if progress is not None:
                progress(done, len(self.lengths))
            tables.append(rpr_solver.solve_slice(eliminant, length, digits).to_json())
        return self.report(document_head(manipulator, digits, self.fixed_leg), tables)

    def report(self, head: dict[str, Any], tables: list[dict[str, Any]]) -> dict[str, Any]:
        """Returns the report on the slices of a cusp table."""
        leg = f"l{self.fixed_leg}"
        slices = [{leg: table[leg], "count": table["count"]} for table in tables]
        wrong = [
            {leg: table[leg], "count": table["count"], "example": {leg: table[leg], "cusps": table["cusps"]}}
            for table in tables
            if table["count"] != self.count
        ]
        counts = [table["count"] for table in tables]
        degenerate = [part for table in tables for part in _degenerate(table, table[leg])]
        return {
            **head,
            "requirement": self.to_json(),
            "passed": not wrong and not (degenerate and self.degenerate == REFUSED),
            "max_cusps_found": max(counts),
            "min_cusps_found": min(counts),
            "slices": slices,
            "violations": wrong,
            "degenerate": degenerate,
        }


def _degenerate(table: Mapping[str, Any], length: str) -> Iterator[dict[str, Any]]:
    """Yields the curves of degenerate poses of a slice, and the numbers of its other degenerate points."""
    ends, points = {"from": length, "to": length}, table["degenerate_points"]
    curves = [point for point in points if "equation" in point]
    yield from ({"kind": curve["kind"], **ends, "equation": curve["equation"]} for curve in curves)
    kinds = Counter(point["kind"] for point in points if "equation" not in point)
    yield from ({"kind": kind, **ends, "count": count} for kind, count in sorted(kinds.items()))
