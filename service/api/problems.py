"""Every error of the HTTP service: one registry of problem types, one shape (RFC 9457)."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum

from starlette.responses import Response

from rpr_solver.errors import InputError
from service.schemas.limits import LimitError

MEDIA_TYPE = "application/problem+json"
_IN_DETAIL = 3
_LISTED = 50


@dataclass(frozen=True)
class TypeInfo:
    """What is documented about one type of problem."""

    slug: str
    status: int
    title: str
    meaning: str


class ProblemType(Enum):
    """All types of problems. The address `/problems/{slug}` of each is stable and documents it."""

    INVALID_JSON = TypeInfo(
        "invalid-json", 400, "The body is not valid JSON",
        "The request body is not UTF-8, not JSON, gives a key twice, contains NaN or Infinity, or is nested "
        "too deeply. The detail says where.",
    )  # fmt: skip
    INVALID_HEADER = TypeInfo(
        "invalid-header", 400, "A request header is malformed",
        "A header of the request cannot be understood. The detail names it.",
    )  # fmt: skip
    NOT_FOUND = TypeInfo(
        "not-found", 404, "Nothing is here",
        "There is no resource at this address. A job is forgotten some time after it has ended; posting the "
        "same request again makes the same job again.",
    )  # fmt: skip
    METHOD_NOT_ALLOWED = TypeInfo(
        "method-not-allowed", 405, "The method is not allowed here",
        "The resource exists, but not for this method. The Allow header lists those that it has.",
    )  # fmt: skip
    NOT_ACCEPTABLE = TypeInfo(
        "not-acceptable", 406, "None of the accepted media types can be served",
        "The Accept header excludes every form in which this resource exists. The detail lists them.",
    )  # fmt: skip
    NOT_FINISHED = TypeInfo(
        "job-not-finished", 409, "The job is not finished",
        "The result was asked for while the job is queued or running. Ask again after Retry-After seconds, "
        "or follow the job's events.",
    )  # fmt: skip
    JOB_CANCELED = TypeInfo(
        "job-canceled", 409, "The job was canceled",
        "The job was canceled and will have no result. Posting the request again starts it afresh; slices "
        "that were done by then are not computed twice.",
    )  # fmt: skip
    RESULT_EXPIRED = TypeInfo(
        "result-expired", 410, "The result has expired",
        "The job succeeded, but its result is no longer kept. Post the request again.",
    )  # fmt: skip
    BODY_TOO_LARGE = TypeInfo(
        "body-too-large", 413, "The body is too large",
        "The request body is larger than the limit max_body_bytes (see /v1/limits).",
    )  # fmt: skip
    UNSUPPORTED_MEDIA_TYPE = TypeInfo(
        "unsupported-media-type", 415, "The body is not sent as JSON",
        "Request bodies are application/json, in UTF-8 and not compressed.",
    )  # fmt: skip
    INVALID_REQUEST = TypeInfo(
        "invalid-request", 422, "The request is not valid",
        "The JSON can be read but does not describe a problem that can be solved: a field is missing, "
        "unknown, of the wrong kind, or no manipulator has these lengths. Every field at fault is listed in "
        "errors.",
    )  # fmt: skip
    LIMIT_EXCEEDED = TypeInfo(
        "limit-exceeded", 422, "The request exceeds a limit",
        "The request is valid but larger than this service allows. The errors name the limit, its value and "
        "what was sent; /v1/limits lists all limits.",
    )  # fmt: skip
    JOB_FAILED_INPUT = TypeInfo(
        "job-input-error", 422, "The job failed: its input cannot be solved",
        "The solver refused the geometry or the choice of the fixed leg. Sending it again will fail again.",
    )  # fmt: skip
    JOB_FAILED_SOLVER = TypeInfo(
        "job-solver-error", 422, "The job failed: no answer could be proved",
        "The input is right, but this version of the solver cannot prove an answer for this geometry. "
        "Nothing was guessed.",
    )  # fmt: skip
    TOO_MANY_REQUESTS = TypeInfo(
        "too-many-requests", 429, "Too many requests",
        "Come back after Retry-After seconds.",
    )  # fmt: skip
    INTERNAL = TypeInfo(
        "internal-error", 500, "Something went wrong here",
        "An error that was not foreseen. The request id in the answer finds it in the service's log.",
    )  # fmt: skip
    JOB_FAILED = TypeInfo(
        "job-failed", 500, "The job failed",
        "The job ended without a result. The detail says why; posting the request again tries once more.",
    )  # fmt: skip
    JOB_LOST = TypeInfo(
        "job-worker-lost", 500, "The job failed: its worker was lost",
        "The worker process died more often than a job is tried again. Posting the request again tries once "
        "more.",
    )  # fmt: skip
    JOB_EXHAUSTED = TypeInfo(
        "job-resource-exhausted", 500, "The job failed: it needs more memory than it may use",
        "The computation reached the memory limit of a worker. Ask for fewer digits or simpler numbers.",
    )  # fmt: skip
    UNAVAILABLE = TypeInfo(
        "unavailable", 503, "The queue cannot be reached",
        "Redis, which holds the queue and the results, cannot be reached or takes no more data. Come back "
        "after Retry-After seconds.",
    )  # fmt: skip
    JOB_TIMEOUT = TypeInfo(
        "job-timeout", 504, "The job failed: it took too long",
        "The computation reached its deadline. Ask for fewer digits or simpler numbers.",
    )  # fmt: skip

    @property
    def uri(self) -> str:
        """The `type` member of the problem document."""
        return f"/problems/{self.value.slug}"


_OF_JOB_ERROR = {
    "input-error": ProblemType.JOB_FAILED_INPUT,
    "solver-error": ProblemType.JOB_FAILED_SOLVER,
    "timeout": ProblemType.JOB_TIMEOUT,
    "worker-lost": ProblemType.JOB_LOST,
    "resource-exhausted": ProblemType.JOB_EXHAUSTED,
}

_OF_STATUS = {
    404: ProblemType.NOT_FOUND,
    405: ProblemType.METHOD_NOT_ALLOWED,
    406: ProblemType.NOT_ACCEPTABLE,
    413: ProblemType.BODY_TOO_LARGE,
    415: ProblemType.UNSUPPORTED_MEDIA_TYPE,
    422: ProblemType.INVALID_REQUEST,
    429: ProblemType.TOO_MANY_REQUESTS,
    503: ProblemType.UNAVAILABLE,
}


class ProblemError(Exception):
    """An error that is answered to the client as a problem document."""

    def __init__(
        self,
        kind: ProblemType,
        detail: str,
        *,
        errors: Iterable[tuple[str, str]] = (),
        headers: Mapping[str, str] | None = None,
        extra: Mapping[str, object] | None = None,
    ) -> None:
        super().__init__(detail)
        self.kind = kind
        self.detail = detail
        self.errors = tuple(errors)
        self.headers = dict(headers or {})
        self.extra = dict(extra or {})

    @classmethod
    def of_input(cls, error: InputError) -> ProblemError:
        """The verdict on bad input, of the solver or of what stands before it."""
        faults = [(p.field, p.message) for p in error.problems]
        detail = "; ".join(f"{field}: {message}" for field, message in faults[:_IN_DETAIL])
        more = f"; and {len(faults) - _IN_DETAIL} more" if len(faults) > _IN_DETAIL else ""
        kind, extra = ProblemType.INVALID_REQUEST, {}
        if isinstance(error, LimitError):
            kind, extra = ProblemType.LIMIT_EXCEEDED, {"limit": {"name": error.limit, "value": error.value}}
        return cls(kind, detail + more, errors=faults[:_LISTED], extra=extra)

    @classmethod
    def of_job(cls, job_id: str, error: Mapping[str, str] | None) -> ProblemError:
        """Why a job failed, as an answer to the question for its result."""
        error = error or {}
        kind = _OF_JOB_ERROR.get(error.get("type", ""), ProblemType.JOB_FAILED)
        return cls(kind, error.get("detail", "The job failed."), extra={"job": f"/v1/jobs/{job_id}"})

    @classmethod
    def of_cancel(cls, job_id: str) -> ProblemError:
        """That a job was canceled, as an answer to the question for its result."""
        detail = "The job was canceled; post the request again to start it afresh."
        return cls(ProblemType.JOB_CANCELED, detail, extra={"job": f"/v1/jobs/{job_id}"})

    @classmethod
    def of_status(cls, status: int, detail: str, headers: Mapping[str, str] | None = None) -> ProblemError:
        """A problem of the framework, of which only the status is known."""
        kind = _OF_STATUS.get(status, ProblemType.INTERNAL if status >= 500 else ProblemType.INVALID_HEADER)
        return cls(kind, detail, headers=headers)

    def document(self, instance: str | None = None) -> dict[str, object]:
        """The problem document."""
        info = self.kind.value
        document: dict[str, object] = {
            "type": self.kind.uri,
            "title": info.title,
            "status": info.status,
            "detail": self.detail,
            "errors": [{"field": field, "message": message} for field, message in self.errors],
        }
        if instance is not None:
            document["instance"] = instance
        return {**document, **self.extra}

    def response(self, instance: str | None = None) -> Response:
        """The problem as an HTTP response."""
        # ASCII only: what is quoted from the request may not be encodable as UTF-8
        body = json.dumps(self.document(instance), separators=(",", ":")).encode("ascii")
        headers = {"Cache-Control": "no-store", **self.headers}
        return Response(body, self.kind.value.status, headers, media_type=MEDIA_TYPE)
