"""Readers of the members that several kinds of documents have."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rpr_solver.verify.core.numbers import POSITIVE, Geometry, decimal, exact, exact_within, short_positive
from rpr_solver.verify.core.reader import Read, Record, count, nothing_or, record, rows, text, told, word

POSE_KINDS = ("swallowtail", "lips", "beak-to-beak", "isolated-point", "node", "quadruple", "higher")
"""Kinds of degenerate poses."""
RANGE = record({"from": exact_within(0, ends=True), "to": nothing_or(POSITIVE)})
_HASH = text("sha256:[0-9a-f]{64}")


class Leg:
    """Readers of what depends on the fixed leg and the digits."""

    def __init__(self, fixed: int, digits: int) -> None:
        self.fixed, self.length = fixed, f"l{fixed}"
        self.theta = f"theta{fixed}_deg"
        self.free = tuple(f"l{leg}" for leg in (1, 2, 3) if leg != fixed)
        self.angle = decimal(digits, -180, 180)
        self.positive = decimal(digits, 0, zero=False)
        self.start = decimal(digits, 0)
        self.number = decimal(digits)
        self.head: dict[str, Read] = {
            "geometry": Geometry.read,
            "geometry_hash": _HASH,
            "digits": count(digits, digits),
            "solver_version": told(text(r"[0-9A-Za-z.+-]{1,40}")),
        }
        self.on_leg: dict[str, Read] = {**self.head, "fixed_leg": count(fixed, fixed)}
        self.point: dict[str, Read] = {
            "alpha_deg": self.angle,
            self.theta: self.angle,
            **dict.fromkeys(self.free, self.positive),
        }
        # a leg may be closed at a degenerate pose, never at a cusp
        self.degenerate_point: dict[str, Read] = {
            "kind": word(*POSE_KINDS),
            **self.point,
            **dict.fromkeys(self.free, self.start),
        }
        self.event = record(self.degenerate_point)
        self.degenerate = rows(self._degenerate)

    def _degenerate(self, value: object, at: str) -> Record:
        kind = value.get("kind") if isinstance(value, Mapping) else None
        curve: dict[str, Read] = {} if kind == "curve" else {"count": count(1)}
        equation: dict[str, Read] = {"equation": text()} if kind == "curve" else {}
        ends: dict[str, Read] = {"from": self.end, "to": nothing_or(self.end)}
        return record({"kind": word("curve", *POSE_KINDS), **ends, **curve}, equation)(value, at)  # type: ignore[no-any-return]

    def end(self, value: object, at: str) -> Any:
        """An end of an interval: an exact number, or a decimal of all digits."""
        try:
            return self.positive(value, at)
        except ValueError:
            return exact_within(0, ends=True)(value, at)

    def box(self, *names: str) -> dict[str, Read]:
        """Sides of a box, with a centre and a radius that are exact numbers."""
        side = record({"centre": exact, "radius": short_positive})
        return dict.fromkeys(names, side)
