"""Paths and poses of all manipulators whose six lengths are within a tolerance, in balls of doubles.

A path that changes the assembly mode of the given manipulator is, in its angles, a path of each other one.
On it J keeps its sign for all of them, which boxes prove. At its end a neighbour has other leg lengths than
at its start, but a pose with those is near by: with Y near the inverse of the derivative of both legs, the
map x ↦ x − Y (legs at x − legs at the start) takes a box round the end into itself for every manipulator
(mathematics.md#zeros-in-boxes). That box has J ≠ 0 as well, so that each manipulator goes on to that pose
(mathematics.md#paths-of-neighbours).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from flint import arb, ctx

from rpr_solver.boxes.balls import UP, Balls
from rpr_solver.exact.numerals import double
from rpr_solver.exact.plane import PlaneNumber
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.legs import free_points
from rpr_solver.margins.problems import validity
from rpr_solver.margins.systems import orientation_of, third_corner
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.lengths import Bounds
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.corridors import Corridors
from rpr_solver.paths.pose_boxes import LegsInBalls, PoseBoxes, unit_of
from rpr_solver.paths.pose_grid import degrees_of
from rpr_solver.paths.proofs import NO_BOUNDS
from rpr_solver.paths.routes import EndPose, Route
from rpr_solver.paths.widest import on_arc

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

_BITS = 128
_SLACK = 1e-9
"""Degrees and units: more than the rounding of a control point in doubles."""
_ROUNDED = 1e-14
"""More than the rounding of a length in units."""
_LONGEST = 0.5
"""Degrees: pieces of a path are at most about so long, so that few boxes are needed round each."""
_MOST_PIECES, _MOST_BOXES = 4_000, 400_000
_CUTS = 7
"""How often boxes are quartered."""
_STEPS, _ROUNDS, _WIDER = 3, 6, 1.2
"""Of Newton's method, and trials of boxes round what it finds, each so much wider than the last image."""
_FLAT = 1e-12
_RADIANS = np.pi / 180


Gaps = Callable[["Doubles"], "tuple[Balls, Doubles | None]"]
"""Two functions at a spot, for all manipulators, and about the inverse of their derivatives by angles."""


class Chords(NamedTuple):
    """A path as chords between spots, by α and θ in degrees and lengths in units, and by how much it strays
    from each, by its angles together and by its length."""

    first: Doubles
    last: Doubles
    sag: Doubles
    lift: Doubles


