"""What an answer costs, estimated from the sizes of its numbers before anything is computed.

The estimates are seconds of one core. They grow with each size, take microseconds, and look at a number only
for its length. `benchmarks/cost.py` compares them with measurements; docs/worker.md has the outcome.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import gcd, lcm
from typing import Any

from worker.answers import (
    article,
    aspects,
    censuses,
    certified,
    checks,
    curves,
    paths,
    plots,
    poses,
    singular,
    tables,
    verifications,
)
from worker.answers.requests import JobRequest, Kind

_INTERVALS = 20  # between two transitions, of a typical manipulator
_BALLS_SPREAD = 1000  # bits; beyond, the balls of a slice with few digits do not decide it
_KNOWN = 0.001  # seconds, to find that an answer is known
_SLICES_OF_PLOTS = {"census": _INTERVALS, "locus": _INTERVALS * plots.SAMPLES}
_SUBDIVISION = 0.5  # seconds, of a slice within joint limits
_RANGE_OF_SLICES = 6  # as many slices does the subdivision of a range take
_SIDES = ("a2x", "a3x", "a3y", "d1", "d2", "d3")


@dataclass(frozen=True)
class Cost:
    """Estimated seconds of one core: `once` for a job, and `each` for every part of it."""

    once: float
    each: float

    def of(self, parts: int) -> float:
        """Returns the seconds for so many parts."""
        return self.once + self.each * parts


@dataclass(frozen=True)
class Sizes:
    """The sizes that decide the cost.

    Attributes:
        geometry: bits of the sides of the manipulator, once all are integers without a common factor: a mean
            in which the longest counts half as much again.
        lengths: bits of the longest numerator or denominator of the leg lengths in the question.
        spread: bits of the quotient of the longest and the shortest of all these lengths.
        digits: significant digits of the answer.
        count: the slices of a table, the lengths at which curves are sampled, or the samples of a path; else
            1.
    """

    geometry: int
    lengths: int
    spread: int
    digits: int
    count: int
    censuses: int = 0
    """How many censuses the answer may need beside its own computation."""
    limited: int = 0
    """How many slices are subdivided within joint limits."""


def sizes(request: JobRequest) -> Sizes:
    """Returns the sizes of a request."""
    content = request.content
    sides = [Fraction(request.geometry[name]) for name in _SIDES]
    legs = [Fraction(text) for text in _lengths(content)]
    unit = lcm(*(side.denominator for side in sides))
    whole = [side.numerator * (unit // side.denominator) for side in sides]
    common = gcd(*whole).bit_length() - 1
    bits = [abs(x).bit_length() - common for x in whole if x]
    scales = [_scale(x) for x in (*sides, *legs) if x]
    of_poses = request.kind is paths.KIND and "from" in content
    is_limited = content.get("limits") is not None
    per_interval = 1 if request.kind is paths.KIND else _INTERVALS
    points = len(content.get("lengths", ())) + per_interval * (content.get("samples") or 0)
    if request.kind is plots.KIND:
        points = _SLICES_OF_PLOTS.get(content["plot"], 1)
    if request.kind is verifications.KIND:
        points = parts_to_verify(content["document"])
    return Sizes(
        geometry=(max(bits) + 2 * sum(bits) // len(sides)) // 3,
        lengths=max((max(x.numerator.bit_length(), x.denominator.bit_length()) for x in legs), default=1),
        spread=max(scales) - min(scales),
        digits=request.digits,
        censuses=int(of_poses and not is_limited),
        limited=(_RANGE_OF_SLICES if content["between"] else 1) if of_poses and is_limited else 0,
        count=len(content["l1"]) if isinstance(content.get("l1"), list) else max(1, points),
    )


def cost(request: JobRequest) -> Cost:
    """Returns the estimated cost of a request of which nothing is known."""
    return _COSTS[request.kind](sizes(request))


def seconds_after(request: JobRequest, seen: set[str]) -> float:
    """Returns the estimated seconds of a question after others, of which `seen` has what is computed once.

    Adds what this one computes.
    """
    whole = cost(request)
    parts = len(request.parts) if request.kind.by_slices else 1
    if request.content_hash in seen:
        return _KNOWN * parts
    once = whole.once
    if once:
        shared = f"{request.geometry_hash} {request.fixed_leg}"
        once = 0.0 if shared in seen else once
        seen.add(shared)
    seen.add(request.content_hash)
    return once + whole.each * parts


def seconds(kind: Kind, size: Sizes) -> float:
    """Returns the estimated seconds for a whole request of these sizes."""
    return _COSTS[kind](size).of(size.count if kind.by_slices else 1)


def _lengths(content: Mapping[str, Any]) -> Iterable[str]:
    if "l2" in content:
        return [content[leg] for leg in ("l1", "l2", "l3")]
    requirement = content.get("requirement", content)
    ends = [requirement.get("range", {}), *(requirement.get("limits") or {}).values()]
    if "length" in content:
        return [content["length"]]
    listed = [*content.get("l1", ()), *content.get("lengths", ())]
    return [*listed, *(end for pair in ends for end in pair.values() if end)]


def _scale(x: Fraction) -> int:
    return x.numerator.bit_length() - x.denominator.bit_length()


def _elimination(size: Sizes) -> float:
    """In balls at so many lengths, whose precision grows with the coefficients."""
    return 0.02 + 0.003 * size.geometry + 4e-6 * size.geometry**2


def _slice(size: Sizes) -> float:
    """In balls; lengths of very different sizes need a higher precision, and at last number fields."""
    numbers = 1e-5 * size.geometry + 5e-6 * size.lengths + 4e-6 * size.spread**2
    balls = 0.002 + numbers + 2e-6 * size.digits + 8e-10 * size.digits**2
    return balls + (_exact_slice(size) if size.spread > _BALLS_SPREAD else 0.0)


def _exact_slice(size: Sizes) -> float:
    return 0.1 + 5e-6 * size.geometry**2


def _article(size: Sizes) -> float:
    return (0.15 + 0.015 * size.geometry + 0.0006 * size.geometry**2) * size.count


def _events(size: Sizes) -> float:
    """All transitions of a manipulator."""
    return 0.35 + 0.009 * size.geometry + 2.5e-5 * size.geometry**2 + 2e-4 * size.digits


def _poses(size: Sizes) -> float:
    return 0.005 + 1e-5 * (size.geometry + size.lengths + size.digits) + 1e-7 * size.spread**2


def _plot(size: Sizes) -> float:
    """A slice that is traced, or all transitions, and curves sampled between them."""
    drawing = 0.15 + _elimination(size) + 2 * _slice(size)
    return drawing if size.count == 1 else 1.4 + _events(size) + _slice(size) * size.count


def parts_to_verify(document: Mapping[str, Any]) -> int:
    """Returns how many slices a verification solves anew: those listed, or one in each interval.

    Ten tubes of a full certificate cost as much as one.
    """
    lists = [document.get(name) for name in ("slices", "intervals", "curves")]
    slices = max((len(part) for part in lists if isinstance(part, list)), default=1) or 1
    return slices + _tubes(document) // 10


def _tubes(document: Mapping[str, Any]) -> int:
    match document.get("certificate"):
        case {"full": {"chains": [*chains]}}:
            lists = [chain.get("tubes") for chain in chains if isinstance(chain, Mapping)]
            return sum(len(tubes) for tubes in lists if isinstance(tubes, list))
    return 0


def _curves(size: Sizes) -> float:
    """All transitions, and the slices of the points."""
    return 1.4 + _events(size) + _slice(size) * size.count


def _verification(size: Sizes) -> float:
    """Each slice is eliminated by itself; digits and long numbers make intervals wide."""
    bits = size.geometry + size.lengths
    return (0.15 + 2e-3 * bits + 2e-6 * bits**2 + 2e-4 * size.digits + 2e-8 * size.digits**2) * size.count


def _path(size: Sizes) -> float:
    """The slice, the search of the path, and its samples."""
    sample = 2e-4 + 1e-6 * (size.geometry + size.lengths + size.digits)
    search = 0.05 + size.limited * _SUBDIVISION
    return search + _elimination(size) + _slice(size) + sample * size.count + size.censuses * _events(size)


def _singular(size: Sizes) -> float:
    """The slice, the sweep, a sextic for each region, and the drawing."""
    return 0.08 + _elimination(size) + 2 * _slice(size) + 1e-3 * (size.geometry + size.lengths)


_COSTS: Mapping[Kind, Callable[[Sizes], Cost]] = {
    tables.KIND: lambda size: Cost(_elimination(size), _slice(size)),
    article.KIND: lambda size: Cost(0.0, _article(size)),
    poses.KIND: lambda size: Cost(0.0, _poses(size)),
    censuses.KIND: lambda size: Cost(0.0, _events(size)),
    checks.KIND: lambda size: Cost(0.0, _events(size)),
    paths.KIND: lambda size: Cost(0.0, _path(size)),
    singular.KIND: lambda size: Cost(0.0, _singular(size)),
    aspects.KIND: lambda size: Cost(0.0, _singular(size)),
    certified.KIND: lambda size: Cost(0.0, _elimination(size) + 2 * _slice(size) * size.count),
    certified.CENSUS: lambda size: Cost(0.0, _events(size)),
    verifications.KIND: lambda size: Cost(0.0, _verification(size)),
    plots.KIND: lambda size: Cost(0.0, _plot(size)),
    curves.KIND: lambda size: Cost(0.0, _curves(size)),
    certified.CURVES: lambda size: Cost(0.0, 3.5 * _curves(size)),
}
