"""Certified cusp points of planar 3-RPR parallel manipulators.

>>> from rpr_solver import EXAMPLES, cusp_table
>>> [table] = cusp_table(EXAMPLES["innocenti"], ["14.98"], digits=15)
>>> table.count, table.cusps[0].theta_deg
(6, '-69.1293760614883')
"""

from rpr_solver.article import ArticleTable, article_table
from rpr_solver.census import Census, Transition, TransitionPoint, census
from rpr_solver.check import CheckedInterval, CheckReport, Requirement, check
from rpr_solver.cusp_curves import CurveEnd, CurvePoint, CuspCurve, CuspCurves, cusp_curves
from rpr_solver.cusps import (
    DEFAULT_DIGITS,
    MAX_DIGITS,
    MIN_DIGITS,
    SliceTable,
    cusp_table,
    slice_error_json,
    solve_slice,
    table_json,
)
from rpr_solver.eliminant import SOLVER_VERSION, Eliminant, eliminate
from rpr_solver.errors import FieldProblem, InputError, SolverError
from rpr_solver.geometry import EXAMPLES, Manipulator
from rpr_solver.kinematics import DirectPolynomial, PlatformPose, PoseTable, poses, poses_of_squares
from rpr_solver.numbers import exact_str, parse_exact
from rpr_solver.points import JointPoint
from rpr_solver.tables import census_csv, curves_csv, restrict_census, shorten_slice, table_csv

__all__ = [
    "DEFAULT_DIGITS",
    "EXAMPLES",
    "MAX_DIGITS",
    "MIN_DIGITS",
    "SOLVER_VERSION",
    "ArticleTable",
    "Census",
    "CheckReport",
    "CheckedInterval",
    "CurveEnd",
    "CurvePoint",
    "CuspCurve",
    "CuspCurves",
    "DirectPolynomial",
    "Eliminant",
    "FieldProblem",
    "InputError",
    "JointPoint",
    "Manipulator",
    "PlatformPose",
    "PoseTable",
    "Requirement",
    "SliceTable",
    "SolverError",
    "Transition",
    "TransitionPoint",
    "article_table",
    "census",
    "census_csv",
    "check",
    "curves_csv",
    "cusp_curves",
    "cusp_table",
    "eliminate",
    "exact_str",
    "parse_exact",
    "poses",
    "poses_of_squares",
    "restrict_census",
    "shorten_slice",
    "slice_error_json",
    "solve_slice",
    "table_csv",
    "table_json",
]
