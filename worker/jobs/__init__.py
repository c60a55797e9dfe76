"""Jobs and batches in Redis."""

from worker.jobs.keys import InRedis
from worker.jobs.plan import LANES, Lane, QueueFullError, lanes_of, queue_name

__all__ = ["LANES", "InRedis", "Lane", "QueueFullError", "lanes_of", "queue_name"]
