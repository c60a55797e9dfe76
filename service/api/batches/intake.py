"""The acceptance of a batch: its body is spooled to a file, then read and kept item by item."""

from __future__ import annotations

import hashlib
import re
from collections.abc import AsyncGenerator, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from tempfile import SpooledTemporaryFile
from typing import IO

import anyio
from fastapi import Request
from redis import Redis
from redis.exceptions import RedisError

from rpr_solver.errors import InputError, clipped, shown
from service.api.answer import allowed_url, call_back, media_type_of, too_large
from service.api.batches.bodies import Elements, Sent, lines
from service.api.batches.rows import Rows, read_item
from service.api.caller import Admission, Caller, caller_of, client_of
from service.api.context import Context
from service.api.problems import ProblemError, ProblemType
from service.api.settings import RETRY_SECONDS
from service.schemas.answers import CSV, JSON, NDJSON
from service.schemas.limits import LimitError, Limits
from worker.answers.kinds import Item, new_batch, seconds_after
from worker.jobs.attempts import ItemsLostError
from worker.jobs.batches import INTAKE_TTL, Reception
from worker.jobs.queue import JobQueue
from worker.jobs.records import Client
from worker.jobs.view import JobView
from worker.lua import Scripts

NDJSON_TYPES = (NDJSON, "application/ndjson", "application/jsonl")
MEDIA_TYPES = (JSON, *NDJSON_TYPES, CSV)

_IN_MEMORY = 1 << 20  # bytes of a body; a longer one goes to the disk
_READ_AT_ONCE = 64 << 10  # bytes of a body, or what is left of it, that a thread is given to write
_AT_ONCE = 500  # items that are pushed together
_KEPT_AT_ONCE = 1 << 20  # or bytes


class Intake:
    """The items of one batch so far."""

    def __init__(self, queue: JobQueue, limits: Limits, caller: Caller | None) -> None:
        self.limits = limits
        self.caller = caller
        self.quotas = queue.quotas
        self._admission = Admission(caller, queue.quotas, limits)
        self.token = new_batch()
        self.count = 0
        self._reception = Reception(queue.redis, queue.settings, self.token)
        self._costs: dict[int, float] = {}
        self._work = 0.0
        self._seen: set[str] = set()
        self._ids: dict[str, int] = {}  # id → number of its first item
        self._texts: list[str] = []
        self._waiting = self._size = 0

    @property
    def job_id(self) -> str:
        """The id that the batch will have."""
        return self._reception.job_id

    @property
    def is_full(self) -> bool:
        """Whether it is time to push."""
        return len(self._texts) >= _AT_ONCE or self._waiting >= _KEPT_AT_ONCE

    def take(self, sent: Iterable[Sent]) -> bool:
        """Read the next items until it is time to push; returns False once there are no more.

        Raises:
            LimitError: there are too many, or they are too large once ranges are written out.
        """
        for text in sent:
            limits = self.limits
            if self.count == limits.max_batch_items:
                shown = f"are more than {limits.max_batch_items}"
                raise LimitError.exceeded(limits, "max_batch_items", shown, "items")
            self.check_size(len(text) if isinstance(text, bytes) else 0)
            item = self._named_once(read_item(text, self.count, limits))
            if item.request is not None:
                cost = self._costs[self.count] = seconds_after(item.request, self._seen)
                self._work += cost
            kept = item.to_json()
            self.count += 1
            self._texts.append(kept)
            self._waiting += len(kept)
            self._size += len(kept)
            if self._size > limits.max_batch_bytes:
                shown = f"take {self._size} bytes with their ranges written out"
                raise LimitError.exceeded(limits, "max_batch_bytes", shown, "items")
            if self.is_full:
                return True
        return False

    def _named_once(self, item: Item) -> Item:
        """Returns the item, or a problem in the place of one with the id of an earlier one."""
        if item.id is None:
            return item
        first = self._ids.setdefault(item.id, self.count)
        if first == self.count or item.request is None:
            return item
        fault = f"is {shown(item.id)}, as of items[{first}]; give each item an id of its own, or none"
        problem = ProblemError.of_input(InputError.of(f"items[{self.count}].id", fault))
        return Item(item.id, problem=problem.document(), kind=item.request.kind.name)

    def check_size(self, size: int) -> None:
        """Refuse the next item if it has this number of bytes or more.

        Raises:
            LimitError: it is too long.
        """
        if size > self.limits.max_body_bytes:
            place = f"items[{self.count}]"
            raise LimitError.exceeded(self.limits, "max_body_bytes", f"has {size} bytes or more", place)

    def push(self) -> None:
        """Keep what was read."""
        if self._texts:
            self._reception.push(self._texts)
        self._texts, self._waiting = [], 0

    def begin(self, who: Client) -> JobView:
        """Make the job of the batch, for a client.

        Raises:
            ProblemError: its items were lost meanwhile.
        """
        with _lost_items_reported():
            return self._reception.begin(self.count, self._costs, who)

    def admit(self) -> None:
        """Count the batch as one of the caller's jobs.

        Raises:
            ProblemError: the caller has as many as it may have, or may not compute.
        """
        self._admission.admit(self.job_id, self._work)

    def drop(self) -> None:
        """Forget a batch that does not begin."""
        self._reception.drop()
        if self.caller is not None:
            self.quotas.forget(self.caller.id, self.job_id)


