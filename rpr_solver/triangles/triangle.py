"""A triangle by the squares of its sides, which are rational, and its sense; read from any of four spellings.

With squared sides a, b, c the number H = 4 a c − (a + c − b)² is 16 times the squared area (Heron). Positive
a, b and c are those of a triangle if and only if H ≥ 0, and the square of the distance of two points whose
coordinates are surds is rational if and only if two products are, or cancel
(mathematics.md#squared-sides). So everything is decided exactly. Two corners, but not all three, may be one
point, where two legs share a joint: the triangle is flat then, with one side 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

from rpr_solver.errors import FieldProblem, InputError, clipped, shown
from rpr_solver.exact import decided
from rpr_solver.exact.precision import GREATEST_BITS
from rpr_solver.exact.rationals import MAX_DIGITS, exact_str, parse_all
from rpr_solver.triangles.surds import SQUARE, Surd, parse_surd

CCW, CW = "ccw", "cw"
Point: TypeAlias = tuple[Surd, Surd]
Squares: TypeAlias = tuple[Fraction, Fraction, Fraction]
SIDES = ((0, 1), (1, 2), (2, 0))
"""The corners at the ends of the sides 12, 23 and 31."""


@dataclass(frozen=True)
class Triangle:
    """A triangle in the plane, up to its place and direction.

    Attributes:
        squares: the squared sides 12, 23 and 31, rational, with H ≥ 0; at most one is 0.
        sense: ``"ccw"`` if the corners 1, 2, 3 are counter-clockwise, ``"cw"`` if clockwise; a flat triangle
            is ``"ccw"``.
        points: the corners as they were given, if they were. Equal triangles may have different ones.

    >>> read_triangle({"equilateral": "sqrt(2)"}, "geometry.base")
    Triangle(sqrt(2), sqrt(2), sqrt(2), ccw)
    """

    squares: Squares
    sense: str = CCW
    points: tuple[Point, Point, Point] | None = field(default=None, compare=False)

    def __repr__(self) -> str:
        return f"Triangle({', '.join(map(str, self.sides))}, {self.sense})"

    @cached_property
    def sides(self) -> tuple[Surd, Surd, Surd]:
        """The sides 12, 23 and 31."""
        first, second, third = map(Surd.root, self.squares)
        return first, second, third

    @cached_property
    def area16(self) -> Fraction:
        """H, 16 times the squared area; 0 for a flat triangle."""
        return heron(self.squares)

    @property
    def shared(self) -> int | None:
        """The number of the side that is 0, whose corners are one point; None if there is none."""
        return self.squares.index(Fraction(0)) if 0 in self.squares else None

    @property
    def axis2(self) -> Fraction:
        """The squared length of the vector 12, or of 13 where this is 0: the *axis*, which the x-axis of a
        frame is along."""
        return self.squares[0] or self.squares[2]

    @cached_property
    def corner3(self) -> tuple[Fraction, Surd]:
        """Corner 3 as (x, y), where corner 1 is (0, 0) and the axis ends at (1, 0)."""
        a, b, c = self.squares
        if not a:
            return Fraction(1), Surd.of(0)
        y = Surd.root(self.area16 / (2 * a) ** 2, -1 if self.sense == CW else 1)
        return (a + c - b) / (2 * a), y

    def mirrored(self) -> Triangle:
        """The mirror image; a flat triangle is its own."""
        return replace(self, sense=CW if self.sense == CCW and self.area16 else CCW, points=None)


def heron(squares: Squares) -> Fraction:
    """H of three squared sides: 16 times the squared area, negative if they are of no triangle."""
    a, b, c = squares
    return 4 * a * c - (a + c - b) ** 2


class Named(NamedTuple):
    """How messages name a triangle: the field of it, and its corners, such as A1, A2 and A3.

    ``sides`` are fields of the sides, if these are no members of the triangle.
    """

    field: str
    corners: str
    sides: tuple[str, str, str] | None = None

    def side(self, number: int) -> str:
        """The name of a side, such as A1A2."""
        if self.sides:
            return self.sides[number].rpartition(".")[2]
        return "".join(f"{self.corners}{corner + 1}" for corner in SIDES[number])

    def side_field(self, number: int) -> str:
        """The field of a side."""
        return self.sides[number] if self.sides else f"{self.field}.sides[{number}]"


EXAMPLES = {
    "sides": '{"sides": ["3", "4", "5"]}',
    "points": '{"points": [["0", "0"], ["3", "0"], ["0", "4"]]}',
    "equilateral": '{"equilateral": "10"}',
    "circumradius": '{"circumradius": "sqrt(3)"}',
}
"""The spellings of a triangle by their member, each with an example."""
_OTHER_NAMES = {
    "sides": ("side_lengths", "lengths", "edges", "s12", "s23", "s31", "d1", "d2", "d3"),
    "points": (
        "point",
        "vertices",
        "corners",
        "anchors",
        "joints",
        "coordinates",
        "xy",
        "x",
        "y",
        "a1",
        "b1",
    ),
    "equilateral": ("side", "length", "edge", "a", "s"),
    "circumradius": ("radius", "r", "circle", "diameter", "circumcircle"),
}
"""What people call the members of a spelling."""


def read_triangle(value: object, field: str, corners: str = "", *, max_digits: int = MAX_DIGITS) -> Triangle:
    """Reads ``{"sides": [s12, s23, s31]}``, ``{"points": [[x, y], [x, y], [x, y]]}``, ``{"equilateral":
    side}`` or ``{"circumradius": R}``, R being the radius of the circle through the corners of an equilateral
    triangle.

    Numbers are those of :func:`parse_surd`, in the user's unit of length. A triangle that is not given by
    points is counter-clockwise.

    Args:
        value: the JSON object.
        field: its name in an error message, such as ``geometry.base``.
        corners: the letter of the corners in messages; that of the field's name if it is empty.
        max_digits: limit on the digits of numbers.

    Raises:
        InputError: naming each member, number, side or corner at fault.

    >>> read_triangle({"points": [[0, 0], [10, 0], [5, "-5*sqrt(3)"]]}, "geometry.base")
    Triangle(10, 10, 10, cw)
    """
    named = Named(field, corners or ("B" if field.endswith("platform") else "A"))
    kind, content = _spelling(value, field)
    if kind == "sides":
        return by_sides(_list_of_three(content, f"{field}.sides", "lengths", named), named, max_digits)
    if kind == "points":
        return by_points(_list_of_three(content, f"{field}.points", "corners", named), named, max_digits)
    name = f"{field}.{kind}"
    length = parse_surd(content, name, max_digits=max_digits)  # type: ignore[arg-type]
    if length <= Surd.of(0):
        what = "the side of a triangle" if kind == "equilateral" else "the radius of a circle"
        raise InputError.of(name, f"is {_text(length)}; {what} must be > 0")
    # the side of an equilateral triangle is √3 times the radius of the circle through its corners
    square = length.square * (1 if kind == "equilateral" else 3)
    return Triangle((square, square, square))


def _spelling(value: object, field: str) -> tuple[str, object]:
    """The one member of a triangle's object and its content."""
    if not isinstance(value, Mapping):
        has_points = isinstance(value, Sequence) and any(
            isinstance(x, Sequence | Mapping) and not isinstance(x, str) for x in value
        )
        example = EXAMPLES["points" if has_points else "sides"]
        raise InputError.of(field, f"is {shown(value)}; give an object such as {example}")
    unknown = [str(name) for name in value if name not in EXAMPLES][:_LISTED]
    if unknown:
        raise InputError([FieldProblem(f"{field}.{clipped(name, 60)}", _unknown(name)) for name in unknown])
    if len(value) != 1:
        has = " and ".join(value) or "nothing"
        raise InputError.of(
            field, f"has {has}; give one of {', '.join(EXAMPLES)}, such as {EXAMPLES['sides']}"
        )
    [(kind, content)] = value.items()
    return kind, content


