"""The eliminant Q(u, L): every cusp of every slice, as one polynomial over ℤ[ω].

With the half tangents t and u of α and θ (slice_map.py), all degrees formal, eliminating t from J and E gives

    Res_t(J, E) = c · w(u)² · (1+ρu²)⁹ · q(u, L) · Q(u, L),     48 = 4 + 18 + 2 + 24

- w: the fixed leg lies along the base line to leg f; ∇f = 0 at both such poses, so E = 0 is no condition;
- q: leg f has length 0; again ∇f = 0;
- 1 + ρu²: the circular points. The Newton polygons of J and E, as Laurent polynomials in exp(iα) and exp(iθ),
  are so small that the resultant has the exponents −15…15 of exp(iθ) instead of −24…24, hence a factor
  (1+ρu²)⁹ for every geometry;
- Q: degree 24 in u, 10 in L.

The first three are factors for every geometry, and Q is integral (mathematics.md#the-eliminant); so is its
quotient by some squared sides (mathematics.md#the-content-of-the-eliminant). So Q at one length is determined
by balls round its values at ±2ᵏ that hold one integer each (exact/two_values.py). Q for all lengths is
interpolated from 12 of them, the negative ones for nothing. Where few slices are asked for, Q is computed at
their lengths alone.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from math import isqrt, prod
from threading import Lock
from typing import Any

from flint import arb, fmpq, fmpq_mat, fmpz, fmpz_mat, fmpz_poly, nmod_mat

from rpr_solver.contract import FEW_SLICES, SOLVER_VERSION, check_leg, check_type
from rpr_solver.exact.elimination import ball_resultant, no_quotient
from rpr_solver.exact.modular import primes
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.two_values import from_two_values, resultant_bits
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.triangles import points_needed, read_geometry

DEGREE_U = 24
DEGREE_L = 10
_DEGREE, _TWOS = 26, 8
"""The degree of Q in all lengths, without the squared sides, and half of that in those of the platform."""
_LENGTHS = 6
_CIRCULAR = 9
"""The power of 1 + ρu² in the resultant."""
_MULTIPLES = [sign * k for sign in (1, -1) for k in range(1, _LENGTHS + 1)]
_FROM_LENGTHS = fmpq_mat([[k**power for power in range(2 * _LENGTHS)] for k in _MULTIPLES]).inv()
"""From values at the lengths ±1, …, ±6 to coefficients; there is one more length than coefficients."""


@dataclass
class Coefficients:
    """The integers of Q = A + ω B, computed when they are needed: for the first few slices Q is not."""

    slice_map: SliceMap
    known: tuple[fmpz_mat, fmpz_mat] | None = None
    _slices: dict[Fraction, QuadraticPoly] = field(default_factory=dict, init=False, compare=False)

    def whole(self) -> tuple[fmpz_mat, fmpz_mat]:
        """A and B, see :class:`Eliminant`.

        Raises:
            SolverError: the resultant lacks one of its known factors.
        """
        if self.known is None:
            self.known = self._sampling.whole()
            self._slices.clear()
        return self.known

    def at(self, length: Fraction) -> QuadraticPoly:
        """Q at one *scaled* L, primitive; raises the same error."""
        if self.known is None and length not in self._slices and len(self._slices) < FEW_SLICES:
            self._slices[length] = self._sampling.at(length)[0].primitive()
        if q := self._slices.get(length):
            return q
        n, d = fmpz(length.numerator), fmpz(length.denominator)
        powers = fmpz_mat(DEGREE_L + 1, 1, [n**k * d ** (DEGREE_L - k) for k in range(DEGREE_L + 1)])
        a, b = (fmpz_poly((part * powers).entries()) for part in self.whole())
        return QuadraticPoly(a, b, self.slice_map.radicand).primitive()

    @property
    def likely_bytes(self) -> int:
        """About what all coefficients take, once they are known."""
        if self.known is not None:
            return sum(fmpz(x).bit_length() // 8 + 32 for part in self.known for x in part.entries())
        step, unit = (int(x).bit_length() for x in (self._sampling.step, self._sampling.unit))
        bits = _DEGREE * step + DEGREE_L * unit
        return 2 * (DEGREE_U + 1) * (DEGREE_L + 1) * (bits // 8 + 32)

    @cached_property
    def _sampling(self) -> _Sampling:
        return _Sampling.of(self.slice_map)


@dataclass(frozen=True)
class Eliminant:
    """Q(u, L) of one manipulator and one fixed leg: every cusp of every slice is above one of its roots.

    u is the half tangent of the fixed leg's angle, L its *scaled* length: the length in the user's unit times
    ``slice_map.scale``. Q = A + ω B has integer coefficients, degree 24 in u and 10 in L; it is the factor
    that the article keeps (step 5), for symbolic L. Where legs share joints, no slice has a cusp, and Q is 1.

    Attributes:
        manipulator: the geometry.
        slice_map: the integer model of its slices, with the fixed leg, the scale and ω² (``radicand``).
        coefficients: those of Q, as far as they are known.
        kept: what the solver of slices keeps for the next ones.

    >>> from rpr_solver import EXAMPLES, eliminate
    >>> eliminate(EXAMPLES["zein-flat"])
    <Eliminant of leg 1: degree 24 in u, 10 in L1>
    """

    manipulator: Manipulator
    slice_map: SliceMap
    coefficients: Coefficients
    kept: dict[Any, Any] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __repr__(self) -> str:
        leg = self.slice_map.fixed_leg
        return f"<Eliminant of leg {leg}: degree {DEGREE_U} in u, {DEGREE_L} in L{leg}>"

    @property
    def a(self) -> fmpz_mat:
        """A: a row for each of 25 powers of u, a column for each of 11 powers of the scaled L.

        A and B have no common content.
        """
        return self.coefficients.whole()[0]

    @property
    def b(self) -> fmpz_mat:
        """B, likewise."""
        return self.coefficients.whole()[1]

    @cached_property
    def residues(self) -> tuple[int, int, nmod_mat]:
        """A prime, a value of ω modulo it, and A + ω B modulo it in the same rows and columns."""
        p, omega = next(primes(self.slice_map.radicand))
        pairs = zip(self.a.entries(), self.b.entries(), strict=True)
        image = [int((a + omega * b) % p) for a, b in pairs]
        return p, omega, nmod_mat(DEGREE_U + 1, DEGREE_L + 1, image, p)

    def rows(self, omega: Any) -> list[list[Any]]:
        """For each power of u the coefficients of L⁰, L¹, … in a ring with ω."""
        rows = zip(self.a.tolist(), self.b.tolist(), strict=True)
        return [[omega * int(y) + int(x) for x, y in zip(*row, strict=True)] for row in rows]

    def at(self, length: Fraction) -> QuadraticPoly:
        """Q at one *scaled* L, primitive: A(u) + ω B(u); zero if J and E share a curve there."""
        return self.coefficients.at(length)

    def expect(self, slices: int) -> Eliminant:
        """The same, with its coefficients computed now if this many slices repay it."""
        if slices > FEW_SLICES:
            self.coefficients.whole()
        return self

    def to_json(self) -> dict[str, Any]:
        """A JSON form for caches (about 100 kB); :meth:`from_json` is its inverse."""
        return {
            "solver_version": SOLVER_VERSION,
            "geometry": self.manipulator.to_json(),
            # what the coordinates depend on, where it is not the canonical form alone
            "points": points_needed(self.manipulator.geometry),
            "fixed_leg": self.slice_map.fixed_leg,
            "a": " ".join(str(x) for x in self.a.entries()),
            "b": " ".join(str(x) for x in self.b.entries()),
        }

    @classmethod
    def from_json(cls, obj: Mapping[str, object]) -> Eliminant:
        """The inverse of :meth:`to_json`.

        Raises:
            ValueError: made by another version of the solver.
        """
        if obj["solver_version"] != SOLVER_VERSION:
            raise ValueError(f"eliminant of solver version {obj['solver_version']}, not {SOLVER_VERSION}")
        geometry, points, leg = obj["geometry"], obj["points"], obj["fixed_leg"]
        if not isinstance(geometry, Mapping) or not isinstance(points, Mapping) or not isinstance(leg, int):
            raise ValueError("not an eliminant")
        read = read_geometry(geometry, max_digits=1 << 20)
        manipulator = Manipulator.of(read.with_points(points))
        a, b = (
            fmpz_mat(DEGREE_U + 1, DEGREE_L + 1, [fmpz(x) for x in str(obj[part]).split()]) for part in "ab"
        )
        slice_map = SliceMap.of(manipulator, leg, with_shared=True)
        return cls(manipulator, slice_map, Coefficients(slice_map, (a, b)))


def eliminate(manipulator: Manipulator, fixed_leg: int = 1) -> Eliminant:
    """Q(u, L) of a manipulator and one fixed leg, to be shared by all slices.

    It is computed for the first few slices at their lengths (a third of a millisecond to one each), then or
    when its coefficients are needed for all lengths (5 to 30 ms).

    Args:
        manipulator: the geometry.
        fixed_leg: the leg of fixed length, 1, 2 or 3.

    Raises:
        InputError: naming ``manipulator`` or ``fixed_leg``.

    >>> from rpr_solver import EXAMPLES, solve_slice
    >>> eliminant = eliminate(EXAMPLES["zein-flat"], fixed_leg=3)
    >>> solve_slice(eliminant, 10, 15)
    <SliceTable L3=10: 4 cusps, 15 digits>
    """
    slice_map = SliceMap.of(manipulator, fixed_leg, with_shared=True)
    known = _one() if manipulator.geometry.shared_joints else None
    return Eliminant(manipulator, slice_map, Coefficients(slice_map, known))


def _one() -> tuple[fmpz_mat, fmpz_mat]:
    """Q = 1, where no slice has a cusp (mathematics.md#shared-joints)."""
    size = DEGREE_U + 1, DEGREE_L + 1
    a = fmpz_mat(*size)
    a[0, 0] = 1
    return a, fmpz_mat(*size)


@dataclass(frozen=True)
class _Sampling:
    """Q at single lengths, of which twelve determine it: ±k · step, k = 1, …, 6.

    A negative length in the opposite direction is the same leg, so Q(θ + π, −L) = Q(θ, L), and Q at the
    negative lengths has the coefficients of Q at the positive ones.

    Attributes:
        along: the primitive part of w.
        unit: that of the slice map. Q is computed as a polynomial in L / unit.
    """

    slice_map: SliceMap
    along: QuadraticPoly
    unit: int

    @classmethod
    def of(cls, slice_map: SliceMap) -> _Sampling:
        return cls(slice_map, slice_map.f.collinear.primitive(), slice_map.unit)

    @cached_property
    def _content(self) -> Fraction:
        """That of Q without its powers of ν and of the denominator of L (see :meth:`at`)."""
        f, g = self.slice_map.f, self.slice_map.g
        sides = f.platform2**2 * g.platform2 * self.slice_map.side2
        content = sides * Fraction(self.unit**_DEGREE, 1 << _TWOS) * f.collinear.content**2
        return content * self.slice_map.rho**3

    @cached_property
    def step(self) -> int:
        """In terms of the unit."""
        legs = self.slice_map.f, self.slice_map.g
        size = isqrt(max(x for leg in legs for x in (leg.base2, leg.platform2))) // self.unit
        return max((1 << size.bit_length()) // 4, 1)

    def whole(self) -> tuple[fmpz_mat, fmpz_mat]:
        """A and B, as in :class:`Eliminant`; raises SolverError if a known factor is missing."""
        samples = [self.at(Fraction(k * self.step * self.unit)) for k in range(1, _LENGTHS + 1)]
        (a, below_a), (b, below_b) = (
            self._by_length([(part, scale) for part, (_, scale) in zip(parts, samples, strict=True)])
            for parts in ([q.a for q, _ in samples], [q.b for q, _ in samples])
        )
        below = below_a.lcm(below_b)
        a, b = a * (below // below_a), b * (below // below_b)
        content = fmpz_poly([*a.entries(), *b.entries()]).content() or fmpz(1)
        size = DEGREE_U + 1, DEGREE_L + 1
        first, second = (fmpz_mat(*size, [x // content for x in part.entries()]) for part in (a, b))
        return first, second

    def _by_length(self, samples: Sequence[tuple[fmpz_poly, Fraction]]) -> tuple[fmpz_mat, fmpz]:
        """A or B of Q over a number, from that of the samples: a column for each power of L."""
        rho, top = self.slice_map.rho, DEGREE_U
        values = [[fmpq(*x.as_integer_ratio()) * p[i] for i in range(top + 1)] for p, x in samples]
        # u becomes −1/(ρ u) with −L
        signs = [fmpq(rho) ** (i - top // 2) * (-1) ** i for i in range(top + 1)]
        turned = [[x * row[top - i] for i, x in enumerate(signs)] for row in values]
        *rows, spare = (_FROM_LENGTHS * fmpq_mat(values + turned)).tolist()
        if any(spare):
            raise no_quotient()
        length = fmpq(self.step * self.unit)
        return (
            fmpq_mat([[x / length**k for x in row] for k, row in enumerate(rows)]).transpose().numer_denom()
        )

    def at(self, length: Fraction) -> tuple[QuadraticPoly, Fraction]:
        """Q at one length over a number, and this number; raises the same error.

        With L = x/y what is computed of J, E and q is times powers of y, as they have of L.
        """
        slice_map, rho = self.slice_map, self.slice_map.rho
        closed, (j, e) = slice_map.f.closed(length), slice_map.sliced(length)
        over, known = closed.content, (self.along, self.along, closed.primitive())
        # of primitive factors the quotient is integral
        divided = Fraction(j.content**e.degree * e.content**j.degree, over)
        power = e.degree * j.powers + j.degree * e.powers - 2
        denominators = Fraction(length.denominator**power, (length / self.unit).denominator ** DEGREE_L)
        content = (self._content * denominators / divided).numerator
        bits = resultant_bits(j.size(rho), e.size(rho), known, content, DEGREE_U, rho)

        def value(u: int) -> Callable[[arb], arb]:
            pairs = [(p.a(u), p.b(u)) for p in (*j.rows, *e.rows, *known)]
            circular = content * (1 + rho * u * u) ** _CIRCULAR

            def at(omega: arb) -> arb:
                values = [arb(a) + omega * b if b else arb(a) for a, b in pairs]
                first, second = values[: j.degree + 1], values[j.degree + 1 : -len(known)]
                return ball_resultant(first, second) / prod(values[-len(known) :], start=arb(circular))

            return at

        q = from_two_values(slice_map.radicand, DEGREE_U, bits, value)
        return q, content * divided / length.denominator**power


MOST_BYTES = 16 << 20
"""What the coefficients that are kept may take: those of about 200 manipulators of ordinary sides."""

_Key = tuple[Manipulator, int]


@dataclass
class KeptEliminants:
    """Eliminants by geometry and fixed leg, the last used ones; safe for threads.

    Each call gets an :class:`Eliminant` of its own, which shares nothing that changes.

    >>> from rpr_solver import EXAMPLES
    >>> store = KeptEliminants()
    >>> first, second = (store.eliminant(EXAMPLES["innocenti"], 1) for _ in range(2))
    >>> first is second, first.a is second.a, len(store)
    (False, True, 1)
    """

    most_bytes: int = MOST_BYTES
    _stored: OrderedDict[_Key, tuple[Eliminant, int]] = field(default_factory=OrderedDict, repr=False)
    _bytes: int = 0
    _lock: Lock = field(default_factory=Lock, repr=False)

    def __len__(self) -> int:
        return len(self._stored)

    def eliminant(self, manipulator: Manipulator, fixed_leg: int) -> Eliminant:
        """As :func:`eliminate`, which is only called for what is not kept.

        Raises:
            InputError: naming ``manipulator`` or ``fixed_leg``.
            SolverError: the resultant lacks one of its known factors.
        """
        check_type(manipulator, Manipulator, "manipulator")
        key = manipulator, check_leg(fixed_leg)
        with self._lock:
            if key in self._stored:
                self._stored.move_to_end(key)
                return replace(self._stored[key][0])
        # without the lock: another thread may want another manipulator meanwhile
        eliminant = eliminate(manipulator, fixed_leg)
        size = eliminant.coefficients.likely_bytes
        with self._lock:
            if size <= self.most_bytes and key not in self._stored:
                self._stored[key] = eliminant, size
                self._bytes += size
            while self._bytes > self.most_bytes:
                _, (_, freed) = self._stored.popitem(last=False)
                self._bytes -= freed
        return replace(eliminant)


kept_eliminant = KeptEliminants().eliminant
"""As :func:`eliminate`, for calls that are likely to come again with the same geometry and leg."""
