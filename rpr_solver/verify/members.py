"""Members that documents of several kinds have, and a document as it was read."""

from __future__ import annotations

from dataclasses import dataclass

from rpr_solver.verify.geometry import Geometry
from rpr_solver.verify.numbers import NOT_NEGATIVE, POSITIVE, Printed, printed
from rpr_solver.verify.reader import (
    Read,
    Record,
    count,
    either,
    no_claim,
    nothing_or,
    record,
    rows,
    text,
    word,
)

POSE_KINDS = ("swallowtail", "lips", "beak-to-beak", "isolated-point", "node", "quadruple", "higher")
"""Kinds of degenerate poses."""
RANGE = record({"from": NOT_NEGATIVE, "to": nothing_or(POSITIVE)})
"""A range of lengths of the fixed leg; without ``to`` it has no upper end."""

IN_GIVEN_FRAME: dict[str, Read] = dict.fromkeys(("x", "y", "phi_deg"), no_claim(text()))
"""What poses and samples have beside if triangles were given by points, which a document does not tell."""


@dataclass(frozen=True)
class Document:
    """A document as it was read.

    Attributes:
        kind: such as ``"cusp-table"``.
        geometry: the manipulator.
        fixed: the fixed leg; 1 for poses, which have none.
        members: all members, frozen.
    """

    kind: str
    geometry: Geometry
    fixed: int
    members: Record


class Leg:
    """Readers of what depends on the fixed leg and on the number of digits."""

    def __init__(self, fixed: int, digits: int) -> None:
        self.fixed, self.digits, self.length = fixed, digits, f"l{fixed}"
        self.theta = f"theta{fixed}_deg"
        self.free = tuple(f"l{leg}" for leg in (1, 2, 3) if leg != fixed)
        self.angle = printed(digits, -180, 180)
        self.positive = printed(digits, 0, zero=False)
        self.start = printed(digits, 0)
        self.number = printed(digits)
        self.head: dict[str, Read] = {
            "geometry": Geometry.read,
            "geometry_hash": text("sha256:[0-9a-f]{64}"),
            "digits": count(digits, digits),
            "solver_version": no_claim(text(r"[0-9A-Za-z.+-]{1,40}")),
        }
        self.on_leg: dict[str, Read] = {**self.head, "fixed_leg": count(fixed, fixed)}
        self.angles: dict[str, Read] = {"alpha_deg": self.angle, self.theta: self.angle}
        self.point: dict[str, Read] = {**self.angles, **dict.fromkeys(self.free, self.positive)}
        # a leg may be closed at a degenerate pose, never at a cusp
        self.degenerate_point: dict[str, Read] = {
            "kind": word(*POSE_KINDS),
            **self.angles,
            **dict.fromkeys(self.free, self.start),
        }
        part = {"from": self.end, "to": nothing_or(self.end)}
        curve = record({"kind": word("curve"), "equation": text(), **part})
        poses = record({"kind": word(*POSE_KINDS), "count": count(1), **part})
        self.degenerate = rows(either(lambda value: value.get("kind") == "curve", curve, poses))

    def end(self, value: object, at: str) -> object:
        """An end of an interval: a decimal of all digits (:class:`Printed`), or an exact number."""
        try:
            number: Printed = self.positive(value, at)
        except ValueError:
            return NOT_NEGATIVE(value, at)
        return number
