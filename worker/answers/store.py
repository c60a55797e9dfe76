"""Results, immutable and keyed by content: in Redis for a limited time, or in the archive."""

from __future__ import annotations

import hashlib
import json
import logging
import secrets
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from typing import TYPE_CHECKING, Any, TypeVar, cast

import rpr_solver
from rpr_solver.contract import FEW_SLICES
from worker.answers.kind import Document, JobRequest, Kept, SliceJson, Store, single_flight
from worker.answers.layout import (
    AWAY,
    ERROR_TTL,
    HEAD_BYTES,
    Measured,
    ResultKeys,
    address_in,
    dump,
    eliminant_ttl,
    lifetimes,
    measured_by,
    pack,
    unpack,
)
from worker.lua import Scripts

if TYPE_CHECKING:  # the command line needs no server, and its import takes half of its time
    from redis import Redis

    from worker.settings import WorkerSettings


log = logging.getLogger("rpr_cusps.archive")

LOCK_SECONDS = 5.0
"""Seconds for which a lock lives that its holder's worker does not renew: several heartbeats."""


class Values:
    """Values of results, by their keys: in Redis, or in the archive if their addresses are there."""

    def __init__(self, redis: Redis, settings: WorkerSettings, holder: str = "") -> None:
        """`holder` is the chunk in whose name locks are taken; for it, what cannot be read is not known."""
        self.redis = redis
        self.settings = settings
        self.holder = holder
        self.keys = ResultKeys.of(settings)
        self._run = Scripts(redis)

    def keep(self, results: Mapping[str, tuple[int, str | bytes]]) -> None:
        """Keep results under their keys for a number of seconds each: the first of several equal ones."""
        values = [part for lifetime_and_value in results.values() for part in lifetime_and_value]
        self._run("keep", results=list(results), values=values)

    def _mget(self, keys: Sequence[str]) -> list[bytes | None]:
        return self._resolved(keys, cast("list[bytes | None]", self.redis.mget(keys)))

    def _texts(self, keys: Sequence[str]) -> list[bytes | None]:
        """Returns the JSON of documents, which is packed in the archive only."""
        values = self._mget(keys)
        return [value if value is None or value[:1] == b"{" else unpack(value) for value in values]

    def _resolved(self, keys: Sequence[str], values: list[bytes | None]) -> list[bytes | None]:
        """Returns the values, those in the archive packed; None for one that is lost, whose address goes."""
        away = [i for i, value in enumerate(values) if value is not None and value[:1] == AWAY]
        if not away:
            return values
        from worker.answers.archive import ArchiveAwayError, archive_of

        addresses = [cast(bytes, values[i]) for i in away]
        try:
            found = archive_of(self.settings).read([address_in(address) for address in addresses])
        except ArchiveAwayError:
            if not self.holder:
                raise
            found = [None] * len(away)  # then it is computed again
        else:
            self._forget([(keys[i], x) for i, x, p in zip(away, addresses, found, strict=True) if p is None])
        for i, packed in zip(away, found, strict=True):
            values[i] = packed
        return values

    def _forget(self, lost: Sequence[tuple[str, bytes]]) -> None:
        """Remove addresses under which the archive has nothing any more, or something else."""
        if not lost:
            return
        log.warning("the archive lost %d answers, the first of them %s", len(lost), lost[0][0])
        values = [part for _, old in lost for part in (hashlib.sha1(old).hexdigest(), b"")]
        self._run("replace", results=[key for key, _ in lost], ttl=0, values=values)
        self.redis.hincrby(self.keys.archive, "lost", len(lost))


T = TypeVar("T")

_MEASURED_AT_ONCE = 512


