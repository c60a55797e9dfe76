"""Certified real roots, against polynomials whose roots are known or counted by other means."""

from collections.abc import Callable, Iterable
from fractions import Fraction
from itertools import pairwise
from math import prod

import pytest
from flint import arb, arb_poly, ctx, fmpq, fmpq_poly, fmpz_poly
from hypothesis import assume, example, given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES
from rpr_solver.errors import Unproved
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import (
    RealRoot,
    _sign_changes,
    ball_of,
    bisected,
    number_of_real_roots,
    real_roots,
    roots_below,
    separated,
    separated_roots,
)
from tests.support.shared import eliminant_of
from tests.support.strategies import examples

RATIONALS = st.builds(Fraction, st.integers(-60, 60), st.integers(1, 12))


def with_roots(roots: Iterable[Fraction], *others: list[int]) -> QuadraticPoly:
    """The polynomial with these rational roots, times others."""
    factors = [[-x.numerator, x.denominator] for x in roots]
    return QuadraticPoly.rational(prod(map(fmpz_poly, (*factors, *others)), start=fmpz_poly([1])))


def ends(ball: arb) -> tuple[Fraction, Fraction]:
    """The lowest and the highest number in a ball, not rounded to the working precision."""
    middle, radius = (
        Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
        for mantissa, exponent in (x.man_exp() for x in (ball.mid(), ball.rad()))
    )
    return middle - radius, middle + radius


def holds(ball: arb, x: Fraction) -> bool:
    low, high = ends(ball)
    return low <= x <= high


def sturm(p: fmpz_poly) -> Callable[[Fraction], int]:
    """The sign changes of Sturm's chain at x: those at a less those at b count the roots in (a, b]."""
    chain = [fmpq_poly(p), fmpq_poly(p.derivative())]
    while chain[-1]:
        chain.append(-(chain[-2] % chain[-1]))

    def changes(x: Fraction) -> int:
        values = [value for q in chain if (value := q(fmpq(x.numerator, x.denominator))) != 0]
        return sum((a > 0) != (b > 0) for a, b in pairwise(values))

    return changes


def assert_each_holds_one(intervals: list[arb], p: fmpz_poly) -> None:
    """Ascending intervals with one root each, and none elsewhere, by Sturm's theorem."""
    changes = sturm(p)
    bound = Fraction(10) ** 200
    pairs = [ends(x) for x in intervals]
    assert all(a[1] < b[0] for a, b in pairwise(pairs))
    assert changes(-bound) - changes(bound) == len(pairs)
    tiny = Fraction(1, 10**300)  # the count is of roots above the lower end
    assert all(changes(low - tiny) - changes(high) == 1 for low, high in pairs)


# which roots are real


@given(st.lists(st.integers(-9, 9), min_size=1, max_size=9))
@example([0, 1])
@example([5])
@example([-2, 0, 1])
@example([1, 0, 0, 0, 1])
@examples(60)
def test_every_real_root_has_a_ball_of_its_own(coefficients: list[int]) -> None:
    p = fmpz_poly(coefficients)
    assume(p and p.gcd(p.derivative()).degree() == 0)
    assert_each_holds_one([root.ball for root in real_roots(QuadraticPoly.rational(p))], p)


@given(st.sets(RATIONALS, min_size=1, max_size=6), st.integers(-40, 40), st.integers(1, 40))
@examples(40)
def test_known_roots_are_found_and_pairs_off_the_axis_are_not(
    roots: set[Fraction], centre: int, gap: int
) -> None:
    """A pair 1/gap above and below the real axis is no real root."""
    pair = [centre**2 * gap**2 + 1, -2 * centre * gap**2, gap**2]
    balls = [root.refined(80) for root in real_roots(with_roots(roots, pair))]
    assert len(balls) == len(roots)
    assert all(holds(ball, x) for ball, x in zip(balls, sorted(roots), strict=True))


@given(st.lists(st.integers(-9, 9), min_size=2, max_size=5), st.lists(st.integers(-9, 9), max_size=5))
@example([0, 0, 1], [-1])
@examples(40)
def test_roots_over_a_quadratic_field_are_those_of_the_norm_less_the_conjugates(
    a: list[int], b: list[int]
) -> None:
    """A + √2 B and A − √2 B share the real roots of the rational norm among them."""
    p = QuadraticPoly(fmpz_poly(a), fmpz_poly(b), 2)
    norm = p.norm
    assume(p.b and p.degree > 0 and norm.degree() > 0 and norm.gcd(norm.derivative()).degree() == 0)
    changes = sturm(norm)
    bound = Fraction(10) ** 200
    both = [real_roots(p), real_roots(p.conjugate)]
    assert sum(map(len, both)) == changes(-bound) - changes(bound)
    for own, other in ((p, p.conjugate), (p.conjugate, p)):
        for root in real_roots(own):
            x = root.refined(400)
            assert own.ball(500)(x).contains(0)
            assert not other.ball(500)(x).contains(0)


