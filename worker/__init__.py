"""The worker layer: results and jobs in Redis, and the RQ worker processes that compute them."""

from worker.answers.requests import JobRequest
from worker.answers.store import ResultStore
from worker.connection import connect
from worker.jobs.queue import JobQueue
from worker.jobs.records import JobView
from worker.settings import WorkerSettings

__all__ = [
    "JobQueue",
    "JobRequest",
    "JobView",
    "ResultStore",
    "WorkerSettings",
    "connect",
]
