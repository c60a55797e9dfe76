"""The errors of the HTTP service: all types of problems, and their documents (RFC 9457)."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from enum import Enum
from pathlib import Path

from starlette.responses import Response

from rpr_solver.errors import InputError
from service.api.settings import here
from service.schemas.answers import ascii_bytes
from service.schemas.limits import LimitError
from service.schemas.resources import address
from worker.jobs.view import JobView

MEDIA_TYPE = "application/problem+json"
_IN_DETAIL = 3
_LISTED = 50


_TYPES = tomllib.loads((Path(__file__).parent / "problems.toml").read_text(encoding="utf-8"))


class ProblemType(Enum):
    """Every type of problem, by its name in addresses; `problems.toml` has the texts.

    The address `/problems/{slug}` is stable and documents the type.

    Attributes:
        slug: the name in addresses.
        status: the HTTP status.
        title: what happened, in a few words.
        meaning: what it means, and what to do.
    """

    INVALID_HEADER = "invalid-header"
    INVALID_CSV = "invalid-csv"
    INVALID_JSON = "invalid-json"
    UNAUTHORIZED = "unauthorized"
    FORBIDDEN = "forbidden"
    NOT_FOUND = "not-found"
    METHOD_NOT_ALLOWED = "method-not-allowed"
    NOT_ACCEPTABLE = "not-acceptable"
    JOB_NOT_FINISHED = "job-not-finished"
    JOB_CANCELED = "job-canceled"
    SUBMISSION_IN_PROGRESS = "submission-in-progress"
    RESULT_EXPIRED = "result-expired"
    MALFORMED_REQUEST = "malformed-request"
    REQUEST_TIMEOUT = "request-timeout"
    HEADERS_TOO_LARGE = "headers-too-large"
    BODY_TOO_LARGE = "body-too-large"
    UNSUPPORTED_MEDIA_TYPE = "unsupported-media-type"
    UNKNOWN_HOST = "unknown-host"
    INVALID_REQUEST = "invalid-request"
    IDEMPOTENCY_KEY_REUSED = "idempotency-key-reused"
    LIMIT_EXCEEDED = "limit-exceeded"
    JOB_INPUT_ERROR = "job-input-error"
    JOB_SOLVER_ERROR = "job-solver-error"
    TOO_MANY_REQUESTS = "too-many-requests"
    INTERNAL_ERROR = "internal-error"
    JOB_FAILED = "job-failed"
    JOB_WORKER_LOST = "job-worker-lost"
    JOB_RESOURCE_EXHAUSTED = "job-resource-exhausted"
    TRANSFER_CODING_NOT_SUPPORTED = "transfer-coding-not-supported"
    UNAVAILABLE = "unavailable"
    QUEUE_FULL = "queue-full"
    NO_WORKER = "no-worker"
    BUSY = "busy"
    JOB_TIMEOUT = "job-timeout"

    def __init__(self, slug: str) -> None:
        self.slug = slug
        self.status: int = _TYPES[slug]["status"]
        self.title: str = _TYPES[slug]["title"]
        self.meaning: str = _TYPES[slug]["meaning"]

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
        retry_s: int | None = None,
        extra: Mapping[str, object] | None = None,
        in_body: bool = False,
    ) -> None:
        super().__init__(detail)
        self.in_body = in_body
        self.kind = kind
        self.detail = detail
        self.errors = tuple(errors)
        self.headers = dict(headers or {})
        if retry_s is not None:
            self.headers["Retry-After"] = str(retry_s)
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
        """Returns the problem of a job or a batch that failed or was canceled, in place of its result."""
        extra = {"job": here(address(view.id))}
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
    def too_many(
        cls, detail: str, limit: str, value: int, retry_s: int, extra: Mapping[str, object] | None = None
    ) -> ProblemError:
        """Returns the problem of a caller that has reached one of its limits."""
        extra = {"limit": {"name": limit, "value": value}, **(extra or {})}
        return cls(ProblemType.TOO_MANY_REQUESTS, detail, retry_s=retry_s, extra=extra)

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
        body = ascii_bytes(self.document(instance))
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
