"""Lists of jobs, the newest first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from worker.answers.kinds import is_batch
from worker.jobs.keys import InRedis
from worker.jobs.view import ACTIVE, JobView, Status, view_of
from worker.lua.scripts import VIEW_FIELDS

What = Literal["jobs", "batches"]


_STEP, _STEPS = 100, 5  # how many are looked at at once, and how often for one page


@dataclass(frozen=True)
class Listed:
    """A job in a list.

    Attributes:
        view: its state.
        maker: the client that asked for it first, if it is known.
    """

    view: JobView
    maker: str | None


@dataclass(frozen=True)
class Page:
    """A page of a list; `before` is where the next one begins, None after the last one."""

    items: Sequence[Listed]
    before: str | None


class Listing(InRedis):
    """The lists of jobs."""

    def page(
        self, what: What, client: str | None, statuses: frozenset[Status], before: str, limit: int
    ) -> Page:
        """Returns jobs or batches in one of the states, at most `limit`, made before the time `before`.

        The cost of a page is bounded, so that one may have few items, or none, and yet not be the last one.
        `client`: only what this one asked for.
        """
        index = self.keys.listed(what, client)
        if client is None and statuses <= ACTIVE:
            index = self.keys.active
        found: list[Listed] = []
        for _ in range(_STEPS):
            entries = self._entries(index, before)
            for job_id, score, listed in self._read(entries):
                is_asked_for = is_batch(job_id) is (what == "batches")
                if is_asked_for and listed is not None and listed.view.status in statuses:
                    found.append(listed)
                before = score
                if len(found) == limit:
                    return Page(found, before)
            if len(entries) < _STEP:
                return Page(found, None)
        return Page(found, before)

    def _entries(self, index: str, before: str) -> list[tuple[str, str]]:
        raw: Any = self.redis.zrevrangebyscore(
            index, f"({before}" if before else "+inf", "-inf", start=0, num=_STEP, withscores=True
        )
        return [(job_id.decode(), f"{score:.6f}") for job_id, score in raw]

    def _read(self, entries: Sequence[tuple[str, str]]) -> list[tuple[str, str, Listed | None]]:
        with self.redis.pipeline(transaction=False) as pipe:
            for job_id, _ in entries:
                pipe.hmget(self.keys.job(job_id).record, [*VIEW_FIELDS, "maker"])
            records = pipe.execute()
        return [
            (job_id, score, _listed(job_id, fields))
            for (job_id, score), fields in zip(entries, records, strict=True)
        ]


def _listed(job_id: str, fields: list[bytes | None]) -> Listed | None:
    view = view_of(job_id, fields)
    if view is None:
        return None
    maker = fields[-1]
    return Listed(view, maker.decode() if maker else None)
