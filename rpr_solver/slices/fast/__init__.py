"""Many slices of one manipulator at once."""

from rpr_solver.slices.fast.scan import Scan

__all__ = [
    "Scan",
]
