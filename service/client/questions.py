"""The questions that a client asks, in the words of the library."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypedDict, Unpack

from rpr_solver import CHECK_DIGITS, DEFAULT_DIGITS, Exact, Manipulator, Requirement
from rpr_solver.along.leg_poses import held_lengths
from rpr_solver.contract import DEFAULT_TOLERANCE, LEGS, MIN_DIGITS
from rpr_solver.designs import Options
from rpr_solver.model.lengths import ExactLimits, MotionQuestion, Sampling
from service.client.bodies import Asked, Lengths, ask_by, ends_of, lengths_of, limits_of
from service.schemas.censuses import Census, CensusRequest, CheckReport, CheckRequest
from service.schemas.curves import CuspCurves, CuspCurvesRequest, Margin, MarginRequest
from service.schemas.designs import Design, DesignRequest
from service.schemas.document import Source, read
from service.schemas.limits import Limits
from service.schemas.modes import AssemblyModes, AssemblyModesRequest, PoseConnections, PoseConnectionsRequest
from service.schemas.motions import Path
from service.schemas.paths import PathRequest
from service.schemas.plots import Plot, PlotRequest, Verification, VerificationRequest
from service.schemas.poses import (
    LegPoses,
    PosesRequest,
    PoseTable,
    RangeAspects,
    RangeAspectsRequest,
    SingularCurves,
    SingularCurvesRequest,
)
from service.schemas.tables import CuspTable, CuspTableRequest


class CensusOptions(TypedDict, total=False):
    """Whether a census has sensitivities, its tolerance, and the deadline in seconds."""

    sensitivities: bool
    tolerance: Exact | Mapping[str, Exact] | None
    deadline: float | None


class CurveOptions(TypedDict, total=False):
    """The options of `cusp_curves` beside its points: the digits, and the deadline in seconds."""

    digits: int
    deadline: float | None


class PlotOptions(TypedDict, total=False):
    """What a picture shows, its theme, how it is set in print, and the deadline in seconds."""

    length: Exact | None
    fixed_leg: int
    lengths: tuple[Exact, Exact, Exact] | None
    start: Exact | None
    stop: Exact | None
    cusp: int | str | None
    pose: int | None
    theme: str
    width_mm: Exact | None
    style: str | None
    unit: str | None
    labels: str | None
    deadline: float | None


def cusp_table(
    manipulator: Manipulator,
    lengths: Lengths,
    *,
    digits: int = DEFAULT_DIGITS,
    fixed_leg: int = 1,
    method: str = "fast",
    deadline: float | None = None,
) -> Asked[CuspTable]:
    """The cusps of slices; `deadline` is the time in seconds after which the answer is of no use.

    Raises:
        InputError: naming every fault.
    """
    members: dict[str, Any] = {f"l{fixed_leg}": lengths_of(lengths), "fixed_leg": fixed_leg, "digits": digits}
    return ask_by(CuspTableRequest, CuspTable, manipulator, deadline=deadline, method=method, **members)


def census(
    manipulator: Manipulator,
    *,
    fixed_leg: int = 1,
    digits: int = DEFAULT_DIGITS,
    start: Exact | None = None,
    stop: Exact | None = None,
    **options: Unpack[CensusOptions],
) -> Asked[Census]:
    """Every length at which the number of cusps changes.

    With `sensitivities` each event says how fast it moves when the lengths of the manipulator change; with a
    `tolerance`, as `margin` has it, the census holds for every manipulator within it.
    """
    own: dict[str, Any] = {"fixed_leg": fixed_leg, "range": (start, stop), "digits": digits}
    return ask_by(CensusRequest, Census, manipulator, **own, **options)


def cusp_curves(
    manipulator: Manipulator,
    *,
    fixed_leg: int = 1,
    start: Exact | None = None,
    stop: Exact | None = None,
    lengths: Lengths = (),
    samples: int | None = None,
    **options: Unpack[CurveOptions],
) -> Asked[CuspCurves]:
    """Each cusp followed from where it appears to where it vanishes."""
    points = {f"l{fixed_leg}": lengths_of(lengths) or None, "samples": samples}
    own: dict[str, Any] = {"fixed_leg": fixed_leg, "range": (start, stop), **points}
    own |= {"digits": DEFAULT_DIGITS, **options}
    return ask_by(CuspCurvesRequest, CuspCurves, manipulator, **own)


def check(
    manipulator: Manipulator,
    requirement: Requirement,
    *,
    digits: int = CHECK_DIGITS,
    tolerance: Exact | Mapping[str, Exact] | None = None,
    deadline: float | None = None,
) -> Asked[CheckReport]:
    """Whether a manipulator satisfies a requirement on its cusps; with a tolerance, as `margin` has it,
    whether every geometry within it does."""
    own = {"requirement": requirement, "tolerance": tolerance, "digits": digits}
    return ask_by(CheckRequest, CheckReport, manipulator, deadline=deadline, **own)


def poses(
    manipulator: Manipulator,
    l1: Exact,
    l2: Exact,
    l3: Exact,
    *,
    digits: int = DEFAULT_DIGITS,
    deadline: float | None = None,
) -> Asked[PoseTable]:
    """All poses with given lengths of the legs."""
    return ask_by(PosesRequest, PoseTable, manipulator, deadline=deadline, digits=digits, l1=l1, l2=l2, l3=l3)


def leg_poses(
    manipulator: Manipulator,
    lengths: Mapping[str, Exact],
    start: Exact | None = None,
    stop: Exact | None = None,
    *,
    digits: int = DEFAULT_DIGITS,
    deadline: float | None = None,
) -> Asked[LegPoses]:
    """The numbers of poses at all lengths of one leg; `lengths` has those of both others, by their names.

    Raises:
        InputError: naming every fault.
    """
    held = held_lengths(lengths)
    legs = {leg: held.get(leg, (start, stop)) for leg in LEGS}
    return ask_by(PosesRequest, LegPoses, manipulator, deadline=deadline, digits=digits, **legs)


def singular_curves(
    manipulator: Manipulator,
    length: Exact,
    *,
    fixed_leg: int = 1,
    tolerance: Exact = DEFAULT_TOLERANCE,
    digits: int = MIN_DIGITS,
    deadline: float | None = None,
) -> Asked[SingularCurves]:
    """The singular curves of a slice, the number of poses in each region, and the aspects."""
    own = {f"l{fixed_leg}": length, "fixed_leg": fixed_leg, "tolerance": tolerance, "digits": digits}
    return ask_by(SingularCurvesRequest, SingularCurves, manipulator, deadline=deadline, **own)


def range_aspects(
    manipulator: Manipulator,
    start: Exact | None = None,
    stop: Exact | None = None,
    *,
    fixed_leg: int = 1,
    deadline: float | None = None,
) -> Asked[RangeAspects]:
    """The aspects while the length of one leg varies within a range; an end that is missing is open."""
    own = {"range": (start, stop), "fixed_leg": fixed_leg, "digits": MIN_DIGITS}
    return ask_by(RangeAspectsRequest, RangeAspects, manipulator, deadline=deadline, **own)


def margin(
    manipulator: Manipulator,
    length: Exact | None = None,
    *,
    requirement: Requirement | None = None,
    window: Exact | None = None,
    fixed_leg: int = 1,
    weights: Mapping[str, Exact] | None = None,
    tolerance: Exact | Mapping[str, Exact] | None = None,
    deadline: float | None = None,
) -> Asked[Margin]:
    """How far the lengths may change before a slice, a requirement or a window loses its number of cusps."""
    own: dict[str, Any] = {f"l{fixed_leg}": length, "window": window, "weights": weights}
    own |= {"fixed_leg": fixed_leg, "requirement": requirement, "tolerance": tolerance}
    return ask_by(MarginRequest, Margin, manipulator, deadline=deadline, **own)


def design(
    manipulator: Manipulator,
    objective: str,
    requirement: Requirement | None = None,
    *,
    deadline: float | None = None,
    **options: Unpack[Options],
) -> Asked[Design]:
    """A geometry near a given one with a longer range, a smaller change, a larger margin, or more cusps."""
    members: dict[str, Any] = {"objective": objective, "requirement": requirement, **options}
    if "fixed" in members:
        members["fixed"] = list(members["fixed"])
    if isinstance(vary := options.get("vary"), Mapping):
        members["vary"] = {name: (*ends,) for name, ends in vary.items()}
    if members.get("budget") is not None:
        members["budget"] = {"censuses": members["budget"]}
    return ask_by(DesignRequest, Design, manipulator, deadline=deadline, **members)


def plot(manipulator: Manipulator, plot: str = "slice", **options: Unpack[PlotOptions]) -> Asked[Plot]:
    """A picture, of a kind of ``POST /v1/plots``.

    A slice and a loop have the ``length`` of the fixed leg, the mechanism all three ``lengths``, or a length
    and a cusp, the others a range.
    """
    given: dict[str, Any] = {**options}
    length, lengths, *ends = (given.pop(name, None) for name in ("length", "lengths", "start", "stop"))
    given[f"l{given.get('fixed_leg', 1)}"] = length
    given |= {f"l{leg}": x for leg, x in enumerate(lengths or (), 1)}
    given["range"] = None if ends == [None, None] else tuple(ends)
    return ask_by(PlotRequest, Plot, manipulator, plot=plot, **given)


def verify_document(document: Mapping[str, Any], *, deadline: float | None = None) -> Asked[Verification]:
    """A verification of a document by independent means."""
    members = {"document": document, **({} if deadline is None else {"deadline_s": str(deadline)})}
    question = read(VerificationRequest, members, Source(Limits.of_environment(), is_text=True))
    return Asked(question, Verification)


class PathOptions(TypedDict, total=False):
    """The options of paths: those of the library, whether the answer has the other poses, and the deadline in
    seconds."""

    limits: ExactLimits | None
    fixed_leg: int
    digits: int
    samples: int
    timing: str
    duration: Exact
    motion: MotionQuestion | None
    sampling: Sampling | None
    clearance: Exact | None
    others: bool
    deadline: float | None


def cusp_loop(
    manipulator: Manipulator, length: Exact, cusp: int | str, **options: Unpack[PathOptions]
) -> Asked[Path]:
    """A loop of the leg lengths round a cusp, without a singularity, from one pose to another.

    With `others` the answer says what becomes of the other poses meanwhile.
    """
    leg = options.get("fixed_leg", 1)
    return _path(manipulator, options, {f"l{leg}": length, "cusp": cusp})


def joint_path(
    manipulator: Manipulator,
    l1: Exact,
    l2: Exact,
    l3: Exact,
    start: int,
    stop: int,
    *,
    between: tuple[Exact, Exact] | None = None,
    **options: Unpack[PathOptions],
) -> Asked[Path]:
    """A path without a singularity from one pose of a joint vector to another, or why there is none."""
    ends = {"l1": l1, "l2": l2, "l3": l3, "from": start, "to": stop}
    return _path(manipulator, options, {**ends, "between": ends_of(between)})


def pose_path(
    manipulator: Manipulator,
    start: Mapping[str, Exact],
    stop: Mapping[str, Exact],
    *,
    between: tuple[Exact, Exact] | None = None,
    **options: Unpack[PathOptions],
) -> Asked[Path]:
    """A path without a singularity from any pose to any other one, or why there is none."""
    ends = {"from": start, "to": stop}
    return _path(manipulator, options, {**ends, "between": ends_of(between)})


class ConnectionOptions(TypedDict, total=False):
    """The options of pose connections: those of the library, and the deadline in seconds."""

    to: Sequence[Exact] | None
    between: tuple[Exact, Exact] | None
    parts: bool
    limits: ExactLimits | None
    fixed_leg: int
    digits: int
    deadline: float | None


def pose_connections(
    manipulator: Manipulator, l1: Exact, l2: Exact, l3: Exact, **options: Unpack[ConnectionOptions]
) -> Asked[PoseConnections]:
    """Which poses of a joint vector, or of two, are joined by paths without a singularity."""
    to = options.get("to")
    given: dict[str, Any] = {
        **options,
        "to": to and {f"l{leg}": x for leg, x in enumerate(to, 1)},
        "between": ends_of(options.get("between")),
        "limits": limits_of(options.get("limits"), options.get("fixed_leg", 1)),
    }
    return ask_by(PoseConnectionsRequest, PoseConnections, manipulator, l1=l1, l2=l2, l3=l3, **given)


def assembly_modes(
    manipulator: Manipulator,
    length: Exact | None = None,
    *,
    between: tuple[Exact, Exact | None] | None = None,
    limits: ExactLimits | None = None,
    fixed_leg: int = 1,
    deadline: float | None = None,
) -> Asked[AssemblyModes]:
    """Whether the assembly mode can change without a singularity, in a slice or in a range."""
    own: dict[str, Any] = {f"l{fixed_leg}": length, "fixed_leg": fixed_leg, "limits": limits_of(limits)}
    own["range"] = ends_of(between)
    return ask_by(AssemblyModesRequest, AssemblyModes, manipulator, deadline=deadline, **own)


def _path(manipulator: Manipulator, options: PathOptions, members: Mapping[str, Any]) -> Asked[Path]:
    limits = limits_of(options.get("limits"), options.get("fixed_leg", 1))
    given: dict[str, Any] = {**members, **options, "limits": limits}
    return ask_by(PathRequest, Path, manipulator, **given)
