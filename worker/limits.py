"""What the settings of the workers and the limits on requests share."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, PositiveFloat

Deadline = Annotated[
    PositiveFloat,
    Field(
        allow_inf_nan=False,
        description="maximum `deadline_s` of a request, and run time of a chunk, in seconds",
    ),
]
"""A setting of the workers, and a limit of requests."""

DEADLINE = 600.0
"""Its value if nothing else is said."""