def test_roots_are_told_apart_however_close() -> None:
    """Two real roots 1e-40 apart; and a pair that misses the real axis by as little."""
    close = [Fraction(0), Fraction(1, 10**40)]
    found = real_roots(with_roots(close, [1, 0, 1]))
    assert all(holds(root.refined(200), x) for root, x in zip(found, close, strict=True))
    [root] = real_roots(with_roots([Fraction(3)], [1, 0, 10**80]))
    assert holds(root.ball, Fraction(3))


@given(st.integers(8, 120), st.integers(2, 8), st.integers(-5, 5))
@examples(15)
def test_a_cluster_and_its_polynomial_of_mignotte(exponent: int, degree: int, sign: int) -> None:
    """xⁿ − (Ax − 1)² has two real roots near 1/A, as near as roots can be; with + it has none there."""
    large = 2**exponent + sign
    for plus, count in ((-1, 2), (1, 0)):
        p = fmpz_poly([0] * (degree + 1) + [1]) + plus * fmpz_poly([-1, large]) ** 2
        assume(p.gcd(p.derivative()).degree() == 0)
        roots = real_roots(QuadraticPoly.rational(p))
        balls = [root.refined(2000) for root in roots]
        assert sum(abs(ends(x)[0] * large - 1) < Fraction(1, 2) for x in balls) == count
        assert_each_holds_one(balls, p)


def test_a_cluster_far_out_is_not_lost() -> None:
    """FLINT's iteration misses these two at low precision."""
    balls = [root.refined(60) for root in real_roots(rational(48390, -440, 1))]  # 220 ± √10
    assert [round(float((ends(x)[0] - 220) ** 2), 9) for x in balls] == [10, 10]


def rational(*coefficients: int) -> QuadraticPoly:
    return QuadraticPoly.rational(list(coefficients))


def test_roots_that_are_one_are_unproved(monkeypatch: pytest.MonkeyPatch) -> None:
    """A polynomial that is not squarefree, against the contract."""
    monkeypatch.setattr("rpr_solver.exact.real_roots.GREATEST_BITS", 1 << 10)
    with pytest.raises(Unproved, match="could not be told apart"):
        real_roots(QuadraticPoly.rational(fmpz_poly([-2, 0, 1]) ** 2))


# what discs prove


def steps_counted(monkeypatch: pytest.MonkeyPatch) -> list[arb]:
    """The lengths of the intervals that are examined from now on, a list that grows."""
    steps: list[arb] = []

    def counted(polynomial: arb_poly, low: arb, high: arb) -> int | None:
        steps.append(high - low)
        return _sign_changes(polynomial, low, high)

    monkeypatch.setattr("rpr_solver.exact.real_roots._sign_changes", counted)
    return steps


# refining


@pytest.mark.parametrize("bits", [1, 60, 64, 500, 5000])
def test_a_refined_ball_has_the_bits_and_holds_the_root(bits: int) -> None:
    low, high = real_roots(rational(-2, 0, 1))
    for root, sign in ((low, -1), (high, 1)):
        x = root.refined(bits)
        assert x.rel_accuracy_bits() >= bits
        one, other = (end**2 for end in ends(x))
        assert min(one, other) <= 2 <= max(one, other)
        assert sign * x > 0


def test_zero_is_exact() -> None:
    for p in (rational(0, 1), rational(0, -3, 1), QuadraticPoly(fmpz_poly([0, 1]), fmpz_poly([0, 0, 1]), 3)):
        assert RealRoot(p, arb(0, 0.25)).refined(100).is_zero()


def test_a_root_near_zero_is_not_taken_for_zero() -> None:
    """ω + 10⁹ x and 1 + 10⁹ x."""
    for a, b, root in (([0, 10**9], [1], -(2**0.5)), ([1, 10**9], [0], -1)):
        x = RealRoot(QuadraticPoly(fmpz_poly(a), fmpz_poly(b), 2), arb(0, 0.25)).refined(100)
        assert float(x.mid()) * 10**9 == pytest.approx(root)


