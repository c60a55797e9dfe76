"""The worker layer: results and jobs in Redis, and the RQ worker processes that compute them."""

from worker.connection import connect
from worker.queue import JobQueue
from worker.records import JobView
from worker.requests import DocumentRequest, JobRequest, TableRequest
from worker.settings import WorkerSettings
from worker.store import ResultStore

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
