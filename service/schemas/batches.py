"""Batches: the items as they are sent, the state of a batch, and the lines of its results."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import ConfigDict, Field, PlainValidator

from rpr_solver.errors import InputError
from service.schemas.document import Document, Expected
from service.schemas.exact_json import JsonNumber, json_kind
from service.schemas.jobs import ESTIMATE, OVERRUNS, JobError
from service.schemas.model import Model
from service.schemas.points import optional
from service.schemas.problems import ProblemDocument
from worker.answers import kinds
from worker.answers.kinds import KINDS

KIND_NAMES = tuple(kind.name for kind in KINDS)

is_batch = kinds.is_batch
"""Whether the id of a job is that of a batch."""

_LONGEST_ID = 200


def _id(value: object) -> str | None:
    if value is None:
        return None
    if not isinstance(value, str) or isinstance(value, JsonNumber):
        raise InputError.of("", f"is {json_kind(value)}; give a string of your choice")
    if len(value) > _LONGEST_ID:
        raise InputError.of("", f"has {len(value)} characters; at most {_LONGEST_ID} are allowed")
    return value


def _kind(value: object) -> str:
    if isinstance(value, str) and value in KIND_NAMES:
        return value
    shown = repr(value[:40]) if isinstance(value, str) else json_kind(value)
    raise InputError.of("", f"is {shown}; it must be one of {', '.join(KIND_NAMES)}")


def _request(value: object) -> Mapping[str, Any]:
    if isinstance(value, Mapping):
        return value
    raise InputError.of("", f"is {json_kind(value)}; give an object, as posted alone")


class BatchItem(Document):
    """One question of a batch."""

    expected: ClassVar[str] = "give an object with kind and request"

    id: Annotated[str | None, PlainValidator(_id, json_schema_input_type=str | None)] = Field(
        default=None, description="A name of your choice, which its result carries."
    )
    kind: Annotated[
        str,
        PlainValidator(_kind, json_schema_input_type=Literal[KIND_NAMES]),
        Expected(f"give one of {', '.join(KIND_NAMES)}"),
    ] = Field(description="The kind of the document that is asked for.")
    request: Annotated[
        Mapping[str, Any],
        PlainValidator(_request, json_schema_input_type=dict[str, Any]),
        Expected("give the question, as posted alone"),
    ] = Field(description="The question as it is posted alone, but without `deadline_s`.")


class BatchRequest(Model):
    """Many questions of any kind."""

    model_config = ConfigDict(extra="forbid")

    items: list[BatchItem] = Field(min_length=1)
    callback_url: str | None = Field(
        default=None,
        description="Where to POST an event when the batch ends; its host must be one that the service "
        "allows.",
    )


class BatchLinks(Model):
    """The addresses of a batch's resources."""

    self: str
    results: str
    events: str
    cancel: str | None = optional(
        "In the answer to its submission only: DELETE it to withdraw the batch, also without a key."
    )


class Batch(Model):
    """A batch, and the numbers of its items by state; those that are in none of them are not done yet."""

    id: str
    status: Literal["queued", "running", "succeeded", "failed", "canceled"] = Field(
        description="`succeeded` once every item is done, whether it has an answer or not; `failed` if the "
        "batch could not go on."
    )
    total: int = Field(description="Number of items.")
    done: int = Field(description="Items that are done.")
    succeeded: int = Field(description="Items with an answer.")
    failed: int = Field(description="Items with a problem in place of an answer.")
    canceled: int = Field(description="Items that were not done when the batch was canceled.")
    created_at: str = Field(description="ISO 8601, UTC.", json_schema_extra={"format": "date-time"})
    started_at: str | None = Field(description="ISO 8601, UTC; null until its first item is begun.")
    finished_at: str | None = Field(description="ISO 8601, UTC; null until it has ended.")
    expires_at: str | None = Field(
        description="ISO 8601, UTC: until when it can be fetched; null until it has ended."
    )
    error: JobError | None = Field(description="null unless the batch failed.")
    position: int | None = Field(
        description="Batches before it in its lane of the queue; null unless it is queued."
    )
    estimate_s: float | None = ESTIMATE
    overruns: int = OVERRUNS
    links: BatchLinks


class BatchResult(Model):
    """One line of the results: an item with its answer or its problem."""

    index: int = Field(description="The position of the item in the batch, from 0.")
    id: str | None = Field(description="The name that its sender gave it.")
    kind: str | None = Field(
        default=None, description="The kind of the document; null for an item that names none."
    )
    status: Literal["succeeded", "failed", "canceled"]
    result: dict[str, Any] | None = optional("The document, exactly as the question alone is answered.")
    problem: ProblemDocument | None = optional("Why there is none.")
