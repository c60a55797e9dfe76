"""Rising precision for questions that balls may leave open, and the error beyond its limit."""

import pytest
from flint import arb, ctx

import rpr_solver
from rpr_solver import SolverError, Unproved
from rpr_solver.exact.precision import decided


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
