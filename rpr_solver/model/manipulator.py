"""The manipulator: exact geometry, validated, with a canonical form and a content hash."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import lcm
from os import PathLike, fspath
from pathlib import Path
from types import MappingProxyType
from typing import Any

from rpr_solver.contract import LENGTHS
from rpr_solver.errors import FieldProblem, InputError, clipped, shown
from rpr_solver.exact.rationals import MAX_DIGITS, Exact, exact_str, parse_all, parse_exact
from rpr_solver.notebook import html_table
from rpr_solver.notebook.figure import Figure, draw

CCW, CW = "ccw", "cw"
_FIELDS = (*LENGTHS, "orientation")
_NOTES = ("name", "unit")
_BESIDE = ("$schema", *_NOTES)
"""What a geometry may have beside its fields: for editors and readers, and no part of its identity."""
_MISSING = object()


@dataclass(frozen=True)
class Manipulator:
    """A planar 3-RPR manipulator, exact (the article's Fig. 1).

    Base points A1 = (0, 0), A2 = (a2x, 0), A3 = (a3x, a3y); platform B1B2B3.

    Args:
        a2x: the x coordinate of A2, in the user's unit of length like all lengths, ≠ 0.
        a3x: the x coordinate of A3.
        a3y: the y coordinate of A3.
        d1: the side |B1B2| of the platform, > 0.
        d2: the side |B2B3|.
        d3: the side |B3B1|.
        orientation: ``"ccw"`` if B1B2B3 is counter-clockwise, ``"cw"`` if clockwise; for a flat platform
            both are the same manipulator.

    Raises:
        InputError: naming every field at fault: a length is not an exact number, two base points coincide,
            a side is not positive, the sides break the triangle inequality, or the orientation is unknown.

    >>> manipulator = Manipulator("15.91", 0, 10, "17.04", "16.54", "20.84")
    >>> manipulator.d1, manipulator == EXAMPLES["innocenti"]
    (Fraction(426, 25), True)
    >>> Manipulator(15.91, 0, 10, 17, 16, 40)
    Traceback (most recent call last):
    rpr_solver.errors.InputError: geometry.a2x: 15.91 is a binary float, not an exact number; write "15.91"
    """

    a2x: Fraction
    a3x: Fraction
    a3y: Fraction
    d1: Fraction
    d2: Fraction
    d3: Fraction
    orientation: str = CCW

    def __init__(
        self, a2x: Exact, a3x: Exact, a3y: Exact, d1: Exact, d2: Exact, d3: Exact, orientation: str = CCW
    ) -> None:
        values = zip(LENGTHS, (a2x, a3x, a3y, d1, d2, d3), strict=True)
        lengths = parse_all({f"geometry.{name}": value for name, value in values}, parse_exact)
        for name, length in zip(LENGTHS, lengths.values(), strict=True):
            object.__setattr__(self, name, length)
        object.__setattr__(self, "orientation", orientation)
        if problems := self._problems():
            raise InputError(problems)
        if self.area16 == 0:
            object.__setattr__(self, "orientation", CCW)

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={shown(text)}" for name, text in self.to_json().items())
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
        """Reads the contract's geometry object; numbers are exact (see :func:`parse_exact`).

        Raises:
            InputError: naming every missing, unknown or invalid field.

        >>> Manipulator.from_json({"a2x": 20, "a3x": 6, "a3y": 0, "d1": 7, "d2": 9, "d3": 17})
        Traceback (most recent call last):
        rpr_solver.errors.InputError: geometry.d3: d3 = 17 breaks the triangle inequality: ...
        """
        if not isinstance(obj, Mapping):
            raise InputError.of(
                "geometry", f"{shown(obj)} is not an object with the fields {', '.join(LENGTHS)}"
            )
        problems = [
            FieldProblem(f"geometry.{name}", f"unknown field; known are {', '.join(_FIELDS)}")
            for name in obj
            if name not in (*_FIELDS, *_BESIDE)
        ]
        problems += _problems_beside(obj)

        def length(value: Any, field: str) -> Fraction:
            if value is _MISSING:
                raise InputError.of(field, "is missing; give a number")
            return parse_exact(value, field, max_digits=max_digits)

        try:
            lengths = parse_all({f"geometry.{name}": obj.get(name, _MISSING) for name in LENGTHS}, length)
        except InputError as error:
            problems += error.problems
        if problems:
            raise InputError(problems)
        return cls(*lengths.values(), orientation=obj.get("orientation", CCW))  # type: ignore[arg-type,misc]

    def to_json(self) -> dict[str, str]:
        """The contract's geometry object, with numbers in canonical text; :meth:`from_json` is its inverse.

        >>> EXAMPLES["innocenti"].to_json()["d1"]
        '17.04'
        """
        lengths = {name: exact_str(getattr(self, name)) for name in LENGTHS}
        return {**lengths, "orientation": self.orientation}

    def to_dict(self) -> dict[str, Any]:
        """The constructor's arguments, exact: ``Manipulator(**m.to_dict()) == m``.

        >>> Manipulator(**{**EXAMPLES["innocenti"].to_dict(), "d1": "17.05"}).d1
        Fraction(341, 20)
        """
        return {name: getattr(self, name) for name in _FIELDS}

    def _repr_html_(self) -> str:
        return html_table("3-RPR manipulator", [self.to_json()])

    def _repr_svg_(self) -> str:
        return self.figure().svg()

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
        """The geometry and its hash, the head of every document."""
        return {"geometry": self.to_json(), "geometry_hash": self.geometry_hash}

    @property
    def area16(self) -> Fraction:
        """16 times the squared area of the platform (Heron): 0 for a flat platform."""
        (d1, d2, d3), unit = self._sides
        return Fraction((d1 + d2 + d3) * (-d1 + d2 + d3) * (d1 - d2 + d3) * (d1 + d2 - d3), unit**4)

    @property
    def _sides(self) -> tuple[list[int], int]:
        """The numerators of the sides of the platform over a common denominator, and this."""
        sides = self.d1, self.d2, self.d3
        unit = lcm(*(side.denominator for side in sides))
        return [side.numerator * (unit // side.denominator) for side in sides], unit

    def _problems(self) -> list[FieldProblem]:
        problems: list[FieldProblem] = []

        def problem(name: str, message: str) -> None:
            problems.append(FieldProblem(f"geometry.{name}", message))

        if not self.a2x:
            problem("a2x", "is 0, so A1 and A2 coincide; give a2x ≠ 0")
        if not self.a3x and not self.a3y:
            problem("a3x", "A1 and A3 coincide; give a3x ≠ 0 or a3y ≠ 0")
        if self.a2x and not self.a3y and self.a3x == self.a2x:
            problem("a3x", "A2 and A3 coincide; give a3x ≠ a2x or a3y ≠ 0")
        numerators, unit = self._sides
        sides = dict(zip(("d1", "d2", "d3"), numerators, strict=True))
        for name, side in sides.items():
            if side <= 0:
                problem(name, f"is {_short(Fraction(side, unit))}; a side of the platform must be > 0")
        whole, longest = sum(numerators), max(sides, key=lambda name: sides[name])
        if not problems and 2 * (side := sides[longest]) > whole:
            others = " + ".join(name for name in sides if name != longest)
            broken = f"{longest} = {_short(Fraction(side, unit))} breaks the triangle inequality"
            limit = _short(Fraction(whole - side, unit))
            problem(longest, f"{broken}: it must be at most {others} = {limit}")
        if self.orientation not in (CCW, CW):
            problem("orientation", f'{shown(self.orientation)} is neither "ccw" nor "cw"')
        return problems


def geometry_within(value: Any) -> Any:
    """The geometry in a JSON value: the value, or the member ``geometry`` of an answer or another object.

    >>> geometry_within({"count": 6, "geometry": {"a2x": "20"}})
    {'a2x': '20'}
    """
    if isinstance(value, Mapping) and not any(name in value for name in LENGTHS):
        inner = value.get("geometry")
        return inner if isinstance(inner, Mapping) else value
    return value


def notes_on(geometry: Mapping[str, Any]) -> dict[str, str]:
    """The name and the unit that a geometry gives.

    Raises:
        InputError: one of them is no text.
    """
    if problems := _problems_beside(geometry):
        raise InputError(problems)
    return {name: geometry[name] for name in _NOTES if name in geometry}


def without_notes(geometry: Mapping[str, Any]) -> dict[str, Any]:
    """A geometry without what it may have beside its fields.

    Raises:
        InputError: its name or its unit is no text.
    """
    notes_on(geometry)
    return {name: value for name, value in geometry.items() if name not in _BESIDE}


def _problems_beside(geometry: Mapping[str, Any]) -> list[FieldProblem]:
    wrong = {name: geometry[name] for name in _NOTES if type(geometry.get(name, "")) is not str}
    return [
        FieldProblem(
            f"geometry.{name}", f"is {value if isinstance(value, str) else shown(value)}; give a text"
        )
        for name, value in wrong.items()
    ]


def hash_of_canonical(geometry: Mapping[str, str]) -> str:
    """The hash of a geometry as :meth:`Manipulator.to_json` gives it, without reading its numbers."""
    text = ";".join(f"{name}={geometry[name]}" for name in _FIELDS)
    return "sha256:" + hashlib.sha256(f"3-RPR;{text}".encode()).hexdigest()


def _short(x: Fraction) -> str:
    return clipped(exact_str(x))


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
