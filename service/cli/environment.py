"""Variables of the environment that look like settings and are none."""

from __future__ import annotations

import difflib
import logging
import os
import sys
from collections.abc import Iterable, Iterator, Mapping

from pydantic import BaseModel

from service.api.settings import Settings
from service.schemas.limits import Limits
from service.stack.supervisor import SupervisorSettings
from service.webhooks.settings import WebhookSettings
from worker.logs import told
from worker.settings import ConnectionSettings, WorkerSettings

PREFIX = "RPR_CUSPS_"


def models() -> tuple[type[BaseModel], ...]:
    """Returns the models that read settings from the environment."""
    from service.client import ClientSettings  # imported here to keep the start of `serve` quick

    ours = (Limits, Settings, WebhookSettings, SupervisorSettings, ClientSettings)
    return *ours, WorkerSettings, ConnectionSettings


def names() -> set[str]:
    """Returns the names of all settings."""
    return {PREFIX + name.upper() for model in models() for name in model.model_fields}


def unknown_settings(environment: Mapping[str, str]) -> Iterator[str]:
    """Yields a sentence for each variable that has the prefix of settings and is none."""
    set_here = sorted(name for name in environment if name.upper().startswith(PREFIX))
    known = names() if set_here else set()
    for name in set_here:
        if name.upper() not in known:
            yield f"{name} is not a setting and has no effect{_hint(name.upper(), known)}"


def warn_of_unknown_settings(command: str) -> None:
    """Say those sentences on stderr, at the start of a process."""
    for sentence in unknown_settings(os.environ):
        print(told(f"rpr-cusps {command}", sentence, logging.WARNING), file=sys.stderr)


def _hint(name: str, known: Iterable[str]) -> str:
    near = difflib.get_close_matches(name, known, n=1, cutoff=0.75)
    return f"; did you mean {near[0]}?" if near else ""
