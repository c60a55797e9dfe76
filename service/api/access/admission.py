"""Whether a caller may have one more job computed."""

from __future__ import annotations

from service.api.access.caller import Caller, check_scope
from service.api.problems import ProblemError, ProblemType
from service.schemas.limits import LimitError, Limits
from worker.answers.requests import JobRequest
from worker.jobs.clients import Quota, QuotaError, Quotas

_RETRY_S = 5


def admit(caller: Caller | None, request: JobRequest, quotas: Quotas, limits: Limits) -> None:
    """Count a job as one of the caller's.

    Raises:
        ProblemError: the caller has as many as it may have, or may not compute.
        LimitError: it is more than is ever kept.
    """
    if caller is not None and caller.is_limited:
        work = request.kind.seconds(request.sizes)
        admit_work(caller, request.job_id, work, len(request.to_json()), quotas, limits)


def admit_work(
    caller: Caller | None, job_id: str, work: float, size: int, quotas: Quotas, limits: Limits
) -> None:
    """Count a job, with its estimated work in seconds and its size in bytes, for the caller.

    Raises:
        ProblemError: the caller has as many as it may have, or may not compute.
        LimitError: it is more than is ever kept.
    """
    if caller is None or not caller.is_limited:
        return
    check_scope(caller, "submit")  # independent of the route
    quota = _quota(limits, size)
    try:
        quotas.admit(caller.id, job_id, work, quota, size)
    except QuotaError as error:
        raise _too_much(error, quota, size) from None


def admit_bytes(
    caller: Caller | None, job_id: str, size: int, quotas: Quotas, limits: Limits, seconds: float
) -> None:
    """Count the received part of a question as kept for the caller; more is expected within the given
    seconds.

    Raises:
        ProblemError: as much is kept for the caller as may be.
        LimitError: it is more than is ever kept.
    """
    if caller is None or not caller.is_limited:
        return
    quota = _quota(limits, size)
    try:
        quotas.receive(caller.id, job_id, size, quota, seconds)
    except QuotaError as error:
        raise _too_much(error, quota, size) from None


def _quota(limits: Limits, size: int) -> Quota:
    """Returns the quota of callers.

    Raises:
        LimitError: the question alone is more than it.
    """
    if 0 < limits.max_kept_bytes < size:
        raise LimitError.exceeded(limits, "max_kept_bytes", f"has {size} bytes", "body")
    return Quota(limits.max_active_jobs, limits.max_active_seconds, limits.max_kept_bytes)


def _too_much(error: QuotaError, quota: Quota, size: int) -> ProblemError:
    if error.kept_bytes is not None:
        return _too_many_bytes(error, quota, size)
    is_number = 0 < quota.jobs <= error.jobs
    name, value = ("max_active_jobs", quota.jobs) if is_number else ("max_active_seconds", quota.seconds)
    return ProblemError(
        ProblemType.TOO_MANY_REQUESTS,
        f"You have {error.jobs} active jobs with about {error.seconds:.0f} s of estimated work; the limit "
        f"{name} is {value}. Wait for some of them, or withdraw them (DELETE).",
        headers={"Retry-After": str(_RETRY_S)},
        extra={"limit": {"name": name, "value": value}},
    )


def _too_many_bytes(error: QuotaError, quota: Quota, size: int) -> ProblemError:
    most, kept = quota.kept_bytes, error.kept_bytes or 0
    then = "withdraw from active jobs (DELETE), or wait for them"
    if error.retry_s:
        then = f"wait {error.retry_s} s, until older ones have expired"
    return ProblemError(
        ProblemType.TOO_MANY_REQUESTS,
        f"{kept} bytes of your questions are kept, in {error.jobs} active jobs and in records of ended ones; "
        f"this one has {size}, and the limit max_kept_bytes is {most}. Send {max(0, most - kept)} bytes at "
        f"most, or {then}.",
        headers={"Retry-After": str(error.retry_s or _RETRY_S)},
        extra={"limit": {"name": "max_kept_bytes", "value": most}, "kept_bytes": kept},
    )
