"""Proofs modulo a prime."""

from rpr_solver.verify.core.modular import simple_and_apart
from rpr_solver.verify.core.surds import Ring, rational


def test_simple_roots_and_shared_ones() -> None:
    ring = Ring(7)
    simple, other = ((1, 1), (2, 0), (0, 3)), rational([5, 1])
    assert simple_and_apart(ring, simple, other)
    assert not simple_and_apart(ring, ring.product(simple, simple), other)
    assert not simple_and_apart(ring, ring.product(simple, other), other)
    assert simple_and_apart(Ring(1), rational([-2, 0, 1]), other)
