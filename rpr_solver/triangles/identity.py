"""The head of a document: the canonical form of a geometry, its hash, and special shapes near it.

Most geometries are near none. That is decided by doubles, from the canonical texts alone and within a proved
bound of their roundings; only the others are read, and measured exactly (:mod:`rpr_solver.triangles.near`).
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from fractions import Fraction
from functools import lru_cache
from math import lcm, sqrt
from typing import Any, TypeAlias

from rpr_solver.contract import LENGTHS
from rpr_solver.exact.numerals import fraction
from rpr_solver.triangles.geometry import Canonical, read_geometry
from rpr_solver.triangles.triangle import heron

Doubles: TypeAlias = tuple[float, float, float]

_SPREAD = 1.0041
"""Greatest quotient of two squares of ratios within the distance 1/1000: (1001/999)² = 1.0040120…"""
_FLAT = 0.00101
"""Greatest (a + b − c) / (a + b + c) of what is within the distance 1/1000, and more than roundings."""
_LEAST, _GREATEST = 1e-140, 1e140
"""Squared sides between these are far from where doubles end; so are their quotients."""
_CANCELLED = 1e-8
"""A squared side below this part of the square of what it is the difference of is not known well enough."""
_ROOT = "sqrt("
_KEPT = 4096
"""Geometries whose shapes nearby are kept."""


def identity_json(canonical: Canonical, geometry_hash: str) -> dict[str, Any]:
    """The members of every document that say what it is about: ``geometry``, ``geometry_hash``, and ``near``
    if special shapes are near.

    Args:
        canonical: the canonical form (:meth:`~rpr_solver.triangles.Geometry.to_json`).
        geometry_hash: its hash.

    >>> from rpr_solver import EXAMPLES
    >>> list(EXAMPLES["innocenti"].identity_json())
    ['geometry', 'geometry_hash']
    """
    head = {"geometry": canonical, "geometry_hash": geometry_hash}
    near = near_json(canonical)
    return {**head, "near": near} if near else head


def near_json(canonical: Canonical) -> list[dict[str, Any]]:
    """The special shapes near a geometry as documents have them; those that matter first.

    >>> near_json({"a2x": "7", "a3x": "2", "a3y": "5", "d1": "3", "d2": "3", "d3": "4", "orientation": "ccw"})
    []
    """
    return deepcopy(_near(tuple((x, y if isinstance(y, str) else tuple(y)) for x, y in canonical.items())))


@lru_cache(_KEPT)
def _near(canonical: tuple[tuple[str, str | tuple[str, ...]], ...]) -> list[dict[str, Any]]:
    members = {name: value if isinstance(value, str) else list(value) for name, value in canonical}
    if not may_be_near(members):
        return []
    from rpr_solver.triangles.near import near_shapes  # here, as it loads FLINT

    return [shape.to_json() for shape in near_shapes(read_geometry(members, max_digits=1 << 20))]


def may_be_near(canonical: Mapping[str, Any]) -> bool:
    """Whether a geometry may be near a special shape that it has not got; False is proved.

    The squared sides are known as doubles with a relative error below 10⁻⁷ (else the answer is True): each
    operation rounds by at most 2⁻⁵³, and a side that is a difference is at least 10⁻⁴ of the numbers it comes
    from. The bounds leave more than that. With two squared sides s ≥ t of one triangle, or with squares of
    quotients of sides of both:

    - an isosceles shape within 1/1000 has s/t ≤ (1001/999)²; right isosceles and equilateral ones, too;
    - so have, for all pairs of quotients, similar shapes, congruent ones and mirrored ones;
    - a flat one has (a + b − c) / (a + b + c) < 1/1000.

    What doubles do not exclude is no shape nearby if all of it holds exactly, as integers tell.
    """
    try:
        base, platform = _base(canonical), _platform(canonical)
    except OverflowError:
        return True
    if base is None or not all(_LEAST < square < _GREATEST for square in (*base, *platform)):
        return True
    suspects = [_is_suspect(base), _is_suspect(platform)]
    quotients = [x / y for x, y in zip(base, platform, strict=True)]
    are_alike = max(quotients) <= _SPREAD * min(quotients)
    if not are_alike and not any(suspects):
        return False
    exact = _exact_squares(canonical)
    triangles = zip(suspects, exact, (base, platform), strict=True)
    return (are_alike and not _are_exactly_alike(*exact)) or any(
        is_suspect and not _is_exactly_special(squares, _is_low(doubles))
        for is_suspect, squares, doubles in triangles
    )


def _is_suspect(squares: Doubles) -> bool:
    a, b, c = sorted(squares)
    return b <= _SPREAD * a or c <= _SPREAD * b or _is_low(squares)


def _is_low(squares: Doubles) -> bool:
    """Whether a triangle may be flat, or nearly."""
    a, b, c = map(sqrt, sorted(squares))
    return a + b - c < _FLAT * (a + b + c)


Integers: TypeAlias = tuple[int, int, int]
_PARTS = 10_000
_SPREAD_PARTS = 10_041


def _are_close(x: int, y: int) -> bool:
    return _PARTS * max(x, y) <= _SPREAD_PARTS * min(x, y)


def _is_exactly_special(squares: Integers, is_low: bool) -> bool:
    """Whether all shapes that a triangle may be near are shapes that it has."""
    a, b, c = sorted(squares)
    if is_low and heron((Fraction(a), Fraction(b), Fraction(c))):
        return False
    if (a != b and _are_close(a, b)) or (b != c and _are_close(b, c)):
        return False
    # the legs of a right isosceles triangle are its shorter sides
    return a != b or c == 2 * a or not _are_close(c, 2 * a)


def _are_exactly_alike(base: Integers, platform: Integers) -> bool:
    """Whether two triangles, which may be near similar ones, are similar or mirrored, and not nearly
    congruent."""
    (a, b, c), (x, y, z) = base, platform
    return a * y == b * x and a * z == c * x and (a == x or not _are_close(a, x))


def _exact_squares(canonical: Mapping[str, Any]) -> tuple[Integers, Integers]:
    """The squared sides of base and platform, all times one factor."""
    if "base" in canonical:
        squares = [_square(text) for name in ("base", "platform") for text in canonical[name]]
        factor = lcm(*(square.denominator for square in squares))
        a, b, c, x, y, z = (square.numerator * (factor // square.denominator) for square in squares)
        return (a, b, c), (x, y, z)
    lengths = [fraction(canonical[name]) for name in LENGTHS]
    factor = lcm(*(length.denominator for length in lengths))
    x2, x3, y3, d1, d2, d3 = (length.numerator * (factor // length.denominator) for length in lengths)
    return (x2 * x2, (x3 - x2) ** 2 + y3 * y3, x3 * x3 + y3 * y3), (d1 * d1, d2 * d2, d3 * d3)


def _square(text: str) -> Fraction:
    return fraction(text[len(_ROOT) : -1]) if text.startswith(_ROOT) else fraction(text) ** 2


def _base(canonical: Mapping[str, Any]) -> Doubles | None:
    """The squared sides of the base; None if doubles do not know one well enough."""
    if "base" in canonical:
        return _of_sides(canonical["base"])
    x2, x3, y3 = (_double(canonical[name]) for name in ("a2x", "a3x", "a3y"))
    squares = x2 * x2, (x3 - x2) ** 2 + y3 * y3, x3 * x3 + y3 * y3
    return None if squares[1] < _CANCELLED * (abs(x2) + abs(x3)) ** 2 else squares


def _platform(canonical: Mapping[str, Any]) -> Doubles:
    if "platform" in canonical:
        return _of_sides(canonical["platform"])
    return _of_sides([canonical[name] for name in ("d1", "d2", "d3")])


def _of_sides(texts: list[str]) -> Doubles:
    a, b, c = (
        _double(text[len(_ROOT) : -1]) if text.startswith(_ROOT) else _double(text) ** 2 for text in texts
    )
    return a, b, c


def _double(text: str) -> float:
    return float(fraction(text)) if "/" in text else float(text)
