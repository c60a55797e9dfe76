"""The curve of a pose that the leg lengths of a path carry along: its points, and its folds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb, arb_mat, arb_poly, ctx

from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.arcs import Arc, Expansion, expanded
from rpr_solver.paths.isolated import Angles, Image, local_map, newton_step

_NEWTON_STEPS = 12

Place = tuple[arb, arb, arb]
"""α, θ and τ; or a direction in their space."""
Two = tuple[arb, arb]


@dataclass(frozen=True)
class Carrier:
    """F(p) = F(q(τ)): the curve of the poses p = (α, θ) that the legs of one arc q carry along."""

    slice_map: SliceMap
    arc: Arc

    def slopes(self, box: Place) -> tuple[Place, Place, Place]:
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

    def singularity(self, place: Place) -> arb:
        """J at a place."""
        length = self.arc.length(place[2])
        return local_map(self.slice_map, length, (place[0], place[1]), 1).singularity().value

    def arrival(self, near: Angles) -> Angles | None:
        """The pose at τ = 1 near a place, as a small ball; None without a proof."""
        at = expanded(self.slice_map, self.arc, arb(1), 0)
        image, length = (at.first[0], at.second[0]), self.arc.length(arb(1))
        angles = near[0].mid(), near[1].mid()
        for _ in range(_NEWTON_STEPS):
            new = newton_step(self.slice_map, length, image, angles)
            if new is None or any(abs(x - y) > 1 for x, y in zip(new, near, strict=True)):
                return None
            angles = new[0].mid(), new[1].mid()
        box = _around(angles)
        inner = newton_step(self.slice_map, length, image, (box[0], box[1]))
        return inner if inner is not None and _inside(inner, box) else None

    def fold(self, ends: tuple[Place, Place]) -> Place | None:
        """A fold between two places of the curve, as a small ball; None without a proof."""
        first, last = (self.singularity(place) for place in ends)
        share = first / (first - last)
        middle = [(x + share * (y - x)).mid() for x, y in zip(*ends, strict=True)]
        for _ in range(_NEWTON_STEPS):
            new = self._fold_step(middle, middle)
            if new is None or any(abs(x - y) > 1 for x, y in zip(new, middle, strict=True)):
                return None
            middle = [x.mid() for x in new]
        box = _around(middle)
        inner = self._fold_step(middle, box)
        return (inner[0], inner[1], inner[2]) if inner is not None and _inside(inner, box) else None

    def _fold_step(self, middle: Sequence[arb], box: Sequence[arb]) -> list[arb] | None:
        """One interval Newton step for F(p) = F(q(τ)), J(p) = 0."""
        still, leading = self._both((middle[0], middle[1], middle[2]), 0)
        values = [
            still.first[0] - leading.first[0],
            still.second[0] - leading.second[0],
            still.singularity[0],
        ]
        return solved(self.slopes((box[0], box[1], box[2])), values, middle)

    def _both(self, place: Place, order: int) -> tuple[Expansion, Expansion]:
        """The expansions at τ of a pose whose angles stay, and of the path."""
        alpha, theta, tau = place
        still = Arc(arb_poly([alpha]), arb_poly([theta]), self.arc.length(arb_poly([tau, 1])))
        return (
            expanded(self.slice_map, still, arb(0), order),
            expanded(self.slice_map, self.arc, tau, order),
        )

    def image_gap(self, place: Place) -> Image:
        """F(p) − F(q(τ))."""
        still, leading = self._both(place, 0)
        return still.first[0] - leading.first[0], still.second[0] - leading.second[0]


def within(carrier: Carrier, origin: Place, across: tuple[Place, Place], radii: Two) -> Place | None:
    """The point of the curve in a plane near a place, as a small ball; None without a proof or outside."""
    w: Sequence[arb] = [arb(0), arb(0)]

    def at(w: Sequence[arb]) -> Place:
        x, y, z = (o + w[0] * a + w[1] * b for o, a, b in zip(origin, *across, strict=True))
        return x, y, z

    def step(middle: Sequence[arb], box: Sequence[arb]) -> list[arb] | None:
        rows = carrier.slopes(at(box))[:2]
        slopes = [[sum((x * y for x, y in zip(row, n, strict=True)), arb(0)) for n in across] for row in rows]
        return solved(slopes, carrier.image_gap(at(middle)), middle)

    for _ in range(_NEWTON_STEPS):
        new = step(w, w)
        if new is None or not all(abs(x) < radius for x, radius in zip(new, radii, strict=True)):
            return None
        w = [x.mid() for x in new]
    box = _around(w)
    inner = step(w, box)
    return at(inner) if inner is not None and _inside(inner, box) else None


def solved(slopes: Sequence[Sequence[arb]], values: Sequence[arb], middle: Sequence[arb]) -> list[arb] | None:
    """The middle less the inverse of the slopes times the values: a Newton step, in balls."""
    try:
        move = arb_mat([list(row) for row in slopes]).solve(arb_mat([[-x] for x in values]))
    except ZeroDivisionError:
        return None
    new = [x + move[i, 0] for i, x in enumerate(middle)]
    return new if all(x.is_finite() for x in new) else None


def _around(middle: Sequence[arb]) -> list[arb]:
    return [arb(x, arb(2) ** -(ctx.prec // 2)) for x in middle]


def _inside(inner: Sequence[arb], box: Sequence[arb]) -> bool:
    return all(abs(y - x.mid()) < x.rad() for x, y in zip(box, inner, strict=True))
