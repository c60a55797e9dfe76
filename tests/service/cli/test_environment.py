"""Settings with a slip of the pen are told at the start."""

from __future__ import annotations

import sys

import pytest
from pydantic_settings import BaseSettings

from docs import reference
from service.cli.options import models, unknown_settings
from service.schemas.limits import Limits
from tests.support.processes import completed, environment
from worker.settings import EnvironmentSettings


def test_a_slip_is_told_with_the_setting_that_was_meant() -> None:
    given = {
        "RPR_CUSPS_CHUNKSIZE": "1",
        "RPR_CUSPS_CHUNK_SIZE": "1",
        "rpr_cusps_deadline": "1",
        "RPR_CUSPS_COLOUR_OF_THE_SKY": "1",
        "OTHER": "1",
    }
    assert list(unknown_settings(given)) == [
        "RPR_CUSPS_CHUNKSIZE is not a setting and has no effect; did you mean RPR_CUSPS_CHUNK_SIZE?",
        "RPR_CUSPS_COLOUR_OF_THE_SKY is not a setting and has no effect",
    ]


def test_every_setting_is_known_and_in_the_reference() -> None:
    models_of = {m for base in (BaseSettings, EnvironmentSettings) for m in base.__subclasses__()}
    written = {m for m in models_of if m.__module__.startswith(("worker.", "service."))}
    assert {*written, Limits} - {EnvironmentSettings} == set(models()) == set(reference.GROUPS.values())


@pytest.mark.parametrize("command", ["serve", "worker"])
def test_each_process_of_the_service_tells(command: str) -> None:
    nobody = ["--redis-url", "redis://127.0.0.1:1/none"]
    words = [sys.executable, "-m", "service", command, *nobody]
    done = completed(words, environment(log_levle="INFO"))
    told = [line for line in done.stderr.splitlines() if "LEVLE" in line]
    hint = "did you mean RPR_CUSPS_LOG_LEVEL?"
    slip = "RPR_CUSPS_LOG_LEVLE"
    assert told == [f"rpr-cusps {command}: {slip} is not a setting and has no effect; {hint}"]
    assert done.returncode != 0, "it cannot reach Redis"