_LISTED = 20
"""The most unknown members of a triangle that are told."""


def _unknown(name: object) -> str:
    for ours, others in _OTHER_NAMES.items():
        if str(name).lower() in others:
            return f"unknown member; a triangle is given by {ours}, as in {EXAMPLES[ours]}"
    return f"unknown member; known are {', '.join(EXAMPLES)}, as in {EXAMPLES['sides']}"


def _list_of_three(value: object, field: str, what: str, named: Named) -> Sequence[Any]:
    names = [f"{named.corners}{n}" for n in (1, 2, 3)]
    if what == "lengths":
        names = [named.side(n) for n in range(3)]
    if isinstance(value, str | bytes) or not isinstance(value, Sequence):
        raise InputError.of(field, f"is {shown(value)}; give the list of the three {what} {', '.join(names)}")
    if len(value) != 3:
        raise InputError.of(field, f"has {len(value)} {what}; give three, {', '.join(names)}")
    return value


def by_sides(sides: Sequence[Any], named: Named, max_digits: int = MAX_DIGITS) -> Triangle:
    """The counter-clockwise triangle with these sides 12, 23 and 31.

    Raises:
        InputError: naming each side at fault.
    """
    fields = {named.side_field(n): side for n, side in enumerate(sides)}
    lengths = list(
        parse_all(fields, lambda side, name: parse_surd(side, name, max_digits=max_digits)).values()
    )
    problems = []
    for n, length in enumerate(lengths):
        if length.sign < 0:
            first, second = (f"{named.corners}{corner + 1}" for corner in SIDES[n])
            message = f"is {_text(length)}; the side {first}{second} must be > 0, or 0 if two legs share it"
            problems.append(FieldProblem(named.side_field(n), message))
    if problems:
        raise InputError(problems)
    triangle = Triangle((lengths[0].square, lengths[1].square, lengths[2].square))
    if not any(triangle.squares):
        raise one_point(named)
    if triangle.area16 < 0:
        raise _broken(lengths, named)
    return triangle


def one_point(named: Named) -> InputError:
    """The error of a triangle whose corners are all one point."""
    letter = named.corners
    effect = (
        "a platform of one point has no orientation"
        if letter == "B"
        else "the platform can turn about this point whatever the legs do, so that every pose is singular"
    )
    return InputError.of(named.field, f"{letter}1, {letter}2 and {letter}3 are one point: {effect}")


