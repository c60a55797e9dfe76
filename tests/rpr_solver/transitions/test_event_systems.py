"""The systems of events: what each form is, by the definitions, and every factor of their resultants."""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from itertools import pairwise

import mpmath as mp
import pytest
from flint import fmpz, nmod_mat, nmod_poly
from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, Manipulator
from rpr_solver.exact.biform import OMEGA, RING, BiForm, T, U
from rpr_solver.exact.quadratic import Form
from rpr_solver.model.slice_map import Leg, SliceMap
from rpr_solver.transitions.event_systems import (
    EventSystems,
    NotGeneric,
    System,
    limit_system,
)
from tests.support.definitions import DIGITS, Slices, real
from tests.support.families import family
from tests.support.sampling import sample
from tests.support.strategies import examples

CHEAP = EXAMPLES["zein-flat"], family("isosceles, irrational"), family("folded flat platform")
TANGENTS = (
    (Fraction(1, 3), Fraction(7, 4)),
    (Fraction(-5, 2), Fraction(3, 7)),
    (Fraction(4), Fraction(-1, 5)),
    (Fraction(7, 9), Fraction(-11, 4)),
)


@cache
def systems_of(m: Manipulator, fixed_leg: int = 1) -> EventSystems:
    return EventSystems.of(SliceMap.of(m, fixed_leg))


def on_surface(slices: Slices, t: Fraction, v: Fraction) -> tuple[mp.mpf, tuple[mp.mpf, mp.mpf, mp.mpf]]:
    """J1 and the place at which L makes the pose singular; J is L (J0 + L J1), up to a constant."""
    alpha, theta = 2 * mp.atan(real(t)), mp.atan(real(v))
    plus, minus = (slices.values((alpha, theta, sign * real(slices.size)), "j").j for sign in (1, -1))
    j0, j1 = plus - minus, plus + minus
    return j1, (alpha, theta, -j0 / j1 * real(slices.size))


