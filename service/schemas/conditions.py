"""Condition numbers: how a question asks for them, and what an answer says of all of them."""

from __future__ import annotations

from fractions import Fraction
from typing import Annotated, Any

from pydantic import BaseModel

from rpr_solver import exact_str
from rpr_solver.errors import InputError
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


def condition_member(question: BaseModel) -> dict[str, Any]:
    """Returns what a question asks of condition numbers in its canonical form, as a member; nothing if it
    does not ask for them. Each of its members asks for them.

    Raises:
        InputError: naming `condition`, which is false beside another one.
    """
    members = {"length_scale": "length_scale", "max_condition": "max"}
    given = {name: x for name in members if (x := getattr(question, name, None)) is not None}
    is_asked = getattr(question, "condition", False)
    if given and not is_asked and "condition" in question.model_fields_set:
        raise InputError.of("condition", f"is false, but {next(iter(given))} is given; leave one out")
    if not given and not is_asked:
        return {}
    return {"condition": {members[name]: exact_str(x) for name, x in given.items()}}


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