@pytest.mark.parametrize(("degree", "low", "high"), [(2, "0.001", "10"), (2, "1.3", "1000"), (3, "1.1", "2")])
def test_where_the_slope_varies_much_the_ball_is_halved(degree: int, low: str, high: str) -> None:
    """ⁿ√2 and −ⁿ√2, from balls in which Newton's step alone does not contract."""
    for sign in (1, -1):
        p = rational(-2, *[0] * (degree - 1), sign**degree)
        x = RealRoot(p, arb(low).union(arb(high)) * sign).refined(100)
        one, other = ((sign * end) ** degree for end in ends(x))
        assert min(one, other) <= 2 <= max(one, other)


@given(st.sets(RATIONALS, min_size=2, max_size=5), st.data())
@examples(30)
def test_any_isolating_ball_is_refined(roots: set[Fraction], data: st.DataObject) -> None:
    """Not only those that are found: half of the way to the neighbours, whatever the slope does there."""
    ordered = sorted(roots)
    polynomial = with_roots(ordered)
    i = data.draw(st.integers(0, len(ordered) - 1))
    ends = [*(x for x in ordered[max(0, i - 1) : i + 2] if x != ordered[i])]
    reach = min(abs(x - ordered[i]) for x in ends) * Fraction(data.draw(st.integers(1, 9)), 20)
    with ctx.workprec(200):
        root = RealRoot(polynomial, arb(ball_of(ordered[i]).mid(), ball_of(reach).upper()))
    assume(not slope_may_vanish(root))
    x = root.refined(300)
    assert holds(x, ordered[i])
    assert ordered[i] == 0 or x.rel_accuracy_bits() >= 300


def slope_may_vanish(root: RealRoot) -> bool:
    with ctx.workprec(200):
        return bool(root.polynomial.ball(200).derivative()(root.ball).contains(0))


def test_a_wide_isolating_ball_is_refined_at_any_precision() -> None:
    """Evaluated at high precision only, a wide ball's slope would not exclude zero."""
    eliminant = eliminant_of(EXAMPLES["innocenti"])
    q = eliminant.at(Fraction("14.98") * eliminant.slice_map.scale)
    norm = QuadraticPoly.rational(q.norm)
    assert [root for root in real_roots(norm) if root.refined(3466).rel_accuracy_bits() < 3466] == []


def test_what_cannot_be_refined_is_unproved(monkeypatch: pytest.MonkeyPatch) -> None:
    """A ball without a root: its images leave it, and no precision helps."""
    monkeypatch.setattr("rpr_solver.exact.real_roots.GREATEST_BITS", 1 << 10)
    with ctx.workprec(100):
        nowhere = RealRoot(rational(-2, 0, 1), arb(-1, 3))
    with pytest.raises(Unproved, match="could not be refined to 100 bits"):
        nowhere.refined(100)


# bisection


@given(
    st.lists(st.integers(-30, 30), min_size=1, max_size=6, unique=True),
    st.integers(1, 50),
    st.integers(-300, 300),
)
@examples(40)
def test_bisection_finds_every_real_root(numbers: list[int], denominator: int, shift: int) -> None:
    """Clusters far from the unit circle, and pairs off the real axis beside them."""
    roots = sorted(Fraction(n, denominator) + shift for n in numbers)
    exact = with_roots(roots, [4, 0, 1], [shift**2 + 1, -2 * shift, 1])
    tries = (bisected(exact.ball(bits), bits) for bits in (256, 512, 1024, 2048))
    intervals = next(x for x in tries if x is not None)
    assert len(intervals) == len(roots)
    assert all(holds(x, root) for x, root in zip(intervals, roots, strict=True))
    assert_each_holds_one(intervals, exact.a)
    refined = [root.refined(60) for root in real_roots(exact)]
    assert all(holds(x, root) for x, root in zip(refined, roots, strict=True))


def test_bisection_does_not_guess_where_the_precision_is_too_low() -> None:
    close = with_roots([Fraction(1, 3), Fraction(1, 3) + Fraction(1, 2**200)])
    assert bisected(close.ball(128), 128) is None
    found = bisected(close.ball(2048), 2048)
    assert found is not None
    assert_each_holds_one(found, close.a)


