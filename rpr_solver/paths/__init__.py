"""Paths between poses that meet no singular pose, and proofs that there is none."""

from rpr_solver.paths.routes import DecimalPose, EndPose, by_leg

__all__ = [
    "DecimalPose",
    "EndPose",
    "by_leg",
]
