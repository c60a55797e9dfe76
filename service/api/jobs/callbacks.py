"""Callbacks of jobs and batches, and the log of their deliveries."""

from __future__ import annotations

from urllib.parse import urlsplit

from rpr_solver.errors import InputError
from service.api.context import Context
from service.api.jobs.views import state_json
from service.api.settings import prefixed
from service.schemas.document import JsonNumber, json_kind
from service.webhooks.deliverer import Shown, event_type
from service.webhooks.settings import FIELD, target_of
from worker.jobs.clients import MAX_CALLBACKS_PER_JOB, Delivery, Subscriber, TooManyCallbacksError
from worker.jobs.views import JobView
from worker.settings import WorkerSettings


def allowed_url(context: Context, *sent: object) -> str | None:
    """Returns the callback URL of a batch, which is given in the query or in the body, or None.

    Raises:
        InputError: it may not be called, or there are two.
    """
    urls = [url for url in sent if url is not None]
    if len(urls) > 1:
        raise InputError.of(FIELD, "is given in the query and in the body; give it once")
    for url in urls:
        if not isinstance(url, str) or isinstance(url, JsonNumber):
            raise InputError.of(FIELD, f"is {json_kind(url)}; give a URL")
        target_of(url, context.settings.webhooks)
        return url
    return None


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
        text = f"the job has {MAX_CALLBACKS_PER_JOB} callbacks, the most that it may have"
        raise InputError.of(FIELD, text) from None


def deliveries_json(deliveries: list[Delivery]) -> dict[str, object]:
    """Returns the log. It names hosts only, since other callers may have asked the same."""
    return {"deliveries": [_delivery_json(delivery) for delivery in deliveries]}


def event_documents(settings: WorkerSettings, prefix: str = "") -> Shown:
    """Returns what gives the document of a job or a batch for an event, whose links have a prefix."""

    def document(view: JobView) -> dict[str, object]:
        with prefixed(prefix):
            return state_json(view, settings)

    return document


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
