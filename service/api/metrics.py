"""Metrics in the Prometheus text format: requests are counted, the queue is read at each scrape."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from prometheus_client import (
    CollectorRegistry,
    Counter,
    Gauge,
    Histogram,
    disable_created_metrics,
    generate_latest,
)

from service.api import metric_families as families
from service.api.metric_families import Family
from service.api.queue_metrics import QueueCollector
from worker.answers import tables
from worker.jobs.queue import JobQueue

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"
_BUCKETS = (0.001, 0.002, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30)
_METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})


class Metrics:
    """The metrics of one API process."""

    def __init__(self, queue: JobQueue) -> None:
        disable_created_metrics()  # type: ignore[no-untyped-call]
        self.registry = CollectorRegistry()
        self.requests = Counter(*_words(families.REQUESTS), registry=self.registry)
        self.seconds = Histogram(*_words(families.SECONDS), buckets=_BUCKETS, registry=self.registry)
        self.in_flight = Gauge(*_words(families.IN_FLIGHT), registry=self.registry)
        self.followers = Gauge(*_words(families.FOLLOWERS), registry=self.registry)
        self.tables = Counter(*_words(families.TABLES), registry=self.registry)
        self.answers = Counter(*_words(families.ANSWERS), registry=self.registry)
        self.registry.register(QueueCollector(queue))

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


def _words(family: Family) -> tuple[str, str, tuple[str, ...]]:
    return family.name, family.meaning, family.labels


def _is_static(scope: Mapping[str, Any]) -> bool:
    return str(scope.get("path", "")).startswith("/static/")
