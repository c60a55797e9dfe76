"""A batch as the contract shows it."""

from __future__ import annotations

from service.api.jobs.views import cancel_link, expires_at
from service.api.prefix import here
from worker.jobs.subscriptions import Subscriber
from worker.jobs.views import JobView
from worker.settings import WorkerSettings


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
