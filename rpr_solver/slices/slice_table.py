"""The table of a slice."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from rpr_solver.exact.decimals import sorted_by_balls
from rpr_solver.exact.rationals import exact_str
from rpr_solver.model.classify import PoseKind
from rpr_solver.model.joint_points import ClassifiedPoint, JointPoint
from rpr_solver.notebook import Row, counted, html_table, shortened, text_table, with_floats
from rpr_solver.slices.certificate import RootCertificate, SliceCertificate


@dataclass(frozen=True)
class SliceTable:
    """All cusps of one slice, and its degenerate points.

    Proved: these are exactly the cusps of the slice, and every printed digit is right. Iteration gives the
    cusps, and ``len`` their number; ``print`` shows a table. Coordinates are exact texts: compute with
    ``float(cusp.l2)``, ``Decimal(cusp.l2)``, or the floats of ``rows()``. The picture of a slice is
    ``singular_curves(manipulator, length).figure()``.

    Attributes:
        fixed_leg: the leg that is held, 1, 2 or 3.
        length: its length, exact, in the user's unit.
        digits: the significant digits of every printed number.
        cusps: the cusps, sorted by the fixed leg's angle, then by α.
        degenerate_points: poses other than cusps at which more than two poses coalesce or the singular curve
            is not smooth: each has its ``kind`` and the same coordinates as a cusp. A whole curve of such
            poses has the kind ``"curve"`` and an ``equation`` instead.
        certificate: how the table is proved.

    >>> from rpr_solver import EXAMPLES, cusp_table
    >>> [table] = cusp_table(EXAMPLES["zein-flat"], 10, digits=15)
    >>> table
    <SliceTable L1=10: 4 cusps, 15 digits>
    >>> table.cusps[0], len(table), [float(cusp.l2) for cusp in table][0]
    (<JointPoint alpha_deg=...>, 4, 25.2233542007524)
    >>> {name: table.rows()[0][name] for name in ("l1", "kind", "cusp", "l2", "l2_text")}
    {'l1': 10.0, 'kind': 'cusp', 'cusp': 1, 'l2': 25.2233542007524, 'l2_text': '25.2233542007524'}
    """

    fixed_leg: int
    length: Fraction
    digits: int
    cusps: tuple[JointPoint, ...]
    degenerate_points: tuple[Mapping[str, str], ...]
    certificate: SliceCertificate

    @classmethod
    def of(
        cls,
        fixed_leg: int,
        length: Fraction,
        digits: int,
        roots: RootCertificate,
        points: Iterable[ClassifiedPoint],
        curves: Iterable[Mapping[str, str]] = (),
    ) -> SliceTable:
        """The table of classified points in any order, and of curves of degenerate poses."""
        points = sorted_by_balls(points, lambda point: (point.theta, point.alpha))
        cusps = [x for x in points if x.kind is PoseKind.CUSP]
        others = ({"kind": x.kind.value, **x.point.to_json()} for x in points if x.kind is not PoseKind.CUSP)
        certificate: SliceCertificate = {
            **roots,
            "working_bits": max((x.bits for x in points), default=0),
            "proofs": [x.proof for x in cusps],
        }
        return cls(fixed_leg, length, digits, tuple(x.point for x in cusps), (*curves, *others), certificate)

    @classmethod
    def of_sorted(
        cls,
        fixed_leg: int,
        length: Fraction,
        digits: int,
        roots: RootCertificate,
        cusps: Sequence[tuple[JointPoint, dict[str, str]]],
        bits: int,
    ) -> SliceTable:
        """The table of cusps in their order, with their proofs, all decided at one precision."""
        certificate: SliceCertificate = {
            **roots,
            "working_bits": bits if cusps else 0,
            "proofs": [proof for _, proof in cusps],
        }
        return cls(fixed_leg, length, digits, tuple(point for point, _ in cusps), (), certificate)

    def __repr__(self) -> str:
        beside = f" and {len(self.degenerate_points)} degenerate" if self.degenerate_points else ""
        leg = f"L{self.fixed_leg}={shortened(exact_str(self.length))}"
        return f"<SliceTable {leg}: {counted(self.count, 'cusp')}{beside}, {self.digits} digits>"

    def __str__(self) -> str:
        return text_table(repr(self)[1:-1], self._records())

    def __iter__(self) -> Iterator[JointPoint]:
        return iter(self.cusps)

    def __len__(self) -> int:
        return len(self.cusps)

    def __bool__(self) -> bool:
        return True  # a table without cusps is an answer

    @property
    def count(self) -> int:
        """The number of cusps."""
        return len(self.cusps)

    def to_json(self) -> dict[str, Any]:
        """The contract's slice object."""
        return {
            f"l{self.fixed_leg}": exact_str(self.length),
            "count": self.count,
            "cusps": [cusp.to_json() for cusp in self.cusps],
            "degenerate_points": [dict(point) for point in self.degenerate_points],
            "certificate": dict(self.certificate),
        }

    def rows(self) -> list[Row]:
        """A row for each cusp, then for each degenerate point, for ``pandas.DataFrame(table.rows())``.

        Lengths and angles are floats; ``l2_text`` has all digits of ``l2``, and so on. ``cusp`` is the
        number of the cusp from 1, None for a degenerate point, whose ``kind`` is not ``"cusp"``.
        """
        return with_floats(self._records())

    def _records(self) -> list[dict[str, object]]:
        head: dict[str, object] = {f"l{self.fixed_leg}": exact_str(self.length)}
        return [
            *({**head, "kind": "cusp", "cusp": n, **cusp.to_json()} for n, cusp in enumerate(self.cusps, 1)),
            *({**head, "kind": point["kind"], "cusp": None, **point} for point in self.degenerate_points),
        ]

    def _repr_html_(self) -> str:
        return html_table(repr(self)[1:-1], self._records())
