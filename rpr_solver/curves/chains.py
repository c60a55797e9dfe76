"""Chains of tubes, the full certificate of cusp curves: the proof that points are joined, to be checked.

    {"chains": [{"from": {"curve": "C1", "l1": "27"}, "to": {"curve": "C1", "l1": "28"}, "tubes": [
        {"parameter": "l1", "leg": 2, "half_alpha": ["s", "c"], "half_theta": ["s", "c"], "l1": "27",
         "slopes": ["…", "…"], "bends": ["…", "…"], "reach": "…", "radii": ["…", "…"]}, …]}, …]}

A chain leads from one point of the document to another, of the same curve or, past the end at which the two
curves join, of the other one. The first tube holds the first point, each other one begins on the curve in
the tube before it, and the last one holds the last point. A tube is a
:class:`~rpr_solver.curves.short_tubes.ShortTube`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

from rpr_solver.contract import Progress
from rpr_solver.curves.cusp_curve import CurvePoint, CuspCurve
from rpr_solver.curves.destinations import Tracker
from rpr_solver.curves.follower import LostError
from rpr_solver.curves.short_tubes import ProvedTube, ShortTube, shortened
from rpr_solver.errors import Unproved
from rpr_solver.exact.rationals import exact_str
from rpr_solver.model.lengths import LengthRange

_MOST_TUBES = 1 << 13


@dataclass(frozen=True)
class _Link:
    """Two points, by their curves, that a chain is to join, and the lengths that it may not leave."""

    start: tuple[str, CurvePoint]
    stop: tuple[str, CurvePoint]
    low: Fraction
    high: Fraction
    upwards: bool

    def backwards(self) -> _Link:
        """The same between two points of one curve, from the other side."""
        return _Link(self.stop, self.start, self.low, self.high, not self.upwards)


def full_certificate(
    tracker: Tracker, curves: tuple[CuspCurve, ...], span: LengthRange, progress: Progress
) -> dict[str, Any]:
    """The member ``full``: chains between the neighbouring points of each curve, and past the ends that join.

    Raises:
        Unproved: no tubes lead from one point to the other.
    """
    leg = tracker.eliminant.slice_map.fixed_leg
    links = list(_links(curves, span))
    chains = []
    for done, link in enumerate(links):
        progress(done, len(links))
        tubes = _chain(tracker, link)
        if tubes is None and link.start[0] == link.stop[0]:
            link = link.backwards()
            tubes = _chain(tracker, link)
        if tubes is None:
            (name, point), (other, _) = link.start, link.stop
            raise Unproved(f"no tubes lead from {name} at {exact_str(point.length)} to {other}")
        ends = {
            side: {"curve": name, f"l{leg}": exact_str(point.length)}
            for side, (name, point) in (("from", link.start), ("to", link.stop))
        }
        chains.append({**ends, "tubes": [tube.to_json(leg) for tube in tubes]})
    progress(len(links), len(links))
    return {"chains": chains}


def _links(curves: tuple[CuspCurve, ...], span: LengthRange) -> Iterator[_Link]:
    by_name = {curve.name: curve for curve in curves}
    for curve in curves:
        for a, b in pairwise(curve.points):
            yield _Link((curve.name, a), (curve.name, b), a.length, b.length, upwards=True)
        for end, place, upwards in ((curve.start, 0, False), (curve.stop, -1, True)):
            other = by_name.get(end.joins or "")
            if other is None or other.name <= curve.name or not (curve.points and other.points):
                continue
            here, there, turn = curve.points[place], other.points[place], Fraction(end.length or 0)
            if here.length == there.length and turn in span:
                low, high = (here.length, 2 * turn) if upwards else (turn / 2, here.length)
                yield _Link((curve.name, here), (other.name, there), low, high, upwards)


def _chain(tracker: Tracker, link: _Link) -> list[ShortTube] | None:
    """The tubes from one point to the other; None if they lead elsewhere."""
    (_, start), (_, stop) = link.start, link.stop
    scale = tracker.eliminant.slice_map.scale
    follower = tracker.follower((start.length, start.cusp - 1), upwards=link.upwards)
    proved: list[ProvedTube] = []
    for _ in range(_MOST_TUBES):
        try:
            arrival = follower.walk(link.low * scale, link.high * scale, 0)
        except LostError:
            return None
        if arrival is not None:
            break
        assert follower.tube is not None
        before = proved[-1] if proved else None
        place = None if proved else tracker.place((start.length, start.cusp - 1), follower.bits)
        short = shortened(follower.tube, tracker.forms, follower.bits, before, place)
        if short is None:
            return None
        proved.append(short)
    else:
        return None
    last = proved[-1]
    goal = tracker.place((stop.length, stop.cusp - 1), last.bits)
    return [x.tube for x in proved] if last.contains(*goal) else None
