"""The manipulator: exact geometry, validated, with a canonical form and a content hash."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from fractions import Fraction
from functools import cached_property
from types import MappingProxyType

from rpr_solver.errors import FieldProblem, InputError
from rpr_solver.exact.rationals import MAX_DIGITS, exact_str, parse_exact, shown

CCW, CW = "ccw", "cw"
_LENGTHS = ("a2x", "a3x", "a3y", "d1", "d2", "d3")


@dataclass(frozen=True)
class Manipulator:
    """A planar 3-RPR manipulator (method.md section 1; the article's Fig. 1).

    Base points A1=(0,0), A2=(a2x,0), A3=(a3x,a3y); platform sides d1=|B1B2|, d2=|B2B3|,
    d3=|B3B1|, all exact rationals in the user's unit of length. ``orientation`` is
    ``"ccw"`` when B1B2B3 runs counter-clockwise, ``"cw"`` when clockwise; for a flat
    platform both are the same manipulator.

    Raises:
        InputError: two base points coincide, a side is not positive, the sides break the
            triangle inequality, or the orientation is unknown; every field at fault is named.
    """

    a2x: Fraction
    a3x: Fraction
    a3y: Fraction
    d1: Fraction
    d2: Fraction
    d3: Fraction
    orientation: str = CCW

    def __post_init__(self) -> None:
        if problems := self._problems():
            raise InputError(problems)
        if self.area16 == 0 and self.orientation == CW:
            object.__setattr__(self, "orientation", CCW)

    @classmethod
    def from_json(cls, obj: Mapping[str, object], *, max_digits: int = MAX_DIGITS) -> Manipulator:
        """Read the contract's geometry object; numbers are exact (see :func:`parse_exact`).

        Raises:
            InputError: naming every field that is missing, unknown or wrong.
        """
        if not isinstance(obj, Mapping):
            raise InputError.of(
                "geometry", f"{shown(obj)} is not an object with the fields {', '.join(_LENGTHS)}"
            )
        problems = [
            FieldProblem(f"geometry.{name}", f"unknown field; known are {', '.join(_LENGTHS)}, orientation")
            for name in obj
            if name not in (*_LENGTHS, "orientation")
        ]
        lengths: dict[str, Fraction] = {}
        for name in _LENGTHS:
            if name not in obj:
                problems.append(FieldProblem(f"geometry.{name}", "is missing; give a number"))
                continue
            try:
                lengths[name] = parse_exact(obj[name], f"geometry.{name}", max_digits=max_digits)  # type: ignore[arg-type]
            except InputError as error:
                problems.extend(error.problems)
        if problems:
            raise InputError(problems)
        return cls(**lengths, orientation=obj.get("orientation", CCW))  # type: ignore[arg-type]

    def to_json(self) -> dict[str, str]:
        """The contract's geometry object, each number in its canonical text."""
        lengths = {name: exact_str(getattr(self, name)) for name in _LENGTHS}
        return {**lengths, "orientation": self.orientation}

    @cached_property
    def geometry_hash(self) -> str:
        """``sha256:`` and 64 hex digits over the canonical text; equal geometries share it."""
        return hash_of_canonical(self.to_json())

    def identity_json(self) -> dict[str, object]:
        """The geometry and its hash, with which every document begins."""
        return {"geometry": self.to_json(), "geometry_hash": self.geometry_hash}

    @property
    def area16(self) -> Fraction:
        """16 times the squared area of the platform (Heron): 0 for a flat platform."""
        d1, d2, d3 = self.d1, self.d2, self.d3
        return (d1 + d2 + d3) * (-d1 + d2 + d3) * (d1 - d2 + d3) * (d1 + d2 - d3)

    def _problems(self) -> list[FieldProblem]:
        problems = []
        if self.a2x == 0:
            problems.append(FieldProblem("geometry.a2x", "is 0, so A1 and A2 coincide; give a2x ≠ 0"))
        if self.a3x == 0 and self.a3y == 0:
            problems.append(FieldProblem("geometry.a3x", "A1 and A3 coincide; give a3x ≠ 0 or a3y ≠ 0"))
        if self.a3x == self.a2x != 0 and self.a3y == 0:
            problems.append(FieldProblem("geometry.a3x", "A2 and A3 coincide; give a3x ≠ a2x or a3y ≠ 0"))
        sides = {"d1": self.d1, "d2": self.d2, "d3": self.d3}
        for name, side in sides.items():
            if side <= 0:
                problems.append(
                    FieldProblem(f"geometry.{name}", f"is {_short(side)}; a side of the platform must be > 0")
                )
        if not problems:
            for name, side in sides.items():
                others = sum(sides.values()) - side
                if side > others:
                    rest = " + ".join(n for n in sides if n != name)
                    problems.append(
                        FieldProblem(
                            f"geometry.{name}",
                            f"{name} = {_short(side)} breaks the triangle inequality:"
                            f" it must be at most {rest} = {_short(others)}",
                        )
                    )
        if self.orientation not in (CCW, CW):
            problems.append(
                FieldProblem("geometry.orientation", f'{shown(self.orientation)} is neither "ccw" nor "cw"')
            )
        return problems


def hash_of_canonical(geometry: Mapping[str, str]) -> str:
    """The hash of a geometry as :meth:`Manipulator.to_json` gives it, without reading its numbers."""
    text = ";".join(f"{name}={geometry[name]}" for name in (*_LENGTHS, "orientation"))
    return "sha256:" + hashlib.sha256(f"3-RPR;{text}".encode()).hexdigest()


def _short(x: Fraction) -> str:
    text = exact_str(x)
    return text if len(text) <= 40 else f"{text[:40]}…"


def _example(*values: str) -> Manipulator:
    names = [field.name for field in fields(Manipulator)]
    return Manipulator.from_json(dict(zip(names, values, strict=True)))


EXAMPLES: Mapping[str, Manipulator] = MappingProxyType(
    {
        "innocenti": _example("15.91", "0", "10", "17.04", "16.54", "20.84", CCW),
        "zein-flat": _example("30", "11", "27", "13", "9", "4", CCW),
        "twelve-cusps": _example("10", "16.5", "12.5", "22.5", "38", "25.5", CW),
        "fourteen-cusps": _example("10", "16.212", "9.019", "20.433", "32.895", "22.502", CW),
    }
)
"""Manipulators by name: the article's first and second, and two with many cusps."""
