"""Batches: many questions in one job, whose parts are items."""

from __future__ import annotations

import secrets

from worker.answers.requests import JobRequest, Kind

KIND = Kind("batch", "ba-", unit="items", by_items=True)


def new_batch() -> str:
    """Returns the token that distinguishes a batch from all others."""
    return secrets.token_hex(16)


def batch_request(token: str, count: int = 0) -> JobRequest:
    """Returns the request for the job of a batch; a batch is one submission, whatever its items are."""
    return JobRequest(KIND, {"batch": token, "count": count})
