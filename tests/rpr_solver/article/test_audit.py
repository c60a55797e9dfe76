"""The article's algorithm: an independent derivation of its equations, its eliminant, the solver's cusps."""

from fractions import Fraction
from typing import Any

import mpmath as mp
import pytest
import sympy as sp
from flint import fmpz_mpoly_ctx
from hypothesis import given

from rpr_solver import (
    EXAMPLES,
    InputError,
    Manipulator,
    SolverError,
    article_table,
    eliminate,
    solve_slice,
)
from rpr_solver.article.eliminant import ArticleEliminant, article_forms
from rpr_solver.article.equations import Legs, adjugate, coalescence
from rpr_solver.exact.biform import BiForm
from rpr_solver.model.slice_map import SliceMap
from tests.support.article import pose as article_pose
from tests.support.reference import CASES
from tests.support.strategies import examples, lengths, manipulators

VECTORS = [
    pytest.param(
        case["geometry"],
        item,
        id=f"{case['name']}-{item['l1']}",
        marks=() if n == 0 and case["name"] in ("innocenti", "flat-base", "congruent") else pytest.mark.slow,
    )
    for case in CASES
    for n, item in enumerate(case["slices"])
]


class TestEquations:
    """(1) → (5), (6), (8), (9), (10), (11): the solver's formulas against a derivation by SymPy."""

    lengths = sp.symbols("L1:4", positive=True)
    thetas = sp.symbols("theta1:4", real=True)
    a2x, a3x, a3y, d1, d2, d3 = sp.symbols("A2x A3x A3y d1 d2 d3", real=True)

    @property
    def vectors(self) -> list[tuple[Any, Any]]:
        return [(r * sp.cos(t), r * sp.sin(t)) for r, t in zip(self.lengths, self.thetas, strict=True)]

    @property
    def legs(self) -> Legs:
        return Legs(tuple(self.vectors), self.a2x, self.a3x, self.a3y)  # type: ignore[arg-type]

    @property
    def constraints(self) -> list[Any]:
        """Equation (1)."""
        base = [(0, 0), (self.a2x, 0), (self.a3x, self.a3y)]
        b1, b2, b3 = (
            sp.Matrix([a + x for a, x in zip(point, vector, strict=True)])
            for point, vector in zip(base, self.vectors, strict=True)
        )
        sides = [(b2, b1, self.d1), (b3, b2, self.d2), (b1, b3, self.d3)]
        return [(p - q).dot(p - q) - d**2 for p, q, d in sides]

    @property
    def jacobian(self) -> Any:
        return sp.Matrix(self.constraints).jacobian(self.thetas)

    @staticmethod
    def same(x: Any, y: Any) -> bool:
        return sp.expand(sp.expand_trig(x - y)) == 0

    def test_the_jacobian_has_the_six_entries_k(self) -> None:
        k, o = self.legs.k, 0
        expected = 2 * sp.Matrix([[k[6], k[5], o], [o, k[1], k[3]], [k[4], o, k[2]]])
        assert all(self.same(x, y) for x, y in zip(self.jacobian, expected, strict=True))

    def test_k_is_equation_9(self) -> None:
        (l1, l2, l3), (t1, t2, t3) = self.lengths, self.thetas
        a2x, a3x, a3y = self.a2x, self.a3x, self.a3y
        s1, s2, s3 = (sp.sin(t) for t in self.thetas)
        c1, c2, c3 = (sp.cos(t) for t in self.thetas)
        s12, s13, s23 = sp.sin(t1 - t2), sp.sin(t1 - t3), sp.sin(t2 - t3)
        printed = {
            1: 2 * l2 * ((a3x - a2x) * s2 + l3 * s23 - a3y * c2),
            2: -2 * l3 * (l1 * s13 + a3x * s3 - a3y * c3),
            3: -2 * l3 * ((a3x - a2x) * s3 + l2 * s23 - a3y * c3),
            4: 2 * l1 * (l3 * s13 + a3x * s1 - a3y * c1),
            5: -2 * l2 * (l1 * s12 + a2x * s2),
            6: 2 * l1 * (l2 * s12 + a2x * s1),
        }
        assert all(self.same(printed[i], 2 * k) for i, k in self.legs.k.items())

    def test_the_adjugate_is_equation_8(self) -> None:
        """Equal except for one sign, a misprint: the entry in row 2, column 3 is −k3 k6."""
        k = dict(zip(range(1, 7), sp.symbols("k1:7"), strict=True))
        matrix = sp.Matrix([[k[6], k[5], 0], [0, k[1], k[3]], [k[4], 0, k[2]]])
        assert (matrix.adjugate() - sp.Matrix(adjugate(k))).expand().is_zero_matrix

    def test_the_second_derivatives_are_equation_11(self) -> None:
        for constraint, ours in zip(self.constraints, self.legs.second_derivatives, strict=True):
            hessian = sp.hessian(constraint, self.thetas)
            assert all(self.same(x, 2 * y) for x, y in zip(hessian, sp.Matrix(ours), strict=True))

    def test_equation_10_takes_the_first_row_and_column_of_the_adjugate(self) -> None:
        k = dict(zip(range(1, 7), sp.symbols("k1:7"), strict=True))
        h = [sp.Matrix(3, 3, sp.symbols(f"h{n}_1:10")) for n in range(3)]
        adj = sp.Matrix([[k[6], k[5], 0], [0, k[1], k[3]], [k[4], 0, k[2]]]).adjugate()
        u, v = adj.row(0), adj.col(0)
        form = sum((u[n] * h[n] for n in range(3)), sp.zeros(3))
        assert sp.expand((v.T * form * v)[0] - coalescence(k, [m.tolist() for m in h])) == 0

    def test_equation_6_says_that_the_leg_lines_meet(self) -> None:
        base = [(0, 0), (self.a2x, 0), (self.a3x, self.a3y)]
        lines = [
            [y, -x, a * y - b * x] for (x, y), (a, b) in zip(self.vectors, base, strict=True)
        ]  # the line through (a, b) along (x, y)
        (t1, t2, t3), (_, s2, s3) = self.thetas, (sp.sin(t) for t in self.thetas)
        printed = self.a2x * s2 * sp.sin(t3 - t1) + (self.a3x * s3 - self.a3y * sp.cos(t3)) * sp.sin(t1 - t2)
        product = sp.prod(self.lengths)
        assert self.same(self.legs.singularity, product * printed)
        meet = sp.Matrix(lines).det()
        assert self.same(meet, self.legs.singularity) or self.same(meet, -self.legs.singularity)


