"""Every slice of the reference vectors, to the last of 90 digits; and the article's four tables."""

from decimal import ROUND_DOWN, ROUND_HALF_EVEN, Context, Decimal
from functools import cache

import mpmath as mp
import pytest

from rpr_solver import EXAMPLES, Eliminant, Manipulator, eliminate, parse_exact, solve_slice
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


ARTICLE_TABLES = {
    ("innocenti", "14.98"): """
        50.67 -69.12 0.84 3.77;   -2.59 177.32 13.85 6.26;  -122.89 114.05 31.27 16.17;
        57.48 133.77 30.44 26.61; -0.59 15.46 16.02 29.56;  170.37 -10.65 17.98 26.44""",
    ("innocenti", "34"): """
        -3.84 -167.01 33.22 19.00; 52.71 -61.76 19.46 22.68; -1.07 15.43 35.00 48.64;
        55.85 128.19 49.14 45.52""",
    ("innocenti", "27"): """
        -0.95 15.47 28.01 41.63;   56.20 129.36 42.21 38.54;  -5.11 -168.45 26.31 11.84;
        52.23 -63.22 12.56 15.71;
        -168.17 8.70 5.92 29.74;  -125.54 43.86 7.98 27.36;  -113.95 63.88 13.96 21.66;
        -129.36 103.65 35.57 4.80""",
    # cusp A: the article prints 12.52 for alpha, an erratum
    ("zein-flat", "3"): """
        12.65 -145.11 19.80 29.43; 156.76 -63.48 40.68 31.11; -168.74 26.38 40.08 29.14;
        -20.32 114.01 19.11 27.01""",
}


@pytest.mark.parametrize(("name", "l1"), ARTICLE_TABLES)
def test_the_articles_tables_to_their_printed_truncated_digits(name: str, l1: str) -> None:
    table = solve_slice(eliminate(EXAMPLES[name]), parse_exact(l1, "l1"), 30)
    truncate = Context(prec=30, rounding=ROUND_DOWN)
    ours = {
        tuple(Decimal(x).quantize(Decimal("0.01"), context=truncate) for x in cusp.to_json().values())
        for cusp in table.cusps
    }
    printed = {tuple(map(Decimal, line.split())) for line in ARTICLE_TABLES[name, l1].split(";")}
    assert ours == printed
