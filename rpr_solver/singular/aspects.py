"""Aspects, the connected regions of poses on which J has one sign: of a slice, and of a range of lengths.

Inside an aspect two poses are joined by a motion without a singular pose; between aspects there is none.
Those of a slice are classes of *cells*, the gaps between the arcs of each slab, joined where a gap
continues through a line (mathematics.md#the-sweep).

In a range the fixed leg is free too. J is L (J0 + L J1), so for each (α, θ) the lengths in [a, b] with
s J > 0 form an interval, which contains a or b if it is not empty; if both are in it, all between are. So the
aspects of the range are the components of {s J(a) > 0} ∪ {s J(b) > 0} on the torus: the aspects of the two
slices, those of one sign joined where they overlap. An overlap is open, and between neighbouring lines of
both sweeps and of the resultant of J(a) and J(b) it is seen on any line θ = const
(mathematics.md#aspects-of-a-range).

At an open end the limits of J / L and of J / L² take the place of a slice: J0 for L → 0, J1 for L → ∞.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise, product
from math import degrees, pi, sqrt
from typing import Any, Generic, TypeVar

from flint import fmpz_poly

from rpr_solver.contract import check_leg
from rpr_solver.errors import SolverError
from rpr_solver.exact.biform import BiForm, without_common_factors
from rpr_solver.exact.elimination import resultant
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.rationals import Exact
from rpr_solver.exact.real_roots import RealRoot, fraction_of, real_roots
from rpr_solver.model.float_slice import drawn
from rpr_solver.model.jets import whole_angle
from rpr_solver.model.joint_points import coordinate_names
from rpr_solver.model.lengths import LengthRange
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.singular.charts import Chart, turned_rows, turns_of
from rpr_solver.singular.line import between, position
from rpr_solver.singular.polygons import Point, polygon_area, strips
from rpr_solver.singular.simple_lines import line_events, simple_chart
from rpr_solver.singular.sweep import Sweep, in_order, sweep
from rpr_solver.singular.tracing import TURN, Sample

T = TypeVar("T", bound=Hashable)
Cell = tuple[int, int]
"""A slab and the number of a gap in it."""


class UnionFind(Generic[T]):
    """Classes of things that are joined pairwise."""

    def __init__(self, things: Iterable[T]) -> None:
        self._above: dict[T, T] = {}
        self.add(things)

    def add(self, things: Iterable[T]) -> None:
        """More things; those that are there already stay as they are."""
        for thing in things:
            self._above.setdefault(thing, thing)

    def __contains__(self, thing: T) -> bool:
        return thing in self._above

    def root(self, thing: T) -> T:
        """The representative of a class."""
        above = self._above
        while above[thing] != thing:
            above[thing] = thing = above[above[thing]]
        return thing

    def join(self, first: T, second: T) -> None:
        """Makes one class of two."""
        self._above[self.root(second)] = self.root(first)

    def classes(self) -> list[list[T]]:
        """The classes, each in the order in which its things were given."""
        result: dict[T, list[T]] = {}
        for thing in self._above:
            result.setdefault(self.root(thing), []).append(thing)
        return list(result.values())


@dataclass(frozen=True)
class Aspect:
    """A connected region of the torus of poses (α, θ) on which J has one sign.

    Attributes:
        sign: that of J.
        share: the part of the torus that it covers, about.
        polygons: closed polygons of (α, θ) in degrees, from −180 to 180, for drawing; together they cover
            the aspect, and they meet only along their edges.

    >>> from rpr_solver import EXAMPLES, singular_curves
    >>> [aspect.sign for aspect in singular_curves(EXAMPLES["innocenti"], 27).aspects]
    [1, 1, -1]
    >>> singular_curves(EXAMPLES["innocenti"], 27).aspects[0]
    <Aspect of J > 0: 47.6% of the poses>
    """

    sign: int
    share: float
    polygons: tuple[tuple[Point, ...], ...]

    def __repr__(self) -> str:
        return f"<Aspect of J {'>' if self.sign > 0 else '<'} 0: {self.share:.1%} of the poses>"

    def to_json(self, fixed_leg: int) -> dict[str, Any]:
        """The document's aspect object."""
        alpha, theta, *_ = coordinate_names(fixed_leg)
        return {
            "sign": self.sign,
            "share": round(self.share, 6),
            "polygons": [
                dict(zip((alpha, theta), map(drawn, zip(*polygon, strict=True)), strict=True))
                for polygon in self.polygons
            ],
        }