def value(form: BiForm, t: mp.mpf, u: mp.mpf) -> mp.mpf:
    omega = mp.sqrt(form.radicand)
    rows = [
        mp.polyval([int(c) for c in reversed(row.a.coeffs())] or [0], u)
        + omega * mp.polyval([int(c) for c in reversed(row.b.coeffs())] or [0], u)
        for row in form.rows
    ]
    return mp.polyval(rows[::-1], t)


@pytest.mark.parametrize("name", ["innocenti", "zein-flat", "twelve-cusps"])
def test_13_and_14_are_6_and_10_with_half_angles_put_in(name: str) -> None:
    """At any pose, up to one constant each and powers of 1 + t² and 1 + u²."""
    m, l1 = EXAMPLES[name], Fraction("14.98")
    slice_map = SliceMap.of(m)
    f1, e1 = article_forms(slice_map, l1 * slice_map.scale)
    ratios: list[tuple[mp.mpf, mp.mpf]] = []
    with mp.workdps(60):
        for alpha, theta in ((20, 50), (-130, 70), (95, -160)):
            at = article_pose(m, str(l1), str(alpha), str(theta))
            vectors = [(r * c, r * s) for r, c, s in zip(at.lengths, at.cosines, at.sines, strict=True)]
            a2x, a3x, a3y = (mp.mpf(x.numerator) / x.denominator for x in (m.a2x, m.a3x, m.a3y))
            legs = Legs(tuple(vectors), a2x, a3x, a3y)  # type: ignore[arg-type]
            t, u = (mp.tan(mp.radians(x) / 2) for x in (alpha, theta))
            weight = (1 + t * t) * (1 + u * u)
            printed = legs.singularity, coalescence(legs.k, legs.second_derivatives)
            ratios.append(
                (
                    value(f1, t, u) / weight**2 / printed[0],
                    value(e1, t, u) / weight**6 / printed[1],
                )
            )
        for ratio in ratios[1:]:
            assert all(abs(x / y - 1) < mp.mpf(10) ** -30 for x, y in zip(ratio, ratios[0], strict=True))


