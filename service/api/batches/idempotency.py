"""Submissions that are repeated: the same Idempotency-Key of one caller gives the same batch, for a day.

After the IETF draft *The Idempotency-Key HTTP Header Field*.
"""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from typing import cast

from fastapi import Request
from redis import Redis

from service.api.access.caller import Caller
from service.api.problems import ProblemError, ProblemType
from worker.jobs.batches import INTAKE_TTL

_KEPT = 86400  # seconds
_NEW = 10  # seconds from the note of a submission to its job, at most
KEY_PATTERN = "[!-~]{1,255}"

# Returns the earlier submission {token, digest, job id}, or nothing: then the key is the caller's.
_CLAIM = """
local earlier = redis.call('HMGET', KEYS[1], 'token', 'digest', 'job')
if earlier[1] then return {earlier[1], earlier[2] or '', earlier[3] or ''} end
redis.call('HSET', KEYS[1], 'token', ARGV[1])
redis.call('EXPIRE', KEYS[1], ARGV[2])
return false
"""

_NOTE = """
local token, digest, job, kept = unpack(ARGV)
redis.call('HSET', KEYS[1], 'token', token, 'digest', digest, 'job', job, 'since', redis.call('TIME')[1])
redis.call('EXPIRE', KEYS[1], kept)
"""

# Forgets a submission; if `after` is given, only one that was noted so many seconds ago.
_RELEASE = """
local token, after = unpack(ARGV)
local owner, since = unpack(redis.call('HMGET', KEYS[1], 'token', 'since'))
if owner ~= token then return end
if after ~= '' and redis.call('TIME')[1] - (since or 0) < tonumber(after) then return end
redis.call('DEL', KEYS[1])
"""


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
        self._claim = redis.register_script(_CLAIM)
        self._note = redis.register_script(_NOTE)
        self._release = redis.register_script(_RELEASE)

    def claim(self, key: str, token: str) -> Submission | None:
        """Take a key for a new batch; returns the submission that has it already, if one has."""
        reply = self._claim(keys=[self._prefix + key], args=[token, INTAKE_TTL])
        return Submission(*(part.decode() for part in cast("list[bytes]", reply))) if reply else None

    def note(self, key: str, submission: Submission) -> None:
        """Note a batch that was received, just before its job is made."""
        args: list[str | int] = [submission.token, submission.digest, submission.job_id, _KEPT]
        self._note(keys=[self._prefix + key], args=args)

    def release(self, key: str, token: str) -> None:
        """Forget a batch that does not begin."""
        self._release(keys=[self._prefix + key], args=[token, ""])

    def forget_unless_new(self, key: str, submission: Submission) -> None:
        """Forget a batch that was received, but has no job, since its process died just then."""
        self._release(keys=[self._prefix + key], args=[submission.token, _NEW])


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
