"""The public names of `rpr_solver` are those listed here, each with a docstring."""

import doctest
import inspect
import tomllib
from pathlib import Path

import rpr_solver

CONSTANTS = {
    "CHECK_DIGITS",
    "DEFAULT_DIGITS",
    "EXAMPLES",
    "MAX_DIGITS",
    "MIN_DIGITS",
    "SOLVER_VERSION",
    "__version__",
}
TYPES = {"Exact", "Progress"}
FUNCTIONS = {
    "article_table",
    "assembly_modes",
    "pose_connections",
    "census",
    "census_csv",
    "check",
    "curves_csv",
    "cusp_curves",
    "cusp_loop",
    "cusp_table",
    "design",
    "design_csv",
    "eliminate",
    "exact_str",
    "export",
    "joint_path",
    "leg_poses",
    "poses_csv",
    "pose_path",
    "margin",
    "parse_exact",
    "path_csv",
    "poses",
    "poses_of_squares",
    "aspects",
    "restrict_census",
    "shorten_slice",
    "singular_csv",
    "singular_curves",
    "slice_error_json",
    "slice_json",
    "solve_slice",
    "solve_slices",
    "table_csv",
    "table_document",
    "table_json",
    "tolerance_census",
    "trace_slice",
    "with_condition",
    "with_sensitivities",
    "within_tolerance",
    "verify_document",
    "workspace",
    "workspace_csv",
    "sensed_poses",
    "workspace_sweep",
}
CLASSES = {
    "ArticleTable",
    "Aspect",
    "AssemblyModes",
    "PoseConnections",
    "Census",
    "CheckReport",
    "CheckedInterval",
    "Change",
    "Claim",
    "Counterexample",
    "ClaimStatus",
    "CurveEnd",
    "ConicKind",
    "SweptWorkspace",
    "Workspace",
    "WorkspaceArc",
    "WorkspaceRegion",
    "WorkspaceSweep",
    "WorkspaceVertex",
    "SensedPose",
    "SensedPoses",
    "EndKind",
    "LegEnd",
    "LegInterval",
    "LegPoses",
    "CurvePoint",
    "CuspCurve",
    "CuspCurves",
    "Degeneracy",
    "Design",
    "DirectPolynomial",
    "Eliminant",
    "FieldProblem",
    "FoldPoint",
    "Figure",
    "InputError",
    "JoinedRegion",
    "JointPoint",
    "LengthKind",
    "LengthRange",
    "Margin",
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
    "RangeAspect",
    "Region",
    "Requirement",
    "Resolution",
    "SingularComponent",
    "SingularCurves",
    "SliceTable",
    "SolverError",
    "ToleranceCensus",
    "Strand",
    "Transition",
    "TransitionEvent",
    "Unproved",
    "Verdict",
    "Verification",
    "Vertex",
    "VertexKind",
}


def test_the_public_names_are_these() -> None:
    assert sorted(rpr_solver.__all__) == sorted(CONSTANTS | TYPES | FUNCTIONS | CLASSES)
    public = {name: getattr(rpr_solver, name) for name in rpr_solver.__all__}
    assert {name for name, value in public.items() if inspect.isfunction(value)} == FUNCTIONS
    assert {name for name, value in public.items() if inspect.isclass(value)} == CLASSES


def test_every_public_name_is_documented() -> None:
    for name in sorted(FUNCTIONS | CLASSES):
        text = getattr(rpr_solver, name).__doc__ or ""
        assert text.strip(), name
        assert not text.startswith(f"{name}("), "a dataclass without a docstring gets its signature instead"


def test_every_public_name_has_an_example() -> None:
    for name in sorted(FUNCTIONS | CLASSES):
        text = inspect.getdoc(getattr(rpr_solver, name)) or ""
        assert doctest.DocTestParser().get_examples(text), name


def test_every_public_function_explains_its_arguments() -> None:
    for name in sorted(FUNCTIONS):
        function = getattr(rpr_solver, name)
        text, arguments = inspect.getdoc(function) or "", inspect.signature(function).parameters
        if len(arguments) > 1:
            assert [argument for argument in arguments if f"    {argument}: " not in text] == [], name
            assert "Raises:" in text, name


def test_there_is_one_version() -> None:
    import service

    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))
    assert rpr_solver.__version__ == service.__version__ == project["project"]["version"]


def test_every_public_method_is_documented() -> None:
    for name in sorted(CLASSES):
        members = vars(getattr(rpr_solver, name)).items()
        own = [(key, value) for key, value in members if key[0] != "_" and inspect.isroutine(value)]
        assert [key for key, value in own if not inspect.getdoc(value)] == [], name
