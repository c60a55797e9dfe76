"""What an answer costs, estimated from the sizes of its numbers before anything is computed.

Sizes are read from the texts of a question. Every number counts, in any member, so that a new kind of
question has sizes too; a kind may correct them (`Kind.measure`). The estimates are seconds of one core. They
grow with each size, and take as long as it takes to read the question once. Here are those of what several
kinds need. `python -m benchmarks.cost` searches for the questions that take longest for their estimate;
docs/performance.md has the outcome.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import permutations
from math import gcd, inf, isqrt, lcm
from typing import TYPE_CHECKING, Any

from rpr_solver import triangles
from rpr_solver.errors import InputError

if TYPE_CHECKING:
    from rpr_solver import Manipulator

TYPICAL_WINDOWS = 20
"""The windows of a typical manipulator."""

SHORT_BITS = 40
"""Bits of numbers that are not worth shortening."""

_SIDES = ("a2x", "a3x", "a3y", "d1", "d2", "d3")
_FIRST = tuple("-0123456789")  # characters of a number
_BITS = 3.33  # of a decimal digit
_MOST_DIGITS = 4000  # that `int` reads at once
_APART = ("geometry", "certificate", "polynomial")
"""Members whose numbers are the manipulator's, or are compared with what is computed from others."""

_BALLS_SPREAD = 1000  # bits; beyond, the balls of a slice with few digits do not decide it
_OF_ROOTS = (
    3  # bits that take as long as one of six rational numbers: squares and the field have most of them
)
_FOUND_QUICKLY = 2000  # bits of squared sides; coordinates over one field take milliseconds up to there


@dataclass(frozen=True)
class Cost:
    """Estimated seconds of one core: `once` for a job, and `each` for every one of its `parts`."""

    once: float
    each: float
    parts: int = 1

    @property
    def whole(self) -> float:
        """The seconds for all parts."""
        return self.of(self.parts)

    def of(self, parts: int) -> float:
        """Returns the seconds for this number of parts."""
        return self.once + self.each * parts


@dataclass(frozen=True)
class Sizes:
    """The sizes that decide the cost.

    Attributes:
        geometry: bits of the sides of the manipulator, once all are integers without a common factor: a mean
            in which the longest counts half as much again.
        lengths: bits of the longest numerator or denominator of all other numbers in the question.
        spread: bits of the quotient of the longest and the shortest of the sides and the leg lengths.
        digits: significant digits of the answer.
        count: the slices of a table, the lengths at which curves are sampled, or the samples of a path; else
            1.
        deviations: between how many samples of a path it is bounded how far its legs deviate.
        censuses: how many censuses the answer may need beside its own computation.
        limited: how many slices are subdivided within joint limits.
        modes: how often it is decided, beside other work, whether the assembly mode can change.
        nearness: bits by which the triangles are nearly flat, isosceles, right, congruent or similar, but not
            quite.
        alikeness: bits by which they nearly are congruent, or similar in one sense, corner by corner, but not
            quite.
        is_slice: whether a picture shows one slice or joint vector, rather than all lengths.
        is_special: whether a triangle is flat, or the two are congruent or similar, so that slices are solved
            one by one.
        is_thin: whether the platform is flat, so that no slice keeps its cusps if a side grows.
        fineness: by how much finer than a whole picture curves are drawn, as a root.
        objects: how many objects stand in the lists of a document: cusps, poses, events, points.
        limit: seconds after which a verification stops, as the length of the document allows.
    """

    geometry: int
    lengths: int
    spread: int
    digits: int
    count: int
    censuses: int = 0
    limited: int = 0
    deviations: int = 0
    nearness: int = 0
    alikeness: int = 0
    objects: int = 0
    is_slice: bool = True
    is_special: bool = False
    is_thin: bool = False
    limit: float = inf
    fineness: int = 0
    modes: int = 0


@dataclass(frozen=True)
class _GeometrySizes:
    """What the numbers of a geometry say: those of `Sizes`, and the bits of its lengths, with their signs."""

    geometry: int
    scales: Sequence[int]
    nearness: int
    alikeness: int
    is_special: bool
    is_thin: bool


