"""Paths from pose to pose that keep joint limits.

First the route without limits is tried. If it exceeds them, a subdivision looks for another one, or proves
that there is none.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from flint import ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.lengths import Bounds
from rpr_solver.paths.arcs import Arc, Point
from rpr_solver.paths.boxes import Boxes, Place
from rpr_solver.paths.isolated import IsolatedPose, Legs
from rpr_solver.paths.joint_paths import straightened
from rpr_solver.paths.no_path import Resolution
from rpr_solver.paths.path_limits import PathLimits
from rpr_solver.paths.proofs import ProvedRoute, prove
from rpr_solver.paths.proved import PROOF_BITS
from rpr_solver.paths.straightened import Corner
from rpr_solver.paths.subdivision import Outcome, search

_INWARDS = [Fraction(1, 10**k) for k in range(2, 9)]


@dataclass(frozen=True)
class LimitedSearch:
    """The search for a path between two poses of a joint vector within limits.

    Attributes:
        sign: that of J at both poses.
        start: the first pose.
        stop: the second pose.
        limits: of the free legs; the joint vector keeps them.
        span: the scaled lengths between which the fixed leg may move, both the same if it is held.
    """

    sign: int
    start: IsolatedPose
    stop: IsolatedPose
    limits: PathLimits
    span: tuple[Fraction, Fraction]

    @classmethod
    def of(
        cls,
        start: IsolatedPose,
        stop: IsolatedPose,
        sign: int,
        bounds: Mapping[int, Bounds],
        span: tuple[Fraction, Fraction] | None,
    ) -> LimitedSearch:
        """The search with limits by the legs' numbers and the range of the fixed leg, in the user's unit."""
        slice_map, length = start.slice_map, start.legs[0]
        ends = (length, length) if span is None else (span[0] * slice_map.scale, span[1] * slice_map.scale)
        return cls(sign, start, stop, PathLimits.of(slice_map, bounds, start.legs), ends)

    def kept_by(self, found: ProvedRoute | None) -> ProvedRoute | None:
        """A route with its proof that it keeps the limits, too; None without a proof."""
        if found is None:
            return None
        route, _ = found
        with ctx.workprec(PROOF_BITS):
            arcs = route.at(PROOF_BITS - 64)
            proof = prove(route.slice_map, arcs, self.sign, limits=self.limits)
        return None if proof is None else (route, proof)

    def found(self) -> ProvedRoute | Outcome:
        """A proved route, or the outcome of the subdivision that found none.

        Raises:
            Unproved: there is a path, but it could not be proved; or an end is too near to what is excluded.
        """
        slice_map = self.start.slice_map
        inner = [self._inside(pose) for pose in (self.start, self.stop)]
        # a route in the slice is found sooner than one in the range
        spans = dict.fromkeys([(self.start.legs[0], self.start.legs[0]), self.span])
        for span in spans:
            outcome = search(self._boxes(span), *(_place(pose) for pose in inner))
            if outcome.way is not None:
                break
        if outcome.way is None:
            return outcome
        corners: list[Corner] = [(a, t, length / slice_map.scale) for a, t, length in outcome.way]
        if inner[0] is not self.start:
            corners = [corners[0], *corners, corners[-1]]
        return straightened(slice_map, self.sign, self.start, self.stop, corners, self.limits)

    def resolution(self, outcome: Outcome) -> Resolution:
        """The size of the smallest boxes of an outcome."""
        size = (self.span[1] - self.span[0]) / self.start.slice_map.scale
        length = size / self._boxes(self.span).lengths(outcome.level) if size else None
        return Resolution(Fraction(360, 1 << outcome.level), length)

    def _boxes(self, span: tuple[Fraction, Fraction]) -> Boxes:
        return Boxes(self.start.slice_map, self.sign, self.limits, *span)

    def _inside(self, pose: IsolatedPose) -> IsolatedPose:
        """A pose that is not on a limit, and is joined to this one by a straight line within the limits."""
        if not any(wall.is_touched for wall in self.limits.walls):
            return pose
        for share in _INWARDS:
            with ctx.workprec(PROOF_BITS):
                inner = IsolatedPose.near(pose.slice_map, self._shifted(pose.legs, share), pose.angles)
                if inner is not None:
                    arc = Arc.over([_point(pose), _point(inner)])
                    at_ends = True, False
                    if prove(pose.slice_map, [arc], self.sign, limits=self.limits, at_ends=at_ends):
                        return inner
        raise Unproved("no way from a limit inwards could be proved")

    def _shifted(self, legs: Legs, share: Fraction) -> Legs:
        """Leg lengths changed by this share of them, away from the limits on which they lie."""
        fixed, *free = legs
        for wall in self.limits.walls:
            if wall.is_touched:
                free[wall.leg] *= 1 - wall.side * share
        return fixed, free[0], free[1]


def _place(pose: IsolatedPose) -> Place:
    return *pose.angles, pose.legs[0]


def _point(pose: IsolatedPose) -> Point:
    return *pose.angles, ball_of(pose.legs[0])
