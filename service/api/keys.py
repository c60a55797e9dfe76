"""API keys: random, shown once, and kept in Redis as a hash."""

from __future__ import annotations

import hashlib
import hmac
import json
import re
import secrets
import string
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, fields, replace
from typing import Any, Literal, cast

import anyio
from redis import Redis
from redis.client import Pipeline
from redis.exceptions import ConnectionError as RedisConnectionError
from redis.exceptions import RedisError

from service.api.settings import SCOPES, KeyScope
from service.api.threads import RedisAccess

State = Literal["valid", "expired", "revoked"]

_ALPHABET = string.digits + string.ascii_letters  # a double click selects the whole key
_ID_LENGTH, _SECRET_LENGTH = 8, 43  # 62^43 > 2^256
_TOKEN = re.compile(rf"rpr_([0-9A-Za-z]{{{_ID_LENGTH}}})_([0-9A-Za-z]{{{_SECRET_LENGTH}}})", re.ASCII)
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._@+\-]{0,63}", re.ASCII)


@dataclass(frozen=True)
class ApiKey:
    """What is known of a key once it has been shown. Times are seconds since 1970."""

    id: str
    name: str
    scope: KeyScope
    digest: str
    created: float
    expires: float | None = None
    revoked: float | None = None

    def state(self, now: float) -> State:
        """Returns whether the key opens anything."""
        if self.revoked is not None:
            return "revoked"
        return "valid" if self.expires is None or now < self.expires else "expired"

    def matches(self, token: str) -> bool:
        """Whether this is the record of `token`; takes the same time for every wrong secret."""
        return hmac.compare_digest(self.digest, _digest(token))


def allows(held: KeyScope, needed: KeyScope) -> bool:
    """Whether a scope includes another.

    >>> allows("submit", "read"), allows("submit", "admin")
    (True, False)
    """
    return SCOPES.index(held) >= SCOPES.index(needed)


def make_key(name: str, scope: KeyScope, now: float, expires: float | None = None) -> tuple[ApiKey, str]:
    """Returns the record of a new key and the key itself, which is in no record."""
    key_id = _random(_ID_LENGTH)
    token = f"rpr_{key_id}_{_random(_SECRET_LENGTH)}"
    return ApiKey(key_id, name, scope, _digest(token), now, expires), token


def id_of(token: str) -> str | None:
    """Returns the public part of a key, or None if the text is no key.

    >>> id_of("rpr_4fQ8aZ0k_" + 43 * "x")
    '4fQ8aZ0k'
    """
    match = _TOKEN.fullmatch(token)
    return None if match is None else match[1]


def is_name(text: str) -> bool:
    """Whether a key can have this name.

    >>> is_name("calibration-rig.2"), is_name("-x"), is_name("two words")
    (True, False, False)
    """
    return _NAME.fullmatch(text) is not None


def _random(length: int) -> str:
    return "".join(secrets.choice(_ALPHABET) for _ in range(length))


def _digest(token: str) -> str:
    return hashlib.sha256(token.encode()).hexdigest()


_MEMBERS = [member.name for member in fields(ApiKey)]


