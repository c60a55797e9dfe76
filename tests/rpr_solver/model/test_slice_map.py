"""The slice map's forms against the trigonometric functions that they represent."""

from fractions import Fraction

import mpmath as mp
import pytest

from rpr_solver import EXAMPLES
from rpr_solver.model.slice_map import TRIG, SliceMap, in_tangents


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
