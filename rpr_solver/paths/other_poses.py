"""Other poses of the joint vector of a path, which its leg lengths carry along: each is followed in tubes to
the end, or to the fold at which it vanishes.

While the legs take the lengths of a path q(τ), another pose p of the same joint vector follows by
F(p) = F(q(τ)): a curve in (α, θ, τ). Along it a parabola ẑ(r), r being the coordinate along the tangent,
approximates the curve on a piece, and if A is the inverse of the derivative D of F(p) − F(q(τ)) in the two
directions across, at the middle, and

    |A (F(p̂(r)) − F(q(τ̂(r))))| + |1 − A D| ρ < ρ        for all r of the piece, D over the radii ρ,

then for each r there is exactly one point of the curve within ρ of the parabola (Krawczyk's test). The
pose exists as long as J ≠ 0. Where the curve crosses J = 0 it turns back in τ: this is a fold, on which the
pose meets another one, and both end (mathematics.md#followed-poses).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from flint import arb, arb_mat, arb_poly, ctx

from rpr_solver.boxes.krawczyk import Slopes, Two, contracting_radii
from rpr_solver.boxes.newton import alone_near, newton_image
from rpr_solver.boxes.systems import Box
from rpr_solver.exact.decimals import digit_bits, round_all
from rpr_solver.model.pose_table import PoseTable
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.notebook import shortened
from rpr_solver.paths.path_poses import PathPose, isolated, numbered, of_table
from rpr_solver.paths.routes import (
    Angles,
    Arc,
    Expansion,
    Image,
    IsolatedPose,
    Legs,
    Route,
    bounded,
    by_leg,
    expanded,
    local_map,
    newton_step,
)
from rpr_solver.paths.samples import wrapped

Triple = tuple[arb, arb, arb]
"""α, θ and τ; or a direction in their space."""


@dataclass(frozen=True)
class Carrier:
    """F(p) = F(q(τ)): the curve of the poses p = (α, θ) that the legs of one arc q carry along."""

    slice_map: SliceMap
    arc: Arc

    def slopes(self, box: Triple) -> tuple[Triple, Triple, Triple]:
        """The derivatives of F(p) − F(q(τ)) and of J(p) / L by α, θ and τ, over a box."""
        alpha, theta, tau = box
        length = self.arc.length(tau)
        local = local_map(self.slice_map, length, (alpha, theta), 2)
        j = local.singularity()
        still, leading = self._both(box, 1)
        return (
            (local.f.alpha.value, local.f.theta.value, still.first[1] - leading.first[1]),
            (local.g.alpha.value, local.g.theta.value, still.second[1] - leading.second[1]),
            (j.alpha.value / length, j.theta.value / length, still.singularity[1]),
        )

    def residue(self, hat: Sequence[arb_poly], at: arb, order: int) -> list[Two]:
        """The coefficients of F(p̂(r)) − F(q(τ̂(r))) at one r, for a curve (p̂, τ̂)(r)."""
        tau = hat[2]
        leading = Arc(self.arc.alpha(tau), self.arc.theta(tau), self.arc.length(tau))
        x, y = (expanded(self.slice_map, arc, at, order) for arc in (self.pose(hat), leading))
        return [(x.first[k] - y.first[k], x.second[k] - y.second[k]) for k in range(order + 1)]

    def pose(self, hat: Sequence[arb_poly]) -> Arc:
        """The pose along a curve."""
        return Arc(hat[0], hat[1], self.arc.length(hat[2]))

    def singularity(self, place: Triple) -> arb:
        """J at a place."""
        length = self.arc.length(place[2])
        return local_map(self.slice_map, length, (place[0], place[1]), 1).singularity().value

    def arrival(self, near: Angles) -> Angles | None:
        """The pose at τ = 1 near a place, as a small ball; None without a proof."""
        at = expanded(self.slice_map, self.arc, arb(1), 0)
        step = newton_step(self.slice_map, self.arc.length(arb(1)), (at.first[0], at.second[0]))
        found = alone_near(step, near, (arb(1), arb(1)))
        return None if found is None else (found.at[0], found.at[1])

    def fold(self, ends: tuple[Triple, Triple]) -> Triple | None:
        """A fold between two places of the curve, as a small ball; None without a proof."""
        first, last = (self.singularity(place) for place in ends)
        share = first / (first - last)

        def step(point: Box, box: Box) -> Box | None:
            """For F(p) = F(q(τ)), J(p) = 0."""
            still, leading = self._both(_triple(point), 0)
            gap = still.first[0] - leading.first[0], still.second[0] - leading.second[0]
            return newton_image(point, (*gap, still.singularity[0]), self.slopes(_triple(box)))

        start = [x + share * (y - x) for x, y in zip(*ends, strict=True)]
        found = alone_near(step, start, (arb(1), arb(1), arb(1)))
        return None if found is None else _triple(found.at)

    def _both(self, place: Triple, order: int) -> tuple[Expansion, Expansion]:
        """The expansions at τ of a pose whose angles stay, and of the path."""
        alpha, theta, tau = place
        still = Arc(arb_poly([alpha]), arb_poly([theta]), self.arc.length(arb_poly([tau, 1])))
        return (
            expanded(self.slice_map, still, arb(0), order),
            expanded(self.slice_map, self.arc, tau, order),
        )

    def image_gap(self, place: Triple) -> Image:
        """F(p) − F(q(τ))."""
        still, leading = self._both(place, 0)
        return still.first[0] - leading.first[0], still.second[0] - leading.second[0]


def within(carrier: Carrier, origin: Triple, across: tuple[Triple, Triple], radii: Two) -> Triple | None:
    """The point of the curve in a plane near a place, as a small ball; None without a proof or outside."""

    def at(w: Box) -> Triple:
        return _triple(o + w[0] * a + w[1] * b for o, a, b in zip(origin, *across, strict=True))

    def step(point: Box, box: Box) -> Box | None:
        slopes = [[_dot(row, n) for n in across] for row in carrier.slopes(at(box))[:2]]
        return newton_image(point, carrier.image_gap(at(point)), slopes)

    found = alone_near(step, (arb(0), arb(0)), radii)
    return None if found is None else at(found.at)


_FIRST_STEP = 0.125
"""The first reach of a tube in (α, θ, τ), in radians for angles; those that follow are found by trial."""
_LARGEST_STEP = 0.5
"""The greatest reach."""
_SMALLEST_STEP = 2.0**-20
"""The least reach: a pose that needs a shorter tube is given up."""
_LONGER = 1.2
"""By how much the reach grows after a tube that was proved."""
_SHORTER = 0.6
"""By how much it falls after one that was not."""
_MOST_PIECES = 200
"""Trials along one arc, after which a pose is given up."""


@dataclass(frozen=True)
class Followed:
    """A pose that was followed: where it is at the end, or the fold at which it vanishes before.

    ``fold`` has the arc's number, and α, θ and τ there. Both are None if the pose could be followed neither
    to the end nor to a fold.
    """

    end: Angles | None = None
    fold: tuple[int, Triple] | None = None


def follow(slice_map: SliceMap, arcs: Sequence[Arc], start: Angles) -> Followed:
    """Follows a pose, a small ball, of the joint vector at which the arcs begin.

    The working precision is that of the caller.
    """
    angles = start
    for number, arc in enumerate(arcs):
        outcome = _along(Carrier(slice_map, arc), angles)
        if outcome is None:
            return Followed()
        if outcome.is_fold:
            return Followed(fold=(number, outcome.place))
        angles = outcome.place[0], outcome.place[1]
    return Followed(end=angles)


@dataclass(frozen=True)
class _Outcome:
    """The end of an arc, or a fold before it."""

    place: Triple
    is_fold: bool


def _along(carrier: Carrier, angles: Angles) -> _Outcome | None:
    # Invariant: ``place`` holds the point of the curve of the pose up to which it was followed. It ends after
    # some trials; without an outcome nothing is known of the pose from there on.
    place: Triple = (*angles, arb(0))
    step, backwards = _FIRST_STEP, None
    for _ in range(_MOST_PIECES):
        tube = _Tube.built(carrier, place, arb(step), backwards)
        outcome = None if tube is None else tube.outcome(place)
        if tube is None or outcome is None:
            step *= _SHORTER
            if step < _SMALLEST_STEP:
                return None
            continue
        if outcome.is_fold or outcome.place[2].is_exact():
            return outcome
        place, backwards = outcome.place, tube.tangent
        step = min(_LONGER * step, _LARGEST_STEP)
    return None


@dataclass(frozen=True)
class _Tube:
    """The points within ``radii``, across, of the parabola for 0 ≤ r ≤ ``reach``: one for each r."""

    carrier: Carrier
    hat: tuple[arb_poly, arb_poly, arb_poly]
    tangent: Triple
    across: tuple[Triple, Triple]
    reach: arb
    radii: Two
    lives: bool
    """Whether J ≠ 0 everywhere in the tube."""

    @classmethod
    def built(cls, carrier: Carrier, place: Triple, reach: arb, last: Triple | None) -> _Tube | None:
        """The tube from a place on, in the direction of the last tangent, or else of increasing τ."""
        origin = _triple(x.mid() for x in place)
        rows = carrier.slopes(origin)[:2]
        tangent = _cross(rows[0], rows[1])
        size = _dot(tangent, tangent).sqrt()
        along = tangent[2] if last is None else _dot(tangent, last)
        if size.contains(0) or along.contains(0):
            return None
        size = size if along > 0 else -size
        t = _triple((x / size).mid() for x in tangent)
        across = _across(t, rows)
        try:
            inverse = arb_mat([[_dot(row, n) for n in across] for row in rows]).inv().mid()
        except ZeroDivisionError:
            return None
        straight = [arb_poly([x, d]) for x, d in zip(origin, t, strict=True)]
        bend = inverse * arb_mat([[x] for x in carrier.residue(straight, arb(0), 2)[2]])
        hat = [
            p - arb_poly([0, 0, (bend[0, 0] * a + bend[1, 0] * b).mid()])
            for p, a, b in zip(straight, *across, strict=True)
        ]
        return cls._proved(carrier, (hat[0], hat[1], hat[2]), t, across, inverse, reach)

    @classmethod
    def _proved(
        cls,
        carrier: Carrier,
        hat: tuple[arb_poly, arb_poly, arb_poly],
        tangent: Triple,
        across: tuple[Triple, Triple],
        inverse: arb_mat,
        reach: arb,
    ) -> _Tube | None:
        middle = half = reach / 2
        piece = arb(middle, half)
        near, wide = carrier.residue(hat, middle, 2), carrier.residue(hat, piece, 3)
        errors = [
            sum((abs(near[k][i]) * half**k for k in range(3)), arb(0)) + abs(wide[3][i]) * half**3
            for i in range(2)
        ]
        floor = arb(2) ** -(ctx.prec // 2)
        least = [
            sum((abs(inverse[i, k]) * errors[k] for k in range(2)), arb(0)).abs_upper() + floor
            for i in range(2)
        ]
        rows: tuple[Triple, Triple, Triple] | None = None

        def slopes_over(radii: Two) -> Slopes:
            nonlocal rows
            rows = carrier.slopes(_place(hat, across, piece, (arb(0, radii[0]), arb(0, radii[1]))))
            a, b, c, d = (
                abs(sum((inverse[i, m] * _dot(rows[m], n) for m in range(2)), arb(0)) - (i == k))
                for i in range(2)
                for k, n in enumerate(across)
            )
            return (a, b), (c, d)

        radii, _ = contracting_radii((least[0], least[1]), (2 * least[0], 2 * least[1]), slopes_over)
        if radii is None or rows is None:
            return None
        pose = carrier.pose(hat)
        at, over = (expanded(carrier.slice_map, pose, x, k) for x, k in ((middle, 1), (piece, 2)))
        slack = sum((abs(_dot(rows[2], n)) * r for n, r in zip(across, radii, strict=True)), arb(0))
        j = bounded(at.singularity, over.singularity, half) + arb(0, slack.abs_upper())
        return cls(carrier, hat, tangent, across, reach, radii, not j.contains(0))

    def outcome(self, start: Triple) -> _Outcome | None:
        """What follows: the end of the arc, a fold, or another place; None if it is not decided."""
        if not self.contains(start):
            return None
        end = self._at(self.reach)
        if end is None:
            return None
        if not self.lives:
            first, last = (self.carrier.singularity(place) for place in (start, end))
            if not (first * last < 0):
                return None
            fold = self.carrier.fold((start, end))
            if fold is None or not self.contains(fold):
                return None
            return _Outcome(fold, True) if fold[2] < 1 else None
        if end[2] < 1:
            return _Outcome(end, False)
        pose = self.carrier.arrival((end[0], end[1]))
        if pose is None:
            return None
        arrived = *pose, arb(1)
        return _Outcome(arrived, False) if self.contains(arrived) else None

    def contains(self, place: Triple) -> bool:
        """Proof that a small ball lies in the tube."""
        r = _dot(_triple(x - p[0] for x, p in zip(place, self.hat, strict=True)), self.tangent)
        slack = arb(2) ** -(ctx.prec // 2)
        if not (r > -slack and r < self.reach + slack):
            return False
        aside = _triple(x - p(r) for x, p in zip(place, self.hat, strict=True))
        return all(abs(_dot(aside, n)) < radius for n, radius in zip(self.across, self.radii, strict=True))

    def _at(self, r: arb) -> Triple | None:
        """The point of the curve at one r, as a small ball."""
        return within(
            self.carrier, _place(self.hat, self.across, r, (arb(0), arb(0))), self.across, self.radii
        )


def _place(hat: Sequence[arb_poly], across: tuple[Triple, Triple], r: arb, w: Two) -> Triple:
    return _triple(p(r) + w[0] * a + w[1] * b for p, a, b in zip(hat, *across, strict=True))


def _triple(numbers: Iterable[arb]) -> Triple:
    x, y, z = numbers
    return x, y, z


def _cross(p: Triple, q: Triple) -> Triple:
    (a, b, c), (d, e, f) = p, q
    return b * f - c * e, c * d - a * f, a * e - b * d


def _dot(p: Triple, q: Triple) -> arb:
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


def _across(t: Triple, rows: Sequence[Triple]) -> tuple[Triple, Triple]:
    """Two directions nearly orthogonal to a unit vector: that in which the rows change most, and another.

    With the steepest apart, the slower one does not suffer from its errors, as near a cusp it would.
    """
    row = max(rows, key=lambda row: _dot(row, row).mid())
    size = _dot(row, row).sqrt()
    first = _triple((x / size).mid() for x in row)
    return first, _triple(x.mid() for x in _cross(t, first))


_SPARE_BITS = 128


@dataclass(frozen=True)
class FoldPoint:
    """Where a pose that is followed meets another one, and both vanish: a point of a singular curve.

    Attributes:
        lengths: L1, L2 and L3 there, correctly rounded, in the user's unit.
        alpha_deg: the orientation of the platform, in degrees in (−180, 180].
        theta_deg: the angle of the fixed leg, likewise.

    >>> from rpr_solver import EXAMPLES, cusp_loop
    >>> loop = cusp_loop(EXAMPLES["innocenti"], 27, "A", samples=2).with_others()
    >>> [other.fold.lengths[0] for other in loop.others if other.fold]
    ['27.0000000000000', '27.0000000000000']
    """

    lengths: tuple[str, str, str]
    alpha_deg: str
    theta_deg: str

    def __repr__(self) -> str:
        legs = " ".join(f"l{leg}={shortened(text)}" for leg, text in enumerate(self.lengths, 1))
        return f"<FoldPoint {legs} alpha_deg={shortened(self.alpha_deg)}>"

    def to_json(self, fixed_leg: int) -> dict[str, str]:
        """The document's object."""
        l1, l2, l3 = self.lengths
        angles = {"alpha_deg": self.alpha_deg, f"theta{fixed_leg}_deg": self.theta_deg}
        return {"l1": l1, "l2": l2, "l3": l3, **angles}


