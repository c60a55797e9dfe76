"""The questions that a client asks, in the words of the library."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, TypedDict, Unpack

from rpr_solver import CHECK_DIGITS, DEFAULT_DIGITS, Exact, Manipulator, Requirement, exact_str
from rpr_solver.contract import DEFAULT_SAMPLES, DEFAULT_TOLERANCE, MIN_DIGITS, PATH_DIGITS
from rpr_solver.designs.questions import Options
from rpr_solver.model.lengths import ExactLimits, limits_json, read_limits
from service.client.bodies import Asked, M
from service.schemas.censuses import Census, CensusRequest, CheckReport, CheckRequest
from service.schemas.curves import CuspCurves, CuspCurvesRequest
from service.schemas.designs import Design, DesignRequest
from service.schemas.document import Source, read
from service.schemas.limits import Limits
from service.schemas.margins import Margin, MarginRequest
from service.schemas.modes import AssemblyModes, AssemblyModesRequest
from service.schemas.paths import Path, PathRequest
from service.schemas.plots import Plot, PlotRequest
from service.schemas.poses import (
    PosesRequest,
    PoseTable,
    RangeAspects,
    RangeAspectsRequest,
    SingularCurves,
    SingularCurvesRequest,
)
from service.schemas.questions import Question
from service.schemas.tables import CuspTable, CuspTableRequest
from service.schemas.verifications import Verification, VerificationRequest

_NO_LIMIT = 1_000_000
_Length = Exact | Iterable[Exact]


class CensusOptions(TypedDict, total=False):
    """Further options of :func:`census`."""

    certificate: str
    sensitivities: bool
    tolerance: Exact | Mapping[str, Exact] | None
    deadline: float | None


class MarginOptions(TypedDict, total=False):
    """What the certificate of `margin` holds, and the deadline in seconds."""

    certificate: str
    deadline: float | None


class CurveOptions(MarginOptions, total=False):
    """The options of `cusp_curves` beside its points: as in the library, and the deadline in seconds."""

    digits: int


class PathOptions(TypedDict, total=False):
    """The options of paths: those of the library, whether the answer has the other poses, and the deadline in
    seconds."""

    limits: ExactLimits | None
    fixed_leg: int
    digits: int
    samples: int
    timing: str
    duration: Exact
    others: bool
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
    lengths: _Length,
    *,
    digits: int = DEFAULT_DIGITS,
    fixed_leg: int = 1,
    method: str = "fast",
    certificate: str = "short",
    deadline: float | None = None,
) -> Asked[CuspTable]:
    """The cusps of slices; `deadline` is the time in seconds after which the answer is of no use.

    Raises:
        InputError: naming every fault.
    """
    members = {
        f"l{fixed_leg}": _lengths(lengths),
        "fixed_leg": fixed_leg,
        "method": method,
        "certificate": certificate,
    }
    return _asked(CuspTableRequest, CuspTable, manipulator, digits, deadline, members)


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
    given = _complete(options, certificate="short", sensitivities=False, tolerance=None, deadline=None)
    members = {
        "fixed_leg": fixed_leg,
        "range": _range(start, stop),
        **{name: given[name] for name in ("certificate", "sensitivities")},
        **_numbers(tolerance=given["tolerance"]),
    }
    return _asked(CensusRequest, Census, manipulator, digits, given["deadline"], members)


def cusp_curves(
    manipulator: Manipulator,
    *,
    fixed_leg: int = 1,
    start: Exact | None = None,
    stop: Exact | None = None,
    lengths: _Length = (),
    samples: int | None = None,
    **options: Unpack[CurveOptions],
) -> Asked[CuspCurves]:
    """Each cusp followed from where it appears to where it vanishes."""
    given = _complete(options, digits=DEFAULT_DIGITS, certificate="short", deadline=None)
    members: dict[str, object] = {
        "fixed_leg": fixed_leg,
        "range": _range(start, stop),
        "samples": samples,
        "certificate": given["certificate"],
    }
    if points := _lengths(lengths):
        members[f"l{fixed_leg}"] = points
    return _asked(CuspCurvesRequest, CuspCurves, manipulator, given["digits"], given["deadline"], members)


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
    members = {"requirement": requirement.to_json(), **_numbers(tolerance=tolerance)}
    return _asked(CheckRequest, CheckReport, manipulator, digits, deadline, members)


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
    return _asked(PosesRequest, PoseTable, manipulator, digits, deadline, _legs(l1, l2, l3))


def cusp_loop(
    manipulator: Manipulator, length: Exact, cusp: int | str, **options: Unpack[PathOptions]
) -> Asked[Path]:
    """A loop of the leg lengths round a cusp, without a singularity, from one pose to another.

    With `others` the answer says what becomes of the other poses meanwhile.
    """
    leg = options.get("fixed_leg", 1)
    return _path(manipulator, options, {f"l{leg}": _text(length), "cusp": str(cusp)})


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
    members = {f"l{fixed_leg}": _text(length), "fixed_leg": fixed_leg, "tolerance": _text(tolerance)}
    return _asked(SingularCurvesRequest, SingularCurves, manipulator, digits, deadline, members)


def range_aspects(
    manipulator: Manipulator,
    start: Exact | None = None,
    stop: Exact | None = None,
    *,
    fixed_leg: int = 1,
    deadline: float | None = None,
) -> Asked[RangeAspects]:
    """The aspects while the length of one leg varies within a range; an end that is missing is open."""
    members = {"range": _range(start, stop), "fixed_leg": fixed_leg}
    return _asked(RangeAspectsRequest, RangeAspects, manipulator, MIN_DIGITS, deadline, members)


def assembly_modes(
    manipulator: Manipulator,
    length: Exact | None = None,
    *,
    between: tuple[Exact, Exact] | None = None,
    limits: ExactLimits | None = None,
    fixed_leg: int = 1,
    deadline: float | None = None,
) -> Asked[AssemblyModes]:
    """Whether the assembly mode can change without a singularity, in a slice or in a range."""
    members = {**_numbers(**{f"l{fixed_leg}": length}), "fixed_leg": fixed_leg, **_limits(limits)}
    members |= {} if between is None else {"range": _range(*between)}
    return _asked(AssemblyModesRequest, AssemblyModes, manipulator, None, deadline, members)


def margin(
    manipulator: Manipulator,
    length: Exact | None = None,
    *,
    requirement: Requirement | None = None,
    window: Exact | None = None,
    fixed_leg: int = 1,
    weights: Mapping[str, Exact] | None = None,
    tolerance: Exact | Mapping[str, Exact] | None = None,
    **options: Unpack[MarginOptions],
) -> Asked[Margin]:
    """How far the lengths may change before a slice, a requirement or a window loses its number of cusps."""
    numbers = {f"l{fixed_leg}": length, "window": window, "tolerance": tolerance, "weights": weights}
    given = _complete(options, certificate="short", deadline=None)
    members = {**_numbers(**numbers), "fixed_leg": fixed_leg, "certificate": given["certificate"]}
    if requirement is not None:
        members["requirement"] = requirement.to_json()
    return _asked(MarginRequest, Margin, manipulator, None, given["deadline"], members)


def design(
    manipulator: Manipulator,
    objective: str,
    requirement: Requirement | None = None,
    *,
    deadline: float | None = None,
    **options: Unpack[Options],
) -> Asked[Design]:
    """A geometry near a given one with a longer range, a smaller change, a larger margin, or more cusps."""
    budget, vary = options.pop("budget", None), options.pop("vary", None)
    members: dict[str, Any] = {"objective": objective, **options}
    members |= _numbers(**{name: members.pop(name, None) for name in ("min_height", "ignore_windows")})
    more = {
        "vary": {name: _range(*x) for name, x in vary.items()} if isinstance(vary, Mapping) else vary,
        "requirement": None if requirement is None else requirement.to_json(),
        "budget": None if budget is None else {"censuses": budget},
    }
    members |= {name: value for name, value in more.items() if value is not None}
    return _asked(DesignRequest, Design, manipulator, None, deadline, members)


def plot(manipulator: Manipulator, plot: str = "slice", **options: Unpack[PlotOptions]) -> Asked[Plot]:
    """A picture, of a kind of ``POST /v1/plots``.

    A slice and a loop have the ``length`` of the fixed leg, the mechanism all three ``lengths``, or a length
    and a cusp, the others a range.
    """
    names = ("length", "lengths", "start", "stop", "cusp", "pose", "deadline", "width_mm")
    setting = ("style", "unit", "labels")
    given = _complete(options, fixed_leg=1, theme="auto", **dict.fromkeys((*names, *setting)))
    members: dict[str, object] = {name: given[name] for name in ("theme", "fixed_leg")} | {"plot": plot}
    members |= _numbers(**{f"l{given['fixed_leg']}": given["length"], "width_mm": given["width_mm"]})
    if given["lengths"] is not None:
        members |= _legs(*given["lengths"])
    if (given["start"], given["stop"]) != (None, None):
        members["range"] = _range(given["start"], given["stop"])
    members |= {name: str(given[name]) for name in ("cusp", "pose") if given[name] is not None}
    members |= {name: given[name] for name in setting if given[name] is not None}
    return _asked(PlotRequest, Plot, manipulator, None, given["deadline"], members)


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
    ends = {**_legs(l1, l2, l3), "from": str(start), "to": str(stop)}
    members = ends if between is None else {**ends, "between": _range(*between)}
    return _path(manipulator, options, members)


def verify_document(
    document: Mapping[str, Any], *, effort: int = 1, deadline: float | None = None
) -> Asked[Verification]:
    """A verification of a document by independent means, with so many times the usual work."""
    members = {"document": document, "effort": effort}
    members |= {} if deadline is None else {"deadline_s": str(deadline)}
    question = read(VerificationRequest, members, Source(Limits.of_environment(), is_text=True))
    return Asked(question, Verification)


def _asked(
    question: type[Question],
    model: type[M],
    manipulator: Manipulator,
    digits: int | None,
    deadline: float | None,
    members: Mapping[str, object],
) -> Asked[M]:
    # the service has the limits that count
    limits = Limits.of_environment(max_slices=_NO_LIMIT, max_article_slices=_NO_LIMIT, max_samples=_NO_LIMIT)
    own = {"geometry": manipulator, **members}
    if digits is not None:
        own["digits"] = digits
    if deadline is not None:
        own["deadline_s"] = str(deadline)
    return Asked(read(question, own, Source(limits, is_text=True)), model)


def _numbers(**given: Exact | Mapping[str, Exact] | None) -> dict[str, object]:
    return {
        name: {g: _text(x) for g, x in value.items()} if isinstance(value, Mapping) else _text(value)
        for name, value in given.items()
        if value is not None
    }


def _legs(*lengths: Exact) -> dict[str, str]:
    return {f"l{leg}": _text(x) for leg, x in enumerate(lengths, 1)}


def _path(manipulator: Manipulator, options: PathOptions, members: Mapping[str, object]) -> Asked[Path]:
    usual = {"duration": 1, "others": False, "limits": None, "deadline": None, "timing": "cosine"}
    given = _complete(options, fixed_leg=1, digits=PATH_DIGITS, samples=DEFAULT_SAMPLES, **usual)
    own = {
        **members,
        **{name: given[name] for name in ("fixed_leg", "timing", "others")},
        "samples": str(given["samples"]),
        "duration": _text(given["duration"]),
        **_limits(given["limits"]),
    }
    return _asked(PathRequest, Path, manipulator, given["digits"], given["deadline"], own)


def _complete(options: Mapping[str, Any], **defaults: Any) -> dict[str, Any]:
    """Returns options with the defaults of those that are not given.

    Raises:
        TypeError: there is no such option.
    """
    if unknown := options.keys() - defaults.keys():
        raise TypeError(f"unexpected keyword argument {min(unknown)!r}; known are {', '.join(defaults)}")
    return {**defaults, **options}


def _lengths(lengths: _Length) -> list[str]:
    if isinstance(lengths, Iterable) and not isinstance(lengths, str):
        return [_text(x) for x in lengths]
    return [_text(lengths)]


def _range(start: Exact | None, stop: Exact | None) -> dict[str, str | None]:
    return {"from": None if start is None else _text(start), "to": None if stop is None else _text(stop)}


def _limits(limits: ExactLimits | None) -> dict[str, object]:
    return {} if limits is None else {"limits": limits_json(read_limits(limits, "limits"))}


def _text(x: Exact) -> str:
    return x if isinstance(x, str) else exact_str(x)
