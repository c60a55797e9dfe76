"""The worker layer: results and jobs in Redis, and the RQ worker processes that compute them."""

from worker.answers.store import ResultStore
from worker.connection import connect
from worker.jobs.queue import JobQueue
from worker.jobs.records import JobView
from worker.jobs.requests import DocumentRequest, JobRequest, TableRequest
from worker.settings import WorkerSettings

__all__ = [
    "DocumentRequest",
    "JobQueue",
    "JobRequest",
    "JobView",
    "ResultStore",
    "TableRequest",
    "WorkerSettings",
    "connect",
]