@dataclass(frozen=True)
class OtherPose:
    """Another pose of the joint vector, moved by the leg lengths of a path.

    Attributes:
        start: the pose at the start.
        stop: the pose at the end, if it exists until then.
        fold: the fold at which it vanishes before; if ``stop`` is None too, this is undecided.

    >>> from rpr_solver import EXAMPLES, cusp_loop
    >>> loop = cusp_loop(EXAMPLES["innocenti"], 27, "A", samples=2).with_others()
    >>> [(other.start.number, other.stop and other.stop.number) for other in loop.others]
    [(2, None), (3, None), (4, 4)]
    """

    start: PathPose
    stop: PathPose | None
    fold: FoldPoint | None

    def to_json(self, fixed_leg: int) -> dict[str, Any]:
        """The document's object."""
        return {
            "from": self.start.to_json(fixed_leg),
            "to": self.stop and self.stop.to_json(fixed_leg),
            "fold": self.fold and self.fold.to_json(fixed_leg),
        }


def other_poses(route: Route, table: PoseTable, ends: tuple[PathPose, PathPose]) -> tuple[OtherPose, ...]:
    """The other poses of the joint vector, each followed by proof until the fold at which it vanishes.

    ``table`` has all poses of the joint vector; those that coalesce with others are left out.

    Raises:
        Unproved: two poses could not be separated.
    """
    leg, legs = route.slice_map.fixed_leg, _legs_of(route)
    bits = digit_bits(table.digits) + _SPARE_BITS
    arcs = route.at(bits)
    others = []
    for number, pose in enumerate(table.poses, 1):
        if number == ends[0].number or pose.multiplicity > 1:
            continue
        start = of_table(table, number, leg)
        with ctx.workprec(bits):
            pose_at_start = isolated(route.slice_map, legs, table, number)
            followed = follow(route.slice_map, arcs, pose_at_start.refined(bits - 32))
            stop = None if followed.end is None else _arrived(route, followed.end, table)
            fold = None
            if followed.fold is not None:
                at, place = followed.fold
                fold = _fold_point(route, arcs[at], place, table.digits)
        others.append(OtherPose(start, stop, fold))
    return tuple(others)


def _legs_of(route: Route) -> Legs:
    """The joint vector at both ends."""
    assert isinstance(route.start, IsolatedPose), "the path comes back to its leg lengths"
    return route.start.legs


def _arrived(route: Route, angles: Angles, table: PoseTable) -> PathPose | None:
    pose = IsolatedPose.near(route.slice_map, _legs_of(route), angles)
    return None if pose is None else numbered(pose, table, route.slice_map.fixed_leg)


def _fold_point(route: Route, arc: Arc, place: Triple, digits: int) -> FoldPoint | None:
    alpha, theta, tau = place
    length, scale = arc.length(tau), route.slice_map.scale_ball()
    first, second = (
        square.sqrt() / scale
        for square in local_map(route.slice_map, length, (alpha, theta), 0).squared_lengths()
    )
    texts = round_all((length / scale, first, second, wrapped(alpha), wrapped(theta)), digits)
    if texts is None:
        return None
    return FoldPoint(by_leg(route.slice_map.fixed_leg, texts[:3]), *texts[3:])
