"""The values of results by their keys, wherever they are."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Sequence
from typing import TYPE_CHECKING, cast

from worker.answers.layout import AWAY, ResultKeys, address_in, unpack
from worker.lua import Scripts

if TYPE_CHECKING:  # the command line needs no server, and its import takes half of its time
    from redis import Redis

    from worker.settings import WorkerSettings

log = logging.getLogger("rpr_cusps.archive")


class Values:
    """Values of results, by their keys: in Redis, or in the archive if their addresses are there."""

    def __init__(self, redis: Redis, settings: WorkerSettings, holder: str = "") -> None:
        """`holder` is the chunk in whose name locks are taken; for it, what cannot be read is not known."""
        self.redis = redis
        self.settings = settings
        self.holder = holder
        self.keys = ResultKeys(settings.key_prefix, settings.solver_version)
        self._run = Scripts(redis)

    def keep_text(self, key: str, text: str | bytes, ttl: int) -> None:
        """Keep the first of several equal texts for so many seconds, or longer if it is pinned."""
        self._run("keep_document", document=key, json=text, ttl=ttl)

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
