"""Candidate lengths: between two neighbouring ones neither roots nor cusps come or go."""

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import pytest
import sympy as sp
from flint import fmpz_mat, fmpz_mpoly, fmpz_poly

from rpr_solver import EXAMPLES, Manipulator, SolverError, solve_slice
from rpr_solver.exact.biform import RING, L, U
from rpr_solver.transitions.discriminant import _divided_norm, _in_length, _norm, candidate_lengths
from tests.support.families import family
from tests.support.shared import eliminant_of

CASES = ["both flat", "similar", "congruent", "congruent, mirrored"]
VARIABLE = sp.Symbol("u")


def candidates(m: Manipulator) -> list[Fraction]:
    """The candidate lengths (user's unit), nearly."""
    eliminant = eliminant_of(m)
    balls = (x.scaled_length(128) for x in candidate_lengths(eliminant))
    lengths = sorted(Fraction(x.mid().str(25, radius=False)) / eliminant.slice_map.scale for x in balls)
    return [x for k, x in enumerate(lengths) if not k or x - lengths[k - 1] > Fraction(1, 10**12)]


def samples(ends: list[Fraction]) -> list[list[Fraction]]:
    """Lengths in each interval, at both of its ends."""
    whole = [Fraction(0), *ends, ends[-1] * 3]
    return [
        [(low + (high - low) * Fraction(n, 1000)).limit_denominator(10**9) for n in (1, 999)]
        for low, high in pairwise(whole)
    ]


def at(p: fmpz_mpoly, length: Fraction) -> fmpz_poly:
    """A polynomial in u and L at one L, up to a factor."""
    top = int(p.degrees()[2])
    total: dict[int, int] = {}
    for (_, k, power, _), c in p.to_dict().items():
        weight = length.numerator ** int(power) * length.denominator ** (top - int(power))
        total[int(k)] = total.get(int(k), 0) + int(c) * weight
    return fmpz_poly([total.get(k, 0) for k in range(max(total, default=0) + 1)])


def real_root_count(p: fmpz_poly) -> int:
    """By Sturm's theorem."""
    return int(sp.Poly([int(c) for c in reversed(p.coeffs())], VARIABLE).count_roots())


@pytest.mark.parametrize("name", CASES)
def test_the_number_of_real_roots_is_constant_between_candidates(name: str) -> None:
    m = family(name)
    eliminant = eliminant_of(m)
    norm = _norm(eliminant) or _divided_norm(eliminant.slice_map)
    counts = []
    for lengths in samples(candidates(m)):
        [count] = {real_root_count(at(norm, x * eliminant.slice_map.scale)) for x in lengths}
        counts.append(count)
    assert (len(set(counts)) > 1) == (name != "both flat")


@pytest.mark.parametrize("name", CASES)
def test_the_number_of_cusps_is_constant_between_candidates(name: str) -> None:
    m = family(name)
    counts = []
    for lengths in samples(candidates(m)):
        tables = [solve_slice(eliminant_of(m), x, 15) for x in lengths]
        [count] = {table.count for table in tables}
        counts.append(count)
    assert (len(set(counts)) > 1) == (name == "congruent, mirrored")


def planted(name: str, a: fmpz_mpoly, b: fmpz_mpoly) -> list[float]:
    """The candidate lengths (scaled) of a manipulator whose eliminant would be a + ω b."""

    def matrix(p: fmpz_mpoly) -> fmpz_mat:
        terms = {(int(k), int(power)): c for (_, k, power, _), c in p.to_dict().items()}
        return fmpz_mat(25, 11, [terms.get((k, power), 0) for k in range(25) for power in range(11)])

    eliminant = replace(eliminant_of(family(name)), a=matrix(a), b=matrix(b))
    return sorted(float(x.scaled_length(64).mid()) for x in candidate_lengths(eliminant))


def test_roots_meet_leave_and_are_all_lost_at_candidates() -> None:
    parabola, hyperbola, line = U**2 - L + 2, (L - 5) * U - 1, U - 3
    q = (L - 7) * (L + 1) * parabola * hyperbola * line
    meeting = [float(x) for x in sp.Poly(sp.sympify("(L - 2) * (L - 5)**2 - 1")).nroots() if x.is_real]
    expected = [7, 2, 5, 11, 16 / 3, *meeting]
    assert planted("similar", q, q * 0) == pytest.approx(sorted(expected))


def test_roots_of_an_eliminant_with_a_square_root_meet_at_candidates() -> None:
    """ω is √10: the lines u = ω L and u = 3 meet at L = 3 / √10, and u = −ω L is the conjugate's."""
    line, root = U - 3, 10**0.5
    assert planted("isosceles, irrational", U * line, -L * line) == pytest.approx([3 / root])


@pytest.mark.parametrize("name", CASES)
def test_candidates_are_positive(name: str) -> None:
    lengths = list(candidate_lengths(eliminant_of(family(name))))
    assert lengths
    assert all(x.scaled_length(64) > 0 for x in lengths)


@pytest.mark.parametrize("m", [EXAMPLES["innocenti"], family("both flat"), family("isosceles, irrational")])
def test_the_norm_is_that_of_the_eliminant_at_every_length(m: Manipulator) -> None:
    eliminant = eliminant_of(m)
    norm = _norm(eliminant)
    for length in (Fraction(7, 3), Fraction(150)):
        ours, theirs = at(norm, length), eliminant.at(length).norm
        ours, theirs = ours / ours.content(), theirs / theirs.content()
        assert ours in (theirs, -theirs)


def test_points_off_shared_curves_are_above_roots_of_the_divided_norm() -> None:
    """Congruent triangles: Q vanishes, J and E sharing curves at every L."""
    m = family("congruent")
    eliminant = eliminant_of(m)
    assert not _norm(eliminant)
    norm = _divided_norm(eliminant.slice_map)
    length = Fraction(37)
    polynomial = at(norm, length * eliminant.slice_map.scale)
    points = [
        p for p in solve_slice(eliminant, length, 40).to_json()["degenerate_points"] if p["kind"] != "curve"
    ]
    assert points
    for point in points:
        u = sp.tan(sp.Rational(point["theta1_deg"]) * sp.pi / 360).evalf(60)
        here, beside = (
            sp.Poly([int(c) for c in reversed(polynomial.coeffs())], VARIABLE).eval(x)
            for x in (u, u + sp.Rational(1, 100))
        )
        assert abs(here / beside) < sp.Float("1e-30")


def test_large_factors_are_refused() -> None:
    with pytest.raises(SolverError, match="no small factors"):
        list(candidate_lengths(eliminant_of(family("flat base"))))


def test_a_polynomial_in_the_length_alone() -> None:
    assert _in_length(3 * L**2 - L + 5) == fmpz_poly([5, -1, 3])
    assert _in_length(RING.from_dict({})) == fmpz_poly([])
    assert at(U**2 * L - 4, Fraction(2, 3)) == fmpz_poly([-12, 0, 2])
