"""The base of all models of what is asked and answered."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict


class Model(BaseModel):
    """A pydantic model that is built when it is first used: a process uses few of them, and starts sooner."""

    model_config = ConfigDict(defer_build=True)
