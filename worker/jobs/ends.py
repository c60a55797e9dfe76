"""How jobs ended, counted in one hash for the whole installation.

A field `n:KIND:STATUS:REASON:WAIT:RUN` counts the jobs that ended alike, where WAIT and RUN are the numbers
of time intervals, so that the end of a job costs one count. `wait:KIND` and `run:KIND` add up the seconds,
and `lost:horses` and `lost:workers` count losses. `overruns:KIND:WHAT` counts chunks that took a few times
their estimate: `given-back` to the heavy lane, or `left` to their worker.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field

from worker.answers.kinds import kind_of_job

BOUNDS = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0)
"""The upper bounds of the time intervals, in seconds; the last interval has none."""

COUNT_END = f"""
local bounds = {{{", ".join(f"{bound:g}" for bound in BOUNDS)}}}

local function interval(seconds)
    for i, bound in ipairs(bounds) do if seconds <= bound then return i - 1 end end
    return #bounds
end

-- Counts a job that ends now; one that never ran has no RUN.
local function count_end(record, ends, job_id, status, problem)
    local created, started = unpack(redis.call('HMGET', record, 'created', 'started'))
    if not created then return end
    local kind = string.match(job_id, '^%a+') or ''
    local reason = status == 'failed' and cjson.decode(problem).type or ''
    local wait, run = (started or now) - created, ''
    if started then
        run = interval(now - started)
        redis.call('HINCRBYFLOAT', ends, 'run:' .. kind, now - started)
    end
    redis.call('HINCRBYFLOAT', ends, 'wait:' .. kind, wait)
    redis.call('HINCRBY', ends, table.concat({{'n', kind, status, reason, interval(wait), run}}, ':'), 1)
end
"""
"""The Lua function that counts an end; it needs `now`."""


@dataclass
class Durations:
    """How many jobs took how long: a count for each interval, and the sum of all seconds."""

    counts: list[int] = field(default_factory=lambda: [0] * (len(BOUNDS) + 1))
    seconds: float = 0.0


@dataclass
class Ends:
    """The jobs that ended and the losses so far, by the name of the kind."""

    by_status: Counter[tuple[str, ...]] = field(default_factory=Counter)
    failures: Counter[tuple[str, ...]] = field(default_factory=Counter)
    waits: defaultdict[str, Durations] = field(default_factory=lambda: defaultdict(Durations))
    runs: defaultdict[str, Durations] = field(default_factory=lambda: defaultdict(Durations))
    lost: Counter[str] = field(default_factory=Counter)
    overruns: Counter[tuple[str, ...]] = field(default_factory=Counter)


def read_ends(fields: Mapping[bytes, bytes]) -> Ends:
    """Returns what the fields of the hash say."""
    ends = Ends()
    for raw, value in fields.items():
        what, kind, *rest = raw.decode().split(":")
        if what == "lost":
            ends.lost[kind] += int(value)
            continue
        known = kind_of_job(f"{kind}-")
        kind = kind if known is None else known.name
        if what == "overruns":
            ends.overruns[kind, rest[0]] += int(value)
        elif what == "wait":
            ends.waits[kind].seconds = float(value)
        elif what == "run":
            ends.runs[kind].seconds = float(value)
        elif what == "n":
            status, reason, wait, run = rest
            count = int(value)
            ends.by_status[kind, status] += count
            ends.waits[kind].counts[int(wait)] += count
            if run:
                ends.runs[kind].counts[int(run)] += count
            if reason:
                ends.failures[kind, reason] += count
    return ends