def _broken(lengths: Sequence[Surd], named: Named) -> InputError:
    """The error of sides that are of no triangle: the longest one is too long."""
    longest = max(range(3), key=lambda n: lengths[n])
    first, second = (n for n in range(3) if n != longest)
    others = lengths[first].rational, lengths[second].rational
    if others[0] is not None and others[1] is not None:
        limit = exact_str(others[0] + others[1])
    else:
        from flint import ctx

        with ctx.workprec(128):
            limit = f"about {(lengths[first].ball() + lengths[second].ball()).str(10, radius=False)}"
    message = (
        f"{named.side(longest)} = {_text(lengths[longest])} breaks the triangle inequality: it must be at "
        f"most {named.side(first)} + {named.side(second)} = {limit}"
    )
    return InputError.of(named.side_field(longest), message)


def by_points(points: Sequence[Any], named: Named, max_digits: int = MAX_DIGITS) -> Triangle:
    """The triangle with these corners (x, y).

    Raises:
        InputError: naming each corner or coordinate at fault; the square of a side is not rational.
    """
    fields = {f"{named.field}.points[{n}]": point for n, point in enumerate(points)}
    corners = tuple(parse_all(fields, lambda point, name: _corner(point, name, max_digits)).values())
    problems: list[FieldProblem] = []
    squares = []
    for first, second in SIDES:
        try:
            squares.append(_squared_side(corners, first, second, named, max_digits))
        except InputError as error:
            problems += error.problems
    if problems:
        raise InputError(problems)
    a, b, c = squares
    one, two, three = corners
    if not any(squares):
        raise one_point(named)
    return Triangle((a, b, c), _sense(corners, heron((a, b, c))), (one, two, three))


def _squared_side(
    corners: Sequence[Point], first: int, second: int, named: Named, max_digits: int
) -> Fraction:
    """|P − Q|² = |P|² + |Q|² − 2 P·Q, the two products of P·Q being surds.

    A sum of two surds is rational only if both are, or if they cancel: √A ± √B = q gives q (q ∓ 2√B) = A − B.
    """
    p, q = corners[first], corners[second]
    names = [f"{named.field}.points[{n}]" for n in (first, second)]
    letters = [f"{named.corners}{n + 1}" for n in (first, second)]
    products = [x * y for x, y in zip(p, q, strict=True)]
    whole = [product.rational for product in products]
    if None in whole and products[0] != -products[1]:
        odd = [k for k, part in enumerate(whole) if part is None]
        raise InputError([_at_odds(k, p[k], q[k], names, letters) for k in odd])
    dot = sum((part for part in whole if part is not None), Fraction(0))
    square = sum((z.square for z in (*p, *q)), Fraction(0)) - 2 * dot
    if max(square.numerator, square.denominator).bit_length() > _BITS_OF_A_DIGIT * SQUARE * max_digits:
        raise InputError.of(
            names[1], f"the square of {''.join(letters)} has more than {SQUARE * max_digits} digits"
        )
    return square


_BITS_OF_A_DIGIT = Fraction(3321, 1000)
"""A little less than log₂ 10: a number within so many bits has no more digits."""


def _at_odds(axis: int, x: Surd, y: Surd, names: Sequence[str], letters: Sequence[str]) -> FieldProblem:
    """Two coordinates whose product is irrational, so that the square of the side is."""
    other, own = (f"{name}[{axis}]" for name in names)
    message = (
        f"{_text(y)} is at odds with {other} = {_text(x)}: the square of {''.join(letters)} would be "
        f"irrational, and must be rational; give {'xy'[axis]} of {letters[0]} and {letters[1]} as multiples "
        f"of one root, or the sides, as in {EXAMPLES['sides']}"
    )
    return FieldProblem(own, message)


def _sense(corners: Sequence[Point], area16: Fraction) -> str:
    """The sense of three corners, of which H is known."""
    if not area16:
        return CCW

    from flint import arb, ctx

    def sign(bits: int) -> str | None:
        with ctx.workprec(bits):
            twice = arb(0)
            for n, k in SIDES:
                (x, y), (u, v) = corners[n], corners[k]
                twice += (x * v).ball() - (y * u).ball()
            return None if twice.contains(0) else CCW if twice > 0 else CW

    # twice the area, whose square is H / 4 ≠ 0, so that some precision decides
    return decided(sign, 64, GREATEST_BITS, "the sense of a triangle is open")


def _corner(point: Any, name: str, max_digits: int) -> Point:
    if isinstance(point, str | bytes) or not isinstance(point, Sequence) or len(point) != 2:
        raise InputError.of(name, f'is {shown(point)}; give the two coordinates [x, y], such as ["3", "0"]')
    fields = {f"{name}[{k}]": coordinate for k, coordinate in enumerate(point)}
    x, y = parse_all(fields, lambda value, at: parse_surd(value, at, max_digits=max_digits)).values()
    return x, y


def _text(x: Surd) -> str:
    """A number in a message, shortened if it is long."""
    text = str(x)
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}…"


_SHOWN = 40
