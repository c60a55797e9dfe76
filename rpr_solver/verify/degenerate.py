"""What is degenerate throughout an interval of lengths: the member ``degenerate`` of a census or a report.

In a slice whose eliminant has simple roots only, all degenerate poses are cusps, so nothing else is there. In
others the poses are searched for on the special lines, in one slice between neighbouring ends of the entries.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any

from rpr_solver.verify.boxes import Box, Equations, zero_near
from rpr_solver.verify.claims import Claim, ClaimStatus
from rpr_solver.verify.counts import other_poses, simplest_between
from rpr_solver.verify.eliminant import Eliminant
from rpr_solver.verify.manipulator import Geometry, exact
from rpr_solver.verify.surds import Indivisible
from rpr_solver.verify.system import System, derivative

_BITS = 60
_PLACE = Fraction(617, 1000)
_CURVE = "curve"
_CLAIM = "what is degenerate throughout an interval, or along a curve"
Entry = Mapping[str, Any]


def degenerate_claims(
    geometry: Geometry,
    fixed: int,
    entries: Sequence[Entry],
    parts: Sequence[Entry],
    generic: Sequence[bool | None],
) -> Iterator[Claim]:
    """The claims of the entries.

    Args:
        geometry: the manipulator.
        fixed: the fixed leg.
        entries: the member ``degenerate``.
        parts: the intervals of the document, which fill its range.
        generic: for each of them whether all roots of the eliminants of its slices are simple; None if it was
            not looked at.

    Raises:
        InputError: an end is no number.
    """
    for n, entry in enumerate(entries):
        for k, (part, simple) in enumerate(zip(parts, generic, strict=False)):
            if simple and _meet(entry, part):
                reason = f"the slices of interval {k} have none: all roots of their eliminants are simple"
                yield Claim(f"/degenerate/{n}", _CLAIM, ClaimStatus.REFUSED, reason)
                return
    if all(generic):
        reason = "all slices that were counted have eliminants with simple roots only"
        yield Claim("/degenerate", _CLAIM, ClaimStatus.CHECKED, reason)
        return
    yield _searched(geometry, fixed, entries, *_ends({"from": parts[0]["from"], "to": parts[-1]["to"]}))


def _searched(
    geometry: Geometry, fixed: int, entries: Sequence[Entry], start: Fraction, stop: Fraction | None
) -> Claim:
    """The kinds and numbers in a slice between neighbouring ends."""
    inner = {end for entry in entries for end in _ends(entry) if end is not None and end > start}
    ends = [start, *sorted(end for end in inner if stop is None or end < stop)]
    last = stop if stop is not None else 2 * ends[-1] + geometry.d1
    for low, high in pairwise([*ends, last]):
        here = [x for x in entries if _ends(x)[0] <= low and (_ends(x)[1] is None or high <= _high(x, last))]
        # not the simplest number, which may be the length of a transition
        middle, near = low + (high - low) * _PLACE, (high - low) / 1000
        length = simplest_between(middle - near, middle + near)
        found = found_in(System.of(geometry, fixed, length))
        if found is None:
            reason = f"the slice at {length} was not decided"
            return Claim("/degenerate", _CLAIM, ClaimStatus.NOT_CHECKED, reason)
        curves, kinds = found
        listed = {str(entry.get("equation")) for entry in here if entry["kind"] == _CURVE}
        if listed != set(curves):
            reason = f"J and E vanish along {', '.join(curves) or 'no curve'} in the slice at {length}"
            return Claim("/degenerate", _CLAIM, ClaimStatus.REFUSED, reason)
        if kinds is None:
            reason = f"poses beside the curve in the slice at {length} were not counted"
            return Claim("/degenerate", _CLAIM, ClaimStatus.NOT_CHECKED, reason)
        numbers = Counter({str(x["kind"]): x["count"] for x in here if x["kind"] != _CURVE})
        if numbers != kinds:
            known = ", ".join(f"{count} of kind {kind}" for kind, count in sorted(kinds.items()))
            reason = f"the slice at {length} has {known or 'none'}"
            return Claim("/degenerate", _CLAIM, ClaimStatus.REFUSED, reason)
    reason = "a slice between neighbouring ends has these poses, of these kinds, as far as a search finds"
    return Claim("/degenerate", _CLAIM, ClaimStatus.CHECKED, reason)


def found_in(system: System) -> tuple[list[str], Counter[str] | None] | None:
    """The curves of degenerate poses of a slice, and the numbers of other poses that are no cusps, by kind.

    The numbers are None if there are curves; the whole is None if nothing is known.
    """
    try:
        eliminant = Eliminant.of(system)
    except Indivisible:
        return None
    if not eliminant.form:
        return (eliminant.cut.curves, None) if eliminant.cut.curves else None
    return [], Counter(_kind(system, *pose) for pose in other_poses(system, eliminant))


def _kind(system: System, alpha: Fraction, theta: Fraction) -> str:
    """The kind of a degenerate pose near two angles in degrees."""
    radicand = system.ring.radicand
    first, second = system.legs
    for leg, other in ((first, second), (second, first)):
        box = zero_near(Equations.of(leg.alpha, leg.theta, radicand), alpha, theta, _BITS)
        if box and not any(box.directions.value(slope).sign for slope in (other.alpha, other.theta)):
            return "quadruple"
    slopes = [derivative(system.singular, theta=side) for side in (False, True)]
    box = zero_near(Equations.of(slopes[0], slopes[1], radicand), alpha, theta, _BITS)
    if box and not box.directions.value(system.singular).sign:
        return {1: "isolated-point", -1: "node"}.get(_curvature(system, box), "unknown")
    return "unknown"


def _curvature(system: System, box: Box) -> int:
    """The sign of the determinant of the Hessian of J, 0 if it is open."""
    slopes = (derivative(system.singular, theta=side) for side in (False, True))
    (a, b), (c, d) = (
        [box.directions.value(derivative(p, theta=side)) for side in (False, True)] for p in slopes
    )
    return (a * d - b * c).sign


def _ends(entry: Entry) -> tuple[Fraction, Fraction | None]:
    high = entry["to"]
    return exact(entry["from"], "degenerate"), None if high is None else exact(high, "degenerate")


def _high(entry: Entry, last: Fraction) -> Fraction:
    high = _ends(entry)[1]
    return last if high is None else high


def _meet(entry: Entry, part: Entry) -> bool:
    """Whether something degenerate is so throughout an interval, or in a part of it."""
    (low, high), (start, stop) = _ends(entry), _ends(part)
    return (stop is None or low < stop) and (high is None or start < high) and low != high
