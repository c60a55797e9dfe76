"""Points of a slice in decimals: from balls or exact poses to proved digits."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import overload

from flint import arb, ctx

from rpr_solver.exact.decimals import angle_text, digit_bits, round_all, shorten
from rpr_solver.exact.precision import GREATEST_BITS, decided
from rpr_solver.model.classify import ExactPose, PoseKind
from rpr_solver.notebook import shortened


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
    """A point of a slice, its kind, and the proof of it; θ and α in degrees, as balls, are its sort key."""

    kind: PoseKind
    theta: arb
    alpha: arb
    point: JointPoint
    proof: dict[str, str]
    bits: int


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
        proof = {"field_degree": str(pose.length.field.degree)}
        point = joint_point(texts, pose.local.slice_map.fixed_leg)
        return ClassifiedPoint(pose.kind, theta, alpha, point, proof, bits)

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
