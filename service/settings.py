"""Settings of the HTTP service, from the environment (`RPR_CUSPS_…`) or given in code."""

from __future__ import annotations

from pydantic import Field
from pydantic_settings import BaseSettings, SettingsConfigDict

MIN_DIGITS = 15
MAX_DIGITS = 1000


class Limits(BaseSettings):
    """What one request may ask for. Exceeding a limit is a 4xx that names it; `/v1/limits` shows them."""

    model_config = SettingsConfigDict(env_prefix="RPR_CUSPS_", frozen=True, extra="ignore")

    max_slices: int = Field(default=2000, ge=1, description="slices in one request, at most")
    max_article_slices: int = Field(
        default=50, ge=1, description="slices in one request by the article's method, at most"
    )
    max_samples: int = Field(
        default=50, ge=1, description="points of cusp curves in each interval between transitions, at most"
    )
    min_digits: int = Field(
        default=MIN_DIGITS,
        ge=MIN_DIGITS,
        le=MAX_DIGITS,
        description="significant digits of an answer, at least",
    )
    max_digits: int = Field(
        default=MAX_DIGITS,
        ge=MIN_DIGITS,
        le=MAX_DIGITS,
        description="significant digits of an answer, at most",
    )
    default_digits: int = Field(
        default=90, ge=MIN_DIGITS, le=MAX_DIGITS, description="significant digits when a request does not say"
    )
    max_number_digits: int = Field(
        default=400,
        ge=1,
        le=4000,
        description="digits of an input number's numerator and of its denominator, at most",
    )
    max_body_bytes: int = Field(default=1 << 20, ge=1, description="bytes of a request body, at most")
    max_wait_seconds: int = Field(
        default=30, ge=0, description="seconds that `Prefer: wait` can hold a request"
    )


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
