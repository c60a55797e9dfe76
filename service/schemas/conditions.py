"""Condition numbers: how a question asks for them, and what an answer says of all of them."""

from __future__ import annotations

from fractions import Fraction
from typing import Annotated, Any

from rpr_solver import exact_str
from service.schemas.document import given
from service.schemas.limits import Detail
from service.schemas.numbers import Exact, Length, number_where, positive

LengthScale = Annotated[Fraction, positive("a length scale must be > 0", Length)]
"""The length by which rotations are measured."""
MostCondition = Annotated[
    Fraction, number_where("a condition number is at least 1", lambda most: most >= 1, Exact)
]
"""A condition number that none may exceed."""


def scale_field() -> Any:
    """The member `length_scale`."""
    return given(
        "The length by which condition numbers measure rotations, in the unit of the geometry; > 0. The root "
        "of the mean squared distance of the platform's joints from their centroid unless given."
    )


def condition_member(
    scale: Fraction | None, most: Fraction | None = None, *, is_asked: bool
) -> dict[str, Any]:
    """Returns what is asked of condition numbers in its canonical form, as a member of a question; nothing if
    they are not asked for."""
    if not is_asked and scale is None and most is None:
        return {}
    asked = {"length_scale": scale, "max": most}
    return {"condition": {name: exact_str(x) for name, x in asked.items() if x is not None}}


class ConditionScale(Detail):
    """By what condition numbers measure rotations.

    Attributes:
        length_scale: The length, exact, in the unit of the geometry; it may be `sqrt(…)`.
        reference: The point whose velocity counts: `centroid`, that of the platform's joints.
    """

    length_scale: str
    reference: str


class PathCondition(ConditionScale):
    """The condition numbers of all poses of the path, with six digits.

    Attributes:
        asked: What none may exceed; null unless requested.
        min: None is less, proved.
        max: None is greater, proved; of a path that is not given, since it does not keep what was asked for:
            that of the best path that was found.
    """

    asked: str | None
    min: str
    max: str
