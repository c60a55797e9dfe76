"""The expectation that single slices have a given number of cusps, as a requirement of `check`."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import rpr_solver
from rpr_solver import Manipulator, exact_str
from rpr_solver.contract import document_head


@dataclass(frozen=True)
class Expectation:
    """So many cusps in each of these slices.

    Attributes:
        fixed_leg: the leg whose length is fixed.
        lengths: its lengths.
        count: the number of cusps.
    """

    fixed_leg: int
    lengths: tuple[Fraction, ...]
    count: int

    def to_json(self) -> dict[str, Any]:
        """Returns the expectation as the document of a check has it."""
        lengths = list(map(exact_str, self.lengths))
        return {"fixed_leg": self.fixed_leg, f"l{self.fixed_leg}": lengths, "expect_cusps": self.count}

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
        return {
            **head,
            "requirement": self.to_json(),
            "passed": not wrong,
            "max_cusps_found": max(counts),
            "min_cusps_found": min(counts),
            "slices": slices,
            "violations": wrong,
        }
