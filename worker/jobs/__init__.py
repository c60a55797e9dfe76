"""Jobs and batches in Redis."""

from worker.jobs.plan import InRedis, Lane, QueueFullError, check_lifetimes, lanes_of, queue_name

__all__ = [
    "InRedis",
    "Lane",
    "QueueFullError",
    "check_lifetimes",
    "lanes_of",
    "queue_name",
]
