"""Metrics in the Prometheus text format: requests are counted, the queue is read at each scrape."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Mapping
from itertools import accumulate
from typing import Any

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
from worker.jobs.installation import Durations, Load, read_load
from worker.jobs.queue import JobQueue
from worker.lua.scripts import DURATION_BOUNDS

NAMESPACE = "rpr_cusps"

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
        """Read the queue now. Without Redis, yield only `rpr_cusps_up`, which is 0."""
        try:
            load = read_load(self.queue.redis, self.queue.settings)
        except RedisError as error:
            log.warning("no metrics of the queue: %s", error)
            yield _up(0)
            return
        yield from of_installation(load)


def of_installation(load: Load) -> Iterator[Metric]:
    """Yields the metrics of the whole installation."""
    ends = load.ends
    yield _up(1)
    waiting = "chunks of jobs that wait for a worker"
    yield _gauge("queue_depth", waiting, {(lane.name,): lane.depth for lane in load.lanes}, "lane")
    age = "time since the job first in line was submitted, or 0"
    yield _gauge("queue_age_seconds", age, {(lane.name,): lane.age for lane in load.lanes}, "lane")
    yield _gauge("workers", "number of live workers of this solver version", {(): load.workers})
    yield _gauge("jobs_active", "jobs that are queued or running", {(): load.active_jobs})
    suspected = "chunks that no worker seems to run; they are run again after a grace"
    yield _gauge("chunks_suspected", suspected, {(): load.suspected_chunks})
    yield _counter("jobs_ended", "jobs by the way they ended", ends.by_status, "kind", "status")
    why = "failed jobs by the reason, as in their problem type"
    yield _counter("job_failures", why, ends.failures, "kind", "reason")
    yield _histogram("job_wait_seconds", "time of an ended job in the queue", ends.waits, "kind")
    yield _histogram("job_run_seconds", "time from a job's first chunk to its end", ends.runs, "kind")
    lost = _by_one({name: ends.lost[key] for key, name in _LOST.items()})
    yield _counter("chunks_lost", "chunks that lost their work horse, or their worker", lost, "what")
    too_long = "small jobs that took too long, and went on in the heavy lane"
    yield _counter("jobs_demoted", too_long, ends.demoted, "kind")
    attempts = "attempts to deliver a webhook, by what they left; `pending`: to be repeated"
    yield _counter("webhook_attempts", attempts, _by_one(load.deliveries), "state")
    moved = (
        "answers, bytes and objects that moved to the archive, answers found `lost` there, and objects "
        "`refused`"
    )
    yield _counter("archive", moved, _by_one(load.archive), "what")
    yield _gauge("redis_memory_bytes", "memory that Redis uses", {(): load.memory})
    yield _gauge("redis_memory_limit_bytes", "maxmemory of Redis; 0: none", {(): load.memory_limit})


Values = Mapping[tuple[str, ...], float]
"""Values by those of the labels."""


def _by_one(values: Mapping[str, float]) -> Values:
    return {(name,): value for name, value in values.items()}


def _up(value: int) -> Metric:
    text = "whether Redis can be reached; without it, there is nothing below this line"
    return _gauge("up", text, {(): value})


def _gauge(name: str, text: str, values: Values, *labels: str) -> Metric:
    return _filled(GaugeMetricFamily(f"{NAMESPACE}_{name}", text, labels=labels), values)


def _counter(name: str, text: str, values: Values, *labels: str) -> Metric:
    return _filled(CounterMetricFamily(f"{NAMESPACE}_{name}", text, labels=labels), values)


def _filled(metric: GaugeMetricFamily | CounterMetricFamily, values: Values) -> Metric:
    for labels, value in values.items():
        metric.add_metric(labels, value)
    return metric


def _histogram(name: str, text: str, values: Mapping[str, Durations], *labels: str) -> Metric:
    metric = HistogramMetricFamily(f"{NAMESPACE}_{name}", text, labels=labels)
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
        own: Any = {"namespace": NAMESPACE, "registry": self.registry}
        self.info = Gauge(
            "info",
            "version of this service and of its solver; always 1",
            ["version", "solver_version"],
            **own,
        )
        self.info.labels(__version__, str(rpr_solver.SOLVER_VERSION)).set(1)
        self.requests = Counter(
            "http_requests", "HTTP requests answered", ["method", "route", "status"], **own
        )
        self.seconds = Histogram(
            "http_request_seconds",
            "time to answer an HTTP request",
            ["method", "route"],
            buckets=_BUCKETS,
            **own,
        )
        self.in_flight = Gauge(
            "http_in_flight", "HTTP requests that are being answered, with those that follow events", **own
        )
        self.followers = Gauge("followers", "clients that follow the events of a job", **own)
        self.tables = Counter(
            "table_requests", "requests for a cusp table: cached, or handed to a job", ["answer"], **own
        )
        self.answers = Counter(
            "answers", "questions by kind: cached, or handed to a job", ["kind", "answer"], **own
        )
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
