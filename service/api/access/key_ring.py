"""The keys as one process knows them, a few seconds old at most, so that cached answers stay fast."""

from __future__ import annotations

import time
from collections.abc import Mapping
from contextlib import suppress

import anyio
from redis.exceptions import ConnectionError as RedisConnectionError
from redis.exceptions import RedisError

from service.api.access.keys import ApiKey, KeyStore, id_of
from service.api.threads import RedisAccess

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
