"""The questions that a client asks, in the words of the library."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypedDict, Unpack

from rpr_solver import CHECK_DIGITS, DEFAULT_DIGITS, Exact, Manipulator, Requirement
from rpr_solver.contract import DEFAULT_TOLERANCE, MIN_DIGITS
from rpr_solver.designs.questions import Options
from service.client.bodies import (
    Asked,
    Lengths,
    asked,
    complete,
    legs,
    lengths_of,
    numbers,
    range_of,
    text_of,
)
from service.schemas.censuses import Census, CensusRequest, CheckReport, CheckRequest
from service.schemas.curves import CuspCurves, CuspCurvesRequest
from service.schemas.designs import Design, DesignRequest
from service.schemas.document import Source, read
from service.schemas.limits import Limits
from service.schemas.margins import Margin, MarginRequest
from service.schemas.plots import Plot, PlotRequest
from service.schemas.poses import (
    PosesRequest,
    PoseTable,
    RangeAspects,
    RangeAspectsRequest,
    SingularCurves,
    SingularCurvesRequest,
)
from service.schemas.tables import CuspTable, CuspTableRequest
from service.schemas.verifications import Verification, VerificationRequest


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
    certificate: str = "short",
    deadline: float | None = None,
) -> Asked[CuspTable]:
    """The cusps of slices; `deadline` is the time in seconds after which the answer is of no use.

    Raises:
        InputError: naming every fault.
    """
    members = {
        f"l{fixed_leg}": lengths_of(lengths),
        "fixed_leg": fixed_leg,
        "method": method,
        "certificate": certificate,
    }
    return asked(CuspTableRequest, CuspTable, manipulator, digits, deadline, members)


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
    given = complete(options, certificate="short", sensitivities=False, tolerance=None, deadline=None)
    members = {
        "fixed_leg": fixed_leg,
        "range": range_of(start, stop),
        **{name: given[name] for name in ("certificate", "sensitivities")},
        **numbers(tolerance=given["tolerance"]),
    }
    return asked(CensusRequest, Census, manipulator, digits, given["deadline"], members)


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
    given = complete(options, digits=DEFAULT_DIGITS, certificate="short", deadline=None)
    members: dict[str, object] = {
        "fixed_leg": fixed_leg,
        "range": range_of(start, stop),
        "samples": samples,
        "certificate": given["certificate"],
    }
    if points := lengths_of(lengths):
        members[f"l{fixed_leg}"] = points
    return asked(CuspCurvesRequest, CuspCurves, manipulator, given["digits"], given["deadline"], members)


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
    members = {"requirement": requirement.to_json(), **numbers(tolerance=tolerance)}
    return asked(CheckRequest, CheckReport, manipulator, digits, deadline, members)


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
    return asked(PosesRequest, PoseTable, manipulator, digits, deadline, legs(l1, l2, l3))


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
    members = {f"l{fixed_leg}": text_of(length), "fixed_leg": fixed_leg, "tolerance": text_of(tolerance)}
    return asked(SingularCurvesRequest, SingularCurves, manipulator, digits, deadline, members)


def range_aspects(
    manipulator: Manipulator,
    start: Exact | None = None,
    stop: Exact | None = None,
    *,
    fixed_leg: int = 1,
    deadline: float | None = None,
) -> Asked[RangeAspects]:
    """The aspects while the length of one leg varies within a range; an end that is missing is open."""
    members = {"range": range_of(start, stop), "fixed_leg": fixed_leg}
    return asked(RangeAspectsRequest, RangeAspects, manipulator, MIN_DIGITS, deadline, members)


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
    own = {f"l{fixed_leg}": length, "window": window, "tolerance": tolerance, "weights": weights}
    given = complete(options, certificate="short", deadline=None)
    members = {**numbers(**own), "fixed_leg": fixed_leg, "certificate": given["certificate"]}
    if requirement is not None:
        members["requirement"] = requirement.to_json()
    return asked(MarginRequest, Margin, manipulator, None, given["deadline"], members)


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
    members |= numbers(**{name: members.pop(name, None) for name in ("min_height", "ignore_windows")})
    more = {
        "vary": {name: range_of(*x) for name, x in vary.items()} if isinstance(vary, Mapping) else vary,
        "requirement": None if requirement is None else requirement.to_json(),
        "budget": None if budget is None else {"censuses": budget},
    }
    members |= {name: value for name, value in more.items() if value is not None}
    return asked(DesignRequest, Design, manipulator, None, deadline, members)


def plot(manipulator: Manipulator, plot: str = "slice", **options: Unpack[PlotOptions]) -> Asked[Plot]:
    """A picture, of a kind of ``POST /v1/plots``.

    A slice and a loop have the ``length`` of the fixed leg, the mechanism all three ``lengths``, or a length
    and a cusp, the others a range.
    """
    names = ("length", "lengths", "start", "stop", "cusp", "pose", "deadline", "width_mm")
    setting = ("style", "unit", "labels")
    given = complete(options, fixed_leg=1, theme="auto", **dict.fromkeys((*names, *setting)))
    members: dict[str, object] = {name: given[name] for name in ("theme", "fixed_leg")} | {"plot": plot}
    members |= numbers(**{f"l{given['fixed_leg']}": given["length"], "width_mm": given["width_mm"]})
    if given["lengths"] is not None:
        members |= legs(*given["lengths"])
    if (given["start"], given["stop"]) != (None, None):
        members["range"] = range_of(given["start"], given["stop"])
    members |= {name: str(given[name]) for name in ("cusp", "pose") if given[name] is not None}
    members |= {name: given[name] for name in setting if given[name] is not None}
    return asked(PlotRequest, Plot, manipulator, None, given["deadline"], members)


def verify_document(
    document: Mapping[str, Any], *, effort: int = 1, deadline: float | None = None
) -> Asked[Verification]:
    """A verification of a document by independent means, with so many times the usual work."""
    members = {"document": document, "effort": effort}
    members |= {} if deadline is None else {"deadline_s": str(deadline)}
    question = read(VerificationRequest, members, Source(Limits.of_environment(), is_text=True))
    return Asked(question, Verification)
