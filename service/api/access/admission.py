"""Whether a caller may have one more job computed."""

from __future__ import annotations

from service.api.access.caller import Caller
from service.api.access.rules import check_scope
from service.api.problems import ProblemError, ProblemType
from service.schemas.limits import Limits
from worker.answers.cost import seconds
from worker.answers.requests import JobRequest
from worker.answers.sizes import sizes
from worker.jobs.quotas import Quota, QuotaError, Quotas

_RETRY_S = 5


def admit(caller: Caller | None, request: JobRequest, quotas: Quotas, limits: Limits) -> None:
    """Count a job as one of the caller's.

    Raises:
        ProblemError: the caller has as many as it may have, or may not compute.
    """
    if caller is not None and caller.is_limited:
        admit_work(caller, request.job_id, seconds(request.kind, sizes(request)), quotas, limits)


def admit_work(caller: Caller | None, job_id: str, work: float, quotas: Quotas, limits: Limits) -> None:
    """Count a job of so many seconds of estimated work as one of the caller's.

    Raises:
        ProblemError: the caller has as many as it may have, or may not compute.
    """
    if caller is None or not caller.is_limited:
        return
    check_scope(caller, "submit")  # whatever the way that led here
    quota = Quota(limits.max_active_jobs, limits.max_active_seconds)
    try:
        quotas.admit(caller.id, job_id, work, quota)
    except QuotaError as error:
        raise _too_much(error, quota) from None


def _too_much(error: QuotaError, quota: Quota) -> ProblemError:
    is_number = 0 < quota.jobs <= error.jobs
    name, value = ("max_active_jobs", quota.jobs) if is_number else ("max_active_seconds", quota.seconds)
    return ProblemError(
        ProblemType.TOO_MANY_REQUESTS,
        f"You have {error.jobs} active jobs with about {error.seconds:.0f} s of estimated work; the limit "
        f"{name} is {value}. Wait for some of them, or withdraw from them (DELETE).",
        headers={"Retry-After": str(_RETRY_S)},
        extra={"limit": {"name": name, "value": value}},
    )
