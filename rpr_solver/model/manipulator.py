"""The manipulator: exact geometry, validated, with a canonical form and a content hash."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import inf, isqrt, nextafter
from os import PathLike, fspath
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self, TypeAlias

from rpr_solver.contract import LENGTHS
from rpr_solver.errors import FieldProblem, InputError, shown
from rpr_solver.exact.numerals import double
from rpr_solver.exact.rationals import MAX_DIGITS
from rpr_solver.notebook import html_table, near_words
from rpr_solver.notebook.figure import Figure, Pictured, draw, shown_as_svg
from rpr_solver.triangles import (
    CCW,
    CW,
    Canonical,
    ExactRoot,
    Geometry,
    Surd,
    hash_of_canonical,
    identity_json,
    near_json,
    note_problems,
    read_geometry,
)

if TYPE_CHECKING:
    from flint import arb

    from rpr_solver.triangles import CommonFrame

_FIELDS = (*LENGTHS, "orientation")
_TRIANGLES = ("base", "platform")
_NOTES = ("name", "unit")
"""What a geometry may have beside its fields: for readers, and no part of its identity."""
_DOUBLE_BITS = 128
"""Working precision for doubles: a root is known far beyond the 53 bits of one."""

_BOUND_BITS = 128
"""Bits of rational bounds: far more than doubles have."""

Length: TypeAlias = Fraction | Surd
"""A rational number, or a surd that is irrational."""


@dataclass(frozen=True)
class Manipulator(Pictured):
    """A planar 3-RPR manipulator, exact (the article's Fig. 1): base A1A2A3, platform B1B2B3.

    It is given by six numbers, or by two triangles in any of their spellings
    (:func:`~rpr_solver.triangles.read_geometry`). Each number may be a root, such as ``"5*sqrt(3)/2"``. In
    the article's frame A1 = (0, 0), A2 = (a2x, 0) and A3 = (a3x, a3y). The six lengths are rational numbers
    where they are rational, and :class:`~rpr_solver.triangles.Surd` elsewhere.

    Args:
        a2x: the x coordinate of A2, in the user's unit of length like all lengths, ≠ 0; if a number is
            irrational > 0.
        a3x: the x coordinate of A3.
        a3y: the y coordinate of A3.
        d1: the side |B1B2| of the platform, > 0.
        d2: the side |B2B3|.
        d3: the side |B3B1|.
        orientation: ``"ccw"`` if B1B2B3 is counter-clockwise, ``"cw"`` if clockwise; for a flat platform
            both are the same manipulator.
        base, platform: instead of the six numbers the two triangles, each as an object with ``sides``,
            ``points``, ``equilateral`` or ``circumradius``.

    Raises:
        InputError: naming every field at fault: a length is not an exact number, two corners coincide, a side
            is not positive or its square not rational, the sides break the triangle inequality, or the
            orientation is unknown.

    >>> manipulator = Manipulator("15.91", 0, 10, "17.04", "16.54", "20.84")
    >>> manipulator.d1, manipulator == EXAMPLES["innocenti"]
    (Fraction(426, 25), True)
    >>> Manipulator(base={"equilateral": 10}, platform={"circumradius": 1}).a3y
    Surd('sqrt(75)')
    >>> Manipulator(15.91, 0, 10, 17, 16, 40)
    Traceback (most recent call last):
    rpr_solver.errors.InputError: geometry.a2x: 15.91 is a binary float, not an exact number; write "15.91"
    """

    a2x: Length
    a3x: Length
    a3y: Length
    d1: Length
    d2: Length
    d3: Length
    orientation: str = CCW
    geometry: Geometry = field(init=False, repr=False, compare=False)
    """The two triangles, with the points by which they were given, if they were."""

    def __init__(
        self,
        a2x: ExactRoot | None = None,
        a3x: ExactRoot | None = None,
        a3y: ExactRoot | None = None,
        d1: ExactRoot | None = None,
        d2: ExactRoot | None = None,
        d3: ExactRoot | None = None,
        orientation: str | None = None,
        *,
        base: Mapping[str, object] | None = None,
        platform: Mapping[str, object] | None = None,
    ) -> None:
        names = (*_FIELDS, *_TRIANGLES)
        values = zip(names, (a2x, a3x, a3y, d1, d2, d3, orientation, base, platform), strict=True)
        self._take(read_geometry({name: value for name, value in values if value is not None}))

    def _take(self, geometry: Geometry) -> None:
        for name, length in zip(LENGTHS, geometry.lengths, strict=True):
            value = length.rational
            object.__setattr__(self, name, length if value is None else value)
        object.__setattr__(self, "orientation", geometry.platform.sense)
        object.__setattr__(self, "geometry", geometry)

    @classmethod
    def of(cls, geometry: Geometry) -> Self:
        """The manipulator of a geometry, which keeps the points by which it was given."""
        manipulator = cls.__new__(cls)
        manipulator._take(geometry)
        return manipulator

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={shown(str(text))}" for name, text in self.to_dict().items())
        return f"Manipulator({values})"

    @classmethod
    def from_file(cls, path: str | PathLike[str]) -> Manipulator:
        """Reads a JSON file with the contract's geometry object; numbers are taken exactly as written.

        The file may have a ``name`` and a ``unit``, which are left aside, or be an answer or another object
        that holds its geometry as the member ``geometry``.

        Raises:
            InputError: naming the file: it cannot be read, or does not describe a manipulator.

        >>> Manipulator.from_file("no-such-robot.json")
        Traceback (most recent call last):
        rpr_solver.errors.InputError: path: 'no-such-robot.json' cannot be read: No such file or directory
        """
        try:
            name = fspath(path)
            text = Path(name).read_text(encoding="utf-8")
            obj = json.loads(text, parse_float=str, parse_int=str, parse_constant=str)
        except TypeError:
            raise InputError.of("path", f"{shown(path)} is a {type(path).__name__}; give a path") from None
        except OSError as error:
            raise InputError.of("path", f"{name!r} cannot be read: {error.strerror}") from None
        except (ValueError, RecursionError) as error:
            raise InputError.of("path", f"{name!r} is not JSON: {error}") from None
        try:
            return cls.from_json(geometry_within(obj))
        except InputError as error:
            problems = [FieldProblem(p.field, f"{p.message} (in {name!r})") for p in error.problems]
            raise InputError(problems) from None

    @classmethod
    def from_json(cls, obj: Mapping[str, object], *, max_digits: int = MAX_DIGITS) -> Manipulator:
        """Reads the contract's geometry object, in any spelling; numbers are exact (:func:`parse_surd`).

        Raises:
            InputError: naming every missing, unknown or invalid field, side or corner.

        >>> Manipulator.from_json({"a2x": 20, "a3x": 6, "a3y": 0, "d1": 7, "d2": 9, "d3": 17})
        Traceback (most recent call last):
        rpr_solver.errors.InputError: geometry.d3: d3 = 17 breaks the triangle inequality: ...
        """
        return cls.of(read_geometry(obj, max_digits=max_digits))

    def to_json(self) -> Canonical:
        """The canonical form of the geometry; :meth:`from_json` is its inverse.

        It has the six numbers in canonical text, if they are rational; otherwise the sides of both triangles,
        each as ``q`` or ``sqrt(q)``, and their senses.

        >>> EXAMPLES["innocenti"].to_json()["d1"]
        '17.04'
        """
        return self.geometry.to_json()

    def to_dict(self) -> dict[str, Any]:
        """The constructor's arguments, exact: ``Manipulator(**m.to_dict()) == m``.

        >>> Manipulator(**{**EXAMPLES["innocenti"].to_dict(), "d1": "17.05"}).d1
        Fraction(341, 20)
        """
        return {name: getattr(self, name) for name in _FIELDS}

    def _repr_html_(self) -> str:
        rows = {name: x if isinstance(x, str) else ", ".join(x) for name, x in self.to_json().items()}
        return html_table("3-RPR manipulator", [rows], first=self.remark)

    def _repr_svg_(self) -> str | None:
        return shown_as_svg(self)

    def figure(self) -> Figure:
        """A picture of the base and the platform at α = 0, with a common centre.

        >>> EXAMPLES["innocenti"].figure()
        <Figure 'Manipulator at α = 0'>
        """
        return draw(self.to_json())

    @cached_property
    def geometry_hash(self) -> str:
        """``sha256:`` and 64 hex digits over the canonical text; equal geometries share it, in every version.

        >>> EXAMPLES["innocenti"].geometry_hash[:20]
        'sha256:4a1f436b75ff0'
        """
        return hash_of_canonical(self.to_json())

    def identity_json(self) -> dict[str, Any]:
        """The geometry, its hash, and special shapes near it, the head of every document."""
        return identity_json(self.to_json(), self.geometry_hash)

    @property
    def remark(self) -> str:
        """The first line of every answer if a special shape nearby contradicts or weakens it; else empty.

        >>> EXAMPLES["innocenti"].remark
        ''
        """
        return near_words({"near": near_json(self.to_json())})

    @property
    def lengths(self) -> tuple[Length, ...]:
        """The six lengths a2x, a3x, a3y, d1, d2 and d3."""
        return tuple(getattr(self, name) for name in LENGTHS)

    @cached_property
    def frame(self) -> CommonFrame:
        """Exact coordinates of both triangles over one quadratic field.

        Raises:
            InputError: naming ``geometry.base`` or ``geometry.platform``: there are none.
        """
        from rpr_solver.triangles import CommonFrame  # here, as it loads FLINT

        return CommonFrame.of(self.geometry)

    @property
    def is_rational(self) -> bool:
        """Whether all six lengths are rational."""
        return all(isinstance(length, Fraction) for length in self.lengths)

    def rational_lengths(self, what: str) -> tuple[Fraction, ...]:
        """The six lengths, for ``what`` is computed with rational numbers alone.

        Raises:
            InputError: naming the first length that is irrational.

        >>> Manipulator(base={"equilateral": 2}, platform={"sides": [3, 4, 5]}).rational_lengths("a design")
        Traceback (most recent call last):
        rpr_solver.errors.InputError: geometry.a3y: is sqrt(3), but a design needs six rational numbers
        """
        lengths: list[Fraction] = []
        for name, length in zip(LENGTHS, self.lengths, strict=True):
            if isinstance(length, Surd):
                raise InputError.of(f"geometry.{name}", f"is {length}, but {what} needs six rational numbers")
            lengths.append(length)
        return tuple(lengths)

    def balls(self) -> list[arb]:
        """Balls round the six lengths, at the working precision."""
        from rpr_solver.exact.real_roots import ball_of  # here, as in Surd.ball

        return [ball_of(x) if isinstance(x, Fraction) else x.ball() for x in self.lengths]

    def doubles(self) -> list[float]:
        """The six lengths as doubles; the nearest ones, but that an irrational one may be off by one unit.

        >>> Manipulator(base={"equilateral": 2}, platform={"sides": [3, 4, 5]}).doubles()[2]
        1.7320508075688772
        """
        return [double(x) if isinstance(x, Fraction) else _near(x) for x in self.lengths]

    def intervals(self) -> list[tuple[float, float]]:
        """Doubles between which the six lengths lie; both ends are one double where a length is this."""
        intervals = []
        for length, near in zip(self.lengths, self.doubles(), strict=True):
            if length == near:
                intervals.append((near, near))
            else:
                # the nearest double but one, so that the length is within two units
                low, high = (nextafter(nextafter(near, end), end) for end in (-inf, inf))
                intervals.append((low, high))
        return intervals

    def bounds(self) -> list[tuple[Fraction, Fraction]]:
        """Rational numbers between which the six lengths lie; both are the length where it is rational.

        >>> low, high = Manipulator(base={"equilateral": 2}, platform={"sides": [3, 4, 5]}).bounds()[2]
        >>> low**2 < 3 < high**2, float(high - low) < 1e-38
        (True, True)
        """
        return [(x, x) if isinstance(x, Fraction) else _between(x) for x in self.lengths]

    @property
    def area16(self) -> Fraction:
        """16 times the squared area of the platform (Heron): 0 for a flat platform."""
        return self.geometry.platform.area16


def _near(length: Surd) -> float:
    from flint import ctx

    with ctx.workprec(_DOUBLE_BITS):
        return float(length.ball())


def _between(length: Surd) -> tuple[Fraction, Fraction]:
    n, d = length.square.numerator, length.square.denominator
    # so that the root, an integer over 2ᵏ, has the bits
    k = max((2 * _BOUND_BITS - n.bit_length() + d.bit_length()) // 2 + 1, 0)
    root = isqrt((n << 2 * k) // d)
    low, high = Fraction(root, 1 << k), Fraction(root + 1, 1 << k)
    return (low, high) if length.sign > 0 else (-high, -low)


def geometry_within(value: Any) -> Any:
    """The geometry in a JSON value: the value, or the member ``geometry`` of an answer or another object.

    >>> geometry_within({"count": 6, "geometry": {"a2x": "20"}})
    {'a2x': '20'}
    """
    if isinstance(value, Mapping) and not any(name in value for name in (*LENGTHS, *_TRIANGLES)):
        inner = value.get("geometry")
        return inner if isinstance(inner, Mapping) else value
    return value


def notes_on(geometry: Mapping[str, Any]) -> dict[str, str]:
    """The name and the unit that a geometry gives.

    Raises:
        InputError: one of them is no text.
    """
    if problems := note_problems(geometry):
        raise InputError(problems)
    return {name: geometry[name] for name in _NOTES if name in geometry}


EXAMPLES: Mapping[str, Manipulator] = MappingProxyType(
    {
        "innocenti": Manipulator("15.91", "0", "10", "17.04", "16.54", "20.84", CCW),
        "zein-flat": Manipulator("30", "11", "27", "13", "9", "4", CCW),
        "twelve-cusps": Manipulator("10", "16.5", "12.5", "22.5", "38", "25.5", CW),
        "fourteen-cusps": Manipulator("10", "16.212", "9.019", "20.433", "32.895", "22.502", CW),
        "sixteen-cusps": Manipulator("10", "16.73912", "7.39002", "23.66811", "24.59925", "5.45049", CCW),
        "eighteen-cusps": Manipulator("10", "9.6358", "2.6742", "25.4175", "50.2854", "25.4175", CCW),
    }
)
"""Manipulators by name: the article's first and second, and four with many cusps in slices of leg 1.

>>> sorted(EXAMPLES)
['eighteen-cusps', 'fourteen-cusps', 'innocenti', 'sixteen-cusps', 'twelve-cusps', 'zein-flat']
"""
