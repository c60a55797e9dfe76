"""The jobs of an installation, the newest first.

An index by time has every job that was made, another one every batch, and each client has two of its own.
They are sorted sets beside the set of active jobs, and hold so many only; a job that is kept longer than it
is listed can still be asked for by its id.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from redis import Redis

from worker.jobs.announcements import VIEW_FIELDS
from worker.jobs.keys import Keys
from worker.jobs.views import ACTIVE, JobView, Status, view_of
from worker.settings import WorkerSettings

What = Literal["jobs", "batches"]

MOST, MOST_OF_CLIENT = 20_000, 2_000
"""How many jobs, and how many batches, are listed; and of these, of one client."""

_TTL = 30 * 86400
_STEP, _STEPS = 100, 5  # how many are looked at at once, and how often for one page

LIST = f"""
local function list_in(index, job_id, most)
    redis.call('ZADD', index, now, job_id)
    redis.call('ZREMRANGEBYRANK', index, 0, -most - 1)
    redis.call('EXPIRE', index, {_TTL})
end

local function index_of(active, job_id)
    return active .. ':made:' .. (string.find(job_id, '^ba%-') and 'batches' or 'jobs')
end

-- Lists a job that begins, or begins again.
local function list_job(active, job_id) list_in(index_of(active, job_id), job_id, {MOST}) end

-- Lists a job for the client of a subscription; the first one is its maker.
local function list_for(record, active, job_id, name)
    local client = string.match(name, '^[^#]*')
    redis.call('HSETNX', record, 'maker', client)
    list_in(index_of(active, job_id) .. ':' .. client, job_id, {MOST_OF_CLIENT})
end
"""
"""The Lua functions that list jobs; they need `now`."""


@dataclass(frozen=True)
class Listed:
    """A job in a list.

    Attributes:
        view: its state.
        maker: the client that asked for it first, if it is known.
        runs_s: the seconds for which it has run; None if it has not begun.
    """

    view: JobView
    maker: str | None
    runs_s: float | None


@dataclass(frozen=True)
class Page:
    """A page of a list; `before` is where the next one begins, None after the last one."""

    items: Sequence[Listed]
    before: str | None


class Listing:
    """The lists of jobs."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.keys = Keys.of(settings)

    def page(
        self, what: What, client: str | None, statuses: frozenset[Status], before: str, limit: int
    ) -> Page:
        """Returns jobs or batches in one of the states, at most `limit`, made before the time `before`.

        The cost of a page is bounded, so that one may have few items, or none, and yet not be the last one.
        `client`: only what this one asked for.
        """
        index = f"{self.keys.active}:made:{what}" + ("" if client is None else f":{client}")
        if client is None and statuses <= ACTIVE:
            index = self.keys.active
        found: list[Listed] = []
        for _ in range(_STEPS):
            entries = self._entries(index, before)
            for job_id, score, listed in self._read(entries):
                if listed is not None and listed.view.status in statuses and is_one(job_id, what):
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
            pipe.time()
            for job_id, _ in entries:
                pipe.hmget(self.keys.job(job_id).record, [*VIEW_FIELDS, "maker"])
            (seconds, micros), *records = pipe.execute()
        now = seconds + micros / 1e6
        return [
            (job_id, score, _listed(job_id, fields, now))
            for (job_id, score), fields in zip(entries, records, strict=True)
        ]


def is_one(job_id: str, what: What) -> bool:
    """Whether a job is one of those that are listed: a batch, or not."""
    return job_id.startswith("ba-") is (what == "batches")


def _listed(job_id: str, fields: list[bytes | None], now: float) -> Listed | None:
    view = view_of(job_id, fields)
    if view is None:
        return None
    started = dict(zip(VIEW_FIELDS, fields, strict=False))["started"]
    runs = view.run_seconds
    if started is not None and not view.is_terminal:
        runs = max(0.0, now - float(started))
    maker = fields[-1]
    return Listed(view, maker.decode() if maker else None, runs)
