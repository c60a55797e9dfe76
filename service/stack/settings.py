"""Settings of `rpr-cusps serve`, from the environment (`RPR_CUSPS_…`) or given in code."""

from __future__ import annotations

from pydantic import Field
from pydantic_settings import BaseSettings, SettingsConfigDict


class SupervisorSettings(BaseSettings):
    """How the processes of one machine are looked after."""

    model_config = SettingsConfigDict(env_prefix="RPR_CUSPS_", frozen=True, extra="ignore")

    hang_seconds: float = Field(
        default=10.0,
        ge=3,
        allow_inf_nan=False,
        description="time without a sign of life after which `serve` kills Valkey, a worker or the API "
        "and starts another, in seconds",
    )
