"""Metrics in the Prometheus text format: requests are counted, the queue is read at each scrape."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import accumulate
from typing import Any, Literal, get_args

from prometheus_client import (
    CollectorRegistry,
    Counter,
    Gauge,
    Histogram,
    disable_created_metrics,
    generate_latest,
)
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, HistogramMetricFamily, Metric
from prometheus_client.registry import Collector
from redis.exceptions import RedisError

import rpr_solver
from service import __version__
from worker.answers.tables import CUSP_TABLE
from worker.jobs.installation import Durations, Ends, Load, read_load
from worker.jobs.queue import JobQueue
from worker.lua.scripts import DURATION_BOUNDS

PREFIX = "rpr_cusps_"

Kind = Literal["counter", "gauge", "histogram"]


@dataclass(frozen=True)
class Family:
    """A metric. In the text format the name of a counter ends in `_total`."""

    name: str
    kind: Kind
    meaning: str
    labels: tuple[str, ...] = ()

    @property
    def shown(self) -> str:
        """The name in the text format."""
        return self.name + "_total" * (self.kind == "counter")


def _family(kind: Kind, name: str, meaning: str, *labels: str) -> Family:
    return Family(PREFIX + name, kind, meaning, labels)


_counter, _gauge, _histogram = (partial(_family, kind) for kind in get_args(Kind))


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
ACTIVE = _gauge("jobs_active", "jobs that are queued or running")
SUSPECTED = _gauge("chunks_suspected", "chunks that no worker seems to run; they are run again after a grace")
JOBS_ENDED = _counter("jobs_ended", "jobs by the way they ended", "kind", "status")
FAILURES = _counter("job_failures", "failed jobs by the reason, as in their problem type", "kind", "reason")
WAIT = _histogram("job_wait_seconds", "time of an ended job in the queue", "kind")
RUN = _histogram("job_run_seconds", "time from a job's first chunk to its end", "kind")
LOST = _counter("chunks_lost", "chunks that lost their work horse, or their worker", "what")
DEMOTED = _counter("jobs_demoted", "small jobs that took too long, and went on in the heavy lane", "kind")
WEBHOOKS = _counter(
    "webhook_attempts", "attempts to deliver a webhook, by what they left; `pending`: to be repeated", "state"
)
ARCHIVE = _counter(
    "archive",
    "answers, bytes and objects that moved to the archive, answers found `lost` there, and objects `refused`",
    "what",
)
MEMORY = _gauge("redis_memory_bytes", "memory that Redis uses")
MEMORY_LIMIT = _gauge("redis_memory_limit_bytes", "maxmemory of Redis; 0: none")

OF_PROCESS = (INFO, REQUESTS, SECONDS, IN_FLIGHT, FOLLOWERS, TABLES, ANSWERS)
OF_INSTALLATION = (
    *(UP, QUEUE_DEPTH, QUEUE_AGE, WORKERS, ACTIVE, SUSPECTED),
    *(JOBS_ENDED, FAILURES, WAIT, RUN, LOST, DEMOTED, WEBHOOKS, ARCHIVE, MEMORY, MEMORY_LIMIT),
)


log = logging.getLogger("rpr_cusps.service")

_DURATIONS = (*(f"{bound:g}" for bound in DURATION_BOUNDS), "+Inf")
_LOST = {"horses": "horse", "workers": "worker"}


class QueueCollector(Collector):
    """Reads the queue when it is asked."""

    def __init__(self, queue: JobQueue) -> None:
        self.queue = queue

    def describe(self) -> Iterable[Metric]:
        """Nothing, so that registering does not read Redis."""
        return ()

    def collect(self) -> Iterator[Metric]:
        """Read the queue now. Without Redis, yield only the version and `rpr_cusps_up`, which is 0."""
        yield _read(INFO, {(__version__, str(rpr_solver.SOLVER_VERSION)): 1})
        try:
            load = read_load(self.queue.redis, self.queue.settings)
        except RedisError as error:
            log.warning("no metrics of the queue: %s", error)
            yield _read(UP, {(): 0})
            return
        yield _read(UP, {(): 1})
        yield from _of_load(load)
        yield from _of_ends(load.ends)


def _of_load(load: Load) -> Iterator[Metric]:
    yield _read(QUEUE_DEPTH, {(lane.name,): lane.depth for lane in load.lanes})
    yield _read(QUEUE_AGE, {(lane.name,): lane.age for lane in load.lanes})
    yield _read(WORKERS, {(): load.workers})
    yield _read(ACTIVE, {(): load.active_jobs})
    yield _read(SUSPECTED, {(): load.suspected_chunks})
    yield _read(WEBHOOKS, {(state,): count for state, count in load.deliveries.items()})
    yield _read(ARCHIVE, {(what,): count for what, count in load.archive.items()})
    yield _read(MEMORY, {(): load.memory})
    yield _read(MEMORY_LIMIT, {(): load.memory_limit})


def _of_ends(ends: Ends) -> Iterator[Metric]:
    yield _read(JOBS_ENDED, ends.by_status)
    yield _read(FAILURES, ends.failures)
    yield _read(LOST, {(name,): ends.lost[key] for key, name in _LOST.items()})
    yield _read(DEMOTED, ends.demoted)
    yield _histogram_of(WAIT, ends.waits)
    yield _histogram_of(RUN, ends.runs)


def _read(family: Family, values: Mapping[tuple[str, ...], float]) -> Metric:
    """A gauge or a counter with the values that were read, by their labels."""
    form = CounterMetricFamily if family.kind == "counter" else GaugeMetricFamily
    metric = form(family.name, family.meaning, labels=family.labels)
    for labels, value in values.items():
        metric.add_metric(labels, value)
    return metric


def _histogram_of(family: Family, values: Mapping[str, Durations]) -> Metric:
    metric = HistogramMetricFamily(family.name, family.meaning, labels=family.labels)
    for kind, durations in values.items():
        buckets = list(zip(_DURATIONS, accumulate(durations.counts), strict=True))
        metric.add_metric([kind], buckets, durations.seconds)
    return metric


_BUCKETS = (0.001, 0.002, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30)
_METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})


class Metrics:
    """The metrics of one API process."""

    def __init__(self, queue: JobQueue) -> None:
        disable_created_metrics()  # type: ignore[no-untyped-call]
        self.registry = CollectorRegistry()
        self.requests = Counter(*_words(REQUESTS), registry=self.registry)
        self.seconds = Histogram(*_words(SECONDS), buckets=_BUCKETS, registry=self.registry)
        self.in_flight = Gauge(*_words(IN_FLIGHT), registry=self.registry)
        self.followers = Gauge(*_words(FOLLOWERS), registry=self.registry)
        self.tables = Counter(*_words(TABLES), registry=self.registry)
        self.answers = Counter(*_words(ANSWERS), registry=self.registry)
        self.registry.register(QueueCollector(queue))

    def count_answer(self, kind: str, answer: str) -> None:
        """Count a question by the way of its answer: `cached` or `job`."""
        if kind == CUSP_TABLE.name:
            self.tables.labels(answer).inc()
        self.answers.labels(kind, answer).inc()

    def observe(self, scope: Mapping[str, Any], method: str, status: int, seconds: float) -> None:
        """Count one request."""
        other = "/static" if scope["path"].startswith("/static/") else "unmatched"
        route = getattr(scope.get("route"), "path", None) or other
        method = method if method in _METHODS else "other"
        self.requests.labels(method, route, str(status)).inc()
        self.seconds.labels(method, route).observe(seconds)

    def text(self) -> bytes:
        """Returns all metrics; reads Redis."""
        return generate_latest(self.registry)


def _words(family: Family) -> tuple[str, str, tuple[str, ...]]:
    return family.name, family.meaning, family.labels