@pytest.mark.parametrize("exponent", [100, 800])
def test_near_roots_are_reached_in_leaps(exponent: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Halving alone would take about as many steps as the exponent."""
    roots = [Fraction(k) for k in (-5, 2, 7)] + [Fraction(1, 3), Fraction(1, 3) + Fraction(1, 2**exponent)]
    exact = with_roots(roots, [9, 1, 1])
    steps = steps_counted(monkeypatch)
    found = bisected(exact.ball(8192), 8192)
    assert found is not None
    assert_each_holds_one(found, exact.a)
    assert len(found) == len(roots)
    assert len(steps) < 80


def test_bisection_asks_for_a_leading_coefficient() -> None:
    with ctx.workprec(100):
        assert bisected(arb_poly([1, 1, arb(0, 1e-9)]), 100) is None


def test_bisection_of_wide_coefficients_holds_the_roots_of_each_polynomial_in_them() -> None:
    """x² − c for any c in 2 ± 1/8."""
    with ctx.workprec(100):
        tries = (bisected(arb_poly([arb(-2, 0.125), 0, 1]), bits) for bits in range(100, 140))
        found = [x for x in tries if x is not None]
    assert found
    for low, high in found:
        for near, far in (ends(high), (-x for x in reversed(ends(low)))):
            assert near**2 <= Fraction(15, 8) < Fraction(17, 8) <= far**2


@given(st.sets(RATIONALS, max_size=9), st.sets(st.integers(1, 9), max_size=4), st.integers(-3, 3))
@examples(30)
def test_roots_are_counted_as_they_are_found(roots: set[Fraction], squares: set[int], middle: int) -> None:
    """Also of polynomials that are even, whose remainders fall by two degrees."""
    pairs = [fmpz_poly([-middle, 1]) ** 2 + square for square in squares]
    p = with_roots(roots, *(pair.coeffs() for pair in pairs))
    assert number_of_real_roots(p) == len(real_roots(p)) == len(roots)
    even = with_roots({x for root in roots for x in (root, -root)})
    assert number_of_real_roots(even) == len({x for root in roots for x in (root, -root)})
    assert number_of_real_roots(QuadraticPoly(p.a * 0 + p.b, p.a, 2)) == len(roots)


@given(st.sets(RATIONALS, min_size=1, max_size=6), st.lists(RATIONALS, min_size=1, max_size=4))
@examples(30)
def test_roots_are_counted_below_points(roots: set[Fraction], points: list[Fraction]) -> None:
    p = with_roots(roots, [1, 0, 1])
    found = roots_below(p.ball(512), [*points, None], 512)
    if roots & set(points):
        assert found is None
    elif found is not None:
        assert found == [*(sum(root < x for root in roots) for x in points), len(roots)]
    apart = [Fraction(10**40)]
    assert roots_below(p.ball(512), apart, 512) in (None, [len(roots)])
    assert roots_below((p * p).ball(512), [None], 512) is None


# roots of very unequal size

SIZES = st.builds(
    lambda n, power: n * Fraction(10) ** power, st.sampled_from([-7, -2, -1, 1, 3]), st.integers(-40, 40)
)


@given(st.sets(SIZES, min_size=1, max_size=8), st.integers(-9, 9), st.integers(0, 30))
@example({Fraction(1)}, 0, 0)
@example({Fraction(k) for k in range(1, 9)}, 3, 30)
@examples(25)
def test_roots_of_unequal_size_are_separated(roots: set[Fraction], middle: int, narrow: int) -> None:
    """Beside a pair 10^-narrow off the real axis, which balls must not take for real roots."""
    exact = with_roots(roots, [middle**2 * 100**narrow + 1, -2 * middle * 100**narrow, 100**narrow])
    tries = (separated(exact.ball(bits), bits) for bits in (256, 512, 1024, 2048, 4096))
    found = next(x for x in tries if x is not None)
    assert_each_holds_one(found, exact.a)
    assert all(holds(x, root) for x, root in zip(found, sorted(roots), strict=True))
    same = [root.refined(80) for root in separated_roots(exact)]
    assert all(holds(x, root) for x, root in zip(same, sorted(roots), strict=True))


def test_what_is_not_certain_is_not_separated() -> None:
    close = with_roots([Fraction(1, 3), Fraction(1, 3) + Fraction(1, 2**200)])
    assert separated(close.ball(128), 128) is None
    twice = with_roots([Fraction(2), Fraction(2), Fraction(5)])
    assert separated(twice.ball(512), 512) is None
    with ctx.workprec(100):
        assert separated(arb_poly([1, 1, arb(0, 1e-9)]), 100) is None
    at_zero = with_roots([Fraction(0), Fraction(1, 10**30), Fraction(10**30)])
    assert separated(at_zero.ball(512), 512) is None
    assert [
        holds(root.refined(90), x)
        for root, x in zip(separated_roots(at_zero), (0, Fraction(1, 10**30), 10**30), strict=True)
    ]
    assert separated_roots(QuadraticPoly.rational([7])) == []
