"""Roots on the unit circle, and discs that hold one each."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES
from rpr_solver.exact.real_roots import real_roots
from rpr_solver.slices.fast.proofs import disjoint_discs_inside, guesses
from tests.support.shared import eliminant_of
from tests.support.strategies import examples


def test_guesses_are_the_roots() -> None:
    eliminant = eliminant_of(EXAMPLES["innocenti"])
    lengths = [n * eliminant.slice_map.scale for n in (2, 10, 27, 60)]
    for length, guess in zip(lengths, guesses(eliminant, lengths), strict=True):
        roots = real_roots(eliminant.at(length))
        assert len(roots) + 2 * guess.inside == 24
        assert sorted(n / d for n, d in guess.real) == pytest.approx([float(x.refined(60)) for x in roots])


@given(st.integers(0, 2**32), st.sampled_from([1e-15, 1e-9, 1e-3, 0.1, 1.0]), st.integers(0, 12))
@examples(60)
def test_no_disc_is_claimed_that_holds_no_root(seed: int, noise: float, count: int) -> None:
    """For forms with known roots: as many roots are inside the circle as are claimed, or more."""
    rng = np.random.default_rng(seed)
    inside = rng.uniform(0, 1.2, count) ** 0.3 * np.exp(2j * np.pi * rng.uniform(size=count))
    inside = inside[abs(inside) < 1]
    on = np.exp(2j * np.pi * rng.uniform(size=24 - 2 * len(inside)))
    roots = np.concatenate((inside, 1 / inside.conj(), on))
    p = np.poly(roots)[::-1]
    p = p[None] / abs(p).max()
    z = inside + noise * (rng.normal(size=len(inside)) + 1j * rng.normal(size=len(inside)))
    z = np.concatenate((z, z[: rng.integers(0, 2)]))[None]  # one of them perhaps twice
    chosen = np.ones(z.shape, bool)
    sums = abs(p.real) + abs(p.imag)
    [claimed] = disjoint_discs_inside((p.real, p.imag), sums, z, chosen)
    assert claimed in (0, z.shape[1])
    assert claimed <= len(inside)
