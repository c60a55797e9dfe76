"""The metrics of the whole installation, read from Redis at each scrape."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Mapping
from itertools import accumulate

from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, HistogramMetricFamily, Metric
from prometheus_client.registry import Collector
from redis.exceptions import RedisError

import rpr_solver
from service import __version__
from service.api import metric_families as families
from service.api.metric_families import Family
from worker.jobs.ends import BOUNDS, Durations, Ends
from worker.jobs.load import Load, read_load
from worker.jobs.queue import JobQueue

log = logging.getLogger("rpr_cusps.service")

_BOUNDS = (*(f"{bound:g}" for bound in BOUNDS), "+Inf")
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
        yield _gauge(families.INFO, {(__version__, str(rpr_solver.SOLVER_VERSION)): 1})
        try:
            load = read_load(self.queue.redis, self.queue.settings)
        except RedisError as error:
            log.warning("metrics without a queue: %s", error)
            yield _gauge(families.UP, {(): 0})
            return
        yield _gauge(families.UP, {(): 1})
        yield from _of_load(load)
        yield from _of_ends(load.ends)


def _of_load(load: Load) -> Iterator[Metric]:
    yield _gauge(families.QUEUE_DEPTH, {(lane.name,): lane.depth for lane in load.lanes})
    yield _gauge(families.QUEUE_AGE, {(lane.name,): lane.age for lane in load.lanes})
    yield _gauge(families.WORKERS, {(): load.workers})
    yield _gauge(families.BEAT_AGE, {(): load.oldest_beat})
    yield _gauge(families.ACTIVE, {(): load.active_jobs})
    yield _gauge(families.SUSPECTED, {(): load.suspected_chunks})
    yield _counter(families.WEBHOOKS, {(state,): count for state, count in load.deliveries.items()})
    yield _gauge(families.MEMORY, {(): load.memory})
    yield _gauge(families.MEMORY_LIMIT, {(): load.memory_limit})


def _of_ends(ends: Ends) -> Iterator[Metric]:
    yield _counter(families.JOBS_ENDED, ends.by_status)
    yield _counter(families.FAILURES, ends.failures)
    yield _counter(families.LOST, {(name,): ends.lost[key] for key, name in _LOST.items()})
    yield _counter(families.OVERRUNS, ends.overruns)
    yield _histogram(families.WAIT, ends.waits)
    yield _histogram(families.RUN, ends.runs)


def _gauge(family: Family, values: Mapping[tuple[str, ...], float]) -> Metric:
    metric = GaugeMetricFamily(family.name, family.meaning, labels=family.labels)
    for labels, value in values.items():
        metric.add_metric(labels, value)
    return metric


def _counter(family: Family, values: Mapping[tuple[str, ...], int]) -> Metric:
    metric = CounterMetricFamily(family.name, family.meaning, labels=family.labels)
    for labels, value in values.items():
        metric.add_metric(labels, value)
    return metric


def _histogram(family: Family, values: Mapping[str, Durations]) -> Metric:
    metric = HistogramMetricFamily(family.name, family.meaning, labels=family.labels)
    for kind, durations in values.items():
        buckets = list(zip(_BOUNDS, accumulate(durations.counts), strict=True))
        metric.add_metric([kind], buckets, durations.seconds)
    return metric
