"""A job as the contract shows it."""

from __future__ import annotations

from math import ceil

from service.api.settings import Settings
from worker.answers.kinds import kind_of_job
from worker.jobs.records import JobView
from worker.jobs.subscriptions import Subscriber


def job_json(view: JobView, who: Subscriber | None = None) -> dict[str, object]:
    """Returns the job document; for a client that asks for the job, with the way to withdraw."""
    kind = kind_of_job(view.id)
    here = f"/v1/jobs/{view.id}"
    return {
        "id": view.id,
        "kind": None if kind is None else kind.name,
        "status": view.status,
        "progress": {"done": view.done, "total": view.total},
        "created_at": view.created_at,
        "started_at": view.started_at,
        "finished_at": view.finished_at,
        "error": view.error,
        "position": None if view.place is None else view.place.position,
        "deadline_at": view.deadline_at,
        "links": {
            **{"self": here, "result": f"{here}/result", "events": f"{here}/events"},
            **({} if who is None else {"cancel": cancel_link(here, who)}),
        },
    }


def cancel_link(here: str, who: Subscriber) -> str:
    """Returns the address at which a client withdraws what it has just asked for."""
    return here if who.is_known else f"{here}?subscription={who.token}"


def retry_after(view: JobView, settings: Settings) -> dict[str, str]:
    """Returns the header that says when to ask again for a job: sooner if it runs than if it waits."""
    seconds = 0 if view.place is None else min(ceil(view.place.seconds), settings.longest_poll_seconds)
    return {"Retry-After": str(max(settings.poll_seconds, seconds))}