def aspect_cells(sweep: Sweep) -> list[tuple[int, list[Cell]]]:
    """The sign and the cells of each aspect: first those with J > 0; exact."""
    cells = UnionFind((k, gap) for k, slab in enumerate(sweep.slabs) for gap in range(slab.gaps))
    for line, part in enumerate(sweep.lines):
        for left, right in part.links:
            cells.join((line, right), ((line - 1) % len(sweep.slabs), left))
    signed = [(sweep.slabs[group[0][0]].signs[group[0][1]], group) for group in cells.classes()]
    return sorted(signed, key=lambda x: -x[0])


def number_of_aspects(slice_map: SliceMap, length: Fraction) -> int:
    """The number of aspects of the slice of one *scaled* length; exact.

    Where all critical lines are simple, they are not swept: what each does to the gaps is read on it.

    Raises:
        SolverError: the curves have a component that is not supported.
    """
    chart = simple_chart(slice_map, length)
    if chart is None:
        return len(aspect_cells(sweep(slice_map, length)))
    arcs, lines = line_events(chart)
    joined = UnionFind((0, gap) for gap in range(max(arcs, 1)))
    for k, line in enumerate(lines):
        arcs, passed = line.passed(arcs)
        slab = (k + 1) % len(lines)
        joined.add((slab, gap) for gap in range(max(arcs, 1)))
        for left, right in passed:
            joined.join((k, left), (slab, right))
    return len(joined.classes())


def drawn_aspects(
    sweep: Sweep, course: Callable[[int, int], Sequence[Sample]], span: Callable[[int], Point]
) -> list[Aspect]:
    """The aspects with their polygons, by sign, then by falling size.

    Args:
        sweep: the topology.
        course: the samples of an arc.
        span: the angles θ, in radians, at the ends of a slab.
    """
    drawn = []
    for sign, cells in aspect_cells(sweep):
        polygons = [p for cell in cells for p in _polygons(sweep, cell, course, span)]
        share = sum(abs(polygon_area(polygon)) for polygon in polygons) / 360**2
        drawn.append(Aspect(sign, share, tuple(polygons)))
    return sorted(drawn, key=lambda aspect: (-aspect.sign, -aspect.share))


def _polygons(
    sweep: Sweep, cell: Cell, course: Callable[[int, int], Sequence[Sample]], span: Callable[[int], Point]
) -> Iterator[tuple[Point, ...]]:
    """A cell as polygons within the square."""
    slab, gap = cell
    arcs = len(sweep.slabs[slab].arcs)
    if arcs:
        low = [(x.alpha, x.theta) for x in course(slab, gap)]
        high = [(x.alpha + (TURN if gap == arcs - 1 else 0), x.theta) for x in course(slab, (gap + 1) % arcs)]
    else:
        start, stop = span(slab)
        low, high = [(-TURN / 2, start), (-TURN / 2, stop)], [(TURN / 2, start), (TURN / 2, stop)]
    outline = [(degrees(x), degrees(y)) for x, y in (*low, *reversed(high))]
    for alphas in strips(outline, 0):
        yield from (tuple(polygon) for polygon in strips(alphas, 1) if abs(polygon_area(polygon)) > 0)


_FIRST_BITS = 64


