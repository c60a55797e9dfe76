"""The head of a document: the canonical form of a geometry, its hash, and special shapes near it.

Most geometries are near none. That is decided by doubles, from the canonical texts alone and within a proved
bound of their roundings; only the others are read, and measured exactly (:mod:`rpr_solver.triangles.near`).
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from functools import lru_cache
from math import sqrt
from typing import Any, TypeAlias

from rpr_solver.exact.numerals import fraction
from rpr_solver.triangles.geometry import Canonical, read_geometry

Doubles: TypeAlias = tuple[float, float, float]

_SPREAD = 1.0041
"""Greatest quotient of two squares of ratios within the distance 1/1000: (1001/999)² = 1.0040120…"""
_FLAT = 0.00101
"""Greatest (a + b − c) / (a + b + c) of what is within the distance 1/1000, and more than roundings."""
_LEAST, _GREATEST = 1e-140, 1e140
"""Squared sides between these are far from where doubles end; so are their quotients."""
_CANCELLED = 1e-8
"""A squared side below this part of the square of what it is the difference of is not known well enough."""
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
    """Whether a geometry may have a special shape or be near one; False is proved.

    The squared sides are known with a relative error below 10⁻⁷ (else the answer is True): each operation
    rounds by at most 2⁻⁵³, and a side that is a difference is at least 10⁻⁴ of the numbers it comes from.
    The bounds leave more than that. With the squared sides s and t of two of one triangle, or the quotients
    of sides of both:

    - an isosceles shape within 1/1000 has s/t ≤ (1001/999)²; right isosceles and equilateral ones, too;
    - so have, for all pairs of quotients, similar shapes, congruent ones and mirrored ones;
    - a flat one has (a + b − c) / (a + b + c) < 1/1000.
    """
    try:
        base, platform = _base(canonical), _platform(canonical)
    except OverflowError:
        return True
    if base is None or not all(_LEAST < square < _GREATEST for square in (*base, *platform)):
        return True
    quotients = [x / y for x, y in zip(base, platform, strict=True)]
    return (
        max(quotients) <= _SPREAD * min(quotients)
        or _is_isosceles_or_flat(base)
        or _is_isosceles_or_flat(platform)
    )


def _is_isosceles_or_flat(squares: Doubles) -> bool:
    a, b, c = sorted(squares)
    if b <= _SPREAD * a or c <= _SPREAD * b:
        return True
    x, y, z = sqrt(a), sqrt(b), sqrt(c)
    return x + y - z < _FLAT * (x + y + z)


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
        _double(text[len("sqrt(") : -1]) if text.startswith("sqrt(") else _double(text) ** 2 for text in texts
    )
    return a, b, c


def _double(text: str) -> float:
    return float(fraction(text)) if "/" in text else float(text)
