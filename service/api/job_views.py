"""Jobs, batches and deliveries as the contract shows them."""

from __future__ import annotations

from datetime import datetime, timedelta
from math import ceil
from urllib.parse import urlsplit

from service.api.settings import Settings, here, prefixed
from service.schemas.resources import address
from service.webhooks.callbacks import Delivery
from service.webhooks.deliverer import DocumentOf, event_type
from worker.answers.kinds import is_batch, kind_of_job
from worker.jobs.keys import FAILURE_TTL
from worker.jobs.view import JobView, iso
from worker.settings import WorkerSettings


def state_json(view: JobView, settings: WorkerSettings) -> dict[str, object]:
    """Returns the state of a job or a batch."""
    return (_batch_json if is_batch(view.id) else _job_json)(view, settings, here(address(view.id)))


def _progress_json(view: JobView, settings: WorkerSettings) -> dict[str, object]:
    """Returns what jobs and batches have in common."""
    return {
        "id": view.id,
        "status": view.state,
        "done": view.is_terminal,
        "progress": {"done": view.done, "total": view.total},
        "created_at": view.created_at,
        "started_at": view.started_at,
        "ended_at": view.ended_at,
        "expires_at": _expires_at(view, settings),
        "error": view.error,
        "position": None if view.place is None else view.place.position,
        "estimate_seconds": view.estimate_seconds,
    }


def _job_json(view: JobView, settings: WorkerSettings, own: str) -> dict[str, object]:
    kind = kind_of_job(view.id)
    return {
        **_progress_json(view, settings),
        "kind": None if kind is None else kind.name,
        "run": view.run,
        "deadline_at": view.deadline_at,
        "links": {"self": own, "result": f"{own}/result", "events": f"{own}/events"},
    }


def _batch_json(view: JobView, settings: WorkerSettings, own: str) -> dict[str, object]:
    left = view.total - view.done
    return {
        **_progress_json(view, settings),
        "succeeded": view.done - view.failed,
        "failed": view.failed + (left if view.status == "failed" else 0),
        "canceled": left if view.status == "canceled" else 0,
        "links": {"self": own, "results": f"{own}/results", "events": f"{own}/events"},
    }


def _expires_at(view: JobView, settings: WorkerSettings) -> str | None:
    """Returns until when a job that has ended is kept."""
    if view.ended_at is None:
        return None
    ttl = settings.result_ttl_seconds if view.status == "succeeded" else FAILURE_TTL
    end = datetime.fromisoformat(view.ended_at) + timedelta(seconds=ttl)
    return end.isoformat(timespec="seconds").replace("+00:00", "Z")


def earlier_state(view: JobView, status: str) -> dict[str, object]:
    """Returns what is known of a job for the time when its run came to a state."""
    return {
        "id": view.id,
        "run": view.run,
        "status": status,
        "created_at": view.created_at,
        "started_at": None if status == "queued" else view.started_at,
        "ended_at": None,
        "error": None,
    }


_POLL_SECONDS = 1
"""The least `Retry-After` of a job, in seconds: HTTP knows no shorter one."""


def retry_after(view: JobView, settings: Settings) -> int:
    """Returns the seconds after which to ask again for a job: fewer if it runs than if it waits."""
    seconds = 0 if view.place is None else min(ceil(view.place.seconds), settings.longest_poll_seconds)
    return max(_POLL_SECONDS, seconds)


def delivery_json(delivery: Delivery) -> dict[str, object]:
    """Returns a delivery of the log. It names the host only, since other callers may have asked the same."""
    return {
        "webhook_id": delivery.id,
        "type": event_type(delivery.job),
        "host": urlsplit(delivery.url).hostname,
        "state": delivery.state,
        "next_attempt_at": delivery.next_at,
        "attempts": [
            {"at": iso(attempt.at), "status": attempt.status, "problem": attempt.problem}
            for attempt in delivery.attempts
        ],
    }


def event_documents(settings: WorkerSettings, prefix: str = "") -> DocumentOf:
    """Returns what gives the document of a job or a batch for an event, whose links have a prefix."""

    def document(view: JobView) -> dict[str, object]:
        with prefixed(prefix):
            return state_json(view, settings)

    return document
