"""Rising precision for questions that balls may leave open, and the error beyond its limit."""

import doctest
from itertools import pairwise

import pytest
from flint import arb, ctx
from hypothesis import given
from hypothesis import strategies as st

import rpr_solver
from rpr_solver import SolverError, Unproved, exact
from rpr_solver.exact.precision import decided, decided_or_none, precisions

STARTS = st.integers(1, 1000)


@given(STARTS, st.integers(0, 100_000), st.integers(0, 100_000))
def test_precisions_double_and_stop_once(start: int, limit: int, stop_at: int) -> None:
    tried = list(precisions(start, limit, stop_at=stop_at))
    assert all(bits <= limit for bits in tried)
    assert (start in tried) == (start <= limit)
    assert (stop_at in tried) == (start <= stop_at <= limit)
    for low, high in pairwise(tried):
        assert high == 2 * low or low < high == stop_at < 2 * low
    assert not tried or 2 * tried[-1] > limit


@given(STARTS, st.integers(0, 12), st.integers(0, 12))
def test_the_first_answer_is_taken(start: int, doublings: int, allowed: int) -> None:
    tried: list[int] = []

    def attempt(bits: int) -> int | None:
        tried.append(bits)
        return bits if bits >= start << doublings else None

    answer = decided_or_none(attempt, start, start << allowed)
    assert answer == (start << doublings if doublings <= allowed else None)
    assert tried == [start << i for i in range(min(doublings, allowed) + 1)]


@pytest.mark.parametrize("answer", [0, False, "", [], ()])
def test_an_answer_may_be_false(answer: object) -> None:
    assert decided(lambda _: answer, 1, 1, "never") is answer


def test_what_stays_open_is_refused_by_name() -> None:
    with pytest.raises(Unproved, match="whether 1 is 1"):
        decided(lambda _: None, 64, 1 << 12, "whether 1 is 1")
    assert issubclass(Unproved, SolverError)
    assert "Unproved" in rpr_solver.__all__


def test_a_number_is_decided_as_soon_as_its_ball_is_small() -> None:
    """√2 against its continued fraction: p/q is nearer than 1/q², and q has 1,000 bits."""
    p, q = 1, 1
    while q.bit_length() < 1000:
        p, q = p + 2 * q, p + q

    def sign(bits: int) -> tuple[int, int] | None:
        with ctx.workprec(bits):
            gap = arb(2).sqrt() - arb(p) / q
        return None if gap.contains(0) else (bits, 1 if gap > 0 else -1)

    bits, side = decided(sign, 64, 1 << 14, "never")
    assert side == (1 if p * p < 2 * q * q else -1)
    assert bits == 2048 or (bits == 4096 and 2 * q.bit_length() > 2000)


def test_the_module_s_examples() -> None:
    assert doctest.testmod(exact).failed == 0
