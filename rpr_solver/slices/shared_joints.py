"""Slices of machines whose legs share joints: no cusps, but nodes and curves of degenerate poses.

J is a product K K′ (mathematics.md#shared-joints). With the base joint A of two legs shared, B and B′ their
platform joints, and A″ and B″ the joints of the third leg, K = 0 where A, B and B′ are on a line, and K′ = 0
where A, A″ and B″ are. Both hold at the *nodes*. Seen from the fixed leg, with vectors as in the slice map:

- if it is one of both, m belongs to the other and n and b to the third: e = ±z m/|m|, so that B″ − A = w z
  with w = n ± L m/|m|, and z = ±b w̄/|b w|;
- if it is the third, e = ±a/|a|, and A − B″ = a − L e = z (m + s h) with h = n − m, which gives s by a
  quadratic equation, |m + s h| = |a − L e|.

Where B″ can be A, with L = |n| or L = |a|, a whole line of poses has one joint vector: L e = −n z or L e = a.
If the shared joint is the platform's, the machine turned round has the vectors a and m exchanged, z̄ for z and
−e z̄ for e.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import partial
from typing import Any, TypeAlias

from rpr_solver.exact.biform import OMEGA, T, U
from rpr_solver.exact.number_field import Algebraic, adjoin_real_roots, exact_omega
from rpr_solver.exact.plane import PlaneNumber
from rpr_solver.model.jets import Pose
from rpr_solver.model.joint_points import ExactPose, PoseKind, point_of_pose
from rpr_solver.model.shared_joints import Joint
from rpr_solver.model.slice_map import Point, SliceMap, dot
from rpr_solver.slices.reference import Curve
from rpr_solver.slices.slice_table import SliceCertificate, SliceTable

Vector: TypeAlias = PlaneNumber[Algebraic]
Turns: TypeAlias = tuple[Vector, Vector, Algebraic]
"""The turns z and e of a pose, and ω in their field."""

METHOD = "shared-joints"
"""How the absence of cusps is proved."""


def shared_slice(slice_map: SliceMap, length: Fraction, digits: int) -> SliceTable:
    """The table of a slice where legs share joints: no cusps, and all degenerate poses.

    Args:
        slice_map: of the fixed leg.
        length: its length, in the user's unit.
        digits: significant digits of every printed number.
    """
    scaled = length * slice_map.scale
    points = [point_of_pose(pose, digits) for pose in nodes(slice_map, scaled)]
    proof: SliceCertificate = {
        "eliminant_degree": 0,
        "real_roots": 0,
        "factors": [],
        "method": METHOD,
        "nonzero": [],
    }
    line = line_at(slice_map, scaled)
    curves = [{"kind": PoseKind.CURVE.value, "equation": line}] if line else []
    return SliceTable.of(slice_map.fixed_leg, length, digits, proof, points, curves)


def line_at(slice_map: SliceMap, scaled: Fraction) -> str | None:
    """The equation of the line of poses with one joint vector in the slice of a *scaled* length, if it has
    one."""
    joint = Joint.of(slice_map)
    if dot(joint.radius, joint.radius, slice_map.rho).a != scaled**2:
        return None
    numerator, denominator = scaled.numerator, scaled.denominator
    x, y = (OMEGA * (z.b * denominator) + z.a * denominator for z in joint.radius)
    if not joint.is_on_platform:
        # L e = p
        form = U * (numerator + x) - y
    else:
        # L e = −p z, and 0 where p is along the axis
        circular = 1 + slice_map.rho * T * U
        form = (U - T) * (numerator - x) + circular * y or circular
    if not form:
        return f"theta{slice_map.fixed_leg} = 180 deg"
    return Curve(form.primitive()[1]).equation(slice_map)


def nodes(slice_map: SliceMap, scaled: Fraction) -> Iterator[ExactPose]:
    """The poses of a slice at which both factors of J are 0, each with its kind; of a line of poses with one
    joint vector only those at which other parts of J = 0 cross it."""
    joint, omega = Joint.of(slice_map), exact_omega(slice_map.radicand)
    own, other, away = (
        _vector(point, omega, slice_map.rho) for point in (joint.own, joint.other, joint.away)
    )
    find = _of_the_third if joint.is_third else _of_one_of_both
    for z, e, field_omega in find(own, other, away, omega.field(scaled), omega):
        field = field_omega.field
        if not joint.is_base:
            z, e = z.conjugate(), e * z.conjugate() * field(-1)
        pose = Pose(z.real, z.imag, e.real, e.imag, field(scaled), field_omega)
        yield ExactPose.of(slice_map, pose)


def _vector(point: Point, omega: Algebraic, rho: int) -> Vector:
    one = omega.field(1)
    return PlaneNumber(point[0].times(one, omega), point[1].times(one, omega), rho)


def _of_one_of_both(m: Vector, n: Vector, b: Vector, length: Algebraic, omega: Algebraic) -> Iterator[Turns]:
    for root, lifted in _signed_roots(_norm(m)):
        unit = lifted(m) * root.inverse()
        w, away = lifted(n) + unit * lifted(length), lifted(b)
        square = _norm(w) * _norm(away)
        if square.is_zero:
            continue
        for size, again in _signed_roots(square):
            z = again(away * w.conjugate()) * size.inverse()
            yield z, z * again(unit), again(lifted(omega))
    if (_norm(n) - length * length).is_zero:
        # on the line L e = −n z, where e is normal to b
        for size, lifted in _signed_roots(_norm(b) * b.rho):
            e = _normal(lifted(b)) * size.inverse()
            yield e * lifted(n).conjugate() * -lifted(length).inverse(), e, lifted(omega)


def _of_the_third(m: Vector, n: Vector, a: Vector, length: Algebraic, omega: Algebraic) -> Iterator[Turns]:
    for root, lifted in _signed_roots(_norm(a)):
        e = lifted(a) * root.inverse()
        own, to, h = lifted(m), lifted(a) - e * lifted(length), lifted(n - m)
        square, along = _norm(to), (own * h.conjugate()).real
        rest = along * along - _norm(h) * (_norm(own) - square)
        if square.is_zero:
            # on the line L e = a, if the other triangle is flat, where z h is normal to a
            size2 = _norm(h) * _norm(lifted(a)) * a.rho
            for size, again in _signed_roots(size2) if rest.is_zero else ():
                z = again(_normal(lifted(a)) * h.conjugate()) * size.inverse()
                yield z, again(e), again(lifted(omega))
            continue
        for shift, again in _signed_roots(rest):
            v = again(own) + again(h) * ((shift - again(along)) * again(_norm(h).inverse()))
            z = again(to) * v.conjugate() * again(square).inverse()
            yield z, again(e), again(lifted(omega))


def _normal(v: Vector) -> Vector:
    """j v, normal to v."""
    return PlaneNumber(v.imag * -v.rho, v.real, v.rho)


def _norm(v: Vector) -> Algebraic:
    norm: Algebraic = (v * v.conjugate()).real
    return norm


def _signed_roots(square: Algebraic) -> Iterator[tuple[Algebraic, Callable[[Any], Any]]]:
    """The real square roots, and what lifts numbers and vectors to the field of each."""
    zero = square.field(0)
    if square.is_zero:
        yield square, lambda x: x
        return
    for extension in adjoin_real_roots(square.field, [-square, zero, zero + 1]):
        yield extension.root, partial(_lifted, extension.lift)


def _lifted(lift: Callable[[Algebraic], Algebraic], x: Any) -> Any:
    if isinstance(x, PlaneNumber):
        return PlaneNumber(lift(x.real), lift(x.imag), x.rho)
    return lift(x)
