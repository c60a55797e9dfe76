"""The local algebra at a cusp: where its three poses lie, and on which side of the singular curve.

Let v be the unit tangent of J = 0 in (α, θ), which spans the kernel of DF there, n = ∇J/|∇J|, U = DF·n, and

    β = ⟨D²F(v, v)/2, U⟩ / |U|²,        κ = (J_vv / (2|∇J|) − β) / 3.

At the pose c + x n + y v, J is |∇J| (x + (β + 3κ) y²), and the image is X = x + β y² along U and
Y = y (X + κ y²) along another direction, all to leading order. So the poses over (X, Y) = (−κ s², 0) are
y = ±s, where J has the sign of κ, and y = 0, where it has the other. The parabola
x(y) = b s² − (β + κ + b) y², where b has the sign of κ, leads from y = s to y = −s. On it J / |∇J| runs from
2κ s² over b s² to 2κ s², and its image goes once round that of the cusp.
"""

from __future__ import annotations

from dataclasses import dataclass

from flint import arb

from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.isolated import Angles, local_map


@dataclass(frozen=True)
class CuspFrame:
    """A cusp with its local algebra: approximate, for starting points of what is then proved."""

    cusp: Angles
    normal: Angles
    tangent: Angles
    beta: arb
    kappa: arb

    @classmethod
    def at(cls, slice_map: SliceMap, length: arb, cusp: Angles) -> CuspFrame:
        """The frame of a cusp (radians) of the slice of a scaled length."""
        cusp = cusp[0].mid(), cusp[1].mid()
        local = local_map(slice_map, length, cusp, 3)
        j = local.singularity()
        slope = j.alpha.value, j.theta.value
        steepness = (slope[0] ** 2 + slope[1] ** 2).sqrt()
        n = slope[0] / steepness, slope[1] / steepness
        v = -n[1], n[0]
        image = [leg.alpha.value * n[0] + leg.theta.value * n[1] for leg in (local.f, local.g)]

        def bend(jet_alpha_alpha: arb, jet_alpha_theta: arb, jet_theta_theta: arb) -> arb:
            return (
                jet_alpha_alpha * v[0] ** 2 + 2 * jet_alpha_theta * v[0] * v[1] + jet_theta_theta * v[1] ** 2
            ) / 2

        bends = [
            bend(w.alpha.alpha.value, w.alpha.theta.value, w.theta.theta.value) for w in (local.f, local.g, j)
        ]
        beta = (bends[0] * image[0] + bends[1] * image[1]) / (image[0] ** 2 + image[1] ** 2)
        kappa = (bends[2] / steepness - beta) / 3
        numbers = [w.mid() for w in (*n, *v, beta, kappa)]
        return cls(cusp, (numbers[0], numbers[1]), (numbers[2], numbers[3]), numbers[4], numbers[5])

    @property
    def sign(self) -> int:
        """The sign of J along a loop."""
        return 1 if self.kappa > 0 else -1

    def outer(self, s: arb) -> Angles:
        """The pose y = s, s of either sign, over the point of the cusp's axis."""
        return self._place(-(self.kappa + self.beta) * s * s, s)

    def middle(self, s: arb, width: arb) -> Angles:
        """The middle control point of the Bézier parabola from y = s to y = −s, for b = ``width`` · κ."""
        # a Bézier parabola passes half-way between the middle of its ends and its control point
        x = (2 * width * self.kappa + self.kappa + self.beta) * s * s
        return self._place(x, arb(0))

    def _place(self, x: arb, y: arb) -> Angles:
        n, v = self.normal, self.tangent
        return (self.cusp[0] + x * n[0] + y * v[0]).mid(), (self.cusp[1] + x * n[1] + y * v[1]).mid()
