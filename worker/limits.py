"""What the settings of the workers and the limits on requests share."""

from __future__ import annotations

import re
from inspect import cleandoc
from typing import Annotated, TypeVar

from pydantic import BaseModel, Field, PositiveFloat
from pydantic.fields import FieldInfo

T = TypeVar("T")

CONSTANT = "constant"

Constant = Annotated[T, CONSTANT]
"""The type of a field that is no setting: the environment does not change it, code may give it."""


def is_setting(field: FieldInfo) -> bool:
    """Whether the environment gives the value of a field."""
    return CONSTANT not in field.metadata


ATTRIBUTES = "Attributes:\n"
_ITEM = re.compile("^    (?=[a-z])", re.MULTILINE)


def describe_fields(model: type[BaseModel]) -> None:
    """Make what the docstring of a model says of its attributes the description of its fields."""
    for item in _ITEM.split(cleandoc(model.__doc__ or "").partition(ATTRIBUTES)[2])[1:]:
        names, _, text = item.partition(":")
        for name in set(names.split(", ")) - model.__class_vars__:
            model.model_fields[name].description = " ".join(text.split())


Deadline = Annotated[
    PositiveFloat,
    Field(
        allow_inf_nan=False,
        description="maximum `deadline_seconds` of a request, and run time of a chunk, in seconds",
    ),
]
"""A setting of the workers, and a limit of requests."""

DEADLINE = 600.0
"""Its value if nothing else is said."""