@contextmanager
def _lost_items_reported() -> Iterator[None]:
    try:
        yield
    except ItemsLostError:
        detail = "The items were lost while they were received; send the batch again."
        raise ProblemError(ProblemType.UNAVAILABLE, detail, retry_s=1) from None


async def accept_batch(request: Request, context: Context, callback_url: str | None) -> tuple[JobView, bool]:
    """Accept a batch; returns it, and whether the same submission has made it before.

    Raises:
        ProblemError, InputError, QueueFullError: it is refused.
    """
    queue = context.queue
    media_type = media_type_of(request, MEDIA_TYPES)
    url = allowed_url(context, callback_url)
    caller = caller_of(request.scope)
    key = key_of(request, caller)
    who = client_of(caller)
    intake = Intake(queue, context.settings.limits, caller)
    idempotency = Idempotency(queue.redis, queue.settings.key_prefix)
    if key is not None:
        earlier = await context.redis(idempotency.claim, key, intake.token)
        if earlier is not None:
            return await _repeated(request, context, idempotency, key, earlier), True
    begun = False

    def begin(digest: str) -> JobView:
        nonlocal begun
        intake.push()
        intake.admit()
        if key is not None:
            idempotency.note(key, Submission(intake.token, digest, intake.job_id))
        view = intake.begin(who)
        begun = True
        call_back(context, view.id, who, url)
        return view

    try:
        with SpooledTemporaryFile(_IN_MEMORY) as body:
            digest = await _receive(request, context, body)
            sent = await context.parsing(_items_of, media_type, body, intake)
            await _keep(context, intake, sent)
        if not intake.count:
            raise InputError.of("items", "is empty; send at least one item")
        if isinstance(sent, Elements):
            url = allowed_url(context, callback_url, sent.callback_url)
        return await context.redis(begin, digest), False
    finally:
        if not begun:
            with anyio.CancelScope(shield=True), suppress(RedisError):
                await context.redis(intake.drop)
                if key is not None:
                    await context.redis(idempotency.release, key, intake.token)


async def _receive(request: Request, context: Context, body: IO[bytes]) -> str:
    """Write the body to a file; returns its digest."""
    digest = hashlib.sha256()
    async for piece in _pieces(request, context.settings.limits):
        digest.update(piece)
        await context.parsing(body.write, piece)
    body.seek(0)
    return digest.hexdigest()


async def _keep(context: Context, intake: Intake, items: Iterable[Sent]) -> None:
    iterator = iter(items)
    while await context.parsing(intake.take, iterator):
        await context.redis(intake.push)


async def _repeated(
    request: Request, context: Context, idempotency: Idempotency, key: str, earlier: Submission
) -> JobView:
    """Returns the batch that the same submission made before.

    Raises:
        ProblemError: 409, it is still being received; 422, it had another body.
    """
    digest = hashlib.sha256()
    if earlier.digest:
        async for piece in _pieces(request, context.settings.limits):
            digest.update(piece)
        if digest.hexdigest() != earlier.digest:
            raise ProblemError(
                ProblemType.IDEMPOTENCY_KEY_REUSED,
                "This Idempotency-Key was sent with another body before; use a new key for a new batch.",
                errors=[("Idempotency-Key", "was sent with another body before")],
            )
        view = await context.redis(context.queue.get, earlier.job_id)
        if view is not None:
            return await context.redis(context.queue.with_position, view)
        await context.redis(idempotency.forget_unless_new, key, earlier)
    raise ProblemError(
        ProblemType.SUBMISSION_IN_PROGRESS,
        "A batch with this Idempotency-Key is still being received; ask again in a moment.",
        retry_s=RETRY_SECONDS,
    )


async def _pieces(request: Request, limits: Limits) -> AsyncGenerator[bytes]:
    """Yields the body in pieces that are large enough for a thread, however it is sent."""
    size, held = 0, bytearray()
    async for piece in request.stream():
        size += len(piece)
        if size > limits.max_batch_bytes:
            raise too_large("max_batch_bytes", limits.max_batch_bytes, "more was sent")
        held += piece
        if len(held) >= _READ_AT_ONCE:
            yield bytes(held)
            held.clear()
    if held:
        yield bytes(held)


def _items_of(media_type: str, body: IO[bytes], intake: Intake) -> Iterable[Sent]:
    of = body, intake.limits.max_body_bytes, intake.check_size
    if media_type == CSV:
        return Rows(*of)
    return (line for _, line in lines(*of)) if media_type in NDJSON_TYPES else Elements(*of)


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
            f"Idempotency-Key {clipped(sent)!r} must have 1 to 255 visible ASCII characters, such as a UUID.",
            errors=[("Idempotency-Key", "send 1 to 255 visible ASCII characters")],
        )
    who = "unknown" if caller is None else caller.id
    return hashlib.sha256(f"{who}\n{sent}".encode()).hexdigest()
