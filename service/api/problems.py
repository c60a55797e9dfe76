"""The errors of the HTTP service: all types of problems, and their documents (RFC 9457)."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from enum import Enum

from starlette.responses import Response

from rpr_solver.errors import InputError
from service.api.prefix import here
from service.schemas.limits import LimitError
from worker.jobs.views import JobView

MEDIA_TYPE = "application/problem+json"
_IN_DETAIL = 3
_LISTED = 50


class ProblemType(Enum):
    """Every type of problem: its status, its title, and what it means.

    The address `/problems/{slug}` is stable and documents the type.
    """

    def __init__(self, status: int, title: str, meaning: str) -> None:
        self.status, self.title, self.meaning = status, title, meaning

    INVALID_HEADER = (
        400, "A request header is malformed",
        "The detail names the header that cannot be parsed.",
    )  # fmt: skip
    INVALID_CSV = (
        400, "The body is not valid CSV",
        "The request body is not UTF-8, a quoted cell does not end in its line, or a line has more cells "
        "than there are columns. The detail says where.",
    )  # fmt: skip
    INVALID_JSON = (
        400, "The body is not valid JSON",
        "The request body is not UTF-8 or not JSON, repeats a key, contains NaN or Infinity, or is nested "
        "too deeply. The detail says where.",
    )  # fmt: skip
    UNAUTHORIZED = (
        401, "A key is needed",
        "This service asks for a key: `Authorization: Bearer rpr_…`. The key is missing, unknown, expired or "
        "revoked.",
    )  # fmt: skip
    FORBIDDEN = (
        403, "The key does not allow this",
        "The key is valid, but its scope does not include this call. The detail names the scope that does.",
    )  # fmt: skip
    NOT_FOUND = (
        404, "Nothing is here",
        "There is no resource at this address. Jobs expire some time after they end; posting the same "
        "request again starts the same job again.",
    )  # fmt: skip
    METHOD_NOT_ALLOWED = (
        405, "The method is not allowed here",
        "The resource does not support this method. The Allow header lists the supported methods.",
    )  # fmt: skip
    NOT_ACCEPTABLE = (
        406, "None of the accepted media types can be served",
        "The Accept header excludes every available form of this resource. The detail lists them.",
    )  # fmt: skip
    JOB_NOT_FINISHED = (
        409, "The job is not finished",
        "The result was requested while the job is queued or running. Ask again after Retry-After seconds, "
        "or follow the job's events.",
    )  # fmt: skip
    JOB_CANCELED = (
        409, "The job was canceled",
        "The job was canceled and has no result. Posting the request again restarts it; slices that were "
        "already computed are kept.",
    )  # fmt: skip
    SUBMISSION_IN_PROGRESS = (
        409, "The same submission is still being received",
        "Another request with this Idempotency-Key is still being read. Ask again after Retry-After seconds; "
        "the answer is then the batch that it made.",
    )  # fmt: skip
    RESULT_EXPIRED = (
        410, "The result has expired",
        "The job succeeded, but its result has expired. Post the request again.",
    )  # fmt: skip
    MALFORMED_REQUEST = (
        400, "The request is not HTTP",
        "What was sent is not a request as HTTP/1.1 has it, or could be read in two ways, as with both "
        "Content-Length and Transfer-Encoding. The connection was closed.",
    )  # fmt: skip
    REQUEST_TIMEOUT = (
        408, "The request came too slowly",
        "The head or the body of the request did not arrive in time, and the connection was closed.",
    )  # fmt: skip
    HEADERS_TOO_LARGE = (
        431, "The header fields are too large",
        "The header fields have more bytes together than the service reads.",
    )  # fmt: skip
    BODY_TOO_LARGE = (
        413, "The body is too large",
        "The request body is larger than the limit max_body_bytes (see /v1/limits).",
    )  # fmt: skip
    UNSUPPORTED_MEDIA_TYPE = (
        415, "The body is not sent as JSON",
        "Send the request body as application/json, in UTF-8 and uncompressed.",
    )  # fmt: skip
    UNKNOWN_HOST = (
        421, "This is not the service of that name",
        "The Host header is neither an address nor localhost nor a name in RPR_CUSPS_ALLOWED_HOSTS. This "
        "keeps pages of other sites away from a service on your computer.",
    )  # fmt: skip
    INVALID_REQUEST = (
        422, "The request is not valid",
        "The JSON is well-formed but not a valid question: a field is missing, unknown or of the wrong "
        "kind, or no manipulator has these lengths. The errors list every faulty field.",
    )  # fmt: skip
    IDEMPOTENCY_KEY_REUSED = (
        422, "The Idempotency-Key was sent with another body",
        "A key stands for one submission of one caller, for 24 hours. Take a new key for a new batch.",
    )  # fmt: skip
    LIMIT_EXCEEDED = (
        422, "The request exceeds a limit",
        "The request is valid but larger than this service allows, or its answer would take too long. The "
        "errors give the limit, its value and the requested or estimated value, and name what to reduce; "
        "/v1/limits lists all limits.",
    )  # fmt: skip
    JOB_INPUT_ERROR = (
        422, "The job failed: its input cannot be solved",
        "The solver rejected the geometry or the choice of the fixed leg. The same request will fail again.",
    )  # fmt: skip
    JOB_SOLVER_ERROR = (
        422, "The job failed: no answer could be proved",
        "The input is valid, but this version of the solver could not prove an answer for this geometry. "
        "The solver never guesses.",
    )  # fmt: skip
    TOO_MANY_REQUESTS = (
        429, "Too many requests",
        "The caller has sent too many requests in a minute, or has too many active jobs, too much estimated "
        "work in them, or too many bytes of kept questions. The detail names the limit; try again after "
        "Retry-After seconds.",
    )  # fmt: skip
    INTERNAL_ERROR = (
        500, "Something went wrong here",
        "An unexpected error. The service's log has the details under the request id of the response.",
    )  # fmt: skip
    JOB_FAILED = (
        500, "The job failed",
        "The job ended without a result. The detail says why; posting the request again retries it.",
    )  # fmt: skip
    JOB_WORKER_LOST = (
        500, "The job failed: its worker was lost",
        "The worker process died repeatedly, and the retries of the job are used up. Posting the request "
        "again retries it.",
    )  # fmt: skip
    JOB_RESOURCE_EXHAUSTED = (
        500, "The job failed: it ran out of memory",
        "The computation reached the memory limit of a worker. Request fewer digits or simpler numbers.",
    )  # fmt: skip
    TRANSFER_CODING_NOT_SUPPORTED = (
        501, "The body has a coding that is not understood",
        "Transfer-Encoding may be chunked, and nothing else; compress no bodies.",
    )  # fmt: skip
    UNAVAILABLE = (
        503, "The queue cannot be reached",
        "Redis, which holds the queue and the results, cannot be reached or accepts no more data. Try again "
        "after Retry-After seconds.",
    )  # fmt: skip
    QUEUE_FULL = (
        503, "The queue is full",
        "The jobs in the same lane of the queue hold too much work (`RPR_CUSPS_MAX_BACKLOG`); nothing was "
        "queued. Try again after Retry-After seconds, the estimated time until that work is done.",
    )  # fmt: skip
    NO_WORKER = (
        503, "No worker is running",
        "Redis answers, but no worker of this service's solver version is alive. Known results are served; "
        "new jobs stay queued. Try again after Retry-After seconds.",
    )  # fmt: skip
    BUSY = (
        503, "Too much at the same time",
        "As many large results are being sent, or as many streams of events are open, as this service allows "
        "at the same time. Try again after Retry-After seconds.",
    )  # fmt: skip
    JOB_TIMEOUT = (
        504, "The job failed: it took too long",
        "The job was not done by the deadline of its request, `deadline_s`, or a part of it reached the time "
        "limit of the service. Request fewer digits or simpler numbers, or wait longer.",
    )  # fmt: skip

    @property
    def slug(self) -> str:
        """The name of the type in addresses."""
        return self.name.lower().replace("_", "-")

    @property
    def uri(self) -> str:
        """The `type` member of the problem document."""
        return f"/problems/{self.slug}"


class ProblemError(Exception):
    """An error that becomes a problem document in the response."""

    def __init__(
        self,
        kind: ProblemType,
        detail: str,
        *,
        errors: Iterable[tuple[str, str]] = (),
        headers: Mapping[str, str] | None = None,
        extra: Mapping[str, object] | None = None,
        in_body: bool = False,
    ) -> None:
        super().__init__(detail)
        self.in_body = in_body
        self.kind = kind
        self.detail = detail
        self.errors = tuple(errors)
        self.headers = dict(headers or {})
        self.extra = dict(extra or {})

    @classmethod
    def of_input(cls, error: InputError) -> ProblemError:
        """Returns the problem of bad input, whether the solver or a schema rejects it."""
        faults = [(p.field, p.message) for p in error.problems]
        detail = "; ".join(f"{field}: {message}" for field, message in faults[:_IN_DETAIL])
        more = f"; and {len(faults) - _IN_DETAIL} more" if len(faults) > _IN_DETAIL else ""
        kind, extra = ProblemType.INVALID_REQUEST, {}
        if isinstance(error, LimitError):
            kind, extra = ProblemType.LIMIT_EXCEEDED, {"limit": {"name": error.limit, "value": error.value}}
        return cls(kind, detail + more, errors=faults[:_LISTED], extra=extra, in_body=True)

    @classmethod
    def of_job(cls, view: JobView) -> ProblemError:
        """Returns the problem of a job that failed or was canceled, in place of its result."""
        extra = {"job": here(f"/v1/jobs/{view.id}")}
        if view.status == "failed":
            error = view.error or {"type": "", "detail": "The job failed."}
            return cls.of_failure(error["type"], error["detail"], extra)
        detail = "The job was canceled; post the request again to restart it."
        return cls(ProblemType.JOB_CANCELED, detail, extra=extra)

    @classmethod
    def of_failure(cls, reason: str, detail: str, extra: Mapping[str, object] | None = None) -> ProblemError:
        """Returns the problem of a job, or an item of a batch, that failed for a reason of the worker's."""
        found = (kind for kind in ProblemType if kind.slug == f"job-{reason}")
        return cls(next(found, ProblemType.JOB_FAILED), detail, extra=extra)

    @classmethod
    def expired(cls) -> ProblemError:
        """Returns the problem of a job whose result is gone."""
        return cls(ProblemType.RESULT_EXPIRED, "The result of this job has expired; post the request again.")

    @classmethod
    def of_status(cls, status: int, detail: str, headers: Mapping[str, str] | None = None) -> ProblemError:
        """Returns the problem for a status of the framework: the first type that has it."""
        other = ProblemType.INTERNAL_ERROR if status >= 500 else ProblemType.INVALID_HEADER
        return cls(next((k for k in ProblemType if k.status == status), other), detail, headers=headers)

    def document(self, instance: str | None = None) -> dict[str, object]:
        """Returns the problem document."""
        document: dict[str, object] = {
            "type": here(self.kind.uri),
            "title": self.kind.title,
            "status": self.kind.status,
            "detail": self.detail,
            "errors": [self._error(field, message) for field, message in self.errors],
        }
        if instance is not None:
            document["instance"] = here(instance)
        return {**document, **self.extra}

    def _error(self, field: str, message: str) -> dict[str, str]:
        pointed = {"pointer": pointer(field)} if self.in_body else {}
        return {"field": field, **pointed, "message": message}

    def response(self, instance: str | None = None) -> Response:
        """Returns the HTTP response."""
        # ASCII only: text quoted from the request may not be encodable as UTF-8
        body = json.dumps(self.document(instance), separators=(",", ":")).encode("ascii")
        headers = {"Cache-Control": "no-store", **self.headers}
        return Response(body, self.kind.status, headers, media_type=MEDIA_TYPE)


def pointer(field: str) -> str:
    """Returns the JSON pointer (RFC 6901) to a field with a dotted name; `body` is the whole.

    >>> pointer("geometry.d1"), pointer("l1[3]"), pointer("body")
    ('/geometry/d1', '/l1/3', '')
    """
    if field == "body":
        return ""
    parts = re.sub(r"\[(\d+)\]", r".\1", field).removeprefix("body.").removeprefix(".").split(".")
    return "".join("/" + part.replace("~", "~0").replace("/", "~1") for part in parts)
