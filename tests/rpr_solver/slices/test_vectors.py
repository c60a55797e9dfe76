"""Every slice of the reference vectors, to the last of 90 digits."""

from decimal import ROUND_HALF_EVEN, Context, Decimal
from functools import cache

import mpmath as mp
import pytest

from rpr_solver import Eliminant, Manipulator, eliminate, parse_exact, solve_slice
from tests.support.article import coalescence, pose, singularity
from tests.support.reference import CASES

SLICES = {
    f"{case['name']}-{item['l1']}": (case["geometry"], item) for case in CASES for item in case["slices"]
}


@cache
def eliminant_of(geometry: tuple[tuple[str, str], ...]) -> Eliminant:
    return eliminate(Manipulator.from_json(dict(geometry)))


@pytest.mark.parametrize(("geometry", "expected"), SLICES.values(), ids=SLICES)
def test_reference_slice(geometry: dict[str, str], expected: dict[str, object]) -> None:
    eliminant = eliminant_of(tuple(geometry.items()))
    slice_json = solve_slice(eliminant, parse_exact(str(expected["l1"]), "l1"), 90).to_json()
    assert slice_json["count"] == expected["count"]
    nearest = Context(prec=90, rounding=ROUND_HALF_EVEN)
    for cusp, truth in zip(slice_json["cusps"], expected["cusps"], strict=True):  # type: ignore[call-overload]
        assert cusp.keys() == truth.keys()
        for key, text in cusp.items():
            assert Decimal(text) == nearest.create_decimal(truth[key]), key
            assert len(text.lstrip("-0.").replace(".", "")) == 90
    with mp.workdps(100):
        for cusp in slice_json["cusps"]:  # type: ignore[attr-defined]
            at = pose(eliminant.manipulator, str(expected["l1"]), cusp["alpha_deg"], cusp["theta1_deg"])
            assert abs(singularity(eliminant.manipulator, at)) < mp.mpf(10) ** -80
            assert abs(coalescence(eliminant.manipulator, at)) < mp.mpf(10) ** -80
            for length, text in zip(at.lengths[1:], (cusp["l2"], cusp["l3"]), strict=True):
                assert abs(length - mp.mpf(text)) < mp.mpf(10) ** -85 * length
