"""Jobs, batches, webhooks, limits and versions as the contract shows them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import ConfigDict, Field, PlainValidator

from rpr_solver.errors import InputError
from service.schemas.answers import ProblemDocument, optional
from service.schemas.document import Document, Expected, JsonNumber, json_kind
from service.schemas.limits import Detail, Model
from worker.answers import kinds
from worker.answers.kinds import KINDS

KIND_NAMES = tuple(kind.name for kind in KINDS)

if TYPE_CHECKING:
    KindName = str
else:
    KindName = Literal[KIND_NAMES]

ESTIMATE: Any = Field(
    default=None, description="The estimated work, in seconds of one core; null if it is not known."
)


class Progress(Model):
    """The progress of a job or a batch."""

    done: int = Field(description="Completed slices, steps or items.")
    total: int = Field(
        description="All slices of the job, the steps known so far (may grow), or the items of the batch."
    )


class JobError(Model):
    """Why a job failed."""

    type: str = Field(description="timeout, worker-lost, resource-exhausted, solver-error, input-error, …")
    detail: str


class JobLinks(Model):
    """The URLs of a job's resources."""

    self: str
    result: str
    events: str


class StreamEvent(Model):
    """A server-sent event: its fields.

    Attributes:
        id: Resumes the stream, as Last-Event-ID.
        data: JSON. `status`: the job or batch at that time. `slice`: `slice`, `progress`, and the length of
            the fixed leg by its name (`l1`). `progress`: `progress`. `item`: `index`, `status` and
            `progress`. `improvement`: what a search has found, as in the `trace` of its answer.
    """

    id: str
    event: Literal["status", "slice", "progress", "item", "improvement"]
    data: str = Field(
        json_schema_extra={"contentMediaType": "application/json", "contentSchema": {"type": "object"}}
    )


class DeliveryAttempt(Model):
    """One attempt to deliver an event."""

    at: str = Field(description="ISO 8601, UTC: when it began.")
    status: int | None = Field(description="The HTTP status of the answer; null if there was none.")
    problem: str | None = Field(description="Why it did not succeed; null if it succeeded or has not ended.")


class Delivery(Detail):
    """One event for one receiver."""

    webhook_id: str = Field(description="The `webhook-id` of every attempt.")
    type: str = Field(description="The type of the event.")
    host: str = Field(description="The host of the `callback_url`.")
    state: Literal["pending", "delivered", "gone", "refused", "exhausted"] = Field(
        description="`gone`: the receiver answered 410; `refused`: its address is not allowed; "
        "`exhausted`: the last attempt failed, too."
    )
    next_attempt_at: str | None = Field(description="ISO 8601, UTC; null if there is none.")
    attempts: list[DeliveryAttempt]


DELIVERIES: Any = optional(
    "The log of its webhooks, the oldest first, once it has ended; missing if there are none."
)


class Job(Model):
    """The computation of an answer. A run is queued, then running, then in one of the other states, which is
    final. Posting the question again after the job has failed, been canceled or expired starts a new run
    under the same id.

    Attributes:
        kind: The kind of the document that it computes.
        run: Distinguishes the runs of the job.
        done: Whether this run has ended: succeeded, failed or canceled.
        created_at: ISO 8601, UTC.
        started_at: ISO 8601, UTC; null until the job starts.
        ended_at: ISO 8601, UTC; null until the job ends.
        expires_at: ISO 8601, UTC: until when it can be fetched; null until it ends.
        error: null unless the job failed.
        position: Jobs before it in its lane of the queue; null unless it is queued.
        deadline_at: The time at which it fails if it is not done, from the latest `deadline_seconds`; null
            without one.
    """

    id: str
    kind: str = Field(json_schema_extra={"enum": [*KIND_NAMES]})
    status: Literal["queued", "running", "succeeded", "failed", "canceled"]
    run: str
    done: bool
    progress: Progress
    created_at: str = Field(json_schema_extra={"format": "date-time"})
    started_at: str | None
    ended_at: str | None
    expires_at: str | None
    error: JobError | None
    position: int | None
    deadline_at: str | None
    estimate_seconds: float | None = ESTIMATE
    links: JobLinks
    deliveries: list[Delivery] | None = DELIVERIES


ListedStatus = Literal["active", "queued", "running", "succeeded", "completed", "failed", "canceled"]
"""What may be asked for: a state, or `active`."""


class ListedJob(Model):
    """A job or a batch in a list.

    Attributes:
        kind: The kind of the document that it computes, or `batch`.
        created_at: ISO 8601, UTC.
        started_at: ISO 8601, UTC; null until it starts.
        ended_at: ISO 8601, UTC; null until it ends.
        key: The name of the key that asked for it first; null if that request had no key.
    """

    id: str
    kind: str | None = Field(json_schema_extra={"enum": [*KIND_NAMES, "batch", None]})
    status: Literal["queued", "running", "succeeded", "completed", "failed", "canceled"]
    created_at: str = Field(json_schema_extra={"format": "date-time"})
    started_at: str | None
    ended_at: str | None
    estimate_seconds: float | None = ESTIMATE
    key: str | None


