"""Curves in the plane of the squared free legs that are run by one parameter, of which the legs are waves.

One of them is the *bend*, whose image does not meet itself; the others are *folds*. Where the bend ends at a
fold, their images touch (mathematics.md#folded-slices).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise

from rpr_solver.verify.claims import OpenError
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.core.surds import Ring
from rpr_solver.verify.core.system import Trig
from rpr_solver.verify.fronts import (
    BITS,
    ERROR,
    FRAME,
    ONE,
    ORDER,
    Graph,
    Point,
    Series,
    Vector,
    Wave,
    norms_of,
    powers_of,
    product,
)
from rpr_solver.verify.images import STEP, UNDECIDED, Contact, Image, Leaf, Mark, Pairs

_LONGEST, _LEAST, ROOM = ONE >> 4, ONE >> 250, 1 << 40
_TRIES, _SHORT, _TOP = 60, 24, 8
Waves = Mapping[Vector, Fraction]
"""Σ c cosⁱ sinʲ, by i and j."""


@dataclass(frozen=True, eq=False)
class Course:
    """A part of the image: both squared legs, and a tangent, by one parameter.

    Attributes:
        is_bend: whether it is the bend; the others are folds.
        turning: what is 0 where the image of the bend has a cusp; None if it has none.
    """

    legs: tuple[Wave, Wave]
    tangents: tuple[Wave, Wave]
    is_bend: bool
    turning: Wave | None = None

    @cached_property
    def slopes(self) -> tuple[Wave, Wave]:
        """The first derivatives of the legs."""
        return slope_of(self.legs[0]), slope_of(self.legs[1])

    @cached_property
    def bends(self) -> tuple[Wave, Wave]:
        """The second derivatives of the legs."""
        return slope_of(self.slopes[0]), slope_of(self.slopes[1])

    def point(self, place: int) -> Point:
        """The point at a parameter, known within ROOM."""
        phases = {(p, 0): pair for p, pair in enumerate(powers_of(place, _TOP + 1))}
        first, second = (leg.value(phases) for leg in self.legs)
        blur = ERROR + max(product(leg.norms[1], 2 * ROOM) for leg in self.legs)
        return Point(place, 0, 2 * ROOM, (first, second), blur)

    def chain(self, marks: Sequence[tuple[int, Point]]) -> list[Stretch]:
        """The pieces from the first of some points to the last one."""
        pieces = []
        for (low, first), (high, last) in pairwise(marks):
            number = (high - low) // _LONGEST + 1
            places = [low + (high - low) * k // number for k in range(number + 1)]
            points = [first, *(self.point(place) for place in places[1:-1]), last]
            pieces += [
                Stretch(self, (places[k], places[k + 1]), (points[k], points[k + 1])) for k in range(number)
            ]
        return pieces


def slope_of(wave: Wave) -> Wave:
    """The derivative of a wave."""
    terms = tuple((p, q, p * b, -p * a) for p, q, a, b in wave.terms)
    return Wave(terms, wave.shift, norms_of(terms))


@dataclass(frozen=True, eq=False)
class Stretch(Image):
    """A piece of a course, between two parameters."""

    course: Course
    places: Vector
    ends: tuple[Point, Point]

    @cached_property
    def reach(self) -> int:  # type: ignore[override]
        """How far it reaches from its middle, with room for errors of its ends."""
        return (self.places[1] - self.places[0]) // 2 + 4 * ROOM

    @cached_property
    def _graph(self) -> Graph:
        spend(60, BITS)
        rows = {}
        for p, (c, s) in enumerate(powers_of(sum(self.places) // 2, _TOP + 1)):
            cos, sin = [c], [s]
            for k in range(1, ORDER + 1):
                c, s = -(p * self.reach * s >> BITS) // k, (p * self.reach * c >> BITS) // k
                cos.append(c)
                sin.append(s)
            rows[p, 0] = cos, sin
        square = product(self.reach, self.reach)
        return Graph((1 << FRAME, 0), (0,), rows, product(square, product(square, square)) // 720 + 1)

    def _along(self, waves: Iterable[Wave]) -> tuple[Series, Series]:
        first, second = (wave.along(self._graph) for wave in waves)
        return first, second

    @cached_property
    def image(self) -> tuple[Series, Series]:
        """The squared free legs along it."""
        return self._along(self.course.legs)

    @cached_property
    def tangents(self) -> tuple[Series, Series]:
        """A tangent of the image along it."""
        return self._along(self.course.tangents)

    @cached_property
    def cusps(self) -> frozenset[int]:
        """The number 0 if a cusp may be on it."""
        turning = self.course.turning
        known = None if turning is None else turning.along(self._graph)
        return frozenset() if known is None or abs(known.terms[0]) > known.change else frozenset({0})

    @cached_property
    def halves(self) -> tuple[Stretch, Stretch]:
        """Two pieces of it."""
        low, high = self.places
        if high - low < _LEAST:
            raise OpenError(UNDECIDED)
        # crossings may be in the middle
        middle, (first, last) = low + 47 * (high - low) // 100, self.ends
        point = self.course.point(middle)
        return (
            Stretch(self.course, (low, middle), (first, point)),
            Stretch(self.course, (middle, high), (point, last)),
        )

    def towards(self, point: Point) -> Stretch:
        """The half that ends in one of its ends."""
        return self.halves[0] if self.ends[0] is point else self.halves[1]

    def curvature(self, normal: Vector) -> tuple[int, Interval] | None:
        """As a graph over a direction: which way it runs, and its second derivatives; None if it is none."""
        (x, y), (xx, yy) = (
            [_in_direction(rows, way) for way in (normal, (-normal[1], normal[0]))]
            for rows in (self._along(self.course.slopes), self._along(self.course.bends))
        )
        cube = x * x * x
        return (x.sign, (x * yy - y * xx).over(cube)) if cube.sign else None


def _in_direction(rows: tuple[Series, Series], way: Vector) -> Interval:
    """All values of a vector's component."""
    total = Interval(0, 0, BITS)
    for row, x in zip(rows, way, strict=True):
        total += Interval(row.terms[0] - row.change, row.terms[0] + row.change, BITS).scaled(x)
    return total


