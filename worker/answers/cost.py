"""What an answer costs, estimated from the sizes of its numbers before anything is computed.

The estimates are seconds of one core. They grow with each size (`sizes.py`), and take as long as it takes to
read the question once. `python -m benchmarks.cost` searches for the questions that take longest for their
estimate; docs/worker.md has the outcome.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

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
from worker.answers.sizes import Sizes, sizes

_BALLS_SPREAD = 1000  # bits; beyond, the balls of a slice with few digits do not decide it
_KNOWN = 0.001  # seconds, to find that an answer is known
_SUBDIVISION = 0.5  # seconds, of a slice within joint limits
_FLOATS_TELL = 44  # bits; shapes nearer to a special one than that take long proofs, which may not end
_NOT_TOLD = 90.0  # seconds


@dataclass(frozen=True)
class Cost:
    """Estimated seconds of one core: `once` for a job, and `each` for every part of it."""

    once: float
    each: float

    def of(self, parts: int) -> float:
        """Returns the seconds for so many parts."""
        return self.once + self.each * parts


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


def _elimination(size: Sizes) -> float:
    """In balls at so many lengths, whose precision grows with the coefficients."""
    return 0.02 + 0.003 * size.geometry + 4e-6 * size.geometry**2


def _slice(size: Sizes) -> float:
    """In balls; lengths of very different sizes need a higher precision, and at last number fields."""
    numbers = 1e-5 * size.geometry + 5e-6 * size.lengths + 4e-6 * size.spread**2
    balls = 0.002 + numbers + 2e-6 * size.digits + 8e-10 * size.digits**2
    balls += 0.0015 * max(0, size.nearness - 20) + 0.02 * size.is_special  # one by one
    return balls + (_exact_slice(size) if size.spread > _BALLS_SPREAD else 0.0)


def _exact_slice(size: Sizes) -> float:
    return 0.1 + 5e-6 * size.geometry**2


def _article(size: Sizes) -> float:
    bits = size.geometry + size.lengths
    return (0.1 + 0.8 * size.is_special + 0.015 * bits + 0.0006 * bits**2) * size.count


def _events(size: Sizes) -> float:
    """All transitions of a manipulator, and aspects between, which take long for nearly special shapes."""
    usual = 0.35 + 0.009 * size.geometry + 2.5e-5 * size.geometry**2 + 2e-4 * size.digits
    return usual + _nearness(size)


def _nearness(size: Sizes) -> float:
    return 0.003 * size.nearness**2 if size.nearness < _FLOATS_TELL else _NOT_TOLD


def _poses(size: Sizes) -> float:
    return 0.005 + 1e-5 * (size.geometry + size.lengths + size.digits) + 1e-7 * size.spread**2


def _plot(size: Sizes) -> float:
    """A slice that is traced, or all transitions, and perhaps curves sampled between them."""
    if size.count > 1:
        return 0.2 + _curves(size)
    drawing = 0.15 + _elimination(size) + 2 * _slice(size)
    return drawing if size.is_slice else 0.2 + _events(size)


def _curves(size: Sizes) -> float:
    """All transitions, curves between them, and those of each length."""
    return 1.4 + _events(size) + _narrow(size) + (0.035 + _slice(size)) * size.count


def _narrow(size: Sizes) -> float:
    """To follow cusps between the transitions of a nearly special shape, which are close to each other."""
    return min(20.0, 0.04 * size.nearness**2)


def _certified_curves(size: Sizes) -> float:
    """Tubes along the curves, which take two to three times as long as these."""
    shape = _nearness(size) + _narrow(size)
    return 3.5 * (_curves(size) - shape) + shape


def _verification(size: Sizes) -> float:
    """Each slice is eliminated by itself; each cusp or pose is proved; digits and long numbers make intervals
    wide."""
    bits = size.geometry + size.lengths
    numbers = 0.012 * size.geometry + 1e-4 * size.geometry**2 + 2e-3 * size.lengths + 8e-6 * size.lengths**2
    slices = 0.2 + numbers + 2e-4 * size.digits + 2e-8 * size.digits**2
    objects = 0.012 + 2e-5 * (bits + size.digits) + 3e-6 * size.objects
    return 0.3 + slices * size.count + objects * size.objects


def _path(size: Sizes) -> float:
    """The slice, the search of the path, and its samples."""
    sample = 2e-4 + 1e-6 * (size.geometry + size.lengths + size.digits) + 1.5e-8 * size.digits**2
    search = 0.05 + 0.015 * size.nearness + size.limited * _SUBDIVISION
    return search + _elimination(size) + _slice(size) + sample * size.count + size.censuses * _events(size)


def _aspects(size: Sizes) -> float:
    """The ends of the range, and the transitions of singular curves, which nearly special shapes hide."""
    return _singular(size) + 0.2 * max(0, size.nearness - 60)


def _singular(size: Sizes) -> float:
    """The slice, the sweep, a sextic for each region, and the drawing."""
    drawing = 0.08 + 8e-4 * size.fineness
    return drawing + _elimination(size) + 2 * _slice(size) + 1e-3 * (size.geometry + size.lengths)


_COSTS: Mapping[Kind, Callable[[Sizes], Cost]] = {
    tables.KIND: lambda size: Cost(_elimination(size), _slice(size)),
    article.KIND: lambda size: Cost(0.0, _article(size)),
    poses.KIND: lambda size: Cost(0.0, _poses(size)),
    censuses.KIND: lambda size: Cost(0.0, _events(size)),
    checks.KIND: lambda size: Cost(0.0, _events(size)),
    paths.KIND: lambda size: Cost(0.0, _path(size)),
    singular.KIND: lambda size: Cost(0.0, _singular(size)),
    aspects.KIND: lambda size: Cost(0.0, _aspects(size)),
    certified.KIND: lambda size: Cost(0.0, _elimination(size) + 2 * _slice(size) * size.count),
    certified.CENSUS: lambda size: Cost(0.0, _events(size)),
    verifications.KIND: lambda size: Cost(0.0, _verification(size)),
    plots.KIND: lambda size: Cost(0.0, _plot(size)),
    curves.KIND: lambda size: Cost(0.0, _curves(size)),
    certified.CURVES: lambda size: Cost(0.0, _certified_curves(size)),
}