class SliceStore(Values, Store):
    """The slices of tables, each under its content."""

    def slice_keys(self, request: JobRequest, l1: Sequence[str], digits: int | None = None) -> list[str]:
        """Returns the keys of slices of a request, at its own or another number of digits."""
        at = request.digits if digits is None else digits
        return [self.keys.slice(request.geometry_hash, request.fixed_leg, at, x) for x in l1]

    def get_slices(self, request: JobRequest, l1: Sequence[str] | None = None) -> dict[str, SliceJson]:
        """Returns the known slices of a request (or those of `l1`), by L1.

        This takes one round trip if all are known with exactly these digits. Slices known with more digits
        are shortened if the stored digits suffice for correct rounding.
        """
        slices = request.parts if l1 is None else l1
        if not slices:
            return {}
        with self.redis.pipeline(transaction=False) as pipe:
            pipe.mget(self.slice_keys(request, slices))
            pipe.smembers(self.keys.digits(request.geometry_hash, request.fixed_leg))
            values, digits = pipe.execute()
        known = _parse(slices, self._resolved(self.slice_keys(request, slices), values))
        for more in sorted(d for d in map(int, digits) if d > request.digits):
            missing = [x for x in slices if x not in known]
            if not missing:
                break
            longer = _parse(missing, self._mget(self.slice_keys(request, missing, more)))
            for x, value in longer.items():
                short = None if "error" in value else rpr_solver.shorten_slice(value, more, request.digits)
                if short is not None:
                    known[x] = short
        return known

    def get_texts(self, request: JobRequest, l1: Sequence[str], digits: int) -> dict[str, bytes]:
        """Returns the JSON of the slices that are stored with exactly these digits, by L1."""
        if not l1:
            return {}
        values = self._mget(self.slice_keys(request, l1, digits))
        return {x: unpack(value) for x, value in zip(l1, values, strict=True) if value is not None}

    def get_all_texts(self, requests: Sequence[JobRequest]) -> Iterator[dict[str, bytes]]:
        """Yields the same for all slices of each of several requests, which are read at once."""
        keys = [key for request in requests for key in self.slice_keys(request, request.parts)]
        values = iter(self._mget(keys) if keys else ())
        for request in requests:
            pairs = zip(request.parts, values, strict=False)
            yield {x: unpack(value) for x, value in pairs if value is not None}

    def measure(self, request: JobRequest, l1: Sequence[str]) -> dict[str, Measured]:
        """Returns the sizes and digests of the known slices, by L1; reads only those in the archive.

        They might be lost there, and a table that is begun must have them all.
        """
        found: dict[str, Measured] = {}
        for first in range(0, len(l1), _MEASURED_AT_ONCE):
            group = l1[first : first + _MEASURED_AT_ONCE]
            keys = self.slice_keys(request, group)
            with self.redis.pipeline(transaction=False) as pipe:
                for key in keys:
                    pipe.getrange(key, 0, HEAD_BYTES - 1)
                heads = pipe.execute()
            away = [key for key, head in zip(keys, heads, strict=True) if head[:1] == AWAY]
            values = self._mget(away) if away else []
            lost = {key for key, value in zip(away, values, strict=True) if value is None}
            known = zip(group, keys, heads, strict=True)
            found |= {x: measured_by(head) for x, key, head in known if head and key not in lost}
        return found

    def more_digits(self, request: JobRequest) -> list[int]:
        """Returns the larger numbers of digits with which slices of this geometry are stored, ascending."""
        key = self.keys.digits(request.geometry_hash, request.fixed_leg)
        return sorted(d for d in map(int, cast("set[bytes]", self.redis.smembers(key))) if d > request.digits)

    def renew_slices(self, request: JobRequest, slices: Mapping[str, SliceJson]) -> None:
        """Renew the lifetime of known slices, so that a job's table stays complete.

        Slices that were shortened from more digits are also kept at the request's own digits.
        """
        if not slices:
            return
        answers = {l1: value for l1, value in slices.items() if "error" not in value}
        are_known = self.renew(self.slice_keys(request, list(answers))) if answers else []
        new = {
            l1: value
            for (l1, value), is_known in zip(answers.items(), are_known, strict=True)
            if not is_known
        }
        if new:
            self.put_slices(request, new)

    def renew(self, keys: Sequence[str]) -> list[bool]:
        """Renew the lifetime of results; returns which of them are known."""
        ttl = self.settings.result_ttl_seconds
        return [bool(is_known) for is_known in self._run("renew", results=keys, ttl=ttl)]

    def put_slices(self, request: JobRequest, slices: Mapping[str, SliceJson]) -> None:
        """Keep slices of a request, or the errors in their place."""
        self.put_tables([(request, slices)])

    def put_tables(self, tables: Iterable[tuple[JobRequest, Mapping[str, SliceJson]]]) -> None:
        """Keep slices of several requests, of each at most some hundreds, in one step."""
        ttl, results = self.settings.result_ttl_seconds, {}
        with self.redis.pipeline(transaction=False) as pipe:
            for request, slices in tables:
                for key, value in zip(self.slice_keys(request, list(slices)), slices.values(), strict=True):
                    results[key] = (ERROR_TTL if "error" in value else ttl, packed(value))
                known = self.keys.digits(request.geometry_hash, request.fixed_leg)
                pipe.sadd(known, request.digits)
                pipe.expire(known, lifetimes(self.settings)[-1])
            pipe.execute()
        self.keep(results)


