"""The columns of a geometry in a table, which are the parameters of a question by GET: the article's six
numbers, or the points or the sides of two triangles."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rpr_solver.contract import LENGTHS
from rpr_solver.errors import InputError

_CORNERS = {"base": "a", "platform": "b"}
_SIDES = ("s12", "s23", "s31")
ORIENTATION = "orientation"
"""The column that may stand beside those of any form."""

SIX = LENGTHS
POINTS = tuple(f"{letter}{n}{axis}" for letter in _CORNERS.values() for n in (1, 2, 3) for axis in "xy")
SIDES = tuple(f"{triangle}_{side}" for triangle in _CORNERS for side in _SIDES)
FORMS = (SIX, POINTS, SIDES)
COLUMNS = (*SIX, ORIENTATION, *(name for name in (*POINTS, *SIDES) if name not in SIX))
"""All columns of a geometry; a2x, a3x and a3y are those of two forms."""

EXPECTED = f"give {SIX[0]} … {SIX[-1]}, or {POINTS[0]} … {POINTS[-1]}, or {SIDES[0]} … {SIDES[-1]}"


def form_of(names: Iterable[str]) -> Sequence[str]:
    """The columns of the form that some of them are of; the six numbers, if they are of no other.

    Raises:
        InputError: naming a column: they are of two forms.

    >>> form_of(["l1", "a2x", "a1y"])[:3], form_of(["a2x", "a3y"])[-3:]
    (('a1x', 'a1y', 'a2x'), ('d1', 'd2', 'd3'))
    """
    own = {name: [form for form in FORMS if name in form] for name in names if name in COLUMNS}
    sure = {name: forms[0] for name, forms in own.items() if len(forms) == 1}
    form = next(iter(sure.values()), SIX)
    for name, forms in own.items():
        if forms and form not in forms:
            first = next(iter(sure))
            raise InputError.of(name, f"stands beside {first}, which is of another form; {EXPECTED}")
    return form


def advice_on(name: str) -> str | None:
    """What to give instead of a column that could be one of either triangle.

    >>> advice_on("s12"), advice_on("d1")
    ('give base_s12 or platform_s12', None)
    """
    return f"give base_{name} or platform_{name}" if name in _SIDES else None


def geometry_of(cells: Mapping[str, str]) -> dict[str, Any]:
    """The geometry that cells, by columns, describe.

    Raises:
        InputError: naming a column: they are of two forms, or a cell of two triangles is missing.

    >>> geometry_of({**dict.fromkeys(SIDES, "sqrt(3)"), "orientation": "cw"})["platform"]
    {'sides': ['sqrt(3)', 'sqrt(3)', 'sqrt(3)']}
    """
    form = form_of(cells)
    sense = {ORIENTATION: cells[ORIENTATION]} if ORIENTATION in cells else {}
    if form is SIX:
        return {**{name: cells[name] for name in SIX if name in cells}, **sense}
    for name in form:
        if name not in cells:
            raise InputError.of(name, "is missing; give a number")
    numbers = [cells[name] for name in form]
    half = len(form) // 2
    halves = {"base": numbers[:half], "platform": numbers[half:]}
    if form is SIDES:
        return {**{name: {"sides": sides} for name, sides in halves.items()}, **sense}
    points = {name: list(map(list, zip(xy[::2], xy[1::2], strict=True))) for name, xy in halves.items()}
    return {**{name: {"points": corners} for name, corners in points.items()}, **sense}
