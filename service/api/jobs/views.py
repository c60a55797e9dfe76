"""Jobs and batches as the contract shows them."""

from __future__ import annotations

from datetime import datetime, timedelta
from math import ceil

from service.api.prefix import here
from service.api.settings import Settings
from worker.answers.kinds import kind_of_job
from worker.jobs.clients import Subscriber
from worker.jobs.views import JobView
from worker.settings import WorkerSettings


def job_json(view: JobView, settings: WorkerSettings, who: Subscriber | None = None) -> dict[str, object]:
    """Returns the job document; for a client that asks for the job, with the way to withdraw."""
    kind = kind_of_job(view.id)
    own = here(f"/v1/jobs/{view.id}")
    return {
        "id": view.id,
        "kind": None if kind is None else kind.name,
        "status": view.status,
        "run": view.run,
        "done": view.is_terminal,
        "progress": {"done": view.done, "total": view.total},
        "created_at": view.created_at,
        "started_at": view.started_at,
        "finished_at": view.finished_at,
        "expires_at": expires_at(view, settings),
        "timings": {
            "queued_seconds": _seconds(view.created_at, view.started_at or view.finished_at),
            "running_seconds": _seconds(view.started_at, view.finished_at),
        },
        "error": view.error,
        "position": None if view.place is None else view.place.position,
        "deadline_at": view.deadline_at,
        "estimate_s": view.estimate_s,
        "overruns": view.overruns,
        "links": {
            **{"self": own, "result": f"{own}/result", "events": f"{own}/events"},
            **({} if who is None else {"cancel": cancel_link(own, who)}),
        },
    }


def expires_at(view: JobView, settings: WorkerSettings) -> str | None:
    """Returns until when a job that has ended is kept."""
    if view.finished_at is None:
        return None
    ttl = settings.job_ttl if view.status == "succeeded" else settings.failure_ttl
    end = datetime.fromisoformat(view.finished_at) + timedelta(seconds=ttl)
    return end.isoformat(timespec="seconds").replace("+00:00", "Z")


def state_then(view: JobView, status: str) -> dict[str, object]:
    """Returns what is known of a job for the time when its run came to a state."""
    return {
        "id": view.id,
        "run": view.run,
        "status": status,
        "created_at": view.created_at,
        "started_at": None if status == "queued" else view.started_at,
        "finished_at": None,
        "error": None,
    }


def _seconds(start: str | None, end: str | None) -> float | None:
    if start is None or end is None:
        return None
    return round((datetime.fromisoformat(end) - datetime.fromisoformat(start)).total_seconds(), 3)


def cancel_link(own: str, who: Subscriber) -> str:
    """Returns the address at which a client withdraws what it has just asked for."""
    return own if who.is_known else f"{own}?subscription={who.token}"


def retry_after(view: JobView, settings: Settings) -> dict[str, str]:
    """Returns the header that says when to ask again for a job: sooner if it runs than if it waits."""
    seconds = 0 if view.place is None else min(ceil(view.place.seconds), settings.longest_poll_seconds)
    return {"Retry-After": str(max(settings.poll_seconds, seconds))}


def batch_json(view: JobView, settings: WorkerSettings, who: Subscriber | None = None) -> dict[str, object]:
    """Returns the state of a batch; for the client that submits it, with the way to withdraw it."""
    own = here(f"/v1/batches/{view.id}")
    left = view.total - view.done
    cancel = {} if who is None else {"cancel": cancel_link(own, who)}
    return {
        "id": view.id,
        "status": view.status,
        "total": view.total,
        "done": view.done,
        "succeeded": view.done - view.failed,
        "failed": view.failed + (left if view.status == "failed" else 0),
        "canceled": left if view.status == "canceled" else 0,
        "created_at": view.created_at,
        "started_at": view.started_at,
        "finished_at": view.finished_at,
        "expires_at": expires_at(view, settings),
        "error": view.error,
        "position": None if view.place is None else view.place.position,
        "estimate_s": view.estimate_s,
        "overruns": view.overruns,
        "links": {"self": own, "results": f"{own}/results", "events": f"{own}/events", **cancel},
    }