@dataclass(frozen=True)
class RangeAspect:
    """An aspect of a range of lengths of the fixed leg.

    At an open end, the limit of J / L or of J / L² counts as the slice.

    Attributes:
        sign: that of J.
        at_start: how many aspects of the slice at the lower end it holds.
        at_stop: how many aspects of the slice at the upper end.

    >>> RangeAspect(1, 2, 1)
    RangeAspect(sign=1, at_start=2, at_stop=1)
    """

    sign: int
    at_start: int
    at_stop: int

    def to_json(self) -> dict[str, int]:
        """The document's aspect object."""
        return {"sign": self.sign, "at_start": self.at_start, "at_stop": self.at_stop}


def aspects(
    manipulator: Manipulator, start: Exact | None = None, stop: Exact | None = None, *, fixed_leg: int = 1
) -> tuple[RangeAspect, ...]:
    """The aspects of a manipulator while the length of one leg varies within a range; their number is exact.

    Args:
        manipulator: the geometry.
        start: the least length of the leg, exact, in the user's unit; 0 or None is an open end.
        stop: its greatest length, larger than ``start``; None is an open end.
        fixed_leg: the leg, 1, 2 or 3; the other two are free.

    Returns:
        The aspects with J > 0, then those with J < 0.

    Raises:
        InputError: naming ``manipulator``, ``fixed_leg``, ``start`` or ``stop``.
        SolverError: the singular curves of both slices could not be compared.

    >>> from rpr_solver import EXAMPLES
    >>> aspects(EXAMPLES["innocenti"], 27, 30)
    (RangeAspect(sign=1, at_start=2, at_stop=1), RangeAspect(sign=-1, at_start=1, at_stop=1))
    >>> len(aspects(EXAMPLES["innocenti"]))
    2
    """
    slice_map = SliceMap.of(manipulator, check_leg(fixed_leg))
    span = LengthRange.of(start, stop)
    low, high = span.start * slice_map.scale, None if span.stop is None else span.stop * slice_map.scale
    topology = RangeTopology.of(slice_map, low, high)
    found = []
    for group in topology.classes():
        end, k = group[0]
        ends = [end for end, _ in group]
        found.append(RangeAspect(topology.aspects[end][k][0], ends.count(0), ends.count(1)))
    return tuple(sorted(found, key=lambda x: -x.sign))


@dataclass(frozen=True)
class Overlap:
    """A cell of each slice, and a place in both: its half tangents in the chart, where t = None is ∞."""

    cells: tuple[Cell, Cell]
    t: Fraction | None
    u: Fraction

    def place(self, chart: Chart) -> tuple[float, float]:
        """α and θ in radians, for a chart that is not transposed."""
        offsets, root = chart.offsets, sqrt(chart.slice_map.rho)
        alpha = pi if self.t is None else whole_angle(self.t, root)
        return alpha + offsets[0], whole_angle(self.u, root) + offsets[1]


@dataclass(frozen=True)
class RangeTopology:
    """The slices at both ends of a range, swept in one chart."""

    first: Sweep
    second: Sweep

    @classmethod
    def of(
        cls, slice_map: SliceMap, low: Fraction, high: Fraction | None, *, transposable: bool = True
    ) -> RangeTopology:
        """The ends of a range of *scaled* lengths; 0 and None are open.

        Raises:
            SolverError: no chart is good for both; without ``transposable``, none that sweeps over θ.
        """
        for transposed, turns in product((False, True)[: 1 + transposable], turns_of(slice_map.rho)):
            try:
                ends = (sweep(slice_map, end, [turns], transposed=transposed) for end in (low, high))
                return cls(*ends)
            except SolverError as error:
                problem = error
        raise SolverError(f"the ends of the range cannot be compared: {problem}")

    @property
    def ends(self) -> tuple[Sweep, Sweep]:
        """Both sweeps."""
        return self.first, self.second

    @cached_property
    def aspects(self) -> tuple[list[tuple[int, list[Cell]]], list[tuple[int, list[Cell]]]]:
        """The sign and the cells of each aspect of both slices."""
        return aspect_cells(self.first), aspect_cells(self.second)

    @cached_property
    def overlaps(self) -> tuple[Overlap, ...]:
        """Overlaps of cells in which J has one sign; every overlap of two aspects is among them."""
        return tuple(x for x in _overlaps(self.first, self.second) if self._sign(x, 0) == self._sign(x, 1))

    def _sign(self, overlap: Overlap, end: int) -> int:
        slab, gap = overlap.cells[end]
        return self.ends[end].slabs[slab].signs[gap]

    def classes(self) -> list[list[tuple[int, int]]]:
        """The aspects of the range: classes of the ends' aspects, each by its end, 0 or 1, and its number."""
        numbers = [{cell: k for k, (_, cells) in enumerate(own) for cell in cells} for own in self.aspects]
        joined = UnionFind((end, k) for end in (0, 1) for k in range(len(self.aspects[end])))
        for overlap in self.overlaps:
            one, other = ((end, numbers[end][cell]) for end, cell in enumerate(overlap.cells))
            joined.join(one, other)
        return joined.classes()


