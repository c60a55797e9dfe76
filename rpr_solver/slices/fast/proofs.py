"""Proof of poses guessed in double precision, for all slices of a block at once, by numpy.

With bounds of every rounding error (poses.py), Krawczyk's test shows that a box round the guess holds just
one pose with J = E = 0, and that it is not spurious; ∇f, ∇J and v·∇E are bounded there, so closely that both
bounds are nearly always one text in the certificate (mathematics.md#poses-by-floats). What is not proved here
is left to the reference, with its whole slice.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

from rpr_solver.slices.eliminant import Eliminant
from rpr_solver.slices.fast.poses import Bounded, DoubleMap, GuessedPoses, HalfAngles, map_exponent
from rpr_solver.slices.grid import At, PoseDerivatives, singularity_and_coalescence

if TYPE_CHECKING:
    from rpr_solver.slices.fast.poses import Flags, Floats


_CIRCLE_ERROR = 8
"""Units that bound the rounding errors of a cosine and a sine by half tangents."""
_WIDEST = 2.0**-24
"""The greatest radius of a box."""
_STEEPEST = 2.0**200
"""Bounds the inverse of the gradients, lest it make something of what underflows."""
_SAFE = 1 + 2.0**-20
"""Bounds the roundings of the few operations that follow, and what is of second order in a radius."""
_DUST = 2.0**-600
"""Far above what underflows, and far below what is printed."""
_TO_DOUBLE = 2.0**-53
_FEW_BITS, _SMALL = 32, 36
"""Below 2^36, of numbers of so few bits FLINT may print another radius, as they can be exact in decimals."""

PROOFS = {"rank_1": 2, "grad_J": 4, "v_grad_E": 8}
"""The numbers of a certificate, and their dimensions as powers of a length."""


class NearPose(NamedTuple):
    """A proved cusp: a box that holds it and no other pose, and bounds of the numbers of its certificate.

    Attributes:
        t, t_inverse, t_reach: tan(α/2), or its inverse, and the radius of the box.
        u, u_inverse, u_reach: the same of θ.
        numbers: a lower and an upper bound of each of :data:`PROOFS`, for lengths divided by 2^exponent.
    """

    t: float
    t_inverse: bool
    t_reach: float
    u: float
    u_inverse: bool
    u_reach: float
    numbers: tuple[float, ...]


def proved_boxes(
    eliminant: Eliminant, lengths: Sequence[Fraction], thetas: Sequence[Sequence[tuple[float, float]]]
) -> tuple[int, list[list[NearPose] | None]]:
    """:func:`near_poses` of slices of *scaled* lengths, with the exponent of their numbers."""
    import numpy as np

    exponent = map_exponent(eliminant.slice_map, lengths)
    if ("doubles", exponent) not in eliminant.kept:
        eliminant.kept["doubles", exponent] = DoubleMap.of(np, eliminant.slice_map, exponent)
    double_map: DoubleMap = eliminant.kept["doubles", exponent]
    return exponent, near_poses(np, double_map, double_map.lengths(np, lengths), thetas)


def near_poses(
    np: Any, double_map: DoubleMap, lengths: Floats, thetas: Sequence[Sequence[tuple[float, float]]]
) -> list[list[NearPose] | None]:
    """For each slice the proved cusps near guesses of θ, in ascending order; None if one is not proved.

    Args:
        np: numpy.
        double_map: of the manipulator and its fixed leg.
        lengths: the scaled L / 2^exponent of each slice, right to two units.
        thetas: for each slice numerators and denominators of tan(θ/2).
    """
    sizes = [len(x) for x in thetas]
    if not any(sizes):
        return [[] for _ in sizes]
    index = np.repeat(np.arange(len(sizes)), sizes)
    with np.errstate(all="ignore"):
        guessed = double_map.guessed(np, lengths[index], [pair for x in thetas for pair in x])
        alpha, theta = guessed.alpha, guessed.theta
        radii, derivatives, good = _krawczyk(np, double_map, guessed)
        numbers, usable = _numbers(np, derivatives, double_map.exponent)
        (alpha_reach, alpha_good), (theta_reach, theta_good) = map(_reach, (alpha, theta), radii)
        good &= usable & alpha_good & theta_good & _is_proper(double_map, guessed, radii[1])
        place = theta.place(np)
        order = np.lexsort((place, index))
        good = good[order] & _are_apart(np, index[order], place[order], theta_reach[order])
    columns = alpha.x, alpha.inverse, alpha_reach, theta.x, theta.inverse, theta_reach
    sorted_columns = [x.astype(bool if x.dtype == bool else float)[order].tolist() for x in columns]
    bounds = zip(*(x.astype(float)[order].tolist() for x in numbers), strict=True)
    poses, flags = list(map(NearPose, *sorted_columns, bounds)), good.tolist()
    ends = list(accumulate(sizes, initial=0))
    return [poses[i:k] if all(flags[i:k]) else None for i, k in pairwise(ends)]


def _bounded_pose(unit: float, guessed: GuessedPoses, radii: tuple[Any, Any]) -> At[Bounded]:
    """The pose with both angles within some radii of the guess."""
    length = Bounded(guessed.length, 0.0, unit)
    length.error = 2 * unit * length.size
    (ca, sa), (ct, st) = (
        [Bounded(x, radius + _CIRCLE_ERROR * unit, unit) for x in angle.cos_sin()]
        for angle, radius in zip((guessed.alpha, guessed.theta), radii, strict=True)
    )
    return length, ca, sa, ct, st


def _krawczyk(
    np: Any, double_map: DoubleMap, guessed: GuessedPoses
) -> tuple[tuple[Floats, Floats], PoseDerivatives[Bounded], Flags]:
    """Radii of boxes, the derivatives there, and whether there is just one zero of J and E, by Krawczyk."""
    f, g, unit = double_map.f, double_map.g, double_map.unit
    zero = np.zeros(len(guessed.length))
    j, e = singularity_and_coalescence(f, g, _bounded_pose(unit, guessed, (zero, zero)))
    steps = [(abs(a) * j.greatest + abs(b) * e.greatest) * _SAFE + _DUST for a, b in guessed.inverse]
    radii = 2 * steps[0], 2 * steps[1]
    d = PoseDerivatives.at(f, g, _bounded_pose(unit, guessed, radii))
    columns = (d.j_alpha, d.e_alpha), (d.j_theta, d.e_theta)
    proved = (radii[0] < _WIDEST) & (radii[1] < _WIDEST)
    for row, (a, b) in enumerate(guessed.inverse):
        # 1 − Y F′, where Y is the inverse and F is (J, E)
        distances = [_distance(a, x, b, y, float(row == k)) for k, (x, y) in enumerate(columns)]
        moved = steps[row] + (distances[0] * radii[0] + distances[1] * radii[1])
        proved &= (moved * _SAFE < radii[row]) & (abs(a) + abs(b) < _STEEPEST)
    return radii, d, proved


def _distance(a: Floats, x: Bounded, b: Floats, y: Bounded, target: float) -> Floats:
    """A bound of |a x + b y − target|."""
    first, second = a * x.value, b * y.value
    own = 4 * x.unit * (abs(first) + abs(second) + target)
    return (abs(first + second - target) + (abs(a) * x.error + abs(b) * y.error) + own) * _SAFE  # type: ignore[no-any-return]


def _is_proper(double_map: DoubleMap, guessed: GuessedPoses, radius: Floats) -> Flags:
    """Whether w and q are not 0 within a radius of θ: the pose is not spurious."""
    length, _, _, ct, st = _bounded_pose(double_map.unit, guessed, (radius, radius))
    f = double_map.f
    along = length * (f.ax * ct + f.ay * st)
    closed = length * length + double_map.closed - (along + along)
    return ((f.ay * ct - f.ax * st).least > _DUST) & (closed.least > _DUST)  # type: ignore[no-any-return]


def _reach(angle: HalfAngles, radius: Floats) -> tuple[Floats, Flags]:
    """How far the rounded x can be from that of an angle within a small radius, and whether x is usual."""
    size = abs(angle.x.astype(float))
    reach = (radius / 2 * (1 + size * size) + _TO_DOUBLE * size) * _SAFE
    return reach, (size > 2 * reach) & (size < 1 + 2.0**-26)


def _are_apart(np: Any, index: Floats, place: Floats, reach: Floats) -> Flags:
    """Whether each θ of the same slice is greater than the one before, by proof; they are sorted."""
    apart = np.ones(len(index), dtype=bool)
    gap = place[1:] - place[:-1] - (reach[1:] + reach[:-1])
    apart[1:] = (index[1:] != index[:-1]) | (gap > 2.0**-48)
    return apart  # type: ignore[no-any-return]


def _numbers(np: Any, d: PoseDerivatives[Bounded], unit: int) -> tuple[list[Floats], Flags]:
    """Lower and upper bounds of the numbers of :data:`PROOFS` in turn, and whether they can be printed.

    They can if they exclude 0 and all small numbers of few bits. Lengths are divided by 2^unit.
    """
    usable, bounds = np.ones(len(d.e.size), dtype=bool), []
    gradients = (d.f_alpha, d.f_theta), (d.j_alpha, d.j_theta), (d.v_grad_e,)
    for parts, dimension in zip(gradients, PROOFS.values(), strict=True):
        value, error = parts[0].value, parts[0].error
        for other in parts[1:]:
            greater = other.least > parts[0].greatest
            usable &= greater | (parts[0].least > other.greatest)
            value, error = np.where(greater, other.value, value), np.where(greater, other.error, error)
        error = (error + 2 * _TO_DOUBLE * abs(value)) * _SAFE + _DUST
        bounds += [value - error, value + error]
        mantissa, exponent = np.frexp(abs(value))
        mantissa = np.ldexp(mantissa, _FEW_BITS)
        has_more_bits = abs(mantissa - np.rint(mantissa)) > np.ldexp(error, _FEW_BITS - exponent) * _SAFE
        usable &= has_more_bits | ((exponent + dimension * unit > _SMALL) & (abs(value) > error * _SAFE))
    return bounds, usable
