"""A proof modulo one prime that no pose that is singular for every L is degenerate for any.

They are found by four square roots, so for one prime in about sixteen all of them are over 𝔽ₚ. There the
conditions of a degenerate pose are polynomials in L, coprime as a rule, and what is coprime modulo p is so
over the numbers (mathematics.md#permanent-poses).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice

from flint import nmod_poly

from rpr_solver.exact.biform import BiForm
from rpr_solver.exact.modular import primes
from rpr_solver.model.jets import LocalMap, Pose
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.transitions.event_systems import System

_MOST_PRIMES = 200


def never_degenerate(permanent: System) -> bool:
    """Whether a prime proves it; False if none of many does."""
    for p, omega in islice(primes(permanent.slice_map.radicand), _MOST_PRIMES):
        poses = _poses(permanent, p, omega)
        if poses is not None:
            return all(_apart(permanent.slice_map, pose) for pose in poses)
    return False


Root = tuple[int, int]
"""A tangent modulo a prime as numerator and denominator, 1 and 0 for infinity."""


def _poses(permanent: System, p: int, omega: int) -> list[Pose[nmod_poly]] | None:
    """All permanent poses over 𝔽ₚ, with L as the variable; None if some are not over 𝔽ₚ."""
    eliminant = permanent.eliminant
    directions = _roots(eliminant.polynomial.residue(p, omega), eliminant.degree)
    poses = []
    for y, x in directions or ():
        first, second = (_above(form, (y, x), p, omega) for form in (permanent.first, permanent.second))
        ts = _common_roots(first, second, p)
        if ts is None:
            return None
        poses += [_pose(t, (y, x), p, omega) for t in ts]
    return poses or None


def _roots(polynomial: nmod_poly, degree: int) -> list[Root] | None:
    """The roots of a form of this degree, each once; None if it is 0 or not all are over 𝔽ₚ."""
    if not polynomial:
        return None
    roots = polynomial.roots()
    if sum(multiplicity for _, multiplicity in roots) < polynomial.degree():
        return None
    at_infinity = [(1, 0)] if polynomial.degree() < degree else []
    return [*((int(root), 1) for root, _ in roots), *at_infinity]


def _above(form: BiForm, root: Root, p: int, omega: int) -> list[int]:
    """The coefficients in t at one v."""
    v, finite = root
    rows = form.residue(p, omega).at()
    return [int(row(v)) if finite else int(row[form.degree_u]) for row in rows]


def _common_roots(first: list[int], second: list[int], p: int) -> list[Root] | None:
    """The common roots of two forms; None if both are 0 or not all are over 𝔽ₚ."""
    common = nmod_poly(first, p).gcd(nmod_poly(second, p))
    return _roots(common, common.degree() + (not first[-1] and not second[-1]))


def _pose(t: Root, v: Root, p: int, omega: int) -> Pose[nmod_poly]:
    n, d = t
    # -1 is no square modulo p
    norm = pow(n * n + d * d, -1, p)
    cos, sin = (d * d - n * n) * norm, 2 * n * d * norm
    cos_alpha, sin_alpha, cos_theta, sin_theta, constant = (
        nmod_poly([x % p], p) for x in (cos, sin, v[1], v[0], omega)
    )
    return Pose(cos_alpha, sin_alpha, cos_theta, sin_theta, nmod_poly([0, 1], p), constant)


def _apart(slice_map: SliceMap, pose: Pose[nmod_poly]) -> bool:
    """Whether no L ≠ 0, and not ∞ either, makes a pose degenerate that is singular for every L.

    Where it does, ∇J = 0, or E and v·∇E vanish for both legs.
    """
    local = LocalMap.at(slice_map, pose, 3)
    j = local.singularity()
    along = [local.along(leg, j) for leg in (local.f, local.g)]
    second = [local.along(leg, e) for leg, e in zip((local.f, local.g), along, strict=True)]
    critical = [(j.alpha.value, 1), (j.theta.value, 1)]
    coalescent = [*((e.value, 2) for e in along), *((e.value, 3) for e in second)]
    return _coprime(critical) and _coprime(coalescent)


def _coprime(multiples: Sequence[tuple[nmod_poly, int]]) -> bool:
    """Whether forms in L of these degrees have no common root; they are given times L."""
    p = multiples[0][0].modulus()
    forms = [(multiple // nmod_poly([0, 1], p), degree) for multiple, degree in multiples]
    common = nmod_poly([], p)
    for form, _ in forms:
        common = common.gcd(form)
    return common.degree() == 0 and any(form.degree() == degree for form, degree in forms)