def _overlaps(first: Sweep, second: Sweep) -> Iterator[Overlap]:
    """Pairs of cells of two sweeps that overlap; every overlap of aspects is among them."""
    for u in _samples(_lines(first, second)):
        forms = [part.chart.above(u) for part in (first, second)]
        arcs = [real_roots(form) for form in forms]
        both = forms[0] * forms[1].quotient(QuadraticPoly.rational(_shared(forms), forms[0].radicand))
        slabs = [_slab_at(part, u) for part in (first, second)]
        for t in (None, *(between(x, y) for x, y in pairwise(real_roots(both)))):
            one, other = (
                (slab, _gap(own, t) % part.slabs[slab].gaps)
                for slab, own, part in zip(slabs, arcs, (first, second), strict=True)
            )
            yield Overlap((one, other), t, u)


def _gap(arcs: Sequence[RealRoot], t: Fraction | None) -> int:
    """The number of the gap that holds t, −1 for the last one; None is t = ∞."""
    return -1 if t is None else sum(1 - position(arc, [t]) for arc in arcs) - 1


def _shared(forms: Sequence[QuadraticPoly]) -> fmpz_poly:
    """The common factor of two forms on one line: where a curve is singular for every length."""
    common = fmpz_poly([])
    for form in forms:
        common = common.gcd(form.a).gcd(form.b)
    return common


def _slab_at(part: Sweep, u: Fraction) -> int:
    return (sum(1 - position(line.root, [u]) for line in part.lines) - 1) % len(part.slabs)


def _samples(roots: Sequence[RealRoot]) -> Iterator[Fraction]:
    """Rationals between neighbouring roots, and beyond the first and the last."""
    if not roots:
        yield Fraction(0)
        return
    yield fraction_of(roots[0].refined(_FIRST_BITS).lower()) - 1
    yield from (between(x, y) for x, y in pairwise(roots))
    yield fraction_of(roots[-1].refined(_FIRST_BITS).upper()) + 1


def _lines(first: Sweep, second: Sweep) -> list[RealRoot]:
    """The real zeros u of the lines of both sweeps and of the resultant of J0 and J1, and maybe others."""
    factors: list[fmpz_poly] = []
    for polynomial in (first.chart.lines, second.chart.lines, _resultant(first)):
        for factor, _ in polynomial.norm.factor_squarefree()[1]:
            for other in factors:
                factor = factor / factor.gcd(other)
            factors.append(factor)
    return in_order([root for factor in factors for root in real_roots(QuadraticPoly.rational(factor))])


def _resultant(part: Sweep) -> QuadraticPoly:
    """Res_t(J0, J1) in the chart of a sweep, without what J0 and J1 share."""
    chart = part.chart
    limits = (chart.slice_map.singular.sliced(length) for length in (Fraction(0), None))
    own = (form.transposed if chart.transposed else form for form in limits)
    turned = (turned_rows(form.rows, form.degree_u, chart.alpha, chart.theta) for form in own)
    j0, j1, _ = without_common_factors(*(BiForm.of_rows(rows, 4) for rows in turned))
    found = resultant(j0, j1).polynomial
    if found.is_zero:
        raise SolverError("the slices of this range share a singular curve that is not rational")
    return found
