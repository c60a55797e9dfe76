"""The table of a slice, and its certificate."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, TypedDict

from rpr_solver.exact.decimals import sorted_by_balls
from rpr_solver.exact.factors import FactorShape, shapes_json
from rpr_solver.exact.rationals import exact_str
from rpr_solver.model.joint_points import ClassifiedPoint, JointPoint, PoseKind, free_legs
from rpr_solver.notebook import Row, counted, html_table, shortened, text_table, with_floats


class Factor(FactorShape):
    """A factor of the eliminant: its degree in u = tan(θ/2), its multiplicity and its origin."""

    origin: str


class SliceCertificate(TypedDict):
    """What a slice's table rests on.

    ``eliminant_degree`` and ``real_roots`` refer to the factors of origin ``"cusps"``. ``method`` is
    ``"balls"`` if all of their roots are simple, else ``"exact"``; for the article's algorithm it is
    ``"article"``, and where legs share joints, so that no slice has a cusp, ``"shared-joints"``. ``nonzero``
    names what is proved not to be 0 at every cusp, where J = E = 0 (:data:`NONZERO`).
    """

    eliminant_degree: int
    real_roots: int
    factors: list[Factor]
    method: str
    nonzero: list[str]


NONZERO = ("v", "grad_J", "v_grad_E")
"""What makes a pose with J = E = 0 a cusp where none of it is 0 (:class:`~rpr_solver.PoseKind`): the kernel
vector v of the map, which then has rank 1; ∇J, so that the singular curve is smooth; and v·∇E, so that
exactly three poses coalesce."""


def slice_certificate(
    leg: int, cusp_factors: list[tuple[int, int]], real_roots: int, method: str, *, shared: bool = False
) -> SliceCertificate:
    """The certificate of a slice, of whose eliminant Q has factors of these degrees and multiplicities.

    Args:
        leg: the fixed leg.
        cusp_factors: degree and multiplicity of each factor of Q.
        real_roots: the number of its real roots.
        method: how the slice was decided.
        shared: whether J and E share curves in the slice.
    """
    return {
        "eliminant_degree": sum(degree * multiplicity for degree, multiplicity in cusp_factors),
        "real_roots": real_roots,
        "factors": _factor_table(leg, cusp_factors, shared=shared),
        "method": method,
        "nonzero": [*NONZERO],
    }


def _factor_table(leg: int, cusp_factors: list[tuple[int, int]], *, shared: bool) -> list[Factor]:
    """The factors of Res_t(J, E), a form of degree 48 in u, with their origins."""
    cusps: list[Factor] = [{**shape, "origin": "cusps"} for shape in shapes_json(cusp_factors)]
    if shared:
        return cusps
    closed, _ = free_legs(leg)
    return [
        {"degree": 2, "multiplicity": 1, "origin": f"L{closed}=0"},
        {"degree": 2, "multiplicity": 2, "origin": f"leg {leg} along A{min(leg, closed)}A{max(leg, closed)}"},
        {"degree": 2, "multiplicity": 9, "origin": "circular"},
        *cusps,
    ]


@dataclass(frozen=True)
class SliceTable:
    """All cusps of one slice, and its degenerate points.

    Proved: these are exactly the cusps of the slice, and every printed digit is right. Iteration gives the
    cusps, and ``len`` their number; ``print`` shows a table. Coordinates are exact texts: compute with
    ``float(cusp.l2)``, ``Decimal(cusp.l2)``, or the floats of ``rows()``. The picture of a slice is
    ``singular_curves(manipulator, length).figure()``.

    Attributes:
        fixed_leg: the leg whose length is fixed, 1, 2 or 3.
        length: its length, exact, in the user's unit.
        digits: the significant digits of every printed number.
        cusps: the cusps, sorted by the fixed leg's angle, then by α.
        degenerate_points: poses other than cusps at which more than two poses coalesce or the singular curve
            is not smooth: each has its ``kind`` and the same coordinates as a cusp. A whole curve of such
            poses has the kind ``"curve"`` and an ``equation`` instead.
        certificate: how the table is proved.
        remark: the first line of the table if a special shape near the manipulator contradicts or weakens it.

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
    remark: str = field(default="", repr=False)

    @classmethod
    def of(
        cls,
        fixed_leg: int,
        length: Fraction,
        digits: int,
        certificate: SliceCertificate,
        points: Iterable[ClassifiedPoint],
        curves: Iterable[Mapping[str, str]] = (),
    ) -> SliceTable:
        """The table of classified points in any order, and of curves of degenerate poses."""
        points = sorted_by_balls(points, lambda point: (point.theta, point.alpha))
        cusps = tuple(x.point for x in points if x.kind is PoseKind.CUSP)
        others = ({"kind": x.kind.value, **x.point.to_json()} for x in points if x.kind is not PoseKind.CUSP)
        return cls(fixed_leg, length, digits, cusps, (*curves, *others), certificate)

    def __repr__(self) -> str:
        degenerate = f" and {len(self.degenerate_points)} degenerate" if self.degenerate_points else ""
        leg = f"L{self.fixed_leg}={shortened(exact_str(self.length))}"
        return f"<SliceTable {leg}: {counted(self.count, 'cusp')}{degenerate}, {self.digits} digits>"

    def __str__(self) -> str:
        table = text_table(repr(self)[1:-1], self._records())
        return f"{self.remark}\n{table}" if self.remark else table

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
        return html_table(repr(self)[1:-1], self._records(), first=self.remark)
