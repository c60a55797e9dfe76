"""The article's own algorithm, as an audit of the solver's: steps 1–7, and 5'–6' for its conjecture.

It eliminates t from (6) and (10) instead of J and E, factors the eliminant of degree 96 (eliminant.py), and
for every real root of every factor determines the couples (α, θ1): the article's common solutions (t, u) of
its two equations. Each couple is kept as a cusp, reported as a degenerate point, or rejected with a reason.
As in the article, only leg 1 is fixed.

:meth:`ArticleTable.to_json` is the slice object with two more members::

    "method": "article",
    "audit": {"equations": …, "eliminant_degree": 96, "h": …,
              "factors": [{"origin": …, "degree": 2, "multiplicity": 2,
                           "irreducible": [{"degree": 2, "multiplicity": 1}], "reason": …,
                           "real_roots": 2, "rejected_in_step_6": 3,
                           "couples": [{"alpha_deg": …, "theta1_deg": …,
                                        "verdict": "kept|degenerate|rejected", "reason": …}]}],
              "conjecture": {"holds": true, "answer": …}}

A real root that two factors share is listed with Q, or else with the first of them.
``rejected_in_step_6`` counts the solutions of (13) that violate (14); null if they were not counted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any

from flint import arb, ctx

from rpr_solver.article.couples import (
    AuditReport,
    CouplePoses,
    CoupleReport,
    FactorReport,
    adjugate_stands,
    count_real,
    couple_by_balls,
    exact_couple,
    point_of_balls,
    rejected_by_balls,
)
from rpr_solver.article.eliminant import DEGREE, ArticleEliminant, KnownFactor
from rpr_solver.contract import DEFAULT_DIGITS, Progress, check_digits, check_type, silent
from rpr_solver.errors import SolverError
from rpr_solver.exact import decided_or_none
from rpr_solver.exact.decimals import digit_bits
from rpr_solver.exact.factors import ExactRoot, exact_roots, norm_factors, shapes_json
from rpr_solver.exact.number_field import squarefree_part, trimmed
from rpr_solver.exact.numerals import integer_text
from rpr_solver.exact.precision import TIMES_BEFORE_EXACT
from rpr_solver.exact.rationals import Exact
from rpr_solver.model.jets import HalfTangent, common_root
from rpr_solver.model.joint_points import (
    ClassifiedPoint,
    ExactPose,
    JointPoint,
    PoseKind,
    common_poses,
    place,
)
from rpr_solver.model.lengths import slice_length
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.notebook import Row
from rpr_solver.slices.cusp_table import slices_json, table_json
from rpr_solver.slices.slice_table import NONZERO, SliceCertificate, SliceTable

METHOD = "article"
_Q = "Q"
_Q_REASON = "all that is left: degree 24 (13 and 14 hold, and the adjugate does not vanish)"


@dataclass(frozen=True)
class ArticleTable:
    """A slice's table by the article's algorithm, with the audit of its eliminant.

    Proved: what :class:`SliceTable` proves, and every verdict on a couple (α, θ1).

    Attributes:
        table: the cusps and degenerate points, with the certificate of this algorithm.
        audit: the factors of the eliminant of degree 96, with the couples above their real roots.

    >>> from rpr_solver import EXAMPLES, article_table
    >>> audit = article_table(EXAMPLES["innocenti"], "14.98", digits=15)
    >>> audit
    <ArticleTable L1=14.98: 6 cusps, 15 digits>
    >>> audit.audit["conjecture"]["holds"]
    True
    """

    table: SliceTable
    audit: AuditReport

    def __repr__(self) -> str:
        return repr(self.table).replace("SliceTable", "ArticleTable")

    @property
    def count(self) -> int:
        """The number of cusps."""
        return self.table.count

    @property
    def cusps(self) -> tuple[JointPoint, ...]:
        """The cusps, sorted by θ1."""
        return self.table.cusps

    def to_json(self) -> dict[str, Any]:
        """The slice object with ``method`` and ``audit``."""
        return {**self.table.to_json(), "method": METHOD, "audit": dict(self.audit)}

    def rows(self) -> list[Row]:
        """The rows of the table (see :meth:`SliceTable.rows`)."""
        return self.table.rows()

    def _repr_html_(self) -> str:
        return self.table._repr_html_()


def article_table(manipulator: Manipulator, l1: Exact, *, digits: int = DEFAULT_DIGITS) -> ArticleTable:
    """All cusps of the slice L1 = ``l1`` by the article's own algorithm, steps 1 to 7 (equations 6, 9 to 14).

    Args:
        manipulator: the geometry.
        l1: the length of leg 1, exact, > 0, in the user's unit; the article always fixes leg 1.
        digits: significant digits of every printed number, 15 to 10000; all are proved.

    Raises:
        InputError: naming ``manipulator``, ``l1`` or ``digits``; or a length that is irrational, as the
            article has rational ones.
        SolverError: the article's eliminant vanishes identically (congruent triangles), or a root
            could not be decided.

    >>> from rpr_solver import EXAMPLES, cusp_table
    >>> innocenti = EXAMPLES["innocenti"]
    >>> article_table(innocenti, 27, digits=15).cusps == cusp_table(innocenti, 27, digits=15)[0].cusps
    True
    """
    check_type(manipulator, Manipulator, "manipulator")
    manipulator.rational_lengths("the article's own algorithm")
    return _Audit(manipulator, slice_length(l1, 1), check_digits(digits)).table()


@dataclass
class _Row:
    """A factor of the eliminant with the couples and points above its real roots."""

    factor: KnownFactor
    irreducible: list[tuple[int, int]]
    real_roots: int = 0
    rejected_in_step_6: int | None = 0
    couples: list[CoupleReport] = field(default_factory=list)
    points: list[ClassifiedPoint] = field(default_factory=list)

    def add(self, couple: CoupleReport, point: ClassifiedPoint | None) -> None:
        """Records a couple of (13) and (14), and its point unless it is rejected."""
        self.couples.append(couple)
        if point is not None:
            self.points.append(point)

    def reject(self, real: int | None, kept: int) -> None:
        """Counts the real solutions of (13) above a root that violate (14); None if they are not counted."""
        before = self.rejected_in_step_6
        self.rejected_in_step_6 = None if real is None or before is None else before + real - kept

    def to_json(self) -> FactorReport:
        return {
            "origin": self.factor.origin,
            "degree": self.factor.form.degree,
            "multiplicity": self.factor.multiplicity,
            "irreducible": shapes_json(self.irreducible),
            "reason": self.factor.reason,
            "real_roots": self.real_roots,
            "rejected_in_step_6": self.rejected_in_step_6,
            "couples": self.couples,
        }


class _Audit:
    def __init__(self, manipulator: Manipulator, length: Fraction, digits: int) -> None:
        self.slice_map, self.remark = SliceMap.of(manipulator), manipulator.remark
        self.length = length
        self.scaled = length * self.slice_map.scale
        self.digits = digits
        self.eliminant = ArticleEliminant.of(self.slice_map, self.scaled)
        self._seen: set[object] = set()

    def table(self) -> ArticleTable:
        q = KnownFactor(self.eliminant.q, 1, _Q, _Q_REASON)
        last = self._row(q)  # computed first, so that a root shared with another factor is listed with Q
        rows = [*map(self._row, self.eliminant.known), last]
        certificate: SliceCertificate = {
            "eliminant_degree": DEGREE,
            "real_roots": sum(row.real_roots for row in rows),
            "factors": [
                {
                    "degree": row.factor.form.degree,
                    "multiplicity": row.factor.multiplicity,
                    "origin": "cusps" if row is last else row.factor.origin,
                }
                for row in rows
            ],
            "method": METHOD,
            "nonzero": [*NONZERO],
        }
        points = (x for row in rows for x in row.points)
        table = SliceTable.of(1, self.length, self.digits, certificate, points)
        return ArticleTable(replace(table, remark=self.remark), self._report(rows))

    def _report(self, rows: Sequence[_Row]) -> AuditReport:
        slice_map = self.slice_map
        if self.eliminant.flat:
            h = "symbolic; its value 0 makes (14) follow from (13): step 6 keeps all, step 7 alone decides"
        elif slice_map.radicand == 1:
            h = "rational, put in before eliminating"
        else:
            h = f"symbolic, a rational multiple of sqrt({integer_text(slice_map.radicand)})"
        elsewhere = sum(x.kind is PoseKind.CUSP for row in rows[:-1] for x in row.points)
        answer = (
            "Q gives all cusps. Every other factor is known in closed form, for every geometry: poses in"
            " which a leg has length zero, or the first row or column of the adjugate vanishes, so that (10)"
            " holds without three poses coalescing; their real couples are listed, each with the reason."
        )
        if elsewhere:
            answer = f"{elsewhere} cusps belong to roots of other factors"
        return {
            "equations": "(6), (9)-(12); F1 of degree 4, E1 of degree 12 in tan(alpha/2) and tan(theta1/2)",
            "eliminant_degree": DEGREE,
            "h": h,
            "factors": [row.to_json() for row in rows],
            "conjecture": {"holds": not elsewhere, "answer": answer},
        }

    def _row(self, factor: KnownFactor) -> _Row:
        """Steps 5–7 for the real roots of one factor."""
        factors = norm_factors(factor.form.polynomial)
        row = _Row(factor, [shape for f in factors for shape in f.shape])
        for root in exact_roots(factors):
            if self._new((str(root.root.polynomial.a), root.root.ball.mid().man_exp())):
                row.real_roots += 1
                if not (root.multiplicity == 1 and self._by_balls(row, root)):
                    self._exactly(row, root)
        if at_infinity := factor.form.zeros_at_infinity:
            row.irreducible.append((1, at_infinity))
            if self._new("infinity"):
                row.real_roots += 1
                self._exactly(row, None)
        return row

    def _new(self, key: object) -> bool:
        """Whether a root occurs for the first time."""
        new = key not in self._seen
        self._seen.add(key)
        return new

    def _by_balls(self, row: _Row, root: ExactRoot) -> bool:
        """Decides the unique couple above a simple root; False if the balls do not decide it."""
        flat = self.eliminant.flat
        if flat and row.factor.origin != _Q:
            return False

        def settled(bits: int) -> bool | None:
            u = root.root.refined(bits - 64)
            poses = CouplePoses(self.slice_map, self.scaled, bits)
            with ctx.workprec(bits):
                f1, e1 = (
                    [c.ball(bits)(u) for c in form.rows] for form in (self.eliminant.f1, self.eliminant.e1)
                )
                # for h = 0 (14) is no condition; above a root of Q, J and E have one common root
                t = poses.alpha(u) if flat else common_root(f1, e1)
                if t is None or not self._decided(row, poses, u, t):
                    return None
                row.reject(None if flat else count_real(f1), 1)
                return True

        start = digit_bits(self.digits) + 192
        return bool(decided_or_none(settled, start, TIMES_BEFORE_EXACT * start))

    def _decided(self, row: _Row, poses: CouplePoses, u: arb, t: HalfTangent) -> bool:
        local = poses.local_map(u, t, 2)
        if row.factor.origin != _Q:
            couple = rejected_by_balls(local, u, t, row.factor.closed_leg)
            if couple is not None:
                row.add(couple, None)
            return couple is not None
        if not (self.eliminant.flat or adjugate_stands(local)):
            return False
        cusp = poses.cusp(u, t)
        point = cusp and point_of_balls(cusp, 1, self.digits)
        if not (cusp and point):
            return False
        row.add(couple_by_balls(cusp), point)
        return True

    def _exactly(self, row: _Row, root: ExactRoot | None) -> None:
        """Decides all couples above one root over a number field; None is θ1 = 180°."""
        flat, f1 = self.eliminant.flat, self.eliminant.f1
        second = self.slice_map.coalescence.sliced(self.scaled) if flat else self.eliminant.e1
        f1_at = f1.above(*place(root, f1.radicand))
        couples = common_poses(f1, second, root, self.scaled, 1)
        if couples is None or not trimmed(f1_at):
            raise SolverError("(13) holds on a whole line theta1 = const; the algorithm ends here")
        for pose in couples:
            row.add(*exact_couple(ExactPose.of(self.slice_map, pose), self.digits))
        bits = digit_bits(self.digits)
        with ctx.workprec(bits):
            finite = count_real([c.ball(bits) for c in squarefree_part(trimmed(f1_at))])
        if flat or finite is None:
            row.reject(None, 0)
        else:
            row.reject(finite + f1_at[-1].is_zero, len(couples))


def article_document(
    manipulator: Manipulator, l1: Sequence[Fraction], digits: int, progress: Progress = silent
) -> dict[str, Any]:
    """The document of several slices; a slice without an answer reports the error in its own entry."""
    slices = slices_json(lambda x: article_table(manipulator, x, digits=digits).to_json(), l1, 1, progress)
    return {**table_json(manipulator, 1, digits, slices), "method": METHOD}
