"""The questions about motions that a client asks: loops, paths, pose connections and assembly modes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypedDict, Unpack

from rpr_solver import Exact, Manipulator
from rpr_solver.contract import DEFAULT_SAMPLES, PATH_DIGITS
from rpr_solver.model.lengths import ExactLimits, MotionQuestion, Sampling
from service.client.bodies import Asked, asked, complete, legs, limits_of, numbers, range_of, text_of
from service.schemas.modes import AssemblyModes, AssemblyModesRequest, PoseConnections, PoseConnectionsRequest
from service.schemas.motions import Path
from service.schemas.paths import PathRequest


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
    return _path(manipulator, options, {f"l{leg}": text_of(length), "cusp": str(cusp)})


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
    ends = {**legs(l1, l2, l3), "from": str(start), "to": str(stop)}
    members = ends if between is None else {**ends, "between": range_of(*between)}
    return _path(manipulator, options, members)


def pose_path(
    manipulator: Manipulator,
    start: Mapping[str, Exact],
    stop: Mapping[str, Exact],
    *,
    between: tuple[Exact, Exact] | None = None,
    **options: Unpack[PathOptions],
) -> Asked[Path]:
    """A path without a singularity from any pose to any other one, or why there is none."""
    ends: dict[str, object] = {
        name: {part: text_of(x) for part, x in end.items()} for name, end in (("from", start), ("to", stop))
    }
    members = ends if between is None else {**ends, "between": range_of(*between)}
    return _path(manipulator, options, members)


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
    usual = {"to": None, "between": None, "parts": False, "limits": None, "deadline": None}
    given = complete(options, fixed_leg=1, digits=PATH_DIGITS, **usual)
    members: dict[str, object] = {
        **legs(l1, l2, l3),
        "fixed_leg": given["fixed_leg"],
        **({} if given["to"] is None else {"to": legs(*given["to"])}),
        **({} if given["between"] is None else {"between": range_of(*given["between"])}),
        **({"parts": True} if given["parts"] else {}),
        **limits_of(given["limits"], given["fixed_leg"]),
    }
    digits, deadline = given["digits"], given["deadline"]
    return asked(PoseConnectionsRequest, PoseConnections, manipulator, digits, deadline, members)


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
    members = {**numbers(**{f"l{fixed_leg}": length}), "fixed_leg": fixed_leg, **limits_of(limits)}
    members |= {} if between is None else {"range": range_of(*between)}
    return asked(AssemblyModesRequest, AssemblyModes, manipulator, None, deadline, members)


def _path(manipulator: Manipulator, options: PathOptions, members: Mapping[str, object]) -> Asked[Path]:
    usual = {"others": False, "limits": None, "deadline": None, "motion": None, "sampling": None}
    given = complete(options, fixed_leg=1, digits=PATH_DIGITS, clearance=None, **_SAMPLED, **usual)
    own: dict[str, object] = {
        **members,
        **{name: given[name] for name in ("fixed_leg", "others")},
        # what follows from the motion or from the sampling is sent if it is asked for, to be refused
        **{name: text_of(given[name]) for name in _SAMPLED if name in options or name not in _implied(given)},
        **limits_of(given["limits"], given["fixed_leg"]),
        **({} if given["motion"] is None else {"motion": _texts(given["motion"])}),
        **({} if given["sampling"] is None else {"sampling": _texts(given["sampling"])}),
        **numbers(clearance=given["clearance"]),
    }
    return asked(PathRequest, Path, manipulator, given["digits"], given["deadline"], own)


_SAMPLED = {"samples": DEFAULT_SAMPLES, "timing": "cosine", "duration": 1}


def _implied(given: Mapping[str, object]) -> set[str]:
    """The members that need not be given."""
    by_motion = set() if given["motion"] is None else {"timing", "duration"}
    return by_motion if given["sampling"] is None else by_motion | {"samples"}


def _texts(members: Mapping[str, Exact | Mapping[str, Exact]]) -> dict[str, object]:
    """Exact numbers, and those by leg, as text."""
    return {name: _texts(x) if isinstance(x, Mapping) else text_of(x) for name, x in members.items()}