def value(form: BiForm, t: Fraction, v: Fraction) -> mp.mpf:
    """The trigonometric polynomial whose numerator in tan(α/2) and tan θ the form is."""
    a, b = (
        sum((int(c) * t ** int(i) * v ** int(k) for (i, k, _, _), c in part.to_dict().items()), Fraction(0))
        for part in (form.a, form.b)
    )
    whole = real(a) + real(b) * mp.sqrt(form.radicand)
    return whole / real((1 + t * t) ** (form.degree_t // 2)) / mp.sqrt(real(1 + v * v)) ** form.degree_u


def ratios(form: BiForm, expected: object) -> list[mp.mpf]:
    return [value(form, t, v) / expected(t, v) for t, v in TANGENTS]  # type: ignore[operator]


def agree(numbers: list[mp.mpf]) -> bool:
    assert all(numbers)
    return all(abs(a / b - 1) < mp.mpf("1e-40") for a, b in pairwise(numbers))


@pytest.mark.parametrize("fixed_leg", sample([1, 2, 3], 1))
@pytest.mark.parametrize("m", sample(CHEAP, 1))
def test_each_form_is_what_it_is_said_to_be(m: Manipulator, fixed_leg: int) -> None:
    """Up to a constant, and with the L put in that makes the pose singular."""
    systems, slices = systems_of(m, fixed_leg), Slices.of(m, fixed_leg)
    assert not systems.near_shared_angles

    def quantity(name: str, over: str, power: int = 1) -> object:
        def expected(t: Fraction, v: Fraction) -> mp.mpf:
            j1, place = on_surface(slices, t, v)
            values = slices.values(place, name, over)
            return j1**2 * getattr(values, name) / getattr(values, over) ** power

        return expected

    def j0(t: Fraction, v: Fraction) -> mp.mpf:
        j1, place = on_surface(slices, t, v)
        return j1 * place[2]

    with mp.workdps(DIGITS):
        assert agree(ratios(systems.permanent.first, j0))
        assert agree(ratios(systems.permanent.second, lambda t, v: on_surface(slices, t, v)[0]))
        # ∂L/∂α = −J_α / J_L where J = 0
        assert agree(ratios(systems.critical.first, quantity("j_alpha", "j_length")))
        assert agree(ratios(systems.critical.second, quantity("j_theta", "j_length")))
        assert agree(ratios(systems.swallowtails.first, quantity("e_f", "f_theta")))
        assert agree(ratios(systems.swallowtails.second, quantity("along_e_f", "f_theta", 2)))


@pytest.mark.parametrize("free", [0, 1])
@pytest.mark.parametrize("m", CHEAP)
def test_the_form_of_a_limit_is_the_square_of_the_leg_less_that_of_the_limit(
    m: Manipulator, free: int
) -> None:
    systems, slices = systems_of(m), Slices.of(m)
    slice_map, limit = systems.slice_map, Fraction(37, 5)
    leg = (slice_map.f, slice_map.g)[free]
    system = limit_system(systems, leg, (limit * slice_map.scale) ** 2)

    def expected(t: Fraction, v: Fraction) -> mp.mpf:
        j1, place = on_surface(slices, t, v)
        return j1**2 * (slices.free_legs(place)[free] ** 2 - real(limit**2))

    assert system.first == systems.swallowtails.first
    with mp.workdps(DIGITS):
        assert agree(ratios(system.second, expected))


class Modular:
    """Polynomials in v modulo a prime, by their values on all the points that their degree needs."""

    def __init__(self, slice_map: SliceMap, above: int) -> None:
        p = fmpz(above)
        radicand = fmpz(slice_map.radicand)
        while not (p.is_prime() and p % 2 == 1 and radicand.jacobi(p) == 1):
            p += 1
        self.p, self.omega = int(p), 1 if radicand == 1 else int((radicand % p).sqrtmod(p))
        self.circular = nmod_poly([1, 0, 1], self.p)

    def image(self, form: Form) -> nmod_poly:
        return nmod_poly(form.polynomial.a, self.p) + nmod_poly(form.polynomial.b, self.p) * self.omega

    def at(self, form: BiForm, v: int) -> list[int]:
        """The coefficients in t at one v."""
        row = [0] * (form.degree_t + 1)
        for part, weight in ((form.a, 1), (form.b, self.omega)):
            for (i, k, _, _), c in part.to_dict().items():
                row[i] += int(c) * weight * pow(v, int(k), self.p)
        return row

    def resultant(self, first: BiForm, second: BiForm) -> nmod_poly:
        degree = first.degree_t * second.degree_u + second.degree_t * first.degree_u
        vs = range(2, degree + 3)
        values = [self.sylvester(self.at(first, v), self.at(second, v)) for v in vs]
        powers = nmod_mat(len(vs), len(vs), [pow(v, k, self.p) for v in vs for k in range(len(vs))], self.p)
        solution = powers.solve(nmod_mat(len(vs), 1, values, self.p))
        return nmod_poly([int(x) for x in solution.entries()], self.p)

    def sylvester(self, first: list[int], second: list[int]) -> int:
        """The resultant of two forms, zeros at t = ∞ counted."""
        m, n = len(first) - 1, len(second) - 1
        rows = [[0] * i + first + [0] * (n - 1 - i) for i in range(n)]
        rows += [[0] * i + second + [0] * (m - 1 - i) for i in range(m)]
        return int(nmod_mat(m + n, m + n, [x % self.p for row in rows for x in row], self.p).det())


def exactly_divided(p: nmod_poly, *factors: tuple[nmod_poly, int]) -> nmod_poly:
    """The monic quotient."""
    for factor, exponent in factors:
        p, rest = divmod(p, factor**exponent)
        assert not rest
    return monic(p)


def monic(p: nmod_poly) -> nmod_poly:
    return p * pow(int(p.leading_coefficient()), -1, p.modulus())


def theta_slope(leg: Leg, radicand: int) -> BiForm:
    """Half of f_θ / L: the platform point less the base point, across the fixed leg."""
    omega = RING.gens()[3]
    square_t = 1 + T**2
    x = leg.m * (1 - T**2) - 2 * leg.n * omega * T - leg.ax * square_t
    y = 2 * leg.m * T + leg.n * omega * (1 - T**2) - leg.ay * square_t
    return BiForm.of(y - U * x, radicand, 2, 1)


def check_identities(systems: EventSystems, above: int, square: Fraction) -> None:
    slice_map = systems.slice_map
    mod = Modular(slice_map, above)
    circular, permanent = mod.circular, systems.permanent
    slopes = (theta_slope(leg, slice_map.radicand) for leg in (slice_map.f, slice_map.g))
    a = exactly_divided(mod.resultant(*slopes), (circular, 1))
    z = exactly_divided(mod.resultant(permanent.first, permanent.second), (circular, 1))
    y = exactly_divided(z, (a, 1))
    assert (z, y) == tuple(monic(mod.image(x)) for x in (permanent.eliminant, systems.not_parallel))
    limit = limit_system(systems, slice_map.g, square)
    for system, known, degree in (
        (systems.swallowtails, ((circular, 8), (y, 4)), 32),
        (systems.critical, ((circular, 5), (z, 1)), 18),
        (limit, ((circular, 10), (y, 2), (z, 2)), 24),
    ):
        whole = mod.resultant(system.first, system.second)
        assert system.eliminant.degree == degree
        assert exactly_divided(whole, *known) == monic(mod.image(system.eliminant))
    assert (permanent.eliminant.degree, systems.not_parallel.degree) == (8, 6)


@st.composite
def generic(draw: st.DrawFn, size: int = 10**6) -> Manipulator:
    """Any manipulator with whole lengths and no flat triangle."""
    a2x, a3x, a3y = (draw(st.integers(-size, size).filter(bool)) for _ in range(3))
    d1, d3 = draw(st.integers(2, size)), draw(st.integers(2, size))
    d2 = draw(st.integers(abs(d1 - d3) + 1, d1 + d3 - 1))
    values = map(Fraction, (a2x, a3x, a3y, d1, d2, d3))
    return Manipulator(*values, orientation=draw(st.sampled_from(["ccw", "cw"])))


@given(generic(), st.sampled_from([1, 2, 3]), st.integers(2**61, 2**62), st.integers(1, 10**12))
@settings(examples(4), phases=(Phase.explicit, Phase.reuse, Phase.generate))
def test_they_divide_them_for_every_manipulator(
    m: Manipulator, fixed_leg: int, above: int, square: int
) -> None:
    """All values that the degrees call for are taken, modulo a prime that the solver does not know."""
    try:
        systems = systems_of(m, fixed_leg)
    except NotGeneric:
        assume(False)
    assume(not systems.near_shared_angles and systems.critical.first.degree_t == 6)
    check_identities(systems, above, Fraction(square))


def test_what_two_forms_share_makes_no_eliminant() -> None:
    slice_map = SliceMap.of(CHEAP[0])
    first, second, shared = (BiForm.of(x, 1, 1, 1) for x in (T + U, T - 2 * U, T * U + 5))
    assert System.of(slice_map, first, second).eliminant.degree == 2
    with pytest.raises(NotGeneric):
        System.of(slice_map, first * shared, second * shared)


def test_a_shared_angle_is_taken_out_and_handed_over() -> None:
    slice_map = SliceMap.of(CHEAP[0])
    first, second = BiForm.of((T + U) * (T - 3), 1, 2, 1), BiForm.of((T - 2 * U) * (T - 3), 1, 2, 1)
    none = Form(
        System.of(slice_map, *(BiForm.of(x, 1, 1, 1) for x in (T, T * U + 1))).eliminant.polynomial, 0
    )
    system, angles = System.without_shared_angles(slice_map, first, second, none)
    assert angles is not None
    assert angles.a in (T - 3, 3 - T)
    assert (system.first.degree_t, system.second.degree_t, system.eliminant.degree) == (1, 1, 2)
    with pytest.raises(NotGeneric):
        System.without_shared_angles(slice_map, first, first, none)


def test_poses_of_a_shared_angle_are_degenerate_at_their_length() -> None:
    """Right angles: α = 0 and 180° are out of C and W, and their poses with C = 0 a system of their own."""
    m = family("right angles")
    systems, slices = systems_of(m), Slices.of(m)
    [beside] = systems.near_shared_angles
    assert beside.first == systems.swallowtails.first
    assert beside.second.a in (T, -T)
    assert (beside.second.degree_t, beside.second.zeros_at_infinity) == (2, 1)
    with mp.workdps(DIGITS):
        for v in (Fraction(1, 3), Fraction(-7, 2), Fraction(5)):
            for t in (Fraction(0), Fraction(10**40)):
                _, place = on_surface(slices, t, v)
                values = slices.values(place, "j", "e_f", "along_e_f")
                assert max(map(abs, vars(values).values())) < mp.mpf("1e-30")


def test_an_angle_along_which_l_is_constant_is_out_of_the_critical_poses() -> None:
    """Half a turn of the fixed leg changes the sign of L, so that a constant L is 0: no event is lost."""
    m = family("right angles")
    systems, slices = systems_of(m, 3), Slices.of(m, 3)
    assert systems.critical.first.degree_t < 6
    with mp.workdps(DIGITS):
        along, elsewhere = (
            [abs(on_surface(slices, t, v)[1][2]) for v in (Fraction(1, 3), Fraction(-7, 2))]
            for t in (Fraction(0), Fraction(1))
        )
    assert max(along) < mp.mpf("1e-50")
    assert min(elsewhere) > mp.mpf("0.01")


@pytest.mark.parametrize("name", ["similar", "congruent", "congruent, mirrored"])
def test_events_that_are_not_isolated_are_said_to_be_so(name: str) -> None:
    with pytest.raises(NotGeneric):
        systems_of(family(name))


FIRST, SECOND = T * U + OMEGA, T**2 + U**2 * OMEGA - 3