class Touching(Pairs[Stretch]):
    """Pairs that do not meet: of the bend, or of the bend and a fold beside the point where both touch."""

    def hold(self, x: Stretch, y: Stretch) -> bool:
        """Whether that is so of a pair."""
        if not (x.course.is_bend and y.course.is_bend):
            return any(p is q and _side(x, y) for p in x.ends for q in y.ends)
        return True

    def cut(self, chain: Sequence[Stretch]) -> list[Stretch]:
        """A fold, cut so finely that no two neighbours meet but at their common end; the bend as it is."""
        return list(chain) if chain[0].course.is_bend else super().cut(chain)

    def contacts(self, chains: Sequence[Sequence[Leaf]]) -> Iterator[Contact]:
        """Where the bend ends at a fold.

        Raises:
            OpenError: it is not told on which side.
        """
        folds = {
            id(leaf.piece.ends[0]): leaf for chain in chains for leaf in chain if not _of(leaf).course.is_bend
        }
        for n, chain in enumerate(chains):
            first, last = _of(chain[0]), _of(chain[-1])
            if not first.course.is_bend or first.ends[0] is last.ends[1]:
                continue
            for bend, point, low in ((first, first.ends[0], 0), (last, last.ends[1], len(chain) * STEP)):
                leaf = folds[id(point)]
                fold = _of(leaf)
                for _ in range(_TRIES):
                    if side := _side(bend, fold):
                        break
                    bend, fold = bend.towards(point), fold.towards(point)
                else:
                    raise OpenError(UNDECIDED)
                yield Contact((Mark(leaf.chain, leaf.low), Mark(n, low)), low == 0, side > 0)


def _of(leaf: Leaf) -> Stretch:
    assert isinstance(leaf.piece, Stretch)
    return leaf.piece


def _side(x: Stretch, y: Stretch) -> int:
    """±1 if a piece of the bend is on the left or the right of one of a fold that has a common end with it.

    There they have one tangent. As graphs over it their second derivatives differ, so they meet nowhere else.
    """
    if x.course.is_bend is y.course.is_bend:
        return 0
    bend, fold = (x, y) if x.course.is_bend else (y, x)
    shift = max(max(map(abs, fold.tangent)).bit_length() - _SHORT, 0)
    way = fold.tangent[0] >> shift, fold.tangent[1] >> shift
    first, second = bend.curvature(way), fold.curvature(way)
    return 0 if first is None or second is None else (first[1] - second[1]).sign * second[0]


def both_legs(*rows: Sequence[Waves]) -> tuple[list[tuple[Wave, Wave]], tuple[int, int]]:
    """Both squared legs of all courses, each leg divided by one power of 2."""
    sizes = [max(int(sum(map(abs, row[k].values()))) for row in rows) for k in (0, 1)]
    shifts = sizes[0].bit_length(), sizes[1].bit_length()
    return [(wave_of(row[0], shifts[0]), wave_of(row[1], shifts[1])) for row in rows], shifts


def tangents_of(rows: Iterable[Waves], shifts: Vector) -> tuple[Wave, Wave]:
    """A tangent, given that of the image before both legs are divided by powers of 2; as long as about 1."""
    own = [combined((1 / Fraction(2) ** shift, row)) for shift, row in zip(shifts, rows, strict=True)]
    largest = max(abs(x) for row in own for x in row.values())
    first, second = (wave_of(combined((1 / largest, row)), 0) for row in own)
    return first, second


def wave_of(waves: Waves, shift: int | None = None) -> Wave:
    """The same as a wave, divided by a power of 2."""
    trig: Trig = {(i, j, 0, 0): (x, 0) for (i, j), x in waves.items()}  # type: ignore[misc]
    return Wave.of(trig, Ring(1), shift)


def times(p: Waves, q: Waves) -> Waves:
    """The product."""
    result: dict[Vector, Fraction] = {}
    for (i, j), x in p.items():
        for (k, m), y in q.items():
            result[i + k, j + m] = result.get((i + k, j + m), Fraction(0)) + x * y
    return result


def combined(*parts: tuple[Fraction, Waves]) -> Waves:
    """The sum of multiples."""
    result: dict[Vector, Fraction] = {}
    for factor, waves in parts:
        for key, x in waves.items():
            result[key] = result.get(key, Fraction(0)) + factor * x
    return result
