"""Requests for the tests of this directory."""

from __future__ import annotations

from rpr_solver import EXAMPLES
from worker import TableRequest


def a_request(*l1: str, digits: int = 30) -> TableRequest:
    manipulator = EXAMPLES["innocenti"]
    return TableRequest(manipulator.to_json(), manipulator.geometry_hash, 1, digits, l1)
