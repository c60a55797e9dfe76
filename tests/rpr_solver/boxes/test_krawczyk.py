"""Krawczyk's test: radii that pass hold the one zero, and none pass where the equations may be singular."""

import numpy as np
from flint import arb
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.boxes.krawczyk import Slopes, Two, contracting_radii, contracts
from tests.support.strategies import examples

SMALL = st.floats(-0.4, 0.4)
SHIFTS = st.floats(-1, 1).filter(lambda x: abs(x) > 1e-3)


@given(SMALL, SMALL, SMALL, SMALL, SHIFTS, SHIFTS)
@examples(60)
def test_a_box_that_passes_holds_the_zero(a: float, b: float, c: float, d: float, g: float, h: float) -> None:
    """Of G(x, y) = (x, y) + (a x + b y + g, c x + d y + h), whose slopes are the same everywhere."""
    slopes = (arb(abs(a)), arb(abs(b))), (arb(abs(c)), arb(abs(d)))
    residues = arb(abs(g)), arb(abs(h))
    radii, steepness = contracting_radii(residues, (2 * residues[0], 2 * residues[1]), lambda _: slopes)
    assert radii is not None
    assert contracts(residues, slopes, radii)
    assert not contracts(residues, slopes, (radii[0] / 100, radii[1] / 100))
    assert steepness <= abs(a) + abs(d) + 1e-12
    det = (1 + a) * (1 + d) - b * c
    zero = (-(1 + d) * g + b * h) / det, (c * g - (1 + a) * h) / det
    assert all(abs(x) < radius for x, radius in zip(zero, radii, strict=True))


def test_steep_or_growing_derivatives_do_not_pass() -> None:
    one: Two = (arb(1), arb(1))
    steep: Slopes = ((arb(1), arb(0)), (arb(0), arb(0)))
    assert contracting_radii(one, one, lambda _: steep)[0] is None
    assert contracting_radii(one, one, lambda radii: ((radii[0], arb(0)), (arb(0), radii[1])))[0] is None
    coupled: Slopes = ((arb(0.5), arb(0.6)), (arb(0.6), arb(0.5)))
    radii, steepness = contracting_radii(one, one, lambda _: coupled)
    assert radii is None
    assert steepness > 2


def test_arrays_of_doubles_are_tested_at_once() -> None:
    """The second of three boxes is too small, and the slopes of the third are too great."""
    residues = [np.array([0.1, 0.1, 0.1])] * 2
    slopes = [[np.array([0.4, 0.4, 0.9]), np.array([0.1, 0.1, 0.1])]] * 2
    radii = [np.array([0.3, 0.15, 0.3])] * 2
    assert contracts(residues, slopes, radii).tolist() == [True, False, False]
