"""Webhooks: the events, and the log of their deliveries."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from service.schemas.batches import Batch
from service.schemas.jobs import Job
from service.schemas.model import Model


class JobEvent(Model):
    """The news that a job has ended."""

    type: Literal["job.succeeded", "job.failed", "job.canceled"]
    timestamp: str = Field(description="ISO 8601, UTC: when it ended.")
    data: Job = Field(description="The job as it ended.")


class BatchEvent(Model):
    """The news that a batch has ended."""

    type: Literal["batch.succeeded", "batch.failed", "batch.canceled"]
    timestamp: str = Field(description="ISO 8601, UTC: when it ended.")
    data: Batch = Field(description="The batch as it ended.")


class DeliveryAttempt(Model):
    """One attempt to deliver an event."""

    at: str = Field(description="ISO 8601, UTC: when it began.")
    status: int | None = Field(description="The HTTP status of the answer; null if none came.")
    problem: str | None = Field(description="Why it did not succeed; null if it did, or is not over.")


class Delivery(Model):
    """One event for one receiver."""

    webhook_id: str = Field(description="The `webhook-id` of every attempt.")
    type: str = Field(description="The type of the event.")
    host: str = Field(description="The host of the `callback_url`.")
    state: Literal["pending", "delivered", "gone", "refused", "exhausted"] = Field(
        description="`gone`: the receiver answered 410; `refused`: its address may not be reached; "
        "`exhausted`: the last attempt failed too."
    )
    next_attempt_at: str | None = Field(description="ISO 8601, UTC; null if there is none.")
    attempts: list[DeliveryAttempt]


class Deliveries(Model):
    """The deliveries of a job or a batch, the oldest first."""

    deliveries: list[Delivery]
