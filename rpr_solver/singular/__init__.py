"""Singular curves of a slice: topology, special points, samples, regions and aspects."""

from rpr_solver.singular.slice_curves import (
    SingularComponent,
    SingularCurves,
    singular_csv,
    singular_curves,
    trace_slice,
)

__all__ = [
    "SingularComponent",
    "SingularCurves",
    "singular_csv",
    "singular_curves",
    "trace_slice",
]
