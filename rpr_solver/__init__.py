"""Certified cusp points of planar 3-RPR parallel manipulators.

>>> from rpr_solver import EXAMPLES, cusp_table
>>> [table] = cusp_table(EXAMPLES["innocenti"], "14.98", digits=15)
>>> table
<SliceTable L1=14.98: 6 cusps, 15 digits>
>>> table.cusps[0].theta1_deg, table.cusps[0].l2
('-69.1293760614883', '0.845282018280357')

Every input number is exact (:data:`Exact`): an integer, a ``Fraction``, a ``Decimal``, or a text such as
``"14.98"`` or ``"749/50"``. Lengths are in the user's unit, angles in degrees.
"""

from importlib.metadata import version

from rpr_solver.article.audit import ArticleTable, article_table
from rpr_solver.contract import (
    CHECK_DIGITS,
    DEFAULT_DIGITS,
    MAX_DIGITS,
    MIN_DIGITS,
    SOLVER_VERSION,
    Progress,
)
from rpr_solver.curves.cusp_curve import CurveEnd, CurvePoint, CuspCurve
from rpr_solver.curves.cusp_curves import CuspCurves, cusp_curves
from rpr_solver.documents import (
    census_csv,
    curves_csv,
    path_csv,
    restrict_census,
    shorten_slice,
    singular_csv,
    table_csv,
)
from rpr_solver.errors import FieldProblem, InputError, SolverError, Unproved
from rpr_solver.exact.rationals import Exact, exact_str, parse_exact
from rpr_solver.figures.figure import Figure
from rpr_solver.kinematics.pose_table import (
    DirectPolynomial,
    PlatformPose,
    PoseTable,
    poses,
    poses_of_squares,
)
from rpr_solver.model.classify import PoseKind
from rpr_solver.model.manipulator import EXAMPLES, Manipulator
from rpr_solver.paths.between_poses import NoPath, Obstacle, joint_path
from rpr_solver.paths.ends import PathPose
from rpr_solver.paths.loops import cusp_loop
from rpr_solver.paths.others import FoldPoint, OtherPose
from rpr_solver.paths.path import Path
from rpr_solver.paths.samples import PathSample
from rpr_solver.singular.aspects import Aspect
from rpr_solver.singular.drawing import Strand
from rpr_solver.singular.ranges import RangeAspect, range_aspects
from rpr_solver.singular.regions import Region
from rpr_solver.singular.singular_curves import (
    SingularComponent,
    SingularCurves,
    singular_curves,
    trace_slice,
)
from rpr_solver.singular.vertices import Vertex, VertexKind
from rpr_solver.slices.answers import slice_error_json, slice_json, table_document, table_json
from rpr_solver.slices.cusp_table import cusp_table, solve_slice
from rpr_solver.slices.eliminant import Eliminant, eliminate
from rpr_solver.slices.joint_points import JointPoint
from rpr_solver.slices.slice_table import SliceTable
from rpr_solver.transitions.census import Census, LengthKind, Transition, TransitionEvent, census
from rpr_solver.transitions.check_report import CheckedInterval, CheckReport, check
from rpr_solver.transitions.length_range import LengthRange
from rpr_solver.transitions.requirement import Requirement

__version__ = version("rpr-cusps")

__all__ = [
    "CHECK_DIGITS",
    "DEFAULT_DIGITS",
    "EXAMPLES",
    "MAX_DIGITS",
    "MIN_DIGITS",
    "SOLVER_VERSION",
    "ArticleTable",
    "Aspect",
    "Census",
    "CheckReport",
    "CheckedInterval",
    "CurveEnd",
    "CurvePoint",
    "CuspCurve",
    "CuspCurves",
    "DirectPolynomial",
    "Eliminant",
    "Exact",
    "FieldProblem",
    "Figure",
    "FoldPoint",
    "InputError",
    "JointPoint",
    "LengthKind",
    "LengthRange",
    "Manipulator",
    "NoPath",
    "Obstacle",
    "OtherPose",
    "Path",
    "PathPose",
    "PathSample",
    "PlatformPose",
    "PoseKind",
    "PoseTable",
    "Progress",
    "RangeAspect",
    "Region",
    "Requirement",
    "SingularComponent",
    "SingularCurves",
    "SliceTable",
    "SolverError",
    "Strand",
    "Transition",
    "TransitionEvent",
    "Unproved",
    "Vertex",
    "VertexKind",
    "__version__",
    "article_table",
    "census",
    "census_csv",
    "check",
    "curves_csv",
    "cusp_curves",
    "cusp_loop",
    "cusp_table",
    "eliminate",
    "exact_str",
    "joint_path",
    "parse_exact",
    "path_csv",
    "poses",
    "poses_of_squares",
    "range_aspects",
    "restrict_census",
    "shorten_slice",
    "singular_csv",
    "singular_curves",
    "slice_error_json",
    "slice_json",
    "solve_slice",
    "table_csv",
    "table_document",
    "table_json",
    "trace_slice",
]
