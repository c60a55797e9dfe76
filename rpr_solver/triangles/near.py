"""Special shapes near a geometry: how far they are, what holds there, and how they are spelled exactly.

The *distance* to a special shape of one triangle is the least ε such that all its sides, changed by at most
the fraction ε of their lengths, can have this shape; to one of both triangles the sides of the platform are
changed. With the ratios of the sides to those of the shape, for similar ones up to a common factor, it is

- (R − 1) / (R + 1), R being the greatest ratio over the least: similar, isosceles, right isosceles,
  equilateral;
- the greatest |ratio − 1|: congruent, mirrored;
- (a + b − c) / (a + b + c), c being the longest side: flat;

the least of these over the corners that may have the special part
(mathematics.md#distance-to-a-special-shape).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from functools import partial
from itertools import product
from typing import Any, TypeAlias

from flint import arb, ctx

from rpr_solver.exact import decided
from rpr_solver.exact.decimals import round_ball, round_fraction
from rpr_solver.exact.precision import GREATEST_BITS
from rpr_solver.exact.rationals import exact_str, rational_sqrt
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.triangles.geometry import Geometry
from rpr_solver.triangles.surds import Surd
from rpr_solver.triangles.triangle import CCW, CW, SIDES, Squares, Triangle, heron

NEAR = Fraction(1, 1000)
"""Shapes within this distance are near."""
DISTANCE_DIGITS = 2
"""Significant digits of a printed distance."""
_FIRST_BITS = 64


class Effect(StrEnum):
    """What a special shape nearby means for an answer about the geometry as it was given."""

    CONTRADICTS = "contradicts"
    """The answer for the exact shape is another one: it has no cusps, and no change of mode."""
    WEAKENS = "weakens"
    """Some cusps or poses of the answer are not there, or are degenerate, in the exact shape."""
    HARMLESS = "harmless"
    """The exact shape has the same cusps, up to small changes."""


@dataclass(frozen=True)
class SpecialShape:
    """A special shape near a geometry that has not got it.

    Attributes:
        shape: ``"similar"``, ``"congruent"``, ``"mirrored"``, ``"isosceles"``, ``"right isosceles"``,
            ``"equilateral"`` or ``"flat"``.
        distance: the greatest relative change of a side, rounded to two significant digits.
        says: what holds for the exact shape.
        spelling: the exact shape, as :func:`~rpr_solver.triangles.geometry.read_geometry` reads it.
        effect: what this means for the answer.
    """

    shape: str
    distance: str
    says: str
    spelling: dict[str, Any]
    effect: Effect

    def to_json(self) -> dict[str, Any]:
        """The object of a document."""
        return {
            "shape": self.shape,
            "distance": self.distance,
            "says": self.says,
            "spelling": self.spelling,
            "effect": self.effect.value,
        }


class _Distance:
    """A distance: a rational number, or an irrational one by balls of any precision."""

    def __init__(self, exact: Fraction | None, ball: Callable[[], arb]) -> None:
        self.exact, self._ball = exact, ball

    @property
    def is_near(self) -> bool:
        """Whether it is within :data:`NEAR`, and not 0."""
        return self.exact != 0 and self.is_close

    @property
    def is_close(self) -> bool:
        """Whether it is below :data:`NEAR`."""
        if self.exact is not None:
            return self.exact < NEAR

        def below(bits: int) -> bool | None:
            with ctx.workprec(bits):
                rest = self._ball() - ball_of(NEAR)
                return None if rest.contains(0) else bool(rest < 0)

        # irrational, so that it differs from the bound
        return decided(below, _FIRST_BITS, GREATEST_BITS, "a distance to a special shape is open")

    @property
    def text(self) -> str:
        """Rounded to two digits."""
        if self.exact is not None:
            return round_fraction(self.exact, DISTANCE_DIGITS)

        def rounded(bits: int) -> str | None:
            with ctx.workprec(bits):
                return round_ball(self._ball(), DISTANCE_DIGITS)

        return decided(rounded, _FIRST_BITS, GREATEST_BITS, "a distance to a special shape is open")


def _spread(squares: list[Fraction]) -> _Distance:
    """(R − 1) / (R + 1), from the squares of ratios; R² is that of the greatest to the least."""
    square = max(squares) / min(squares)
    root = rational_sqrt(square)
    if root is not None:
        return _Distance((root - 1) / (root + 1), arb)
    # (R² − 1) / (R + 1)², without cancellation
    return _Distance(None, lambda: ball_of(square - 1) / (ball_of(square).sqrt() + 1) ** 2)


def _change(squares: list[Fraction]) -> _Distance:
    """The greatest |R − 1|, from the squares of ratios."""
    least, greatest = min(squares), max(squares)
    # R − 1 of the greatest is more than 1 − R of the least where the sum of both R is more than 2
    rises = Surd.root(4 * least * greatest) > Surd.of(4 - least - greatest)
    square = greatest if rises else least
    root = rational_sqrt(square)
    if root is not None:
        return _Distance(abs(root - 1), arb)
    # |R² − 1| / (R + 1), without cancellation
    return _Distance(None, lambda: ball_of(abs(square - 1)) / (ball_of(square).sqrt() + 1))


def _height(squares: Squares) -> _Distance:
    """(a + b − c) / (a + b + c), from the squares of the sides."""
    a, b, c = (square / max(squares) for square in sorted(squares))
    first, second = rational_sqrt(a), rational_sqrt(b)
    if first is not None and second is not None:
        return _Distance((first + second - 1) / (first + second + 1), arb)
    area16 = heron((a, b, c))
    if not area16:
        return _Distance(Fraction(0), arb)

    def ball() -> arb:
        # a + b − c is H over the product of the other three sums
        x, y = ball_of(a).sqrt(), ball_of(b).sqrt()
        return ball_of(area16) / ((x + y + 1) ** 2 * (y + 1 - x) * (x + 1 - y))

    return _Distance(None, ball)


Geometries: TypeAlias = Callable[[], list[Geometry]]
Found: TypeAlias = tuple[str, _Distance, str, Effect, Geometries]
"""A shape, its distance, what holds there, the effect, and geometries that have it, the likeliest first."""


def near_shapes(geometry: Geometry) -> list[SpecialShape]:
    """The special shapes within :data:`NEAR` of a geometry that it has not got; those that matter first.

    >>> from rpr_solver.triangles.geometry import read_geometry
    >>> rounded = {"a2x": 10, "a3x": 5, "a3y": "8.6603", "d1": "1.7321", "d2": "1.7321", "d3": "1.7321"}
    >>> first, *_ = near_shapes(read_geometry(rounded))
    >>> first.shape, first.distance, first.spelling
    ('similar', '0.0000020', {'base': {'equilateral': '10'}, 'platform': {'equilateral': 'sqrt(3)'}})
    """
    shapes = [
        SpecialShape(shape, distance.text, says, _likeliest(exact, geometry), effect)
        for shape, distance, says, effect, exactly in _found(geometry)
        if distance.is_near and (exact := exactly())
    ]
    order = list(Effect)
    return sorted(shapes, key=lambda shape: order.index(shape.effect))


def own_shapes(geometry: Geometry) -> list[tuple[str, str]]:
    """The special shapes that a geometry has exactly, and what holds there.

    >>> from rpr_solver.triangles.geometry import read_geometry
    >>> own = read_geometry({"base": {"sides": [3, 4, 5]}, "platform": {"sides": [6, 8, 10]}})
    >>> [shape for shape, _ in own_shapes(own)]
    ['similar']
    """
    return [(shape, says) for shape, distance, says, *_ in _found(geometry) if distance.exact == 0]


def _found(geometry: Geometry) -> Iterator[Found]:
    """The special shapes of a geometry and near it; none where legs share a joint, as no cusps are there.

    A relabelled platform is another manipulator, to which nothing special happens, so that corners of base
    and platform are compared by their numbers.
    """
    if geometry.shared_joints:
        return
    yield from _of_both(geometry)
    for name, own, other in (
        ("base", geometry.base, geometry.platform),
        ("platform", geometry.platform, geometry.base),
    ):
        for shape, distance, says, triangles in _of_one(own, name):
            if not distance.is_close:
                continue
            effect = Effect.HARMLESS
            if shape == "flat" and (not other.area16 or _height(other.squares).is_near):
                says, effect = (
                    f"{says}; if base and platform are flat, no slice has a cusp",
                    Effect.CONTRADICTS,
                )
            yield shape, distance, says, effect, partial(_with, geometry, name, triangles)


def _with(geometry: Geometry, name: str, triangles: Triangles) -> list[Geometry]:
    """The geometry with its base, or its platform, replaced by each of some triangles."""
    base, platform, turned = geometry.base, geometry.platform, geometry.half_turn
    if name == "base":
        return [Geometry(triangle, platform, turned) for triangle in triangles()]
    return [Geometry(base, triangle, turned) for triangle in triangles()]


def _of_both(geometry: Geometry) -> Iterator[Found]:
    """Shapes of the platform that depend on the base."""
    base, platform = geometry.base, geometry.platform
    is_one_sense = base.sense == platform.sense or not (base.area16 and platform.area16)
    ratios = [b / p for b, p in zip(base.squares, platform.squares, strict=True)]
    alike, equal = _spread(ratios), _change(ratios)
    if is_one_sense and alike.is_close:
        says = (
            "base and platform are similar: no slice has a cusp, and the assembly mode never changes "
            "without a singularity"
        )
        yield "similar", alike, says, Effect.CONTRADICTS, partial(_similar, geometry)
    if is_one_sense and equal.is_close:
        says = (
            "base and platform are congruent: no slice has a cusp, the assembly mode never changes "
            "without a singularity, and with equal legs the platform moves although all legs are locked"
        )
        effect = Effect.WEAKENS if alike.exact == 0 else Effect.CONTRADICTS
        yield "congruent", equal, says, effect, partial(_congruent, geometry, base.sense)
    if not is_one_sense and equal.is_close:
        says = (
            "the platform is congruent to the mirrored base: a slice has at most six cusps, and nodes in "
            "place of others"
        )
        yield "mirrored", equal, says, Effect.WEAKENS, partial(_congruent, geometry, platform.sense)


def _similar(geometry: Geometry) -> list[Geometry]:
    """Exactly similar ones: both equilateral or right isosceles, or one with the shape of the other."""
    base, platform, turned = geometry.base, geometry.platform, geometry.half_turn
    pairs = []
    for of in (_equilateral, _right_isosceles):
        both = [
            exact() if distance.is_close else [] for _, distance, _, exact in (of(base, ""), of(platform, ""))
        ]
        pairs += [Geometry(b, p, turned) for b, p in product(*both) if _proportional(b, p)]
    for side in range(3):
        factor = platform.squares[side] / base.squares[side]
        pairs.append(Geometry(base, _scaled(base, factor, platform.sense), turned))
        pairs.append(Geometry(_scaled(platform, 1 / factor, base.sense), platform, turned))
    return pairs


def _proportional(first: Triangle, second: Triangle) -> bool:
    return len({a / b for a, b in zip(first.squares, second.squares, strict=True)}) == 1


def _congruent(geometry: Geometry, sense: str) -> list[Geometry]:
    base, platform, turned = geometry.base, geometry.platform, geometry.half_turn
    return [
        Geometry(base, _scaled(base, Fraction(1), sense), turned),
        Geometry(_scaled(platform, Fraction(1), base.sense), platform, turned),
    ]


def _scaled(triangle: Triangle, factor: Fraction, sense: str) -> Triangle:
    """The triangle with its squared sides times a factor."""
    a, b, c = (square * factor for square in triangle.squares)
    return Triangle((a, b, c), sense if triangle.area16 else CCW)


Triangles: TypeAlias = Callable[[], list[Triangle]]
OfOne: TypeAlias = tuple[str, _Distance, str, Triangles]
"""A shape of one triangle, its distance, what holds there, and triangles that have it."""
_RIGHT = (1, 1, 2)
"""The squared sides of a right isosceles triangle."""


def _of_one(own: Triangle, name: str) -> Iterator[OfOne]:
    """The shapes of one triangle, which is called ``name``."""
    for of in (_equilateral, _right_isosceles, _isosceles, _flat):
        yield of(own, name)


def _equilateral(own: Triangle, name: str) -> OfOne:
    def exact() -> list[Triangle]:
        return _like(own, [(x, x, x) for x in _likely(own.squares)])

    return "equilateral", _spread(list(own.squares)), f"the {name} is equilateral", exact


def _right_isosceles(own: Triangle, name: str) -> OfOne:
    shapes = [[_RIGHT[n - third - 1] for n in range(3)] for third in range(3)]
    ratios = [[x / y for x, y in zip(own.squares, shape, strict=True)] for shape in shapes]
    third = min(range(3), key=lambda n: max(ratios[n]) / min(ratios[n]))
    a, b, c = shapes[third]

    def exact() -> list[Triangle]:
        return _like(own, [(x * a, x * b, x * c) for x in _likely(ratios[third])])

    says = f"the {name} is right isosceles, with its right angle opposite to {_side(third, name)}"
    return "right isosceles", _spread(ratios[third]), says, exact


def _isosceles(own: Triangle, name: str) -> OfOne:
    pairs = [(0, 1), (1, 2), (2, 0)]
    first, second = min(pairs, key=lambda two: _quotient(*(own.squares[n] for n in two)))
    equal = own.squares[first], own.squares[second]

    def exact() -> list[Triangle]:
        changed = [
            [x if n in (first, second) else y for n, y in enumerate(own.squares)] for x in _likely(equal)
        ]
        return _like(own, [(a, b, c) for a, b, c in changed])

    says = f"the {name} is isosceles, {_side(first, name)} = {_side(second, name)}"
    return "isosceles", _spread(list(equal)), says, exact


def _flat(own: Triangle, name: str) -> OfOne:
    def exact() -> list[Triangle]:
        longest = max(range(3), key=lambda n: own.squares[n])
        side, after, before = (own.squares[(longest + n) % 3] for n in range(3))
        # the corner opposite to the longest side, put on it, divides it into two multiples of its length
        part = (side + before - after) / (2 * side)
        parts = {longest: side, (longest + 1) % 3: (1 - part) ** 2 * side, (longest + 2) % 3: part**2 * side}
        return _like(own, [(parts[0], parts[1], parts[2])])

    return "flat", _height(own.squares), f"the {name} is flat, its corners on one line", exact


def _like(own: Triangle, squares: list[Squares]) -> list[Triangle]:
    """Triangles of the sense of one, without repetition."""
    different = [x for x in dict.fromkeys(squares) if heron(x) >= 0]
    return [Triangle(x, own.sense if heron(x) else CCW) for x in different]


def _likely(squares: Sequence[Fraction]) -> list[Fraction]:
    """Squares that may have been meant, simple ones first."""
    return [x for square in squares for x in (*_recognised(square), square)]


def _side(number: int, name: str) -> str:
    letter = "A" if name == "base" else "B"
    return "".join(f"{letter}{corner + 1}" for corner in SIDES[number])


def _quotient(x: Fraction, y: Fraction) -> Fraction:
    return max(x, y) / min(x, y)


_MOST_LIKELY = Fraction(1, 100)
"""The chance below which a simple root that rounds to a decimal is taken for what was rounded."""


def _recognised(square: Fraction) -> list[Fraction]:
    """The square of the root of a simple number that rounds to a side, if it is unlikely to do so by
    chance."""
    side = rational_sqrt(square)
    places = None if side is None else _places(side)
    if side is None or not places:
        return []
    for over in (1, 2, 3, 4):
        simple = Fraction(round(square * over), over)
        # squares within a unit of the last place are so many units of the simple ones apart
        chance = 4 * side * over / 10**places
        if simple > 0 and chance < _MOST_LIKELY and _rounds(Surd.root(simple), side):
            return [simple]
    return []


def _places(x: Fraction) -> int | None:
    """The decimal places of a number, if it is a decimal."""
    text = exact_str(x)
    return None if "/" in text else len(text.partition(".")[2])


def _rounds(exact: Surd, given: Fraction) -> bool:
    """Whether a decimal may be a rounded or truncated number: it is within a unit of its last place.

    Integers are taken to be exact.
    """
    places = _places(given)
    if not places:
        return exact == Surd.of(given)
    unit = Fraction(1, 10**places)
    return Surd.of(given - unit) < exact < Surd.of(given + unit)


def _likeliest(exact: list[Geometry], geometry: Geometry) -> dict[str, Any]:
    """The spelling of the first one whose six numbers round to those that were given; else the shortest."""
    given = geometry.lengths

    def is_rounded(candidate: Geometry) -> bool:
        pairs = zip(candidate.lengths, given, strict=True)
        return all(x == y if y.rational is None else _rounds(x, y.rational) for x, y in pairs)

    rounded = next(filter(is_rounded, exact), None)
    return (
        _spelled(rounded) if rounded else min(map(_spelled, exact), key=lambda spelling: len(str(spelling)))
    )


def _spelled(geometry: Geometry) -> dict[str, Any]:
    """A geometry as people would write it."""
    base, platform = geometry.base, geometry.platform
    a2x, a3x, a3y, *_ = Geometry(base, platform).lengths
    spelling: dict[str, Any] = {"platform": _shortest(platform)}
    if base.sense == CCW and (
        len(set(base.squares)) == 1 or None in (a2x.rational, a3x.rational, a3y.rational)
    ):
        spelling = {"base": _shortest(base), **spelling}
    else:
        points = [["0", "0"], [str(a2x), "0"], [str(a3x), str(a3y)]]
        spelling = {"base": {"points": points}, **spelling}
    if platform.sense == CW:
        spelling["orientation"] = CW
    return spelling


def _shortest(triangle: Triangle) -> dict[str, Any]:
    first, *others = map(str, triangle.sides)
    return {"equilateral": first} if {first} == set(others) else {"sides": [first, *others]}
