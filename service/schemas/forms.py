"""Documents as text, as the service sends them and the command line prints them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import rpr_solver

SHARED = ("geometry_hash", "fixed_leg", "digits", "solver_version")
"""The members of a table that each line of NDJSON has."""


def compact(document: object) -> str:
    """Returns a document as compact JSON."""
    return json.dumps(document, separators=(",", ":"), ensure_ascii=False)


def ndjson_line(table: Mapping[str, Any], part: Mapping[str, Any]) -> str:
    """Returns a slice as a line of NDJSON, with what identifies the table."""
    return compact({**{key: table[key] for key in SHARED if key in table}, **part}) + "\n"


def csv_header(table: Mapping[str, Any]) -> str:
    """Returns the first line of a table's CSV."""
    return rpr_solver.table_csv({**table, "slices": []})


def csv_lines(table: Mapping[str, Any], part: Mapping[str, Any]) -> str:
    """Returns the lines of one slice in a table's CSV."""
    return rpr_solver.table_csv({**table, "slices": [part]}).partition("\n")[2]
