"""Settings of the HTTP service, from the environment (`RPR_CUSPS_…`) or given in code."""

from __future__ import annotations

from pydantic import Field
from pydantic_settings import BaseSettings, SettingsConfigDict

from service.schemas.limits import Limits


class Settings(BaseSettings):
    """How one API process runs."""

    model_config = SettingsConfigDict(env_prefix="RPR_CUSPS_", frozen=True, extra="ignore")

    redis_url: str = Field(
        default="redis://127.0.0.1:6379/0", description="Redis or Valkey of the queue and the results"
    )
    redis_connections: int = Field(default=64, ge=2, description="connections for short commands, at most")
    stream_connections: int = Field(
        default=512, ge=2, description="clients that wait or follow events at once, at most"
    )
    threads: int = Field(default=40, ge=1, description="threads for blocking work")
    poll_seconds: int = Field(default=1, ge=1, description="`Retry-After` of a job that is not finished")
    retry_seconds: int = Field(default=2, ge=1, description="`Retry-After` when Redis cannot be reached")
    keepalive_seconds: float = Field(
        default=15.0, gt=0, description="pause between comments on a quiet event stream"
    )
    gzip_bytes: int = Field(
        default=1024, ge=0, description="answers of this size and more are compressed on request"
    )
    limits: Limits = Field(default_factory=Limits)
