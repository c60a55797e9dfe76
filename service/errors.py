"""The errors of a client of the service."""

from __future__ import annotations


class ServiceError(Exception):
    """The service refused, failed, or cannot be reached; the message is for the user."""

    def __init__(self, message: str, *, is_input: bool = False) -> None:
        super().__init__(message)
        self.is_input = is_input
