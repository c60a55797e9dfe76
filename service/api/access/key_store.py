"""The keys in Redis: one hash for their records, one for the times of their last use."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, fields, replace
from typing import Any, cast

from redis import Redis
from redis.client import Pipeline

from service.api.access.keys import ApiKey

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
    return {key_id.decode(): _read(json.loads(record)) for key_id, record in records.items()}


def _read(record: Mapping[str, Any]) -> ApiKey:
    """A key, without what a newer release may say of it."""
    return ApiKey(**{name: record[name] for name in _MEMBERS if name in record})
