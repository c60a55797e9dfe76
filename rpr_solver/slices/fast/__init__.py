"""Many slices of one manipulator at once, and the eigenvalues that are guesses of roots."""

from rpr_solver.slices.fast.proofs import real_eigenvalues
from rpr_solver.slices.fast.scan import Scan

__all__ = [
    "Scan",
    "real_eigenvalues",
]