def sizes_of(content: Mapping[str, Any], manipulator: Callable[[], Manipulator]) -> Sizes:
    """Returns the sizes of a question in canonical form.

    Args:
        content: the question.
        manipulator: gives its manipulator; only that of irrational numbers is looked at.
    """
    is_rational = _SIDES[0] in content["geometry"]
    own = _of_lengths(content["geometry"]) if is_rational else _of_triangles(manipulator())
    texts = list(_texts(content))
    numbers = [_size(text) for text in texts if text is not None]
    scales = [*own.scales, *(scale for _, scale in numbers if scale is not None)]
    return Sizes(
        geometry=own.geometry,
        lengths=max((size for size, _ in numbers), default=1),
        spread=max(scales) - min(scales),
        digits=int(content["digits"]),
        count=_count(content),
        nearness=own.nearness,
        alikeness=own.alikeness,
        is_special=own.is_special,
        is_thin=own.is_thin,
        fineness=_fineness(content.get("tolerance")),
        objects=texts.count(None),
    )


def _of_lengths(geometry: Mapping[str, str]) -> _GeometrySizes:
    """Of six rational numbers."""
    sides = [_quotient(geometry[name]) for name in _SIDES]
    whole = _integers(sides)
    bits = [abs(x).bit_length() for x in whole if x]
    a2x, a3x, a3y, d1, d2, d3 = whole
    base = (a2x**2, (a2x - a3x) ** 2 + a3y**2, a3x**2 + a3y**2)
    height = _bits_lost(a3y, max(map(abs, whole[:3])))
    is_turned = (geometry.get("orientation") == triangles.CW) == (a2x * a3y > 0)
    shape = _shape(base, (d1**2, d2**2, d3**2), height, is_flat=not a3y, is_turned=is_turned)
    scales = [above.bit_length() - below.bit_length() for above, below in sides if above]
    return _GeometrySizes((max(bits) + 2 * sum(bits) // len(sides)) // 3, scales, *shape)


def _of_triangles(manipulator: Manipulator) -> _GeometrySizes:
    """Of two triangles: the bits are those of their coordinates over one field, of ρ and of the radicand.

    Where there are no such coordinates, or finding them takes long itself, they are those of the squares of
    the sides.
    """
    geometry = manipulator.geometry
    squares = [square.as_integer_ratio() for t in (geometry.base, geometry.platform) for square in t.squares]
    whole = _integers(squares)
    a, b, c = base = (whole[0], whole[1], whole[2])
    area = 4 * a * c - (a + c - b) ** 2  # 16 times its square
    height = _bits_lost(area, max(base) ** 2) // 2
    is_turned = geometry.base.sense != geometry.platform.sense
    platform = whole[3], whole[4], whole[5]
    shape = _shape(base, platform, height, is_flat=not area, is_turned=is_turned)
    scales = [(above.bit_length() - below.bit_length()) // 2 for above, below in squares if above]
    field, frame = 0, None
    if max(map(abs, whole)).bit_length() <= _FOUND_QUICKLY:
        with suppress(InputError):
            frame = triangles.CommonFrame.of(geometry)
    if frame is None:
        parts = whole
    else:
        field = frame.rho.bit_length() + frame.radicand.bit_length()
        corners = (*frame.base, *frame.platform)
        numbers = (x for corner in corners for y in (corner.x, corner.y) for x in (y.a, y.b))
        parts = _integers([x.as_integer_ratio() for x in numbers])
    bits = [abs(x).bit_length() for x in parts if x]
    own = (max(bits) + 2 * sum(bits) // len(bits)) // 3 + field
    return _GeometrySizes(max(1, own // _OF_ROOTS), scales, *shape)


def _integers(numbers: Sequence[tuple[int, int]]) -> list[int]:
    """Quotients as integers without a common factor."""
    unit = lcm(*(below for _, below in numbers))
    whole = [above * (unit // below) for above, below in numbers]
    common = gcd(*whole)
    return [x // common for x in whole]


def fewer_parts(content: Mapping[str, Any], size: Sizes) -> Mapping[str, tuple[Sizes, str]]:
    """Returns the member of a question by which it asks for many slices or samples, with the sizes at best
    and what to do."""
    if size.count == 1:
        return {}
    listed = isinstance(content.get("l1"), list) or content.get("lengths")
    member = f"l{content.get('fixed_leg', 1)}" if listed else "samples"
    return {member: (replace(size, count=1), f"ask for fewer than {size.count}")}


def digits_of_bits(bits: int) -> int:
    """Returns the decimal digits of a number with this number of bits."""
    return int(bits * 0.30103) + 1


def exact_bits(document: Mapping[str, Any], longest: int, digits: int) -> int:
    """Bits of the longest number of a document at which equations are derived: those of its slices and legs.

    A quarter of those that its digits do not explain, elsewhere.
    """
    slices = document.get("slices")
    exact = [document, *(slices if isinstance(slices, list) else ())]
    texts = (text for part in exact if isinstance(part, Mapping) for text in part.values())
    sizes = (_size(text)[0] for text in texts if isinstance(text, str) and text[:1] in _FIRST)
    return max(1, (longest - int(_BITS * (digits + 10))) // 4, *sizes)


def elimination(size: Sizes) -> float:
    """For all lengths, in balls whose precision grows with the coefficients.

    Measured: 35 ms with sides of 4 digits, 0.6 s with 128 and 4 s with 400.
    """
    return 0.02 + 0.003 * size.geometry + 4e-6 * size.geometry**2


def elimination_at_one(size: Sizes) -> float:
    """In balls at the length of one slice.

    Measured with the slice itself, which is 2 ms if short: 7 to 11 ms with sides of 4 digits, 33 with 32,
    120 with 128 and 0.46 s with 400; with short sides and a length of 400 digits 0.14 s.
    """
    return 0.006 + 2e-4 * size.geometry + 1e-4 * size.lengths + 3e-8 * (size.geometry**2 + size.lengths**2)


def one_slice(size: Sizes) -> float:
    """In balls; lengths of very different sizes need a higher precision, and at last number fields."""
    numbers = 1e-5 * size.geometry + 5e-6 * size.lengths + 4e-6 * size.spread**2
    balls = 0.002 + numbers + 2e-6 * size.digits + 8e-10 * size.digits**2
    balls += 0.0015 * max(0, size.nearness - 20) + 0.02 * size.is_special  # one by one
    return balls + (0.1 + 5e-6 * size.geometry**2 if size.spread > _BALLS_SPREAD else 0.0)


def all_events(size: Sizes) -> float:
    """All transitions of a manipulator, and aspects between.

    Measured: 70 ms with sides of 3 digits, 0.7 s with 64 and 1.7 s with 128; beside special shapes of 40
    digits 0.1 to 3 s, of 16 digits 0.1 to 0.8; flat and congruent triangles 0.06 to 0.8 s.
    """
    numbers = 0.0022 * size.geometry + 5e-6 * size.geometry**2 + 2e-4 * size.digits
    return 0.12 + numbers + 0.006 * size.nearness + 0.1 * size.is_special


def _fineness(tolerance: object) -> int:
    return (
        isqrt(int(1 / Fraction(tolerance))) if isinstance(tolerance, str) and Fraction(tolerance) > 0 else 0
    )


def _count(content: Mapping[str, Any]) -> int:
    if isinstance(content.get("l1"), list):
        return len(content["l1"])
    return max(1, len(content.get("lengths", ())) + TYPICAL_WINDOWS * (content.get("samples") or 0))


def _texts(value: Any, *, is_listed: bool = False) -> Iterator[str | None]:
    """All texts in a value that may be numbers, and None for each object in a list."""
    if isinstance(value, str):
        if value[:1] in _FIRST:
            yield value
    elif isinstance(value, Mapping):
        if is_listed:
            yield None
        for name, item in value.items():
            if name not in _APART:
                yield from _texts(item)
    elif isinstance(value, list | tuple):
        for item in value:
            yield from _texts(item, is_listed=True)


def _quotient(text: str) -> tuple[int, int]:
    """Numerator and denominator of a side in canonical text, in lowest terms."""
    whole, point, part = text.partition(".")
    if not point or len(text) > _MOST_DIGITS:
        return Fraction(text).as_integer_ratio()
    above, below = int(whole + part), 10 ** len(part)
    common = gcd(above, below)
    return above // common, below // common


def _size(text: str) -> tuple[int, int | None]:
    """The bits of a number's numerator or denominator, and those of its value, None if it is 0."""
    above, slash, below = text.lstrip("-").partition("/")
    if slash:
        return int(_BITS * max(len(above), len(below))), int(_BITS * (len(above) - len(below)))
    mantissa, _, power = above.partition("e")
    whole, _, part = mantissa.partition(".")
    whole, digits = whole.lstrip("0"), part.lstrip("0")
    try:
        exponent = int(power[:10] or 0)
    except ValueError:
        exponent = 0
    scale = exponent + (len(whole) or len(digits) - len(part))
    size = int(_BITS * max(len(whole) + len(part), abs(scale)))
    return size, int(_BITS * scale) if whole or digits else None


Squares = tuple[int, int, int]
"""The squares of the sides of a triangle."""


def _shape(
    base: Squares, platform: Squares, height: int, *, is_flat: bool, is_turned: bool
) -> tuple[int, int, bool, bool]:
    """Bits by which the triangles nearly are flat, equilateral, congruent or similar; those of the last two,
    corner by corner; whether they are flat or similar; whether the platform is flat.

    `height`: the bits by which the base nearly is flat. `is_turned`: whether their senses differ.

    Congruent are also triangles whose corners have other names. The bits are those of the quotient of what
    then vanishes and its terms; half of them, if they nearly are isosceles or right. A shape that they have
    is none that they nearly have.
    """
    a, b, c = platform
    area = 4 * a * c - (a + c - b) ** 2  # 16 times its square
    most = max(height, _bits_lost(area, max(platform) ** 2))
    for a, b, c in (base, platform):
        size = max(a, b, c)
        equal = sorted(_bits_lost(x, size) for x in (a - b, b - c, c - a))
        right = max(_bits_lost(x, size) for x in (a + b - c, b + c - a, c + a - b))
        most = max(most, equal[1], equal[2] // 2, right // 2)
    congruent, similar, partly, are_similar = _alike(base, platform)
    alike = congruent if is_turned else max(congruent, similar)
    return max(most, congruent, similar, partly), alike, is_flat or not area or are_similar, not area


def _alike(base: Squares, platform: Squares) -> tuple[int, int, int, bool]:
    """Bits by which two triangles nearly are congruent, and similar, corner by corner; those by which they
    are in some sides, or but for the names of the corners; whether they are similar."""
    alike, partly = [0, 0], 0
    pairs = list(zip(base, platform, strict=True))
    turned = pairs[1:] + pairs[:1]
    crossed = [(x * w - y * z, max(x * w, y * z)) for (x, z), (y, w) in zip(pairs, turned, strict=True)]
    for k, forms in enumerate(([(x - y, max(x, y)) for x, y in pairs], crossed)):
        lost = [_bits_lost(x, size) for x, size in forms if x]
        partly = max(partly, max(lost, default=0) // 2)
        alike[k] = min(lost, default=0)
    apart = [[_bits_lost(x - y, max(x, y)) if x != y else inf for y in platform] for x in base]
    for i, j, k in permutations(range(3)):
        least = min(apart[0][i], apart[1][j], apart[2][k])
        partly = max(partly, int(least) if least < inf else 0)
    return alike[0], alike[1], partly, not any(x for x, _ in crossed)


def _bits_lost(x: int, size: int) -> int:
    """The bits by which a form is smaller than its terms; none if it vanishes."""
    return max(0, size.bit_length() - abs(x).bit_length()) if x else 0