class KeyStore:
    """The keys of one installation. A revoked key keeps its record, for its name and times."""

    def __init__(self, redis: Redis, prefix: str) -> None:
        self.redis = redis
        self._records = f"{prefix}:api-keys"
        self._uses = f"{prefix}:api-keys:used"

    def all(self) -> dict[str, ApiKey]:
        """Returns every key that was made, by its id."""
        records = cast("dict[bytes, bytes]", self.redis.hgetall(self._records))
        return _parsed(records)

    def add(self, key: ApiKey, now: float) -> bool:
        """Keep a new key; returns False if a valid key has its name already."""

        def step(pipe: Pipeline) -> Any:
            known = _parsed(cast("dict[bytes, bytes]", pipe.hgetall(self._records)))
            free = not any(other.name == key.name and other.state(now) == "valid" for other in known.values())
            pipe.multi()
            if free:
                pipe.hset(self._records, key.id, _dump(key))
            return free

        return bool(self.redis.transaction(step, self._records, value_from_callable=True))

    def revoke(self, name_or_id: str, now: float) -> ApiKey | None:
        """Revoke the valid key of this name or id; returns it, or None if there is none."""
        for key in self.all().values():
            if name_or_id in (key.name, key.id) and key.state(now) == "valid":
                revoked = replace(key, revoked=now)
                self.redis.hset(self._records, key.id, _dump(revoked))
                return revoked
        return None

    def note_use(self, key_id: str, now: float) -> None:
        """Note that a key was used."""
        self.redis.hset(self._uses, key_id, f"{now:.0f}")

    def last_uses(self) -> Mapping[str, float]:
        """Returns the time of the last use of each key that was used, to about a minute."""
        uses = cast("dict[bytes, bytes]", self.redis.hgetall(self._uses))
        return {key_id.decode(): float(moment) for key_id, moment in uses.items()}


def _dump(key: ApiKey) -> str:
    return json.dumps(asdict(key))


def _parsed(records: Mapping[bytes, bytes]) -> dict[str, ApiKey]:
    """Returns the keys by their ids, without members that a newer release may have added."""
    read = {key_id.decode(): json.loads(record) for key_id, record in records.items()}
    return {key_id: ApiKey(**{x: kept[x] for x in _MEMBERS if x in kept}) for key_id, kept in read.items()}


_MAX_AGE = 2.0
"""Seconds after which a revoked key opens nothing any more, in any process."""

_RELOAD_INTERVAL = 0.2
"""At most one reload in this time for unknown keys, which may have just been created."""

_USE_INTERVAL = 60.0


class KeyRing:
    """Finds the record of a key."""

    def __init__(self, store: KeyStore, ask: RedisAccess) -> None:
        self.store = store
        self._ask = ask
        self._keys: Mapping[str, ApiKey] | None = None
        self._loaded = float("-inf")
        self._failed = float("-inf")
        self._noted: dict[str, float] = {}
        self._lock = anyio.Lock()

    async def is_empty(self) -> bool:
        """Whether no key was ever made."""
        return not await self._known(time.monotonic() - _MAX_AGE)

    async def find(self, token: str) -> ApiKey | None:
        """Returns the record of a key that is valid now, or None."""
        key_id = id_of(token)
        if key_id is None:
            return None
        moment = time.monotonic()
        key = (await self._known(moment - _MAX_AGE)).get(key_id)
        if key is None:
            key = (await self._known(moment)).get(key_id)
        if key is None or not key.matches(token) or key.state(time.time()) != "valid":
            return None
        await self._note_use(key.id)
        return key

    async def _known(self, since: float) -> Mapping[str, ApiKey]:
        """Returns the keys as they were at the time `since` or later; without Redis, as they were last.

        Raises:
            RedisError: Redis cannot be reached, and never could.
        """
        if self._loaded < since:
            asked = time.monotonic()
            async with self._lock:
                if self._loaded < since:
                    await self._load(asked)
        assert self._keys is not None, "what was loaded is kept"
        return self._keys

    async def _load(self, asked: float) -> None:
        if self._failed > asked:  # while this caller waited for the lock: not each in turn waits for Redis
            raise RedisConnectionError("the keys cannot be read")
        await anyio.sleep(max(0.0, self._loaded + _RELOAD_INTERVAL - time.monotonic()))
        moment = time.monotonic()
        try:
            self._keys = await self._ask(self.store.all)
        except RedisError:
            if self._keys is None:
                self._failed = time.monotonic()
                raise
        self._loaded = moment

    async def _note_use(self, key_id: str) -> None:
        moment = time.monotonic()
        if moment - self._noted.get(key_id, float("-inf")) > _USE_INTERVAL:
            self._noted[key_id] = moment
            with suppress(RedisError):  # a server that takes no more data still answers
                await self._ask(self.store.note_use, key_id, time.time())
