"""Callbacks of jobs and batches, and the log of their deliveries."""

from __future__ import annotations

from urllib.parse import urlsplit

from rpr_solver.errors import InputError
from service.api.batch_view import batch_json
from service.api.context import Context
from service.api.job_view import job_json
from service.webhooks.deliverer import Shown
from service.webhooks.urls import FIELD
from worker.answers.kinds import is_batch
from worker.jobs.callbacks import MANY, Delivery, TooManyCallbacksError
from worker.jobs.records import JobView
from worker.jobs.subscriptions import Subscriber
from worker.settings import WorkerSettings


def call_back(context: Context, job_id: str, who: Subscriber, url: str | None) -> None:
    """Have a URL, if there is one, called when the job of a subscriber ends.

    Raises:
        InputError: the job has too many; the subscriber is withdrawn.
    """
    if url is None:
        return
    try:
        context.callbacks.add(job_id, url)
    except TooManyCallbacksError:
        context.queue.withdraw(job_id, who)
        raise InputError.of(FIELD, f"the job has {MANY} callbacks, the most that it may have") from None


def deliveries_json(deliveries: list[Delivery]) -> dict[str, object]:
    """Returns the log. It names hosts only, since other callers may have asked the same."""
    return {"deliveries": [_delivery_json(delivery) for delivery in deliveries]}


def shown(settings: WorkerSettings) -> Shown:
    """Returns what gives the document of a job or a batch for an event."""
    return lambda view: batch_json(view, settings) if is_batch(view.id) else job_json(view, settings)


def event_type(view: JobView) -> str:
    """Returns the type of the event that a job or a batch has ended."""
    return f"{'batch' if is_batch(view.id) else 'job'}.{view.status}"


def _delivery_json(delivery: Delivery) -> dict[str, object]:
    return {
        "webhook_id": delivery.id,
        "type": event_type(delivery.job),
        "host": urlsplit(delivery.url).hostname,
        "state": delivery.state,
        "next_attempt_at": delivery.next_at,
        "attempts": [
            {"at": attempt.at_iso, "status": attempt.status, "problem": attempt.problem}
            for attempt in delivery.attempts
        ],
    }