class ResultStore(SliceStore):
    """Slices, eliminants and documents. All state is in Redis; an instance is cheap and may be shared."""

    keeps = True

    def get_eliminant(self, request: JobRequest) -> rpr_solver.Eliminant | None:
        """Returns the geometry's eliminant, or None if it is not known."""
        raw = self.redis.get(self.keys.eliminant(request.geometry_hash, request.fixed_leg))
        return None if raw is None else rpr_solver.Eliminant.from_json(json.loads(cast(bytes, raw)))

    def has_eliminant(self, request: JobRequest) -> bool:
        """Whether the geometry's eliminant is known."""
        return bool(self.redis.exists(self.keys.eliminant(request.geometry_hash, request.fixed_leg)))

    def put_eliminant(self, request: JobRequest, eliminant: rpr_solver.Eliminant) -> None:
        """Keep the eliminant of the request's geometry."""
        of, ttl = (request.geometry_hash, request.fixed_leg), eliminant_ttl(self.settings)
        with self.redis.pipeline(transaction=False) as pipe:
            pipe.set(self.keys.eliminant(*of), dump(eliminant.to_json()), ex=ttl)
            pipe.set(self.keys.eliminant_use(*of), 1, ex=ttl)
            pipe.execute()

    def eliminant(self, request: JobRequest, slices: int = 1) -> rpr_solver.Eliminant:
        """Returns the manipulator's eliminant for a number of slices.

        It is computed in one worker at a time and stored, unless only few slices of the manipulator were ever
        asked for: then its coefficients are not worth their cost.
        """
        if slices <= FEW_SLICES and self._is_first_use(request):
            return super().eliminant(request)

        def make() -> rpr_solver.Eliminant:
            eliminant = super(ResultStore, self).eliminant(request)
            self.put_eliminant(request, eliminant)
            return eliminant

        return single_flight(lambda: self.get_eliminant(request), lambda: self.eliminant_lock(request), make)

    def _is_first_use(self, request: JobRequest) -> bool:
        """Whether the eliminant was not asked for before, so that it is not known; notes that it was."""
        key = self.keys.eliminant_use(request.geometry_hash, request.fixed_leg)
        return bool(self.redis.set(key, 1, nx=True, ex=eliminant_ttl(self.settings)))

    def get_documents(self, requests: Sequence[JobRequest]) -> list[Document | None]:
        """Returns documents that were computed in one piece, or None for those that are not known."""
        texts = self._texts([self.keys.document(request.content_hash) for request in requests])
        return [None if text is None else Kept(text) for text in texts]

    def get_text(self, content_hash: str) -> bytes | None:
        """Returns the JSON of the same, as it is kept, by the hash of the question."""
        return self._texts([self.keys.document(content_hash)])[0]

    def document(self, request: JobRequest, compute: Callable[[], Document]) -> Document:
        """Returns a document from the store, or computes and keeps it; only one worker at a time does so."""

        def make() -> Document:
            document = compute()
            self.put_document(request, document)
            return document

        lock = self.keys.document_lock(request.content_hash)
        return single_flight(lambda: self.get_document(request), lambda: self._lock(lock), make)

    def put_document(self, request: JobRequest, document: Mapping[str, Any]) -> None:
        """Keep a document, the first of several."""
        text = document.text if isinstance(document, Kept) else dump(document)
        key = self.keys.document(request.content_hash)
        self.keep({key: (self.settings.result_ttl_seconds, text)})

    def answer_lock(self, request: JobRequest) -> AbstractContextManager[bool]:
        """Try to lock the answer to a question; gives False if another worker holds the lock."""
        return self._lock(self.keys.answer_lock(request.content_hash))

    def renew_document(self, request: JobRequest) -> bool:
        """Renew the lifetime of a known document; returns False if it is not known."""
        return self.renew([self.keys.document(request.content_hash)])[0]

    def note_census(self, family: JobRequest, digits: int) -> None:
        """Note that a census of this family is known with this number of digits."""
        key = self.keys.census_digits(family.content_hash)
        with self.redis.pipeline(transaction=False) as pipe:
            pipe.sadd(key, digits)
            pipe.expire(key, lifetimes(self.settings)[-1])
            pipe.execute()

    def census_digits(self, family: JobRequest) -> list[int]:
        """Returns the numbers of digits of the kept censuses of this family, ascending."""
        members = cast("set[bytes]", self.redis.smembers(self.keys.census_digits(family.content_hash)))
        return sorted(map(int, members))

    def eliminant_lock(self, request: JobRequest) -> AbstractContextManager[bool]:
        """Try to lock the computation of the eliminant; gives False if another worker holds the lock."""
        return self._lock(self.keys.eliminant_lock(request.geometry_hash, request.fixed_leg))

    @contextmanager
    def _lock(self, key: str) -> Iterator[bool]:
        """The lock ends with its time, unless the worker of its holder renews it.

        If it ends too early, or is freed just when it has, another worker computes the same: no harm is done.
        """
        locks, token = self.keys.locks(self.holder), secrets.token_hex(8).encode()
        milliseconds = int(1000 * LOCK_SECONDS)
        held = bool(self.redis.set(key, token, nx=True, px=milliseconds))
        try:
            if held:
                with self.redis.pipeline(transaction=False) as pipe:
                    pipe.sadd(locks, key)
                    pipe.pexpire(locks, milliseconds)
                    pipe.execute()
            yield held
        finally:
            if held:
                self.redis.srem(locks, key)
                if self.redis.get(key) == token:
                    self.redis.delete(key)


def packed(value: Mapping[str, Any]) -> bytes:
    """Returns a slice, or the error in its place, as it is stored."""
    return pack(dump(value).encode())


def _parse(l1: Sequence[str], values: Sequence[bytes | None]) -> dict[str, SliceJson]:
    return {x: json.loads(unpack(value)) for x, value in zip(l1, values, strict=True) if value is not None}
