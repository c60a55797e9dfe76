"""Jobs of the worker layer: a request to submit, and the wait for a job's end."""

from __future__ import annotations

from rpr_solver import EXAMPLES
from tests.support.processes import until
from worker import JobQueue, JobView, TableRequest


def a_request(*l1: str, digits: int = 30) -> TableRequest:
    manipulator = EXAMPLES["innocenti"]
    return TableRequest(manipulator.to_json(), manipulator.geometry_hash, 1, digits, l1)


def ended(queue: JobQueue, job_id: str, seconds: float = 30.0) -> JobView:
    """The job when it has come to its end."""

    def terminal() -> JobView | None:
        view = queue.get(job_id)
        assert view is not None, "there is no such job"
        return view if view.is_terminal else None

    return until(terminal, seconds)
