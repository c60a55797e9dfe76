"""What an answer costs, estimated from the sizes of its numbers before anything is computed.

The estimates are seconds of one core. They grow with each size, take microseconds, and look at a number only
for its length. `benchmarks/cost.py` compares them with measurements; docs/worker.md has the outcome.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import gcd, lcm

from worker.answers import article, censuses, checks, curves, poses, tables
from worker.answers.requests import JobRequest, Kind

_INTERVALS = 20  # between two transitions, of a typical manipulator
_LENGTHS = ("a2x", "a3x", "a3y", "d1", "d2", "d3")


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
        geometry: bits of the longest side of the manipulator, once all are integers without a common factor.
        lengths: bits of the longest numerator or denominator of the leg lengths in the question.
        digits: significant digits of the answer.
        count: the slices of a table, or the lengths at which curves are sampled; else 1.
    """

    geometry: int
    lengths: int
    digits: int
    count: int


def sizes(request: JobRequest) -> Sizes:
    """Returns the sizes of a request."""
    sides = [Fraction(request.geometry[name]) for name in _LENGTHS]
    unit = lcm(*(side.denominator for side in sides))
    whole = [side.numerator * (unit // side.denominator) for side in sides]
    common = gcd(*whole) or 1
    content = request.content
    points = len(content.get("lengths", ())) + _INTERVALS * (content.get("samples") or 0)
    return Sizes(
        geometry=max(abs(x) for x in whole).bit_length() - common.bit_length() + 1,
        lengths=_bits(_lengths(request)),
        digits=request.digits,
        count=len(content["l1"]) if isinstance(content.get("l1"), list) else max(1, points),
    )


def cost(request: JobRequest) -> Cost:
    """Returns the estimated cost of a request of which nothing is known."""
    return _COSTS[request.kind](sizes(request))


def seconds(kind: Kind, size: Sizes) -> float:
    """Returns the estimated seconds for a whole request of these sizes."""
    return _COSTS[kind](size).of(size.count if kind.by_slices else 1)


def _lengths(request: JobRequest) -> Iterable[str]:
    content = request.content
    if "l2" in content:
        return [content[leg] for leg in ("l1", "l2", "l3")]
    if "requirement" in content:
        requirement = content["requirement"]
        limits = [end for limit in (requirement.get("limits") or {}).values() for end in limit.values()]
        return [end for end in (*requirement["range"].values(), *limits) if end]
    ends = [end for end in content.get("range", {}).values() if end]
    return [*content.get("l1", ()), *content.get("lengths", ()), *ends]


def _bits(numbers: Iterable[str]) -> int:
    exact = map(Fraction, numbers)
    return max((max(x.numerator.bit_length(), x.denominator.bit_length()) for x in exact), default=1)


def _elimination(size: Sizes) -> float:
    return 0.016 * size.geometry + 1.4e-5 * size.geometry**2


def _slice(size: Sizes) -> float:
    return 0.008 + 2e-5 * size.geometry + 6e-6 * size.lengths + 1.2e-5 * size.digits


def _events(size: Sizes) -> float:
    return 1.0 + 0.06 * size.geometry + 0.0045 * size.geometry**2


_COSTS: Mapping[Kind, Callable[[Sizes], Cost]] = {
    tables.KIND: lambda size: Cost(_elimination(size), _slice(size)),
    article.KIND: lambda size: Cost(0.0, 0.4 * _events(size) * size.count),
    poses.KIND: lambda size: Cost(0.0, 0.005 + 1e-5 * (size.geometry + size.lengths + size.digits)),
    censuses.KIND: lambda size: Cost(0.0, _events(size)),
    checks.KIND: lambda size: Cost(0.0, _events(size)),
    curves.KIND: lambda size: Cost(0.0, 2.5 + _events(size) + 0.05 * size.count),
}
