"""Every metric of the service: its name, what it counts, and for whom."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

PREFIX = "rpr_cusps_"


@dataclass(frozen=True)
class Family:
    """A metric. In the text format the name of a counter ends in `_total`."""

    name: str
    kind: Literal["counter", "gauge", "histogram"]
    meaning: str
    labels: tuple[str, ...] = ()

    @property
    def shown(self) -> str:
        """The name in the text format."""
        return self.name + "_total" * (self.kind == "counter")


def _counter(name: str, meaning: str, *labels: str) -> Family:
    return Family(PREFIX + name, "counter", meaning, labels)


def _gauge(name: str, meaning: str, *labels: str) -> Family:
    return Family(PREFIX + name, "gauge", meaning, labels)


def _histogram(name: str, meaning: str, *labels: str) -> Family:
    return Family(PREFIX + name, "histogram", meaning, labels)


# -- of this API process

INFO = _gauge("info", "version of this service and of its solver; always 1", "version", "solver_version")
REQUESTS = _counter("http_requests", "HTTP requests answered", "method", "route", "status")
SECONDS = _histogram("http_request_seconds", "time to answer an HTTP request", "method", "route")
IN_FLIGHT = _gauge("http_in_flight", "HTTP requests that are being answered, with those that follow events")
FOLLOWERS = _gauge("followers", "clients that follow the events of a job")
TABLES = _counter("table_requests", "requests for a cusp table: cached, or handed to a job", "answer")
ANSWERS = _counter("answers", "questions by kind: cached, or handed to a job", "kind", "answer")

# -- of the whole installation

UP = _gauge("up", "whether Redis can be reached; without it, there is nothing below this line")
QUEUE_DEPTH = _gauge("queue_depth", "chunks of jobs that wait for a worker", "lane")
QUEUE_AGE = _gauge("queue_age_seconds", "time since the job first in line was submitted, or 0", "lane")
WORKERS = _gauge("workers", "number of live workers of this solver version")
BEAT_AGE = _gauge("worker_beat_age_seconds", "time since the least recent heartbeat of a live worker")
ACTIVE = _gauge("jobs_active", "jobs that are queued or running")
SUSPECTED = _gauge("chunks_suspected", "chunks that no worker seems to run; they are run again after a grace")
JOBS_ENDED = _counter("jobs_ended", "jobs by the way they ended", "kind", "status")
FAILURES = _counter("job_failures", "failed jobs by the reason, as in their problem type", "kind", "reason")
WAIT = _histogram("job_wait_seconds", "time of an ended job in the queue", "kind")
RUN = _histogram("job_run_seconds", "time from a job's first chunk to its end", "kind")
LOST = _counter("chunks_lost", "chunks that lost their work horse, or their worker", "what")
OVERRUNS = _counter(
    "chunks_overrun",
    "chunks that took a few times their estimate: left to their worker, or given back to the heavy lane",
    *("kind", "outcome"),
)
WEBHOOKS = _counter(
    "webhook_attempts", "attempts to deliver a webhook, by what they left; `pending`: to be repeated", "state"
)
MEMORY = _gauge("redis_memory_bytes", "memory that Redis uses")
MEMORY_LIMIT = _gauge("redis_memory_limit_bytes", "maxmemory of Redis; 0: none")

OF_PROCESS = (INFO, REQUESTS, SECONDS, IN_FLIGHT, FOLLOWERS, TABLES, ANSWERS)
OF_INSTALLATION = (
    *(UP, QUEUE_DEPTH, QUEUE_AGE, WORKERS, BEAT_AGE, ACTIVE, SUSPECTED),
    *(JOBS_ENDED, FAILURES, WAIT, RUN, LOST, OVERRUNS, WEBHOOKS, MEMORY, MEMORY_LIMIT),
)
