"""The article's equations (5), (6), (8)–(11): an independent derivation by SymPy, and what they mean."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import pytest
import sympy as sp

from rpr_solver.article.eliminant import Legs, adjugate, coalescence
from tests.support.constructed import (
    Constructed,
    cusp,
    fold,
    legs_1_and_3_in_line,
    legs_2_and_3_in_line,
    legs_along_both_sides,
    legs_of,
    lines_meet_in_b1,
    lines_meet_in_b3,
)

pytestmark = pytest.mark.quick


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

    def test_the_determinant_of_the_jacobian_is_equation_6_times_the_platforms_area(self) -> None:
        """So (6) says that (5) is singular, unless the platform is flat and always so."""
        k = self.legs.k
        b1, b2, b3 = (sp.Matrix(point) for point in self.platform)
        area2 = sp.Matrix.hstack(b2 - b1, b3 - b1).det()
        determinant = k[1] * k[2] * k[6] + k[3] * k[4] * k[5]
        assert sp.expand(determinant - area2 * self.legs.singularity) == 0

    @property
    def platform(self) -> list[tuple[Any, Any]]:
        """B1, B2, B3."""
        base = [(0, 0), (self.a2x, 0), (self.a3x, self.a3y)]
        return [(a + x, b + y) for (a, b), (x, y) in zip(base, self.vectors, strict=True)]


def condition(legs: Legs) -> Fraction:
    return Fraction(coalescence(legs.k, legs.second_derivatives))


class TestAtConstructedPoses:
    """What the equations say, against Euler and Savary."""

    def test_where_a3_is_the_centre_of_curvature_6_and_10_hold(self) -> None:
        legs = legs_of(cusp())
        assert legs.singularity == 0
        assert condition(legs) == 0
        assert all(legs.k.values())

    def test_elsewhere_on_leg_3_only_6_holds(self) -> None:
        legs = legs_of(fold())
        assert legs.singularity == 0
        assert condition(legs) != 0

    @pytest.mark.parametrize(
        ("constructed", "zero"),
        [
            (legs_1_and_3_in_line(), {2, 4}),
            (legs_2_and_3_in_line(), {1, 3}),
            (lines_meet_in_b1(), {2, 5}),
            (lines_meet_in_b3(), {1, 4}),
            (legs_along_both_sides(), {2, 4, 5}),
        ],
    )
    def test_10_also_holds_where_a_row_or_column_vanishes(
        self, constructed: Constructed, zero: set[int]
    ) -> None:
        legs = legs_of(constructed)
        assert {i for i, k in legs.k.items() if k == 0} == zero
        assert legs.singularity == 0
        assert condition(legs) == 0
