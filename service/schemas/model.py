"""The base of all models of what is asked and answered."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

DEFERRED = ConfigDict(defer_build=True)
"""What is built when it is first used: a process uses few models, and starts sooner."""


class Model(BaseModel):
    """A pydantic model that is built when it is first used."""

    model_config = DEFERRED
