from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from pydantic import ValidationError

from service import __version__
from service.api.settings import Settings
from service.schemas.limits import Limits


def test_the_environment_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RPR_CUSPS_MAX_SLICES", "7")
    monkeypatch.setenv("RPR_CUSPS_REDIS_URL", "redis://queue:1/2")
    settings = Settings()
    assert (settings.limits.max_slices, settings.redis_url) == (7, "redis://queue:1/2")


def test_settings_do_not_change() -> None:
    with pytest.raises(ValidationError):
        Limits().max_slices = 1  # type: ignore[misc]


def test_a_limit_that_makes_no_sense_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RPR_CUSPS_MAX_DIGITS", "1000000")
    with pytest.raises(ValidationError):
        Settings()


def test_the_version_is_that_of_the_project() -> None:
    project = tomllib.loads((Path(__file__).parents[3] / "pyproject.toml").read_text())
    assert project["project"]["version"] == __version__
