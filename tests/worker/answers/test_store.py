from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from fractions import Fraction

from redis import Redis

import rpr_solver
from tests.support.jobs import a_request
from worker.answers.kind import JobRequest
from worker.answers.layout import ERROR_TTL, HEAD_BYTES, measured, measured_by, pack, unpack
from worker.answers.store import LOCK_SECONDS, ResultStore
from worker.jobs.attempts import Attempts, Chunk
from worker.jobs.chunks import ChunkEntry, ChunkRef
from worker.settings import WorkerSettings


def keep(store: ResultStore, request: JobRequest, l1: str, value: Mapping[str, object]) -> None:
    """Keep a slice as a worker does, for a job that no longer exists."""
    ref, entry = ChunkRef(request.job_id, "gone", 0, 0), ChunkEntry(0, 1, "small")
    at = request.parts.index(l1)
    chunk = Chunk(request, (at,), 1, counts=True, entry=entry)
    assert not Attempts(store.redis, store.settings, store).put_slices(ref, chunk, [at], [dict(value)])


def slice_of(l1: str, mark: int = 0) -> dict[str, object]:
    return {"l1": l1, "count": mark, "cusps": []}


def test_the_first_result_stays(redis: Redis) -> None:
    store = ResultStore(redis, WorkerSettings())
    request = a_request("1", "2")
    keep(store, request, "1", slice_of("1", 1))
    keep(store, request, "1", slice_of("1", 2))
    assert store.get_slices(request) == {"1": slice_of("1", 1)}


def test_results_are_bounded_in_time_and_errors_more_so(redis: Redis) -> None:
    store = ResultStore(redis, WorkerSettings(result_ttl_seconds=1000))
    request = a_request("1", "2")
    keep(store, request, "1", slice_of("1"))
    keep(store, request, "2", {"l1": "2", "error": {"type": "solver-error", "detail": "no"}})
    good, bad = store.slice_keys(request, request.parts)
    assert 990 < redis.ttl(good) <= 1000
    assert 0 < redis.ttl(bad) <= ERROR_TTL < 1000
    assert set(store.get_slices(request)) == {"1", "2"}
    assert all(redis.ttl(key) > 0 for key in redis.keys("cusps:*"))


def test_another_question_has_other_results(redis: Redis) -> None:
    store = ResultStore(redis, WorkerSettings())
    request = a_request("1")
    keep(store, request, "1", slice_of("1"))
    assert store.get_slices(a_request("1", fixed_leg=2)) == {}
    assert store.get_slices(a_request("1", digits=40)) == {}


def test_more_digits_serve_fewer(redis: Redis) -> None:
    store = ResultStore(redis, WorkerSettings())
    long, short = a_request("14.98", digits=60), a_request("14.98", "15", digits=20)
    eliminant = rpr_solver.eliminate(rpr_solver.EXAMPLES["innocenti"])
    solved = rpr_solver.solve_slice(eliminant, Fraction("14.98"), 60).to_json()
    keep(store, long, "14.98", solved)
    expected = rpr_solver.shorten_slice(solved, 60, 20)
    assert store.get_slices(short) == {"14.98": expected}

    store.renew_slices(short, store.get_slices(short))
    redis.delete(*store.slice_keys(long, long.parts))
    assert store.get_slices(short) == {"14.98": expected}


def test_renewed_slices_last_as_long_as_new_ones(redis: Redis) -> None:
    store = ResultStore(redis, WorkerSettings())
    request = a_request("1")
    keep(store, request, "1", slice_of("1"))
    key = store.slice_keys(request, request.parts)[0]
    redis.expire(key, 5)
    store.renew_slices(request, store.get_slices(request))
    assert redis.ttl(key) > 1000


def test_one_worker_at_a_time_computes_an_eliminant(redis: Redis) -> None:
    store, other = ResultStore(redis, WorkerSettings()), ResultStore(redis, WorkerSettings())
    request = a_request("1")
    with store.eliminant_lock(request) as mine, other.eliminant_lock(request) as theirs:
        assert mine
        assert not theirs
    with other.eliminant_lock(request) as held:
        assert held


def test_a_lock_is_renewed_while_it_is_held(redis: Redis) -> None:
    settings, ref = WorkerSettings(), ChunkRef("some", "run", 0, 0)
    store, attempts = ResultStore(redis, settings, holder=ref.rq_id), Attempts(redis, settings)
    request = a_request("1")
    key = store.keys.eliminant_lock(request.geometry_hash, 1)
    with store.eliminant_lock(request):
        redis.expire(key, 1000)
        redis.expire(store.keys.locks(ref.rq_id), 1000)
        attempts.beat(ref, "worker")
        assert redis.ttl(key) <= LOCK_SECONDS
        assert 0 < redis.ttl(store.keys.locks(ref.rq_id)) <= LOCK_SECONDS
    attempts.beat(ref, "worker")
    assert redis.keys("*lock*") == []


def test_a_lock_that_expired_is_not_released_for_its_next_holder(redis: Redis) -> None:
    store, other = ResultStore(redis, WorkerSettings()), ResultStore(redis, WorkerSettings())
    request = a_request("1")
    key = store.keys.eliminant_lock(request.geometry_hash, 1)
    late = ExitStack()
    assert late.enter_context(store.eliminant_lock(request))
    redis.delete(key)  # as its expiry does
    with other.eliminant_lock(request) as held:
        assert held
        late.close()
        assert redis.exists(key)
    assert not redis.exists(key)


def test_the_eliminant_is_kept(redis: Redis) -> None:
    store = ResultStore(redis, WorkerSettings())
    request = a_request("1")
    assert store.get_eliminant(request) is None
    eliminant = rpr_solver.eliminate(rpr_solver.EXAMPLES["innocenti"])
    store.put_eliminant(request, eliminant)
    known = store.get_eliminant(request)
    assert known is not None
    assert known.to_json() == eliminant.to_json()


def test_the_eliminant_of_one_slice_is_not_worth_keeping(redis: Redis) -> None:
    """The first question about a manipulator gets it for its slices, the second stores it."""
    store, request = ResultStore(redis, WorkerSettings()), a_request("1")
    assert store.eliminant(request, slices=4).coefficients.known is None
    assert store.get_eliminant(request) is None
    assert store.eliminant(request, slices=1).coefficients.known is not None
    assert store.get_eliminant(request) is not None
    other = a_request("1", fixed_leg=2)
    assert store.eliminant(other, slices=5).coefficients.known is not None


SLICE = b'{"l1":"14.98","count":1,"cusps":[{"alpha_deg":"12.5"}]}'
ERROR = b'{"l1":"2","error":{"type":"solver-error","detail":"undecided"}}'


def test_a_slice_is_stored_and_read_byte_for_byte() -> None:
    for text in (SLICE, ERROR, SLICE * 100, b""):
        assert unpack(pack(text)) == text


def test_the_head_says_what_the_whole_would() -> None:
    for text in (SLICE, ERROR):
        assert measured_by(pack(text)[:HEAD_BYTES]) == measured(text)
    assert [measured(text).is_error for text in (SLICE, ERROR)] == [False, True]
    assert measured(SLICE).size == len(SLICE)
    assert measured(SLICE).digest != measured(SLICE.replace(b"12.5", b"12.6")).digest


def test_text_takes_half_the_bytes() -> None:
    assert 2 * len(pack(SLICE * 40)) < len(SLICE * 40)
