"""The slice map's forms against the trigonometric functions that they represent."""

from fractions import Fraction

import mpmath as mp
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, Manipulator
from rpr_solver.model.slice_map import TRIG, SliceMap, half_angles, in_tangents, reduced, slopes
from tests.support.strategies import examples, manipulators

INNOCENTI = SliceMap.of(EXAMPLES["innocenti"])


def trigonometric(slice_map: SliceMap, p: object, alpha: mp.mpf, theta: mp.mpf, length: int) -> mp.mpf:
    """A polynomial of the ring TRIG at two angles."""
    at = (mp.cos(alpha), mp.sin(alpha), mp.cos(theta), mp.sin(theta), length, mp.sqrt(slice_map.radicand))
    return mp.fsum(
        mp.mpf(int(c)) * mp.fprod(x ** int(k) for x, k in zip(at, powers, strict=True))
        for powers, c in p.to_dict().items()  # type: ignore[attr-defined]
    )


@pytest.mark.parametrize("name", ["innocenti", "zein-flat", "twelve-cusps"])
@pytest.mark.parametrize("leg", [1, 2, 3])
def test_half_angles_make_the_numerator(name: str, leg: int) -> None:
    slice_map = SliceMap.of(EXAMPLES[name], leg)
    forms = slice_map.singular, slice_map.coalescence
    with mp.workdps(60):
        alpha, theta, length = mp.mpf("0.7"), mp.mpf("-1.9"), 12345
        t, u = mp.tan(alpha / 2), mp.tan(theta / 2)
        for p, form, order in zip(slice_map.trigonometric, forms, (2, 3), strict=True):
            assert (form.degree_t, form.degree_u) == (2 * order, 2 * order)
            in_t = []
            for row in form.at(Fraction(length)):
                a, b = ([int(c) for c in reversed(part.coeffs())] or [0] for part in (row.a, row.b))
                in_t.append(mp.polyval(a, u) + mp.sqrt(form.radicand) * mp.polyval(b, u))
            weight = ((1 + t * t) * (1 + u * u)) ** order
            expected = trigonometric(slice_map, p, alpha, theta, length) * weight
            assert abs(mp.polyval(in_t[::-1], t) / expected - 1) < mp.mpf(10) ** -45


@given(manipulators(size=9, denominators=(1, 10)), st.sampled_from([1, 2, 3]))
@examples(10)
def test_packed_forms_are_those_of_cosines_and_sines(m: Manipulator, leg: int) -> None:
    slice_map = SliceMap.of(m, leg)
    j, e = slice_map.trigonometric
    forms = half_angles(j, (2, 2), 1, slice_map.radicand), half_angles(e, (3, 3), 1, slice_map.radicand)
    assert (slice_map.singular, slice_map.coalescence) == forms
    assert slice_map.tables == tuple(form.coefficients for form in forms)


def test_reduction_keeps_the_function_and_finds_its_degree() -> None:
    cos_a, sin_a, cos_t, _, length, omega = TRIG.gens()
    hidden = (cos_a**2 + sin_a**2) ** 2 * cos_t * omega**3
    assert reduced(hidden, 1, 7) == 7 * cos_t * omega
    function = slopes(INNOCENTI.f)[0] ** 3 * (omega + length * sin_a)
    short = reduced(function, 1, INNOCENTI.radicand)
    with mp.workdps(50):
        at = mp.mpf("2.5"), mp.mpf("0.3"), 17
        values = [trigonometric(INNOCENTI, p, *at) for p in (function, short)]
        assert abs(values[0] / values[1] - 1) < mp.mpf(10) ** -40


def test_a_form_of_lower_degree_keeps_the_order_it_is_given() -> None:
    cos_a = TRIG.gen(0)
    form = half_angles(cos_a + 1, (1, 0), 1, 1)  # (1 − t²) + (1 + t²): zero at α = 180°, twice
    assert (form.degree_t, form.zeros_at_infinity) == (2, 2)


def test_tangents_of_whole_angles_make_the_numerator_over_a_power_of_the_cosine() -> None:
    cos_a, sin_a, cos_t, sin_t, _, omega = TRIG.gens()
    p = sin_a * cos_t**3 + omega * sin_t * cos_a + 5 * sin_t
    form = in_tangents(p, (1, 3), 1, 7)
    assert (form.degree_t, form.degree_u) == (2, 3)
    with mp.workdps(40):
        alpha, theta = mp.mpf("0.7"), mp.mpf("-1.9")
        t, v = mp.tan(alpha / 2), mp.tan(theta)
        total = mp.fsum(
            int(c) * weight * t ** int(i) * v ** int(k)
            for part, weight in ((form.a, 1), (form.b, mp.sqrt(7)))
            for (i, k, _, _), c in part.to_dict().items()
        )
        expected = (
            mp.sin(alpha) * mp.cos(theta) ** 3
            + mp.sqrt(7) * mp.sin(theta) * mp.cos(alpha)
            + 5 * mp.sin(theta)
        )
        assert abs(total / (1 + t * t) * mp.cos(theta) ** 3 / expected - 1) < mp.mpf(10) ** -30


def test_what_half_a_turn_changes_otherwise_is_no_form_in_the_tangent() -> None:
    with pytest.raises(ValueError, match="sign"):
        in_tangents(TRIG.gen(2) + 1, (0, 1), 1, 1)


def test_a_leg_closes_where_its_square_is_zero() -> None:
    """|L e(θ) − a|² = |m|² at the roots u, and its line passes through both bases at the others."""
    leg, length = INNOCENTI.f, Fraction(20) * INNOCENTI.scale
    with mp.workdps(40):
        for u in mp.polyroots([int(c) for c in reversed(leg.closed(length).a.coeffs())]):
            x, y = (1 - u * u) / (1 + u * u), 2 * u / (1 + u * u)
            scaled = mp.mpf(length.numerator) / length.denominator
            square = (scaled * x - leg.ax) ** 2 + (scaled * y - leg.ay) ** 2
            assert abs(square / leg.platform2 - 1) < mp.mpf(10) ** -30
        for u in mp.polyroots([int(c) for c in reversed(INNOCENTI.g.collinear.a.coeffs())]):
            x, y = 1 - u * u, 2 * u
            assert abs(x * INNOCENTI.g.ay - y * INNOCENTI.g.ax) < mp.mpf(10) ** -25