def test_the_eliminant_is_the_resultant() -> None:
    """The modular eliminant against FLINT's resultant over ℤ[ω] with ω a symbol."""
    ring = fmpz_mpoly_ctx.get(("t", "u", "omega"), "lex")
    slice_map = SliceMap.of(Manipulator(*map(Fraction, (10, 5, 8, 6, 7, 7))))
    length = Fraction(9) * slice_map.scale
    ours = ArticleEliminant.of(slice_map, length)

    def joined(form: BiForm) -> Any:
        parts = ((i, w, part) for i, row in enumerate(form.rows) for w, part in enumerate((row.a, row.b)))
        return ring.from_dict(
            {(i, k, w): c for i, w, part in parts for k, c in enumerate(part.coeffs()) if c}
        )

    naive = joined(ours.f1).resultant(joined(ours.e1), "t")
    parts: tuple[dict[int, int], dict[int, int]] = ({}, {})
    for (_, k, w), c in naive.to_dict().items():
        parts[w % 2][k] = parts[w % 2].get(k, 0) + int(c) * slice_map.radicand ** (w // 2)
    top = max(parts[0])
    assert top == 96
    a, b = ours.whole.polynomial.a, ours.whole.polynomial.b
    for k in range(97):  # proportional
        assert parts[0].get(k, 0) * int(a[top]) == int(a[k]) * parts[0][top]
        assert parts[1].get(k, 0) * int(a[top]) == int(b[k]) * parts[0][top]


def test_the_articles_factorisation() -> None:
    """L1 = 14.98: 96 = 24 + quadratics and a quartic to their powers; Q is irreducible over Q(h)."""
    audit: Any = article_table(EXAMPLES["innocenti"], "14.98", digits=15).audit
    shape = [(row["degree"], row["multiplicity"]) for row in audit["factors"]]
    assert shape == [(2, 18), (2, 2), (2, 2), (2, 4), (4, 2), (2, 2), (2, 2), (2, 2), (24, 1)]
    assert sum(degree * times for degree, times in shape) == 96 == audit["eliminant_degree"]
    assert audit["factors"][-1]["irreducible"] == [{"degree": 24, "multiplicity": 1}]
    verdicts = {row["origin"]: {c["verdict"] for c in row["couples"]} for row in audit["factors"]}
    assert verdicts.pop("Q") == {"kept"}
    assert set.union(*verdicts.values()) == {"rejected"}
    reasons = {c["reason"] for row in audit["factors"][:-1] for c in row["couples"]}
    assert any(reason.startswith("leg 2 has length zero") for reason in reasons)
    assert any("adjugate's first column vanishes" in reason for reason in reasons)
    assert any("adjugate's first row vanishes" in reason for reason in reasons)
    assert audit["conjecture"]["holds"]


@pytest.mark.parametrize(("geometry", "expected"), VECTORS)
def test_both_methods_agree(geometry: dict[str, str], expected: dict[str, Any]) -> None:
    m = Manipulator.from_json(geometry)
    truth = solve_slice(eliminate(m), Fraction(expected["l1"]), 90)
    if any(point["kind"] == "curve" for point in truth.degenerate_points):
        with pytest.raises(SolverError, match="vanishes identically"):
            article_table(m, expected["l1"])
        return
    ours = article_table(m, expected["l1"])
    assert ours.count == expected["count"]
    assert ours.cusps == truth.cusps
    assert ours.table.degenerate_points == truth.degenerate_points
    assert ours.audit["conjecture"]["holds"]  # type: ignore[index]
    document = ours.to_json()
    assert (document["method"], document["l1"], document["count"]) == ("article", expected["l1"], truth.count)


@pytest.mark.slow
def test_a_thousand_digits() -> None:
    truth = solve_slice(eliminate(EXAMPLES["innocenti"]), Fraction("14.98"), 1000)
    assert article_table(EXAMPLES["innocenti"], "14.98", digits=1000).cusps == truth.cusps


def test_a_swallowtail_at_theta1_180_is_not_lost() -> None:
    m = Manipulator(*map(Fraction, (2, -4, 4, 1, 4, 3)), orientation="cw")
    ours, truth = article_table(m, 1, digits=30), solve_slice(eliminate(m), Fraction(1), 30)
    assert ours.table.degenerate_points == truth.degenerate_points
    assert ours.table.degenerate_points[0]["theta1_deg"].startswith("180.0")
    assert ours.cusps == truth.cusps


@pytest.mark.slow
@given(manipulators(size=6, denominators=(1,)), lengths(size=8, denominators=(1, 2)))
@examples(20)
def test_both_methods_agree_on_special_geometries(m: Manipulator, length: Fraction) -> None:
    truth = solve_slice(eliminate(m), length, 20)
    try:
        ours = article_table(m, length, digits=20)
    except SolverError:
        assert any(point["kind"] == "curve" for point in truth.degenerate_points)
        return
    assert (ours.cusps, ours.table.degenerate_points) == (truth.cusps, truth.degenerate_points)
    assert ours.audit["conjecture"]["holds"]  # type: ignore[index]


@pytest.mark.parametrize(("l1", "digits", "name"), [("0", 90, "l1"), ("x", 90, "l1"), ("5", 3, "digits")])
def test_bad_input_is_named(l1: str, digits: int, name: str) -> None:
    with pytest.raises(InputError) as caught:
        article_table(EXAMPLES["innocenti"], l1, digits=digits)
    assert [p.field for p in caught.value.problems] == [name]
