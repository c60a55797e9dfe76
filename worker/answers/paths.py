"""Paths without a singularity: loops round cusps, paths from pose to pose, which poses they join, and whether
the assembly mode can change."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from math import ceil, isqrt
from typing import Any

import rpr_solver
from rpr_solver.contract import DEFAULT_SAMPLES, LENGTHS, MOST_POSES, MOST_SAMPLES, Progress
from rpr_solver.errors import FieldProblem, InputError
from rpr_solver.exact.numerals import double, fraction
from rpr_solver.triangles import Canonical, parse_surd
from worker.answers.cost import Sizes, all_events, elimination_at_one, one_slice
from worker.answers.kind import Content, Document, JobRequest, Kind, Store

_NAMES = {"start": "from", "stop": "to"}


def _named(field: str) -> str:
    """A field of the library as the question names it."""
    head, dot, rest = field.partition(".")
    return f"{_NAMES.get(head, head)}{dot}{rest}"


def _limits(content: Content) -> dict[str, tuple[str | None, str | None]]:
    """The joint limits of a question, if it has any."""
    return {leg: (ends["min"], ends["max"]) for leg, ends in (content.get("limits") or {}).items()}


def _ends(content: Content, name: str) -> tuple[str, str] | None:
    """The lengths between which the fixed leg may vary, if a question has a member for them."""
    return (ends := content.get(name)) and (ends["from"], ends["to"])


def _condition(content: Content) -> dict[str, Any]:
    """What is asked of condition numbers."""
    if (asked := content.get("condition")) is None:
        return {}
    names = {"length_scale": "length_scale", "max": "max_condition"}
    return {"condition": True, **{names[name]: number for name, number in asked.items()}}


USUAL: Mapping[str, Any] = {
    "samples": DEFAULT_SAMPLES,
    "timing": "cosine",
    "duration": "1",
    "others": False,
}
"""What a loop is of which nothing more is said."""


def path(request: JobRequest, store: Store, _progress: Progress) -> Document:
    """Compute a path; the eliminant is kept.

    Raises:
        InputError: the slice has no such cusp, or the joint vector no such pose.
        SolverError: the path could not be decided.
    """
    from rpr_solver.paths.loops import loop_in_slice, slice_for_loops  # by those who compute
    from rpr_solver.paths.question import PathTerms

    content, others = request.content, request.content["others"]
    manipulator = request.as_given
    names = "samples", "timing", "duration", "motion", "sampling", "clearance"
    terms_given: dict[str, Any] = {
        "limits": _limits(content),
        "fixed_leg": request.fixed_leg,
        "digits": request.digits,
        **{name: content[name] for name in names if name in content},
        **_condition(content),
    }
    if "cusp" in content:
        own = store.eliminant(request)
        table = slice_for_loops(own, content["length"])
        terms = PathTerms.of(**terms_given)
        path = loop_in_slice(own, table, content["cusp"], terms, manipulator)
        return (path.with_others() if others else path).to_json()
    options = {**terms_given, "between": _ends(content, "between")}
    places = content["from"], content["to"]
    try:
        if isinstance(content["from"], int):
            lengths = content["l1"], content["l2"], content["l3"]
            answer = rpr_solver.joint_path(manipulator, *lengths, *places, **options)
        else:
            answer = rpr_solver.pose_path(manipulator, *places, **options)
    except InputError as error:
        raise InputError([FieldProblem(_named(p.field), p.message) for p in error.problems]) from None
    return (answer.with_others() if others and isinstance(answer, rpr_solver.Path) else answer).to_json()


_RANGE_OF_SLICES = 6  # slices that take as long as the subdivision of a range
_PER_CHORD = 1.5  # samples, for the root of a path as long as the longest leg over the chord
_PER_LIMIT = (("speed", 1.5, 1), ("acceleration", 4.0, 2), ("jerk", 9.0, 3))
"""The time of a path as long as the longest leg, as a multiple of a root of that length over a limit."""
_SUBDIVISION = 0.5  # seconds, of a slice within joint limits
_WIDE = 2  # subdivisions that take as long as the widest path
_WIDE_IN_RANGE = 8  # or as that of a range
_OF_CONDITIONS = 2  # or as condition numbers along a path


def _measure_path(content: Content, size: Sizes) -> Sizes:
    of_poses, is_limited = "from" in content, content.get("limits") is not None
    count = _count(content)
    return replace(
        size,
        count=count,
        nearness=0 if of_poses else size.nearness,
        deviations=count if content.get("motion") or content.get("sampling") else 0,
        censuses=int(of_poses and not is_limited and bool(content.get("between"))),
        limited=((_RANGE_OF_SLICES if content["between"] else 1) if of_poses and is_limited else 0)
        + ((_WIDE_IN_RANGE if content.get("between") else _WIDE) if "clearance" in content else 0)
        + (_OF_CONDITIONS if "condition" in content else 0),
    )


def _count(content: Content) -> int:
    """About how many samples there will be, by the length of a path of which nothing is known yet."""
    sampling, motion = content.get("sampling") or {}, content.get("motion")
    if "samples" in content or not sampling.keys() & {"chord", "step"}:
        return int(content.get("samples") or sampling.get("number") or DEFAULT_SAMPLES)
    legs = (content[name] for name in ("length", "l1", "l2", "l3") if name in content)
    longest = max(_longest(content["geometry"]), *map(fraction, legs))
    if "chord" in sampling:
        count = _PER_CHORD * double(longest / fraction(sampling["chord"])) ** 0.5
    else:
        step = fraction(sampling["step"])
        if motion is None:
            count = double(fraction(content["duration"]) / step)
        else:
            count = 0.0
            for name, share, power in _PER_LIMIT:
                if name in motion:
                    least = min(map(fraction, motion[name].values()))
                    count += share * double(longest / (least * step**power)) ** (1 / power)
    samples: float = min(count + 2, MOST_SAMPLES)
    return ceil(samples)


def _longest(geometry: Canonical) -> Fraction:
    """About the longest of the six numbers, or of the sides of the triangles."""
    if LENGTHS[0] in geometry:
        return max(abs(fraction(str(geometry[name]))) for name in LENGTHS)
    squares = [parse_surd(side, "").square for name in ("base", "platform") for side in geometry[name]]
    longest = max(squares)
    # √(n / d) = √(n d) / d
    return Fraction(isqrt(longest.numerator * longest.denominator) + 1, longest.denominator)


def _path_cost(size: Sizes) -> float:
    """The slice, the search of the path, its samples, and what the legs deviate between them."""
    sample = 2e-4 + 1e-6 * (size.geometry + size.lengths + size.digits) + 1.5e-8 * size.digits**2
    search = 0.03 + 1e-3 * size.nearness + size.limited * _SUBDIVISION
    deviations = 8e-4 * size.deviations
    return (
        search
        + elimination_at_one(size)
        + one_slice(replace(size, nearness=0))
        + sample * size.count
        + deviations
        + size.censuses * all_events(size)
    )


def _fewer_samples(content: Content, size: Sizes) -> Mapping[str, tuple[Sizes, str]]:
    """The member by which a path has many samples, with the sizes at best and what to do."""
    fewer = replace(size, count=1, deviations=min(size.deviations, 1))
    for name in content.get("sampling") or ():
        return {f"sampling.{name}": (fewer, f"give more: this takes about {size.count} samples")}
    return {"samples": (fewer, f"ask for fewer than {size.count}")}


PATH = Kind("path", "pa-", path, _path_cost, measure=_measure_path, fewer=_fewer_samples)


_MODES_PAIRS = 1.5
"""Seconds of the proof that no folds meet."""
_MODES_SLICES = 3
_WIDE = 1
"""Times as long as that proof, or as a subdivision: wide paths, and that there are none. Of 20 questions the
least took a quarter of the estimate, but for limits that few poses keep, and the longest 1.5 times as long;
where it stays undecided, three times."""


def assembly_modes(request: JobRequest, _store: Store, _progress: Progress) -> Document:
    """Decide whether two poses of one joint vector are joined, in a slice or in a range.

    Raises:
        SolverError: the slices could not be decided.
    """
    content = request.content
    return rpr_solver.assembly_modes(
        request.manipulator,
        content.get("length"),
        between=_ends(content, "range"),
        limits=_limits(content),
        fixed_leg=request.fixed_leg,
        clearance=content.get("clearance"),
        tolerance=content.get("tolerance"),
    ).to_json()


def _measure_modes(content: Content, size: Sizes) -> Sizes:
    wide = 0 if content.keys().isdisjoint({"clearance", "tolerance"}) else _WIDE
    return replace(size, censuses=int("range" in content), limited=max(int("limits" in content), wide))


def _modes_cost(size: Sizes) -> float:
    """A loop round a cusp or the pairs of folds, the regions, and the census of a range."""
    slices = _MODES_SLICES * one_slice(size) * (1 + 2 * size.censuses)
    near = 0.015 * (size.nearness if size.is_special else size.alikeness)
    proofs = 0.15 + _MODES_PAIRS * (size.censuses + size.limited) + near
    return elimination_at_one(size) + slices + proofs + size.censuses * all_events(size)


MODES = Kind("assembly-modes", "am-", assembly_modes, _modes_cost, measure=_measure_modes)


_PARTS = 4
"""The number of subdivisions that take as long as the parts of the allowed region."""


def connections(request: JobRequest, _store: Store, _progress: Progress) -> Document:
    """Decide for each pair of poses whether a path joins them.

    Raises:
        InputError: the range does not hold the lengths of the fixed leg, or both joint vectors are the same.
        SolverError: the slice could not be decided.
    """
    content = request.content
    to = content.get("to")
    return rpr_solver.pose_connections(
        request.manipulator,
        *(content[leg] for leg in ("l1", "l2", "l3")),
        to=to and [to[leg] for leg in ("l1", "l2", "l3")],
        between=_ends(content, "between"),
        parts=content.get("parts", False),
        clearance=content.get("clearance"),
        tolerance=content.get("tolerance"),
        limits=_limits(content),
        fixed_leg=request.fixed_leg,
        digits=request.digits,
    ).to_json()


def _measure_connections(content: Content, size: Sizes) -> Sizes:
    slices = _RANGE_OF_SLICES if "between" in content or "to" in content else 1
    limited = slices if "limits" in content else 0
    limited += 0 if content.keys().isdisjoint({"clearance", "tolerance"}) else _WIDE * slices
    return replace(size, count=slices, limited=limited + (_PARTS * slices if "parts" in content else 0))


def _connections_cost(size: Sizes) -> float:
    """The poses, the aspects of the slice or of the range, and the subdivision for both signs."""
    poses = (
        2
        * MOST_POSES
        * (1e-3 + 1e-6 * (size.geometry + size.lengths + size.digits) + 1.5e-8 * size.digits**2)
    )
    return (
        0.02 + poses + 0.015 * size.nearness + size.count * one_slice(size) + 2 * size.limited * _SUBDIVISION
    )


CONNECTIONS = Kind("pose-connections", "pc-", connections, _connections_cost, measure=_measure_connections)
"""Pose connections: the question which poses are joined, and the answer."""
