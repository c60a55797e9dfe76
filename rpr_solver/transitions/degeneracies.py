"""What is degenerate throughout: in every slice of an interval of lengths, or along a whole curve of poses.

Transitions are single lengths with single degenerate poses; any manipulator has some. Symmetric and flat
manipulators also have degenerate poses in all slices, or whole curves of them, as congruent triangles
(mathematics.md#what-is-degenerate-throughout). Their numbers of cusps are right all the same, but a table of
these numbers alone would look clean.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import groupby
from typing import Any

from flint import nmod_mat, nmod_poly

from rpr_solver.exact.biform import BiForm
from rpr_solver.exact.modular import primes
from rpr_solver.exact.number_field import (
    Algebraic,
    Polynomial,
    adjoin_real_roots,
    exact_omega,
    poly_gcd,
    squarefree_part,
    trimmed,
)
from rpr_solver.exact.rationals import exact_or_none, exact_str
from rpr_solver.model.joint_points import PoseKind
from rpr_solver.model.lengths import LengthRange
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.notebook import degenerate_words
from rpr_solver.slices import Eliminant
from rpr_solver.slices.eliminant import DEGREE_L
from rpr_solver.slices.reference import divided, formal_resultant
from rpr_solver.transitions.event_systems import Landmark, length_text
from rpr_solver.transitions.survey import Survey

_PLACES = 2, 3
_FORMAL_DEGREE = 14
"""Of Res_t(J/L, E) in L."""
_DEGREE = DEGREE_L + 2
"""Its degree: that of the eliminant and that of leg f's closing."""


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


def degeneracies(result: Survey, span: LengthRange, digits: int) -> tuple[Degeneracy, ...]:
    """What is degenerate in a range of lengths: curves first, then poses, ascending by their intervals.

    Args:
        result: the survey of that range.
        span: the range.
        digits: significant digits of the ends of intervals.

    Raises:
        SolverError: an end could not be decided.
    """
    slice_map = result.eliminant.slice_map
    ends = [
        lambda: exact_str(span.start),
        *(lambda group=group: length_text(slice_map, group, digits) for group in result.groups),
        lambda: exact_or_none(span.stop),
    ]
    return (*_curves(result.eliminant, span, digits), *_poses(result, ends))


def _poses(result: Survey, ends: Sequence[Callable[[], str | None]]) -> Iterator[Degeneracy]:
    """Runs of intervals whose slices have the same number of degenerate poses of one kind."""
    numbers = [Counter(point["kind"] for point in part.degenerate_points) for part in result.slices]
    found: list[tuple[int, Degeneracy]] = []
    for kind in {kind for number in numbers for kind in number} - {PoseKind.CURVE}:
        places = enumerate(number[kind] for number in numbers)
        for count, run in groupby(places, key=lambda place: place[1]):
            first, *_, last = [*(k for k, _ in run)] * 2
            if count:
                start, stop = ends[first](), ends[last + 1]()
                leg = result.eliminant.slice_map.fixed_leg
                found.append((first, Degeneracy(leg, PoseKind(kind), str(start), stop, count)))
    yield from (part for _, part in sorted(found, key=lambda item: (item[0], item[1].kind)))


def _curves(eliminant: Eliminant, span: LengthRange, digits: int) -> Iterator[Degeneracy]:
    """The curves that J and E share in every slice, and those in the slices of single lengths."""
    slice_map = eliminant.slice_map
    if _has_no_curves(slice_map):
        return
    leg, ends = slice_map.fixed_leg, (exact_str(span.start), exact_or_none(span.stop))
    omega = exact_omega(slice_map.radicand)
    rows = eliminant.rows(omega)
    j, e = slice_map.singular, slice_map.coalescence
    if all(x.is_zero for row in rows for x in row):
        j, e, curves = divided(j, e, slice_map.rho)
        for curve in curves:
            equation = curve.in_unit(slice_map.scale).equation(slice_map)
            yield Degeneracy(leg, PoseKind.CURVE, *ends, equation=equation)
        rows = _rows(BiForm.of(formal_resultant(j, e), slice_map.radicand, 0, 0), omega)
    for length in _common_lengths(rows):
        if _is_inside(length, slice_map, span):
            text = length_text(slice_map, [Landmark(length)], digits)
            for known in _equations(j, e, length, slice_map):
                yield Degeneracy(leg, PoseKind.CURVE, text, text, equation=known)


def _has_no_curves(slice_map: SliceMap) -> bool:
    """Proof modulo a prime that the eliminant in u is 0 for no L; False if there is none.

    Res_t(J, E) is a multiple of it. If two values of u give polynomials in L without a common root modulo the
    prime, one of which keeps its degree, they have none.
    """
    p, omega = next(primes(slice_map.radicand))
    lengths, values = range(1, _FORMAL_DEGREE + 2), []
    for u in _PLACES:
        forms = [[[q.residue(p, omega)(u) for q in row] for row in table] for table in slice_map.tables]
        for length in lengths:
            j, e = (nmod_poly([nmod_poly(row, p)(length) for row in form], p) for form in forms)
            if (j.degree() + 1, e.degree() + 1) != (len(forms[0]), len(forms[1])):
                return False
            values.append(int(j.resultant(e)))
    size = len(lengths)
    powers = nmod_mat(size, size, [length**k for length in lengths for k in range(size)], p)
    columns = powers.solve(nmod_mat(len(_PLACES), size, values, p).transpose()).transpose()
    first, second = (nmod_poly(list(map(int, row)), p) for row in columns.tolist())
    degree = max(first.degree(), second.degree())
    return bool(degree == _DEGREE and first.gcd(second).degree() == 0)


def _rows(form: BiForm, omega: Algebraic) -> list[list[Algebraic]]:
    """For each power of u the coefficients of L⁰, L¹, … of a form without t."""
    [powers] = form.coefficients
    degree = max((max(p.a.degree(), p.b.degree()) for p in powers), default=0)
    return [[p.coefficient(i, omega) for p in powers] for i in range(degree + 1)]


def _common_lengths(rows: Sequence[Sequence[Algebraic]]) -> Iterator[Algebraic]:
    """The L > 0 (scaled) at which all polynomials in L vanish: there the eliminant in u is 0."""
    lowest = min((k for row in rows for k, x in enumerate(row) if not x.is_zero), default=0)
    common: Polynomial = []
    for row in rows:
        common = poly_gcd(common, trimmed(row[lowest:]))
        if len(common) == 1:
            return
    field = rows[0][0].field
    for extension in adjoin_real_roots(field, squarefree_part(common)):
        if extension.root.sign > 0:
            yield extension.root


def _is_inside(length: Algebraic, slice_map: SliceMap, span: LengthRange) -> bool:
    """Whether a *scaled* length is strictly within a range."""
    low, high = (None if x is None else length.field(x * slice_map.scale) for x in (span.start, span.stop))
    return (low is None or (length - low).sign > 0) and (high is None or (high - length).sign > 0)


def _equations(j: BiForm, e: BiForm, length: Algebraic, slice_map: SliceMap) -> list[str | None]:
    """Those of the curves that J and E share at a *scaled* length; [None] if it is irrational."""
    if length.rational is None:
        return [None]
    _, _, curves = divided(j.sliced(length.rational), e.sliced(length.rational), slice_map.rho)
    return [curve.equation(slice_map) for curve in curves]
