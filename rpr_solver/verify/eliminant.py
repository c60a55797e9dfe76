"""The resultant of J and E in tan(α/2), divided exactly by its spurious factors, and its lines.

A *line* is a value of u = tan(θ/2). Every pose in which three or more poses coalesce has J = E = 0, so it
lies on a line where the resultant vanishes, and the order of the resultant there is at least the number of
these poses.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property

from rpr_solver.verify.core.modular import simple_and_apart
from rpr_solver.verify.core.resultants import interpolated_resultant
from rpr_solver.verify.core.roots import Root, real_roots
from rpr_solver.verify.core.surds import (
    ONE,
    ZERO,
    Indivisible,
    Poly,
    Ring,
    Surd,
    derivative,
    primitive,
    rational,
)
from rpr_solver.verify.core.system import System, at_half_tangent

DEGREE = 24
_CIRCULAR = rational([1, 0, 1])
_SAMPLES = 6


@dataclass(frozen=True)
class _Cut:
    """How often t = tan(α/2) divides J and E for every θ, and how often 1/t does."""

    at_zero: tuple[int, int] = (0, 0)
    at_infinity: tuple[int, int] = (0, 0)

    @classmethod
    def of(cls, system: System) -> _Cut:
        # polynomials of degree 6 in u at most, so 13 values of u decide
        samples = range(-_SAMPLES, _SAMPLES + 1)
        counts = []
        for reverse in (False, True):
            orders = []
            for p, degree in ((system.singular, 2), (system.first.kernel, 3)):
                rows = [at_half_tangent(p, degree, degree, Fraction(u)) for u in samples]
                rows = [row[::-1] for row in rows] if reverse else rows
                orders.append(
                    min(next((k for k, x in enumerate(row) if x != ZERO), len(row)) for row in rows)
                )
            counts.append((orders[0], orders[1]) if all(orders) else (0, 0))
        return cls(counts[0], counts[1])

    @property
    def curves(self) -> list[str]:
        """The shared curves, as documents write them."""
        names = ("alpha = 0 deg", self.at_zero), ("alpha = 180 deg", self.at_infinity)
        return [name for name, orders in names if any(orders)]

    def applied(self, row: tuple[Surd, ...], which: int) -> tuple[Surd, ...]:
        """The coefficients in t of J (0) or E (1) without the shared curves."""
        return row[self.at_zero[which] : len(row) - self.at_infinity[which]]


def _resultant(system: System, cut: _Cut) -> Poly:
    return interpolated_resultant(
        system.ring,
        lambda u: cut.applied(at_half_tangent(system.singular, 2, 2, Fraction(u)), 0),
        lambda u: cut.applied(at_half_tangent(system.first.kernel, 3, 3, Fraction(u)), 1),
        48,
    )


@dataclass(frozen=True)
class Eliminant:
    """Q, a form of degree 24 in u, and the two spurious quadratics; Res_t(J, E) = w² (u²+1)⁹ q Q.

    ``form`` is empty if the resultant vanishes identically. Then J and E share the curves of ``cut``, and
    ``rest`` is the resultant of their quotients by these, not divided by anything.
    """

    ring: Ring
    form: tuple[Surd, ...]
    along: Poly
    closed: Poly
    cut: _Cut = field(default_factory=lambda: _Cut())
    rest: Poly = ()

    @classmethod
    def of(cls, system: System) -> Eliminant:
        """Eliminates α.

        Raises:
            Indivisible: the spurious factors do not divide the resultant.
        """
        ring, w, q = system.ring, system.along, system.closed

        resultant = _resultant(system, _Cut())
        if not resultant:
            cut = _Cut.of(system)
            return cls(ring, (), w, q, cut, _resultant(system, cut) if cut.curves else ())
        for factor in (w, w, q, *[_CIRCULAR] * 9):
            resultant = ring.field_quotient(resultant, factor)
        if len(resultant) > DEGREE + 1:
            raise Indivisible("the spurious factors do not divide the resultant at u = infinity")
        form = resultant + (ZERO,) * (DEGREE + 1 - len(resultant))
        return cls(ring, form, w, q)

    @classmethod
    def if_any(cls, system: System) -> Eliminant | None:
        """As :meth:`of`; None where that is impossible."""
        try:
            return cls.of(system)
        except Indivisible:
            return None

    @cached_property
    def finite(self) -> Poly:
        """Q without its roots at u = ∞."""
        return primitive(self.form)

    @property
    def at_infinity(self) -> int:
        """The multiplicity of the root u = ∞."""
        return len(self.form) - len(self.finite)

    @cached_property
    def generic(self) -> bool:
        """Whether a prime proves that all 24 roots are finite, simple and apart from the spurious ones."""
        spurious = self.ring.product(self.along, self.closed)
        whole = bool(self.form) and not self.at_infinity
        return whole and simple_and_apart(self.ring, self.finite, spurious)

    @cached_property
    def parts(self) -> dict[int, Poly]:
        """Multiplicity → the product of the finite factors of Q with it."""
        if not self.form:
            return {}
        return {1: self.finite} if self.generic else self.ring.squarefree_parts(self.finite)

    @property
    def shape(self) -> dict[int, int]:
        """Multiplicity → total degree of the factors of Q, infinity included."""
        shape = {multiplicity: len(part) - 1 for multiplicity, part in self.parts.items()}
        if self.at_infinity:
            shape[self.at_infinity] = shape.get(self.at_infinity, 0) + 1
        return shape

    @cached_property
    def single(self) -> Poly:
        """The product of the simple factors that share no root with the spurious ones."""
        simple = self.parts.get(1, (ONE,))
        if self.generic:
            return simple
        for factor in (self.along, self.closed):
            common = self.ring.gcd(simple, factor)
            if len(common) > 1:
                simple = self.ring.field_quotient(simple, common)
        return simple

    @cached_property
    def single_roots(self) -> list[Root]:
        """The real lines on which exactly one pose has J = E = 0, and this pose is a cusp."""
        return real_roots(self.ring, self.single)

    @cached_property
    def finite_real_roots(self) -> int:
        """The number of different finite real roots of Q."""
        return sum(len(real_roots(self.ring, part)) for part in self.parts.values())

    @cached_property
    def special(self) -> Poly:
        """A squarefree polynomial of all other finite lines: multiple roots of Q, and spurious ones."""
        ring = self.ring
        whole = ring.product(primitive(self.along), primitive(self.closed))
        if not self.form:
            whole = ring.product(whole, self.rest)
        for multiplicity, part in self.parts.items():
            rest = ring.field_quotient(part, self.single) if multiplicity == 1 else part
            whole = ring.product(whole, rest)
        common = ring.gcd(whole, derivative(whole))
        return ring.field_quotient(whole, common)

    @cached_property
    def special_roots(self) -> list[Root]:
        """The finite lines that may hold several poses with J = E = 0, or spurious ones."""
        return real_roots(self.ring, self.special) if len(self.special) > 1 else []

    @property
    def special_at_infinity(self) -> bool:
        """Whether the line u = ∞, where θ = 180°, is one of them."""
        return not self.form or bool(self.at_infinity) or len(self.along) < 3 or len(self.closed) < 3
