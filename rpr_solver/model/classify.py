"""The kind of a singular pose, decided by exact arithmetic (method.md section 2)."""

from __future__ import annotations

from dataclasses import replace

from rpr_solver.exact.number_field import Algebraic, Field
from rpr_solver.model.jets import LocalMap

CUSP = "cusp"


def classify(local: LocalMap[Algebraic]) -> str | None:
    """The name of the pose, or None if it is an ordinary singular pose (or not singular at all)."""
    gradients = {leg: (leg.alpha.value, leg.theta.value) for leg in (local.f, local.g)}
    regular = [leg for leg, slopes in gradients.items() if not all(x.is_zero for x in slopes)]
    if not regular:
        return "quadruple" if _hessians_independent(local) else "higher"
    leg = regular[0]
    j = local.singularity()
    if not j.value.is_zero:
        return None
    e = local.along(leg, j)
    if not e.value.is_zero:
        return None
    second = local.along(leg, e)
    if j.alpha.value.is_zero and j.theta.value.is_zero:
        aa, at, tt = j.alpha.alpha.value, j.alpha.theta.value, j.theta.theta.value
        hessian = (aa * tt - at * at).sign
        # J is L (J0 + L J1); with J = 0, its value at twice the length is a multiple of J1
        doubled = replace(local.pose, length=local.pose.length * 2)
        moves = not LocalMap.at(local.slice_map, doubled, 1).singularity().value.is_zero
        generic = moves and not second.value.is_zero
        if hessian > 0:
            return "lips" if generic else "isolated-point"
        if hessian < 0:
            return "beak-to-beak" if generic else "node"
        return "higher"
    if not second.value.is_zero:
        return CUSP
    return "swallowtail" if not local.along(leg, second).value.is_zero else "higher"


def _hessians_independent(local: LocalMap[Algebraic]) -> bool:
    """Whether the quadratic parts of f and g have no common zero: then exactly 4 poses coalesce."""
    f, g = (
        (leg.alpha.alpha.value, leg.alpha.theta.value * 2, leg.theta.theta.value)
        for leg in (local.f, local.g)
    )
    crossed = [f[i] * g[k] - f[k] * g[i] for i, k in ((0, 2), (0, 1), (1, 2))]
    return not (crossed[0] * crossed[0] - crossed[1] * crossed[2]).is_zero


def cos_sin(half: Algebraic | None, field: Field) -> tuple[Algebraic, Algebraic]:
    """Cosine and sine of the angle whose half has this tangent; None is 180°."""
    if half is None:
        return field(-1), field(0)
    square = half * half
    norm = (square + 1).inverse()
    return (-square + 1) * norm, half * 2 * norm
