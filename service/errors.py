"""The errors of a client of the service."""

from __future__ import annotations


class ServiceError(Exception):
    """The service refused, failed, or cannot be reached; the message is for the user.

    Attributes:
        is_input: whether the request was at fault.
        status: the status of the response, if there was one.
        problem: its type of problem, such as "job-timeout", or "".
    """

    def __init__(
        self, message: str, *, is_input: bool = False, status: int | None = None, problem: str = ""
    ) -> None:
        super().__init__(message)
        self.is_input, self.status, self.problem = is_input, status, problem


class JobInterrupted(KeyboardInterrupt):
    """Ctrl-C while a job was awaited; the message says what became of the job."""
