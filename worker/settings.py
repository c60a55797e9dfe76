"""Settings of the worker layer, from the environment (`RPR_CUSPS_…`) or given in code."""

from __future__ import annotations

from pydantic import Field, ValidationError
from pydantic_settings import BaseSettings, SettingsConfigDict


class WorkerSettings(BaseSettings):
    """Everything that the queue, the store and the worker processes can be told.

    API processes and workers of one installation must agree on `key_prefix` and `queue_name`.
    """

    model_config = SettingsConfigDict(env_prefix="RPR_CUSPS_", frozen=True, extra="ignore")

    key_prefix: str = Field(default="cusps", description="prefix of every Redis key of this service")
    queue_name: str = Field(default="cusps", description="RQ queue of small jobs; large ones use NAME-bulk")
    task: str = Field(
        default="worker.process.tasks.run_chunk", description="dotted name of the function a chunk runs"
    )

    chunk_size: int = Field(default=40, ge=1, description="slices in one RQ job, at most")
    deadline: float = Field(default=600.0, gt=0, description="wall-clock seconds a chunk may take")
    memory_limit_mb: int | None = Field(default=4096, ge=64, description="address space of a work horse, MiB")
    max_losses: int = Field(
        default=2, ge=0, description="how often a chunk is run again after its worker was lost"
    )

    result_ttl: int = Field(default=7 * 86400, ge=1, description="seconds a slice result is kept")
    job_ttl: int = Field(default=7 * 86400, ge=1, description="seconds a succeeded job is kept")
    failure_ttl: int = Field(default=86400, ge=1, description="seconds a failed or canceled job is kept")
    error_ttl: int = Field(
        default=600, ge=1, description="seconds a slice's own error is kept for other jobs"
    )
    eliminant_ttl: int = Field(default=30 * 86400, ge=1, description="seconds an eliminant is kept")
    eliminant_lock: float = Field(
        default=30.0, gt=0, description="seconds one worker may keep others waiting"
    )

    beat_interval: float = Field(
        default=1.0, gt=0, description="seconds between two signs of life of a chunk"
    )
    beat_ttl: float = Field(default=4.0, gt=0, description="seconds after which a silent chunk is suspected")
    sweep_interval: float = Field(
        default=1.5, gt=0, description="seconds between two searches for lost chunks"
    )
    lost_grace: float = Field(
        default=2.0, ge=0, description="seconds a chunk stays suspected before it is run again"
    )
    shutdown_grace: float = Field(
        default=1.0, ge=0, description="seconds a running chunk may still use at a stop"
    )
    log_level: str = Field(default="WARNING", description="log level of worker processes")


def settings_problem(error: ValidationError) -> str:
    """One line that names the variables that are wrong."""
    return "; ".join(
        f"RPR_CUSPS_{'_'.join(map(str, item['loc'])).upper()}: {item['msg']}" for item in error.errors()
    )
