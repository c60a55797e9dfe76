"""From a polyline to a short, smooth, proved route."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import degrees

from flint import ctx

from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.arcs import Arc
from rpr_solver.paths.isolated import IsolatedPose
from rpr_solver.paths.path_limits import NO_LIMITS, PathLimits
from rpr_solver.paths.proofs import PathProof, ProvedRoute, prove
from rpr_solver.paths.proved import PROOF_BITS
from rpr_solver.paths.route import ControlPoint, Route

Corner = tuple[float, float, Fraction]
"""α and θ in radians, and the fixed length in the user's unit."""

_PLACES = 10**7
_ROUNDINGS = (Fraction(1, 2), Fraction(1, 4), Fraction(1, 16))


@dataclass(frozen=True)
class Straightener:
    """Makes routes of polylines, on which J has one sign and the free legs keep their limits."""

    slice_map: SliceMap
    sign: int
    limits: PathLimits = NO_LIMITS

    def route(self, start: IsolatedPose, stop: IsolatedPose, corners: Sequence[Corner]) -> ProvedRoute | None:
        """A proved route along a polyline, its ends included, which are the poses; None without a proof."""
        points = [ControlPoint(_decimal(a), _decimal(t), length) for a, t, length in corners[1:-1]]
        inner: list[ControlPoint | None] = [None, *points, None]
        ends = start, stop
        pulled = self._pulled(ends, inner)
        if pulled is None:
            return None
        for share in _ROUNDINGS:
            smooth = Route(*ends, _rounded(pulled, share))
            proof = self._proof(smooth)
            if proof is not None:
                return smooth, proof
        plain = Route(*ends, tuple(pairwise(pulled)))
        proof = self._proof(plain)
        return None if proof is None else (plain, proof)

    def _pulled(
        self, ends: tuple[IsolatedPose, IsolatedPose], corners: Sequence[ControlPoint | None]
    ) -> list[ControlPoint | None] | None:
        """Few of the corners, so that J keeps its sign on the straight lines between them."""
        kept, at, last = [corners[0]], 0, len(corners) - 1
        while at < last:
            reach = last
            while reach > at + 1 and not self._is_free(ends, corners, at, reach):
                reach = at + max(1, (reach - at) * 2 // 3)
            if reach == at + 1 and not self._is_free(ends, corners, at, reach):
                return None
            kept.append(corners[reach])
            at = reach
        return kept

    def _is_free(
        self,
        ends: tuple[IsolatedPose, IsolatedPose],
        corners: Sequence[ControlPoint | None],
        first: int,
        last: int,
    ) -> bool:
        with ctx.workprec(PROOF_BITS):
            points = []
            for k in (first, last):
                corner = corners[k]
                if corner is None:
                    pose = ends[0] if k == 0 else ends[1]
                    points.append((*pose.angles, ball_of(pose.legs[0])))
                else:
                    points.append(corner.point(self.slice_map.scale))
            at_ends = first == 0, last == len(corners) - 1
            arcs = [Arc.over(points)]
            return prove(self.slice_map, arcs, self.sign, limits=self.limits, at_ends=at_ends) is not None

    def _proof(self, route: Route) -> PathProof | None:
        with ctx.workprec(PROOF_BITS):
            return prove(self.slice_map, route.at(PROOF_BITS - 64), self.sign, limits=self.limits)


def _rounded(
    corners: Sequence[ControlPoint | None], share: Fraction
) -> tuple[tuple[ControlPoint | None, ...], ...]:
    """Bézier arcs round the corners, each of which begins and ends at this share of the edges."""
    if len(corners) <= 3:
        return (tuple(corners),)
    arcs: list[tuple[ControlPoint | None, ...]] = []
    last: ControlPoint | None = None
    for corner, following in pairwise(corners[1:-1]):
        cut = _between(corner, following, share)
        arcs.append((last, corner, cut))
        last = cut
        if share < Fraction(1, 2):
            last = _between(following, corner, share)
            arcs.append((cut, last))
    return (*arcs, (last, corners[-2], None))


def _between(first: ControlPoint | None, second: ControlPoint | None, share: Fraction) -> ControlPoint:
    assert first is not None, "only the ends are poses"
    assert second is not None, "only the ends are poses"
    return ControlPoint(
        first.alpha_deg + share * (second.alpha_deg - first.alpha_deg),
        first.theta_deg + share * (second.theta_deg - first.theta_deg),
        first.length + share * (second.length - first.length),
    )


def _decimal(angle: float) -> Fraction:
    """An angle in degrees, as a decimal."""
    return Fraction(round(degrees(angle) * _PLACES), _PLACES)