class JobList(Model):
    """A page of jobs or of batches, the newest first: a key's own, or all for the operator."""

    items: list[ListedJob]
    next: str | None = Field(
        description="The URL of the next page, null after the last; any page may have few entries."
    )


is_batch = kinds.is_batch
"""Whether the id of a job is that of a batch."""


def address(job_id: str) -> str:
    """Returns the path of a job or a batch."""
    return f"/v1/{'batches' if is_batch(job_id) else 'jobs'}/{job_id}"


_LONGEST_ID = 200


def _id(value: object) -> str:
    if not isinstance(value, str) or isinstance(value, JsonNumber):
        raise InputError.of("", f"is {json_kind(value)}; give a string of your choice")
    if len(value) > _LONGEST_ID:
        raise InputError.of("", f"has {len(value)} characters; at most {_LONGEST_ID} are allowed")
    return value


def _request(value: object) -> Mapping[str, Any]:
    if isinstance(value, Mapping):
        return value
    raise InputError.of("", f"is {json_kind(value)}; give an object, as in the call of its kind")


class BatchItem(Document):
    """One question of a batch.

    Attributes:
        id: A name of your choice, which is repeated with the result.
        kind: The kind of the requested document.
        request: The question as in its own call, but without `deadline_seconds`.
    """

    expected: ClassVar[str] = "give an object with kind and request"

    id: Annotated[str, PlainValidator(_id, json_schema_input_type=str)] | None = None
    kind: Annotated[KindName, Expected(f"give one of {', '.join(KIND_NAMES)}")]
    request: Annotated[
        Mapping[str, Any],
        PlainValidator(_request, json_schema_input_type=dict[str, Any]),
        Expected("give the question, as in the call of its kind"),
    ]


class BatchRequest(Model):
    """Many questions of any kind.

    Attributes:
        callback_url: The URL to which an event is posted when the batch ends. The service must allow its
            host.
    """

    model_config = ConfigDict(extra="forbid")

    items: list[BatchItem] = Field(min_length=1)
    callback_url: str | None = None


class BatchLinks(Model):
    """The URLs of a batch's resources."""

    self: str
    results: str
    events: str


class Batch(Model):
    """A batch, and the numbers of its items by state; the remaining items are not done yet.

    Attributes:
        status: `completed` once every item is done, with or without an answer; `failed` if the batch could
            not continue.
        done: Whether the batch has ended: completed, failed or canceled.
        succeeded: Items with an answer.
        failed: Items with a problem instead of an answer.
        canceled: Items that were not done when the batch was canceled.
        created_at: ISO 8601, UTC.
        started_at: ISO 8601, UTC; null until its first item is started.
        ended_at: ISO 8601, UTC; null until it has ended.
        expires_at: ISO 8601, UTC: until when it can be fetched; null until it has ended.
        error: null unless the batch failed.
        position: Batches before it in its lane of the queue; null unless it is queued.
    """

    id: str
    status: Literal["queued", "running", "completed", "failed", "canceled"]
    done: bool
    progress: Progress
    succeeded: int
    failed: int
    canceled: int
    created_at: str = Field(json_schema_extra={"format": "date-time"})
    started_at: str | None
    ended_at: str | None
    expires_at: str | None
    error: JobError | None
    position: int | None
    estimate_seconds: float | None = ESTIMATE
    links: BatchLinks
    deliveries: list[Delivery] | None = DELIVERIES


class BatchResult(Model):
    """One line of the results: an item with its answer or its problem.

    Attributes:
        index: The position of the item in the batch, from 0.
        id: The name that its sender gave it.
        kind: The kind of the document; null for an item that names none.
        result: The document, exactly as for the same question outside a batch.
        problem: Why there is none.
    """

    index: int
    id: str | None
    kind: str | None = None
    status: Literal["succeeded", "failed", "canceled"]
    result: dict[str, Any] | None = optional()
    problem: ProblemDocument | None = optional()


class JobEvent(Model):
    """The event that a job has ended."""

    type: Literal["job.succeeded", "job.failed", "job.canceled"]
    timestamp: str = Field(description="ISO 8601, UTC: when it ended.")
    data: Job = Field(description="The job as it ended.")


class BatchEvent(Model):
    """The event that a batch has ended."""

    type: Literal["batch.completed", "batch.failed", "batch.canceled"]
    timestamp: str = Field(description="ISO 8601, UTC: when it ended.")
    data: Batch = Field(description="The batch as it ended.")


class Readiness(Model):
    """Requests can be served.

    Attributes:
        workers: Number of live workers.
        warnings: Risks to jobs: a setting of Redis, or a lane of the queue that stands still. Empty if
            there are none.
    """

    status: Literal["ready"]
    workers: int
    warnings: list[str] = Field(default=[])


class Version(Model):
    """The versions of the software that computes the answers."""

    service: str
    commit: str | None = Field(
        default=None,
        description="The commit of the code, with `-dirty` if it was changed since; null if it is not known.",
    )
    solver_version: str
    python: str
    libraries: dict[str, str]