@dataclass(frozen=True)
class Neighbours:
    """All manipulators whose lengths differ from given ones by at most a tolerance.

    Attributes:
        manipulator: the given one.
        slice_map: of it and its fixed leg.
        unit: of scaled lengths.
        lengths: the least and the greatest value of each of its lengths, in the user's unit.
        is_part: whether these are a part of what is asked for.
    """

    manipulator: Manipulator
    slice_map: SliceMap
    unit: Fraction
    lengths: tuple[tuple[Fraction, Fraction], ...]
    is_part: bool = False

    @classmethod
    def of(
        cls, manipulator: Manipulator, slice_map: SliceMap, tolerance: tuple[Fraction, ...], most: Fraction
    ) -> Neighbours | None:
        """For scaled lengths of the fixed leg up to ``most``; None if one of them is flat, or none at all."""
        radius = validity(manipulator, tolerance)
        if radius is not None and radius <= 1:
            return None
        # a power of two beyond all vectors of all of them
        unit = 2 * unit_of(slice_map, max(most, 4 * max(tolerance) * slice_map.scale))
        ends = zip(manipulator.bounds(), tolerance, strict=True)
        lengths = tuple((low - more, high + more) for (low, high), more in ends)
        return cls(manipulator, slice_map, unit, lengths)

    def parts(self) -> Iterator[Neighbours]:
        """The same in parts: with the lower or the upper half of each length."""
        halves = [
            [(low, high)] if low == high else [(low, (low + high) / 2), ((low + high) / 2, high)]
            for low, high in self.lengths
        ]
        for lengths in product(*halves):
            yield replace(self, lengths=lengths, is_part=True)

    def sum_over(self, proof: Callable[[Neighbours], int | None]) -> int | None:
        """The number of steps of a proof for all of them together, or for each part; None if it fails."""
        tests = proof(self)
        if tests is not None:
            return tests
        tests = 0
        for part in self.parts():
            own = proof(part)
            if own is None:
                return None
            tests += own
        return tests

    @cached_property
    def legs(self) -> LegsInBalls:
        """The free legs of all, in the unit."""
        with ctx.workprec(_BITS):
            factor = ball_of(Fraction(self.slice_map.scale) / self.unit)
            own = [
                arb(ball_of((low + high) / 2), ball_of((high - low) / 2).upper()) * factor
                for low, high in self.lengths
            ]
            a2x, a3x, a3y, *sides = own
            corner = third_corner(sides, orientation_of(self.manipulator))
            points = free_points((a2x, a3x, a3y), (sides[0], *corner), self.slice_map.fixed_leg, arb(0))
            return LegsInBalls.around(points)

    @property
    def around(self) -> tuple[Fraction, LegsInBalls]:
        """The unit and the legs, as proofs of folds take them."""
        return self.unit, self.legs

    def keeps(self, route: Route, sign: int, bounds: Mapping[int, Bounds], clearance: Fraction) -> bool:
        """Whether all have J of this sign along a path, as far as a clearance in degrees, keep the limits of
        the free legs, and come from its start to a pose of the same legs, from which it differs, along it.

        The path begins and ends with one joint vector of the given manipulator. What is not proved for all
        together may be for parts of them.
        """
        pieces = self._pieces(route)
        if pieces is None:
            return False

        def holds(some: Neighbours) -> bool:
            return some._keeps(pieces, sign, bounds, double(clearance))

        with np.errstate(all="ignore"):  # what is no number proves nothing
            return holds(self) or all(map(holds, self.parts()))

    def joins(self, route: Route, sign: int, bounds: Mapping[int, Bounds], clearance: Fraction) -> bool:
        """Whether for all of them such a path joins a pose with the leg lengths of its start, which are
        exact, to one with those of its end, each near to that of the given manipulator."""
        pieces = self._pieces(route)
        if pieces is None:
            return False

        def holds(some: Neighbours) -> bool:
            return some._joins(pieces, (route.start, route.stop), sign, bounds, double(clearance))

        with np.errstate(all="ignore"):  # what is no number proves nothing
            return holds(self) or all(map(holds, self.parts()))

    def sign_near(self, pose: EndPose) -> int:
        """The sign of J that all have at their poses with the legs of a pose of the given one, near to it; 0
        if that is not proved."""
        spot = np.array([*degrees_of(pose), double(pose.legs[0] / self.unit)])

        def sign(some: Neighbours) -> int:
            if (found := some._pose_near(pose, spot)) is None:
                return 0
            centre, reach = found
            away = np.array([reach, reach, 0.0])
            own = some._poses((centre - away)[None], (centre + away)[None])
            value = own.over(*own.singularity)
            return int(np.sign(value.mid[0])) if value.excludes_zero[0] else 0

        with np.errstate(all="ignore"):  # what is no number proves nothing
            if together := sign(self):
                return together
            signs = set(map(sign, self.parts()))
        return signs.pop() if len(signs) == 1 else 0

    def _joins(
        self,
        pieces: Chords,
        poses: tuple[EndPose, EndPose],
        sign: int,
        bounds: Mapping[int, Bounds],
        clearance: float,
    ) -> bool:
        first, last, sag, lift = pieces
        for pose, spot in zip(poses, (first[0], last[-1]), strict=True):
            if (end := self._pose_near(pose, spot)) is None:
                return False
            centre, reach = end
            first, last = np.concatenate([first, spot[None]]), np.concatenate([last, centre[None]])
            sag, lift = np.append(sag, reach), np.append(lift, _ROUNDED)
        chords = Chords(first, last, sag, lift)
        return self._keep_limits(chords, bounds) and self._is_clear(chords, sign, clearance)

    def _pose_near(self, pose: EndPose, spot: Doubles) -> tuple[Doubles, float] | None:
        """A spot, and how far from it, in degrees, each manipulator has a pose with the legs of a pose of
        the given one; None if that is not proved."""
        legs = pose.legs[1:]
        if any(leg is None for leg in legs):
            return None
        heights = [double((leg / self.unit) ** 2 / 2) for leg in legs if leg is not None]

        def gaps(place: Doubles) -> tuple[Balls, Doubles | None]:
            own = self._poses(place[None], place[None])
            (sin_a, cos_a), (sin_t, cos_t), number = *(x.sin_cos() for x in own.sides[:2]), own.sides[2]
            found = []
            for waves, height in zip(self.legs.waves, heights, strict=True):
                m, back = waves.both, waves.base
                x = number * cos_t + m.real * cos_a - m.imag * sin_a - back.real
                y = number * sin_t + m.real * sin_a + m.imag * cos_a + back.imag
                found.append((x * x + y * y) * 0.5 - Balls(np.array([height]), np.array([1e-15])))
            matrix = np.array([[rise.mid[0] for rise in leg.rise[:2]] for leg in own.legs])
            if not np.isfinite(matrix).all() or abs(np.linalg.det(matrix)) < _FLAT:
                return Balls.joined(found), None
            return Balls.joined(found), np.linalg.inv(matrix)

        return self._zero_near(gaps, spot)

    def _keeps(self, pieces: Chords, sign: int, bounds: Mapping[int, Bounds], clearance: float) -> bool:
        first, last, sag, lift = pieces
        if (end := self._end(first[0], last[-1])) is None:
            return False
        # from the end of the path on to the poses of all
        centre, reach = end
        chords = Chords(
            np.concatenate([first, last[-1:]]),
            np.concatenate([last, centre[None]]),
            np.append(sag, reach),
            np.append(lift, _ROUNDED),
        )
        return self._keep_limits(chords, bounds) and self._is_clear(chords, sign, clearance)

    def _pieces(self, route: Route) -> Chords | None:
        """Chords of the path; None if there are too many."""
        span = (route.start.legs[0], route.start.legs[0])
        corridors = Corridors.of((route.start, route.stop), span, 1)
        controls, factor = corridors.controls(route), double(corridors.grid.field.unit / self.unit)
        firsts, lasts, sags, lifts = [], [], [], []
        for points in controls:
            own = points * [1.0, 1.0, factor]
            bend = np.abs(own[0] - 2 * own[1] + own[2]) / 4 if len(own) == 3 else np.zeros(3)
            far = np.abs(np.diff(own, axis=0))[:, :2].sum() + np.abs(np.diff(own, axis=0))[:, 2].sum() * 60
            parts = int(max(1, np.ceil(far / _LONGEST)))
            spots = on_arc(own, parts)
            firsts.append(spots[:-1])
            lasts.append(spots[1:])
            sags.append(np.full(parts, float(np.hypot(*bend[:2])) / parts**2 + _SLACK))
            lifts.append(np.full(parts, float(bend[2]) / parts**2 + _ROUNDED))
        first, last, sag, lift = (np.concatenate(x) for x in (firsts, lasts, sags, lifts))
        return Chords(first, last, sag, lift) if len(first) <= _MOST_PIECES else None

    def _poses(self, low: Doubles, high: Doubles) -> PoseBoxes:
        """Boxes between corners, by α and θ in degrees and lengths in units."""
        scale = np.array([_RADIANS, _RADIANS, 1.0])
        middles = (low + high) / 2 * scale
        halves = (high - low) / 2 * scale * UP + _ROUNDED
        return PoseBoxes.of(self.legs, list(middles.T), list(halves.T))

    def _end(self, start: Doubles, stop: Doubles) -> tuple[Doubles, float] | None:
        """A spot, and how far from it, in degrees, each manipulator has a pose with the legs of the start of
        a path; None if that is not proved, or the poses may be those of the start."""
        found = self._zero_near(lambda place: self._gaps(start, place), stop)
        if found is None:
            return None
        centre, reach = found
        away = abs((centre - start)[:2]) % 360
        return found if (np.minimum(away, 360 - away) > reach).any() else None

    def _zero_near(self, gaps_at: Gaps, spot: Doubles) -> tuple[Doubles, float] | None:
        """A spot, and how far from it, in degrees, each manipulator has a zero of two functions that
        differ from the half squares of its legs by constants; None if that is not proved."""
        centre = spot
        for _ in range(_STEPS):
            gaps, inverse = gaps_at(centre)
            if inverse is None:
                return None
            centre = centre - np.array([*(inverse @ gaps.mid) / _RADIANS, 0.0])
        gaps, inverse = gaps_at(centre)
        if inverse is None:
            return None
        residue = abs(inverse) @ (abs(gaps.mid) + gaps.rad) * UP + 1e-14
        radius = _WIDER * residue
        for _ in range(_ROUNDS):
            reach = np.array([*radius / _RADIANS + _SLACK, 0.0])
            box = self._poses((centre - reach)[None], (centre + reach)[None])
            # legs at x less legs at the centre are means of slopes times x less the centre
            means = [box.value(leg)[1][:2] for leg in (0, 1)]
            middles = np.array([[x.mid[0] for x in row] for row in means])
            radii = np.array([[x.rad[0] for x in row] for row in means])
            spread = abs(np.eye(2) - inverse @ middles) + abs(inverse) @ radii + 1e-12
            image = (residue + spread @ radius) * UP + 1e-14
            if not np.isfinite(image).all():
                return None
            if (image < radius).all():
                return centre, float(np.hypot(*reach[:2]))
            radius = _WIDER * image
        return None

    def _gaps(self, start: Doubles, stop: Doubles) -> tuple[Balls, Doubles | None]:
        """Half squares of both legs at one spot less those at another, and about the inverse of their
        derivatives by angles; None if that is singular."""
        slack = np.array([_SLACK, _SLACK, 0.0])
        ends = self._poses(np.array([start - slack, stop - slack]), np.array([start + slack, stop + slack]))
        # waves times differences of their turns, so that what all manipulators have in common cancels
        alpha, theta, number = ends.sides
        steps = []
        for angle in (alpha - theta, theta, alpha):
            sin, cos = angle.sin_cos()
            steps.append(PlaneNumber(cos[1:] - cos[:1], sin[1:] - sin[:1]))
        gaps = Balls.joined([waves.turned(*steps).value(number[1:]) for waves in self.legs.waves])
        matrix = np.array([[rise.mid[1] for rise in leg.rise[:2]] for leg in ends.legs])
        if not np.isfinite(matrix).all() or abs(np.linalg.det(matrix)) < _FLAT:
            return gaps, None
        return gaps, np.linalg.inv(matrix)

    def _is_clear(
        self,
        pieces: Chords,
        sign: int,
        clearance: float,
    ) -> bool:
        """Whether J has this sign for all manipulators at all poses that are at most so far, in degrees, from
        the pieces.

        Boxes round each piece are quartered until J has the sign on each, or it is too far from the piece.
        """
        first, last, sag, lift = pieces
        shortest = np.minimum(first[:, 2], last[:, 2]) - lift
        longest = np.maximum(first[:, 2], last[:, 2]) + lift
        reach = (sag + clearance * (1 + 1e-12) + _SLACK)[:, None]
        low = np.minimum(first, last)[:, :2] - reach
        high = np.maximum(first, last)[:, :2] + reach
        owner = np.arange(len(first))
        done = 0
        # Invariant: J has the sign at all poses near the pieces but for those in the boxes that are left.
        # It ends after so many cuts, or boxes.
        for _ in range(_CUTS):
            done += len(owner)
            if done > _MOST_BOXES:
                return False
            own = self._poses(
                np.column_stack([low, shortest[owner]]), np.column_stack([high, longest[owner]])
            )
            value = own.over(*own.singularity)
            left = ~(value.excludes_zero & (value.mid * sign > 0))
            if not left.any():
                return True
            low, high, owner = low[left], high[left], owner[left]
            middle = (low + high) / 2
            quarters = []
            for x in (0, 1):
                for y in (0, 1):
                    a = np.where([bool(x), bool(y)], middle, low)
                    b = np.where([bool(x), bool(y)], high, middle)
                    quarters.append((a, b, owner))
            low, high, owner = (np.concatenate(part) for part in zip(*quarters, strict=True))
            near = self._distance(low, high, first[owner], last[owner]) <= reach[owner, 0]
            low, high, owner = low[near], high[near], owner[near]
        return not len(owner)

    @staticmethod
    def _distance(low: Doubles, high: Doubles, first: Doubles, last: Doubles) -> Doubles:
        """Lower bounds of the distances of boxes from chords, in degrees."""
        middle, half = (low + high) / 2, np.hypot(*((high - low) / 2).T)
        along = (last - first)[:, :2]
        square = np.maximum((along**2).sum(1), 1e-30)
        away = middle - first[:, :2]
        share = np.clip((away * along).sum(1) / square, 0, 1)[:, None]
        found: Doubles = np.hypot(*(away - share * along).T) - half * (1 + 1e-9) - 1e-9
        return found

    def _keep_limits(self, pieces: Chords, bounds: Mapping[int, Bounds]) -> bool:
        """Whether the free legs keep their limits on the pieces, for all manipulators."""
        first, last, sag, lift = pieces
        reach = np.column_stack([sag, sag, lift])
        own = self._poses(np.minimum(first, last) - reach, np.maximum(first, last) + reach)
        scale = self.slice_map.scale / self.unit
        number = own.sides[2]
        for leg, of in enumerate(free_legs(self.slice_map.fixed_leg)):
            low, high = bounds.get(of, NO_BOUNDS)
            if low is None and high is None:
                continue
            value = own.over(*own.value(leg))
            constant = self.legs.constants[leg]
            half_square = number * number * 0.5
            least, most = (value + half_square + constant).ends()
            if low is not None and not (least > double((low * scale) ** 2 / 2) * UP).all():
                return False
            if high is not None and not (most < double((high * scale) ** 2 / 2) / UP).all():
                return False
        return True
