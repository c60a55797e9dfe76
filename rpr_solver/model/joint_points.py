"""Points of a slice: the kinds of poses; poses in real number fields, classified; and points in decimals.

What the kinds say about neighbouring slices is in mathematics.md#kinds-of-degenerate-poses.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from fractions import Fraction
from typing import overload

from flint import arb, ctx

from rpr_solver.exact import decided
from rpr_solver.exact.biform import BiForm
from rpr_solver.exact.decimals import angle_text, digit_bits, round_all, shorten
from rpr_solver.exact.factors import ExactRoot, same_number
from rpr_solver.exact.number_field import Algebraic, Field, common_roots, exact_omega
from rpr_solver.exact.precision import GREATEST_BITS
from rpr_solver.exact.rationals import rational_sqrt
from rpr_solver.model.bridge import Bridge
from rpr_solver.model.jets import Jet, LocalMap, Pose
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.notebook import shortened


class Kind(StrEnum):
    """A name in documents: a string, also in its ``repr``."""

    __repr__ = str.__repr__


class PoseKind(Kind):
    """The kinds of poses of a slice, by their defining conditions.

    f and g are the squares of the free legs as functions of α and θ, the fixed leg having the length L. A
    pose is singular where J = f_α g_θ − f_θ g_α = 0. There v = (−f_θ, f_α) or (−g_θ, g_α), whichever is not
    zero, spans the kernel of the map's Jacobian; E = v·∇J. All kinds but the first have J = E = 0.

    >>> PoseKind.BEAK_TO_BEAK == "beak-to-beak"
    True
    """

    ORDINARY = ""
    """Regular, or on a fold (J = 0, E ≠ 0: two poses coalesce). Never in a document."""
    CUSP = "cusp"
    """∇J ≠ 0 and v·∇E ≠ 0: exactly three poses coalesce, at a smooth point of the singular curve."""
    SWALLOWTAIL = "swallowtail"
    """∇J ≠ 0, v·∇E = 0 and v·∇(v·∇E) ≠ 0: four poses coalesce; as L passes, two cusps are born or vanish."""
    LIPS = "lips"
    """∇J = 0 with a definite Hessian, and ∂J/∂L ≠ 0: as L passes, an oval of the singular curve with two
    cusps is born or vanishes."""
    BEAK_TO_BEAK = "beak-to-beak"
    """∇J = 0 with an indefinite Hessian, ∂J/∂L ≠ 0 and v·∇E ≠ 0: as L passes, two branches of the singular
    curve reconnect, and two cusps are born or vanish."""
    ISOLATED_POINT = "isolated-point"
    """∇J = 0 with a definite Hessian, but ∂J/∂L = 0: the pose is singular at neighbouring L too."""
    NODE = "node"
    """∇J = 0 with an indefinite Hessian, but ∂J/∂L = 0, or v·∇E = 0 (v is tangent to a branch): two branches
    of the singular curve cross."""
    QUADRUPLE = "quadruple"
    """∇f = ∇g = 0, and the Hessians of f and g, as quadratic forms, have no common zero: exactly four poses
    coalesce."""
    HIGHER = "higher"
    """Degenerate, but of none of these kinds: more poses coalesce, or more conditions hold."""
    CURVE = "curve"
    """A whole curve of degenerate poses, given by its equation; of its poses only those are listed at which
    other parts of the singular curve cross it, or ∇f = ∇g = 0."""


def classify(local: LocalMap[Algebraic]) -> PoseKind:
    """The kind of a pose, from its jets up to the fourth order."""
    gradients = {leg: (leg.alpha.value, leg.theta.value) for leg in (local.f, local.g)}
    regular = [leg for leg, slopes in gradients.items() if not all(x.is_zero for x in slopes)]
    if not regular:
        return PoseKind.QUADRUPLE if _hessians_independent(local) else PoseKind.HIGHER
    leg = regular[0]
    j = local.singularity()
    if not j.value.is_zero:
        return PoseKind.ORDINARY
    e = local.along(leg, j)
    if not e.value.is_zero:
        return PoseKind.ORDINARY
    second = local.along(leg, e)
    is_simple = not second.value.is_zero
    if j.alpha.value.is_zero and j.theta.value.is_zero:
        return _kind_at_a_node(local, j, is_simple=is_simple)
    if is_simple:
        return PoseKind.CUSP
    return PoseKind.SWALLOWTAIL if not local.along(leg, second).value.is_zero else PoseKind.HIGHER


def _kind_at_a_node(local: LocalMap[Algebraic], j: Jet[Algebraic], *, is_simple: bool) -> PoseKind:
    """The kind of a pose where J and its gradient vanish."""
    aa, at, tt = j.alpha.alpha.value, j.alpha.theta.value, j.theta.theta.value
    hessian = (aa * tt - at * at).sign
    # J is L (J0 + L J1); with J = 0, its value at twice the length is a multiple of J1
    doubled = replace(local.pose, length=local.pose.length * 2)
    moves = not LocalMap.at(local.slice_map, doubled, 1).singularity().value.is_zero
    is_generic = moves and is_simple
    if hessian > 0:
        return PoseKind.LIPS if is_generic else PoseKind.ISOLATED_POINT
    if hessian < 0:
        return PoseKind.BEAK_TO_BEAK if is_generic else PoseKind.NODE
    return PoseKind.HIGHER


def _hessians_independent(local: LocalMap[Algebraic]) -> bool:
    """Whether the quadratic parts of f and g have no common zero (mathematics.md#rank-0)."""
    f, g = (
        (leg.alpha.alpha.value, leg.alpha.theta.value * 2, leg.theta.theta.value)
        for leg in (local.f, local.g)
    )
    crossed = [f[i] * g[k] - f[k] * g[i] for i, k in ((0, 2), (0, 1), (1, 2))]
    return not (crossed[0] * crossed[0] - crossed[1] * crossed[2]).is_zero


def tan_half(cos: Algebraic, sin: Algebraic) -> Algebraic | None:
    """The half tangent of a turn; None at half a turn."""
    norm = cos + 1
    return None if norm.is_zero else sin * norm.inverse()


def cos_sin(half: Algebraic | None, field: Field, rho: int) -> tuple[Algebraic, Algebraic]:
    """The turn (c, s), c² + ρ s² = 1, with a half tangent; None is half a turn."""
    if half is None:
        return field(-1), field(0)
    square = half * half * rho
    norm = (square + 1).inverse()
    return (-square + 1) * norm, half * 2 * norm


@dataclass(frozen=True)
class ExactPose:
    """A classified pose with L > 0, all of it in one real number field (scaled units)."""

    kind: PoseKind
    local: LocalMap[Algebraic]

    @classmethod
    def of(cls, slice_map: SliceMap, pose: Pose[Algebraic]) -> ExactPose:
        """The pose with its kind."""
        local = LocalMap.at(slice_map, pose, 4)
        return cls(classify(local), local)

    @property
    def length(self) -> Algebraic:
        """L (scaled)."""
        return self.local.pose.length

    def coordinates(self, bits: int) -> tuple[arb, arb, arb | Fraction, arb | Fraction]:
        """α and θ in degrees, and the free legs in the user's unit; rational lengths are exact."""
        p, bridge = self.local.pose, Bridge.of(self.local.slice_map)
        alpha = bridge.alpha_degrees(p.cos_alpha, p.sin_alpha, p.omega, bits)
        theta = bridge.theta_degrees(p.cos_theta, p.sin_theta, p.omega, bits)
        first, second = (self._length(square, bits) for square in self.local.squared_lengths())
        return alpha, theta, first, second

    def _length(self, square: Algebraic, bits: int) -> arb | Fraction:
        root = None if square.rational is None else rational_sqrt(square.rational)
        if root is not None:
            return root / self.local.slice_map.scale
        ball = square.ball(bits)
        with ctx.workprec(bits):
            return ball.sqrt() / self.local.slice_map.scale_ball()

    def is_at(self, other: ExactPose) -> bool:
        """Whether both poses have the same α and θ, also if their number fields differ."""
        first, second = self.local.pose, other.local.pose
        return same_angle((first.cos_alpha, first.sin_alpha), (second.cos_alpha, second.sin_alpha)) and (
            same_angle((first.cos_theta, first.sin_theta), (second.cos_theta, second.sin_theta))
        )


def same_angle(first: tuple[Algebraic, Algebraic], second: tuple[Algebraic, Algebraic]) -> bool:
    """Whether two turns are equal, also if their number fields differ."""
    x, y = tan_half(*first), tan_half(*second)
    return x is None and y is None if x is None or y is None else same_number(x, y)


def place(root: ExactRoot | None, radicand: int) -> tuple[Algebraic | None, Algebraic]:
    """u, None at ∞, and ω in one field."""
    return (None, exact_omega(radicand)) if root is None else root.in_field()


def common_poses(
    first: BiForm, second: BiForm, root: ExactRoot | None, length: Fraction | int, rho: int
) -> list[Pose[Algebraic]] | None:
    """The real common zeros of two forms above one root u, as poses of the slice of this length.

    ``root`` is None for u = ∞. Returns None if every t is a common zero.
    """
    u, omega = place(root, first.radicand)
    at_u = first.above(u, omega), second.above(u, omega)
    return poses_at(*at_u, *cos_sin(u, omega.field, rho), omega.field(length), omega, rho)


def poses_at(
    first: Sequence[Algebraic],
    second: Sequence[Algebraic],
    cos: Algebraic,
    sin: Algebraic,
    length: Algebraic,
    omega: Algebraic,
    rho: int,
) -> list[Pose[Algebraic]] | None:
    """The poses at the real common roots t of two forms, with this turn θ; None if every t is one."""
    roots = common_roots(first, second, cos, sin, length, omega)
    return None if roots is None else [Pose(*cos_sin(t, at[-1].field, rho), *at) for t, at in roots]


class _Coordinate:
    """A coordinate by its name in documents, which depends on the fixed leg."""

    def __init__(self, meaning: str) -> None:
        self.__doc__ = meaning

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    @overload
    def __get__(self, point: None, owner: type) -> _Coordinate: ...
    @overload
    def __get__(self, point: JointPoint, owner: type) -> str: ...
    def __get__(self, point: JointPoint | None, owner: type) -> str | _Coordinate:
        if point is None:
            return self
        if self._name not in point.names:
            known = ", ".join(point.names)
            raise AttributeError(
                f"a point of a slice of leg {point.fixed_leg} has {known}, and no {self._name}",
                name=self._name,
                obj=point,
            )
        return point.coordinates[point.names.index(self._name)]


@dataclass(frozen=True)
class JointPoint:
    """A cusp or another point of a slice, as correctly rounded decimals.

    Its attributes have the names of documents: for leg 1 fixed ``alpha_deg``, ``theta1_deg``, ``l2`` and
    ``l3``; for leg 2 ``alpha_deg``, ``theta2_deg``, ``l1`` and ``l3``; likewise for leg 3. Angles are in
    degrees in (−180, 180], lengths in the user's unit. ``coordinates`` has the four texts in this order,
    whatever leg is fixed, and ``names`` their names.

    >>> from rpr_solver import EXAMPLES, cusp_table
    >>> [table] = cusp_table(EXAMPLES["zein-flat"], 10, digits=15, fixed_leg=2)
    >>> table.cusps[0].theta2_deg, table.cusps[0].l1
    ('-111.064294980643', '34.9192654883771')
    >>> table.cusps[0].l2
    Traceback (most recent call last):
    AttributeError: a point of a slice of leg 2 has alpha_deg, theta2_deg, l1, l3, and no l2
    """

    fixed_leg: int
    coordinates: tuple[str, str, str, str]

    alpha_deg = _Coordinate("The orientation of the platform, the angle of B1B2.")
    theta1_deg = _Coordinate("The angle of leg 1, where it is fixed.")
    theta2_deg = _Coordinate("The angle of leg 2, where it is fixed.")
    theta3_deg = _Coordinate("The angle of leg 3, where it is fixed.")
    l1 = _Coordinate("The length of leg 1, where another leg is fixed.")
    l2 = _Coordinate("The length of leg 2, where another leg is fixed.")
    l3 = _Coordinate("The length of leg 3, where another leg is fixed.")

    def __repr__(self) -> str:
        values = " ".join(f"{name}={shortened(text)}" for name, text in self.to_json().items())
        return f"<JointPoint {values}>"

    @property
    def names(self) -> tuple[str, str, str, str]:
        """The names of the coordinates, in their order."""
        return coordinate_names(self.fixed_leg)

    def to_json(self) -> dict[str, str]:
        """The contract's object: ``alpha_deg``, ``theta1_deg``, ``l2``, ``l3`` for leg 1."""
        return dict(zip(self.names, self.coordinates, strict=True))

    @classmethod
    def from_json(cls, obj: Mapping[str, str], fixed_leg: int) -> JointPoint:
        """The inverse of :meth:`to_json`; other members are ignored."""
        alpha, theta, first, second = (obj[name] for name in coordinate_names(fixed_leg))
        return cls(fixed_leg, (alpha, theta, first, second))


def coordinate_names(fixed_leg: int) -> tuple[str, str, str, str]:
    """The names of a point's coordinates in documents.

    >>> coordinate_names(2)
    ('alpha_deg', 'theta2_deg', 'l1', 'l3')
    """
    first, second = free_legs(fixed_leg)
    return "alpha_deg", f"theta{fixed_leg}_deg", f"l{first}", f"l{second}"


def free_legs(fixed_leg: int) -> tuple[int, int]:
    """The other two legs, in the order of their numbers."""
    first, second = (leg for leg in (1, 2, 3) if leg != fixed_leg)
    return first, second


@dataclass(frozen=True)
class ClassifiedPoint:
    """A point of a slice, and its kind; θ and α in degrees, as balls, are its sort key."""

    kind: PoseKind
    theta: arb
    alpha: arb
    point: JointPoint


def point_of_pose(pose: ExactPose, digits: int) -> ClassifiedPoint:
    """A classified exact pose in decimals.

    Raises:
        Unproved: the digits could not be decided.
    """

    def decimals(bits: int) -> ClassifiedPoint | None:
        alpha, theta, *lengths = pose.coordinates(bits)
        with ctx.workprec(bits):
            texts = round_all((alpha, theta, *lengths), digits)
        if texts is None:
            return None
        point = joint_point(texts, pose.local.slice_map.fixed_leg)
        return ClassifiedPoint(pose.kind, theta, alpha, point)

    message = f"the digits of a {pose.kind or 'pose'} could not be decided"
    return decided(decimals, digit_bits(digits) + 128, GREATEST_BITS, message)


def joint_point(texts: Sequence[str], fixed_leg: int) -> JointPoint:
    """The point with these rounded angles and lengths."""
    alpha, theta, first, second = texts
    return JointPoint(fixed_leg, (angle_text(alpha), angle_text(theta), first, second))


def shortened_points(points: Iterable[Mapping[str, str]], digits: int) -> list[dict[str, str | None]] | None:
    """Points rounded to fewer digits; None if one of their numbers is a tie."""
    short = [{key: _shorten(key, text, digits) for key, text in point.items()} for point in points]
    return None if any(None in point.values() for point in short) else short


def _shorten(key: str, text: str, digits: int) -> str | None:
    if key in ("kind", "equation"):
        return text
    short = shorten(text, digits)
    return angle_text(short) if short is not None and key.endswith("_deg") else short
