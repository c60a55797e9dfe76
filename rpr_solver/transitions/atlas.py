"""Rows of an atlas: random manipulators, and what their censuses say."""

from __future__ import annotations

import random
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from rpr_solver.contract import MIN_DIGITS
from rpr_solver.errors import InputError, SolverError
from rpr_solver.exact.numerals import double
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.transitions.census import census
from rpr_solver.triangles import CCW, CW

_BASE, _DECIMALS = 10, 3
_FAR, _HIGH, _LONG = 20, 20, 40
_FLAT = Fraction(1, 20)
"""Of the longest side: the least height of both triangles."""


def atlas_geometry(seed: int, index: int) -> Manipulator:
    """The manipulator of a row, which depends on the seed and the number of the row alone.

    A1A2 is 10; A3 is uniform in [−20, 20] × (0, 20], the sides of the platform in (0, 40], each in steps of
    0.001, and the orientation is either. Triangles whose least height is less than a twentieth of their
    longest side are drawn again.

    >>> atlas_geometry(1, 0) == atlas_geometry(1, 0) != atlas_geometry(1, 1)
    True
    """
    numbers = random.Random(f"rpr-cusps atlas {seed} {index}")
    unit = 10**_DECIMALS
    while True:
        a3x = Fraction(numbers.randint(-_FAR * unit, _FAR * unit), unit)
        a3y = Fraction(numbers.randint(1, _HIGH * unit), unit)
        sides = [Fraction(numbers.randint(1, _LONG * unit), unit) for _ in range(3)]
        orientation = numbers.choice((CCW, CW))
        try:
            found = Manipulator(_BASE, a3x, a3y, sides[0], sides[1], sides[2], orientation)
        except InputError:
            continue
        base = max(Fraction(_BASE) ** 2, (_BASE - a3x) ** 2 + a3y**2, a3x**2 + a3y**2)
        longest = max(sides) ** 2
        if (_BASE * a3y) ** 2 >= (_FLAT * base) ** 2 and found.area16 >= 4 * (_FLAT * longest) ** 2:
            return found


def atlas_row(seed: int, index: int) -> dict[str, Any]:
    """A row of an atlas, computed.

    >>> row = atlas_row(1, 0)
    >>> row["index"], row["most_cusps"] >= max(int(n) for n in row["lengths"])
    (0, True)
    """
    manipulator = atlas_geometry(seed, index)
    try:
        document = census(manipulator, digits=MIN_DIGITS).to_json()
    except SolverError as error:
        return failed_row(seed, index, str(error))
    return row_of(seed, index, document)


def failed_row(seed: int, index: int, why: str) -> dict[str, Any]:
    """The row of a manipulator whose census could not be decided."""
    return {"seed": seed, "index": index, **atlas_geometry(seed, index).identity_json(), "error": why}


def row_of(seed: int, index: int, document: Mapping[str, Any]) -> dict[str, Any]:
    """A row of an atlas from the census of its manipulator over all lengths of leg 1.

    ``l1`` is the middle of the widest window with the most cusps, and ``width`` its width, None if it has no
    end; ``lengths`` has the total length of all windows of each number of cusps, None if one has no end;
    ``aspects`` the largest number of aspects, None if none is known.
    """
    windows = [
        (
            interval["count"],
            Fraction(interval["from"]),
            None if interval["to"] is None else Fraction(interval["to"]),
        )
        for interval in document["intervals"]
    ]
    most = max(count for count, *_ in windows)
    best = [(start, stop) for count, start, stop in windows if count == most]
    start, stop = max(best, key=lambda one: (one[1] is None, 0 if one[1] is None else one[1] - one[0]))
    known = [x["aspects"] for x in document["intervals"] if x.get("aspects") is not None]
    return {
        "seed": seed,
        "index": index,
        **{name: document[name] for name in ("geometry", "geometry_hash", "near") if name in document},
        "most_cusps": most,
        "l1": _text(start + 1 if stop is None else (start + stop) / 2),
        "width": None if stop is None else _text(stop - start),
        "transitions": len(document["transitions"]),
        "aspects": max(known, default=None),
        "lengths": {str(n): _total(windows, n) for n in sorted({count for count, *_ in windows})},
    }


def _total(windows: list[tuple[int, Fraction, Fraction | None]], number: int) -> str | None:
    total = Fraction(0)
    for count, start, stop in windows:
        if count == number:
            if stop is None:
                return None
            total += stop - start
    return _text(total)


def _text(x: Fraction) -> str:
    return f"{double(x):.12g}"
