from fractions import Fraction
from math import isqrt

import pytest
from flint import fmpz_mat, fmpz_mpoly_ctx, fmpz_poly

from rpr_solver import EXAMPLES, Eliminant, InputError, Manipulator, eliminate
from rpr_solver.exact.biform import BiForm
from rpr_solver.model.slice_map import SliceMap


def exact_resultant(slice_map: SliceMap, length: Fraction) -> tuple[fmpz_poly, fmpz_poly]:
    """Res_t(J, E) at one L by FLINT's own multivariate resultant, as A + omega B."""
    ring = fmpz_mpoly_ctx.get(("t", "u", "w"), "lex")

    def polynomial(form: BiForm) -> object:
        terms: dict[tuple[int, ...], int] = {}
        for i, row in enumerate(form.at(length)):
            for w, part in enumerate((row.a, row.b)):
                for k, c in enumerate(part.coeffs()):
                    terms[i, k, w] = terms.get((i, k, w), 0) + c
        return ring.from_dict({key: c for key, c in terms.items() if c})

    resultant = polynomial(slice_map.singular).resultant(polynomial(slice_map.coalescence), "t")  # type: ignore[attr-defined]
    parts: tuple[dict[int, int], dict[int, int]] = ({}, {})
    for (_, k, w), c in resultant.to_dict().items():
        part = parts[0 if slice_map.rational else w % 2]
        part[k] = part.get(k, 0) + c * slice_map.radicand ** (w // 2)
    a, b = (fmpz_poly([part.get(k, 0) for k in range(max(part, default=0) + 1)]) for part in parts)
    return a, b


@pytest.mark.parametrize("fixed_leg", [1, 2, 3])
@pytest.mark.parametrize("name", EXAMPLES)
def test_the_resultant_is_the_known_factors_times_q(name: str, fixed_leg: int) -> None:
    eliminant = eliminate(EXAMPLES[name], fixed_leg)
    slice_map = eliminant.slice_map
    for length in (Fraction(7, 3) * slice_map.scale, Fraction(20) * slice_map.scale):
        a, b = exact_resultant(slice_map, length)
        known = slice_map.f.collinear() ** 2 * fmpz_poly([1, 0, 1]) ** 9 * slice_map.f.closed(length)
        quotient_a, quotient_b = a / known, b / known
        assert quotient_a * known == a
        assert quotient_b * known == b
        q = eliminant.at(length)
        assert q.degree == 24
        q_a, q_b = q.a, q.b
        # equal up to a rational constant
        assert q_a * quotient_b == q_b * quotient_a
        lead = next(p for p in (q_a, q_b) if p).leading_coefficient()
        other = next(p for p in (quotient_a, quotient_b) if p).leading_coefficient()
        assert (q_a * other, q_b * other) == (quotient_a * lead, quotient_b * lead)


def test_degrees_are_24_in_u_and_10_in_l() -> None:
    eliminant = eliminate(EXAMPLES["innocenti"])
    assert (eliminant.a.nrows(), eliminant.a.ncols()) == (25, 11)
    assert any(eliminant.a[24, k] for k in range(11))
    assert any(eliminant.a[k, 10] for k in range(25))


def test_a_cached_eliminant_reads_back() -> None:
    eliminant = eliminate(EXAMPLES["innocenti"])
    again = Eliminant.from_json(eliminant.to_json())
    assert (again.a, again.b, again.slice_map) == (eliminant.a, eliminant.b, eliminant.slice_map)


def test_an_eliminant_of_another_version_is_not_taken() -> None:
    stored = eliminate(EXAMPLES["zein-flat"]).to_json()
    with pytest.raises(ValueError, match="version"):
        Eliminant.from_json({**stored, "solver_version": "0"})


def test_a_rational_height_needs_no_square_root() -> None:
    right = Manipulator.from_json({"a2x": 30, "a3x": 0, "a3y": 40, "d1": 15, "d2": 25, "d3": 20})
    eliminant = eliminate(right)
    assert eliminant.slice_map.rational
    assert eliminant.b == fmpz_mat(25, 11, [0] * 275)
    assert not eliminate(EXAMPLES["innocenti"]).slice_map.rational


def test_the_radicand_is_the_square_of_the_height_up_to_a_rational_square() -> None:
    m = EXAMPLES["innocenti"]
    slice_map = SliceMap.of(m)
    height2 = m.area16 / (4 * m.d1**2)
    ratio = height2 * slice_map.scale**2 / slice_map.radicand
    assert ratio == slice_map.g.n**2
    assert isqrt(slice_map.radicand) ** 2 != slice_map.radicand


@pytest.mark.parametrize("leg", [0, 4, "1"])
def test_only_three_legs(leg: int) -> None:
    with pytest.raises(InputError, match="fixed_leg"):
        eliminate(EXAMPLES["innocenti"], leg)
