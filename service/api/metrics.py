"""Metrics in the Prometheus text format: requests are counted, the queue is read at each scrape."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from prometheus_client import CollectorRegistry, Counter, Histogram, disable_created_metrics, generate_latest
from prometheus_client.core import GaugeMetricFamily, Metric
from prometheus_client.registry import Collector
from redis.exceptions import RedisError

from service import __version__
from worker.answers import tables
from worker.jobs.queue import JobQueue

log = logging.getLogger("rpr_cusps.service")

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"
_BUCKETS = (0.001, 0.002, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30)
_METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})


class Metrics:
    """The metrics of one API process."""

    def __init__(self, queue: JobQueue) -> None:
        disable_created_metrics()  # type: ignore[no-untyped-call]
        self.registry = CollectorRegistry()
        labels = ("method", "route")
        self.requests = Counter(
            "rpr_cusps_http_requests", "HTTP requests answered", (*labels, "status"), registry=self.registry
        )
        self.seconds = Histogram(
            "rpr_cusps_http_request_seconds", "time to answer an HTTP request", labels, buckets=_BUCKETS,
            registry=self.registry,
        )  # fmt: skip
        text = "requests for a cusp table: cached, or handed to a job"
        self.tables = Counter("rpr_cusps_table_requests", text, ("answer",), registry=self.registry)
        text = "questions by kind: cached, or handed to a job"
        self.answers = Counter("rpr_cusps_answers", text, ("kind", "answer"), registry=self.registry)
        self.registry.register(_QueueCollector(queue))

    def count_answer(self, kind: str, answer: str) -> None:
        """Count a question by the way of its answer: `cached` or `job`."""
        if kind == tables.KIND.name:
            self.tables.labels(answer).inc()
        self.answers.labels(kind, answer).inc()

    def observe(self, scope: Mapping[str, Any], method: str, status: int, seconds: float) -> None:
        """Count one request."""
        route = getattr(scope.get("route"), "path", None) or ("/static" if _is_static(scope) else "unmatched")
        method = method if method in _METHODS else "other"
        self.requests.labels(method, route, str(status)).inc()
        self.seconds.labels(method, route).observe(seconds)

    def text(self) -> bytes:
        """Returns all metrics; reads Redis."""
        return generate_latest(self.registry)


class _QueueCollector(Collector):
    def __init__(self, queue: JobQueue) -> None:
        self.queue = queue

    def describe(self) -> Iterable[Metric]:
        """Nothing, so that registering does not read Redis."""
        return ()

    def collect(self) -> Iterator[Metric]:
        """Read the queue now. Without Redis, yield only the version and `rpr_cusps_up`, which is 0."""
        yield _gauge("rpr_cusps_info", "version of this service", 1, version=__version__)
        gauges: list[GaugeMetricFamily] = []
        try:
            gauges = [
                _gauge("rpr_cusps_queue_depth", "chunks of jobs that wait for a worker", self.queue.depth()),
                _gauge(
                    "rpr_cusps_workers", "number of live workers of this solver version", self.queue.workers()
                ),
                _gauge("rpr_cusps_jobs_active", "jobs that are queued or running", self._active()),
            ]
        except RedisError as error:
            log.warning("metrics without a queue: %s", error)
        yield _gauge("rpr_cusps_up", "whether Redis can be reached", bool(gauges))
        yield from gauges

    def _active(self) -> int:
        count: Any = self.queue.redis.zcard(self.queue.records.keys.active)
        return int(count)


def _is_static(scope: Mapping[str, Any]) -> bool:
    return str(scope.get("path", "")).startswith("/static/")


def _gauge(name: str, text: str, value: float, **labels: str) -> GaugeMetricFamily:
    family = GaugeMetricFamily(name, text, labels=list(labels))
    family.add_metric(list(labels.values()), value)
    return family
