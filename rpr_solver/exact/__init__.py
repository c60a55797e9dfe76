"""Exact arithmetic that knows no manipulator: numbers, polynomials, real roots, number fields, decimals."""

from rpr_solver.exact.precision import all_decided, decided, decided_or_none, precisions

__all__ = [
    "all_decided",
    "decided",
    "decided_or_none",
    "precisions",
]
