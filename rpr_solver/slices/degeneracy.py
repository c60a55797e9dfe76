"""Something degenerate in a range of slices, as documents say it (transitions/degenerate.py finds it)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from rpr_solver.exact.rationals import exact_or_none, exact_str
from rpr_solver.model.classify import PoseKind
from rpr_solver.notebook import degenerate_words
from rpr_solver.slices.length_range import LengthRange


@dataclass(frozen=True)
class Degeneracy:
    """Degenerate poses that every slice of an interval of lengths has, or a whole curve of them.

    Attributes:
        fixed_leg: the leg whose length varies from slice to slice.
        kind: that of the poses, as a cusp table names it: ``"node"``, ``"quadruple"`` …, or ``"curve"``.
        start, stop: the ends of the interval in the user's unit: exact texts for the ends of the range, else
            correctly rounded decimals; None is an open end. Both are the same where only one length has it.
        count: the number of such poses in each slice; None for a curve.
        equation: that of a curve, exact; None for poses, and for a curve at one irrational length.

    >>> Degeneracy(1, PoseKind.CURVE, "0", None, equation="alpha = 0 deg")
    <Degeneracy curve of degenerate poses in every slice: alpha = 0 deg>
    >>> Degeneracy(2, PoseKind.NODE, "0", "25", count=2).to_json()
    {'kind': 'node', 'from': '0', 'to': '25', 'count': 2}
    """

    fixed_leg: int
    kind: PoseKind
    start: str
    stop: str | None
    count: int | None = None
    equation: str | None = None

    def __repr__(self) -> str:
        return f"<Degeneracy {degenerate_words(self.to_json(), self.fixed_leg)}>"

    def to_json(self) -> dict[str, Any]:
        """The contract's object."""
        about = {"count": self.count, "equation": self.equation}
        known = {name: value for name, value in about.items() if value is not None}
        return {"kind": self.kind.value, "from": self.start, "to": self.stop, **known}

    @classmethod
    def from_json(cls, obj: Mapping[str, Any], fixed_leg: int) -> Degeneracy:
        """The inverse of :meth:`to_json`."""
        kind = PoseKind(obj["kind"])
        return cls(fixed_leg, kind, obj["from"], obj["to"], obj.get("count"), obj.get("equation"))

    def within(self, span: LengthRange) -> Degeneracy | None:
        """The part in a smaller range; None if there is none."""
        low, high = Fraction(self.start), None if self.stop is None else Fraction(self.stop)
        if low == high:
            return self if low in span else None
        if (span.stop is not None and low >= span.stop) or (high is not None and high <= span.start):
            return None
        start = self.start if low > span.start else exact_str(span.start)
        cut = span.stop is not None and (high is None or high >= span.stop)
        return replace(self, start=start, stop=exact_or_none(span.stop) if cut else self.stop)
