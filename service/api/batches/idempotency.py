"""Submissions that are repeated: the same Idempotency-Key of one caller gives the same batch, for a day.

After the IETF draft *The Idempotency-Key HTTP Header Field*.
"""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass

from fastapi import Request
from redis import Redis

from service.api.access.caller import Caller
from service.api.problems import ProblemError, ProblemType
from worker.jobs.batches import INTAKE_TTL
from worker.lua import Scripts

_KEPT = 86400  # seconds
_NEW = 10  # seconds from the note of a submission to its job, at most
KEY_PATTERN = "[!-~]{1,255}"


@dataclass(frozen=True)
class Submission:
    """A batch that was submitted with a key: its token, the digest of the body, and its id; the last two are
    empty while it is received."""

    token: str
    digest: str = ""
    job_id: str = ""


class Idempotency:
    """The keys of submissions."""

    def __init__(self, redis: Redis, prefix: str) -> None:
        self._prefix = f"{prefix}:submission:"
        self._run = Scripts(redis, "service.api.batches")

    def claim(self, key: str, token: str) -> Submission | None:
        """Take a key for a new batch; returns the submission that has it already, if one has."""
        name = self._prefix + key
        reply = self._run("claim_submission", submission=name, token=token, ttl=INTAKE_TTL)
        return Submission(*(part.decode() for part in reply)) if reply else None

    def note(self, key: str, submission: Submission) -> None:
        """Note a batch that was received, just before its job is made."""
        self._run("note_submission", vars(submission), submission=self._prefix + key, ttl=_KEPT)

    def release(self, key: str, token: str) -> None:
        """Forget a batch that does not begin."""
        self._run("release_submission", submission=self._prefix + key, token=token, after="")

    def forget_unless_new(self, key: str, submission: Submission) -> None:
        """Forget a batch that was received, but has no job, since its process died just then."""
        name = self._prefix + key
        self._run("release_submission", submission=name, token=submission.token, after=_NEW)


def key_of(request: Request, caller: Caller | None) -> str | None:
    """Returns the name of a submission by its caller and its Idempotency-Key, if it has one.

    Raises:
        ProblemError: 400, it is malformed.
    """
    sent = request.headers.get("idempotency-key")
    if sent is None:
        return None
    if not re.fullmatch(KEY_PATTERN, sent):
        raise ProblemError(
            ProblemType.INVALID_HEADER,
            f"Idempotency-Key {sent[:60]!r} must have 1 to 255 visible ASCII characters, such as a UUID.",
            errors=[("Idempotency-Key", "send 1 to 255 visible ASCII characters")],
        )
    who = "unknown" if caller is None else caller.id
    return hashlib.sha256(f"{who}\n{sent}".encode()).hexdigest()
