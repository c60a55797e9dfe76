"""How far a pose is from all singular poses of its slice: a proved lower bound.

In a direction of unit length, J changes at first by |∇J| at most, and its second derivative is at most M
anywhere. So J ≠ 0 within the positive root ρ of |J| − |∇J| ρ − M ρ²/2. M follows from the amplitudes of the
sinusoids of which J consists.
"""

from __future__ import annotations

from flint import arb

from rpr_solver.model.jets import Jet
from rpr_solver.model.slice_map import Leg, SliceMap


def clearance_of(slice_map: SliceMap, length: arb, j: Jet[arb]) -> arb:
    """A ball whose lower end bounds the distance, in radians, to the nearest singular pose of the slice.

    ``j`` is the jet of J at the pose, ``length`` the fixed length, scaled.
    """
    value = abs(j.value)
    slope = (j.alpha.value**2 + j.theta.value**2).sqrt()
    return 2 * value / (slope + (slope**2 + 2 * bend_bound(slice_map, length) * value).sqrt())


def bend_bound(slice_map: SliceMap, length: arb) -> arb:
    """An upper bound of the second directional derivatives of J anywhere in the slice.

    f_α is a sum of sinusoids in α − θ and in α, f_θ of sinusoids in α − θ and in θ. In a direction of unit
    length the derivative of the first kind is at most √2 times the amplitude, that of the others at most 1.
    """
    (f_alpha, f_theta), (g_alpha, g_theta) = (_slopes(leg, length) for leg in (slice_map.f, slice_map.g))

    def product(p: list[arb], q: list[arb]) -> arb:
        return p[0] * q[2] + 2 * p[1] * q[1] + p[2] * q[0]

    return product(f_alpha, g_theta) + product(f_theta, g_alpha)


def _slopes(leg: Leg, length: arb) -> tuple[list[arb], list[arb]]:
    """Bounds of f_α and f_θ (of half the square) and of their first and second directional derivatives."""
    platform, base = arb(leg.platform2).sqrt(), arb(leg.base2).sqrt()
    root = arb(2).sqrt()
    both = [length * platform * root**k for k in range(3)]
    return [x + platform * base for x in both], [x + length * base for x in both]
