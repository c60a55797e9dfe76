"""docs/mathematics.md: its theorems, the code that cites them, its identities in indeterminate parameters.

The polynomials have z = exp(iα), w = exp(iθ) (e on the page), L, and the geometry as variables; by
turning the frames and choosing the unit, m = 1 and a is real. Derivatives are z∂/∂z and w∂/∂w, so
factors of i are left out. A Laurent polynomial is kept as a polynomial; ``shift`` is the power of z w by
which it was multiplied.
"""

import re
from collections import Counter
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import pytest
from flint import fmpz_mpoly, fmpz_mpoly_ctx, fmpz_poly

from rpr_solver import Manipulator
from rpr_solver.exact.elimination import resultant
from rpr_solver.exact.modular import simple_and_finite
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.model.slice_map import TRIG, SliceMap, half_angles, reduced, slopes

ROOT = Path(__file__).parents[2]
PAGE = ROOT.joinpath("docs", "mathematics.md").read_text(encoding="utf-8")
THEOREM = re.compile(r"^### (.+)\n\*\*Theorem (\d+)\.\*\*", re.MULTILINE)
LEMMA = re.compile(r"^### (.+)\n\*\*Lemma\.\*\*", re.MULTILINE)
CITED = re.compile(r"mathematics\.md#([\w-]+)")

RING = fmpz_mpoly_ctx.get(("z", "w", "L", "a", "n", "N", "b", "B"), "lex")
Z, W, L, A, N, N_BAR, B, B_BAR = RING.gens()
Corner = tuple[int, int]


def anchor(title: str) -> str:
    return re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-")


def citations() -> Counter[str]:
    sources = sorted(ROOT.joinpath("rpr_solver").rglob("*.py"))
    return Counter(name for path in sources for name in CITED.findall(path.read_text(encoding="utf-8")))


def test_the_code_cites_every_theorem_and_no_other() -> None:
    titles = THEOREM.findall(PAGE)
    assert [int(number) for _, number in titles] == list(range(1, len(titles) + 1))
    lemmas = LEMMA.findall(PAGE)
    assert len(titles) == PAGE.count("\n### ") - len(lemmas)
    assert set(citations()) == {anchor(title) for title in (*lemmas, *(title for title, _ in titles))}


def test_every_theorem_has_a_proof_and_links_to_the_page_itself_have_the_right_number() -> None:
    bodies = re.split(r"^### ", PAGE, flags=re.MULTILINE)[1:]
    assert all("\n*Proof.* " in body and "∎" in body for body in bodies)
    numbers = {anchor(title): number for title, number in THEOREM.findall(PAGE)}
    linked = re.findall(r"\[Theorem (\d+)\]\(#([\w-]+)\)", PAGE)
    assert linked
    assert all(numbers[name] == number for number, name in linked)


def d_z(p: fmpz_mpoly, shift: int) -> fmpz_mpoly:
    return Z * p.derivative(0) - shift * p


def d_w(p: fmpz_mpoly, shift: int) -> fmpz_mpoly:
    return W * p.derivative(1) - shift * p


def by_length(p: fmpz_mpoly) -> list[fmpz_mpoly]:
    rows: list[dict[tuple[int, ...], object]] = [{} for _ in range(p.degrees()[2] + 1)]
    for (i, k, power, *rest), c in p.to_dict().items():
        rows[power][i, k, 0, *rest] = c
    return [RING.from_dict(row) for row in rows]


F = (L * W + Z - A) * (L * Z + W - A * Z * W)
G = (L * W + N * Z - B) * (L * Z + N_BAR * W - B_BAR * Z * W)
F_ALPHA, G_ALPHA, PHI, GAMMA = d_z(F, 1), d_z(G, 1), d_w(F, 1) / L, d_w(G, 1) / L
J = F_ALPHA * GAMMA - PHI * G_ALPHA  # shift 2
J0, J1 = by_length(J)


def along_f(p: fmpz_mpoly, shift: int) -> fmpz_mpoly:
    """v_f·∇p."""
    return F_ALPHA * d_w(p, shift) - L * PHI * d_z(p, shift)


def on_surface(p: fmpz_mpoly) -> fmpz_mpoly:
    """p at L = −J0/J1, times a power of J1."""
    rows = by_length(p)
    top = len(rows) - 1
    return sum((row * (-J0) ** k * J1 ** (top - k) for k, row in enumerate(rows)), RING.from_dict({}))


E = along_f(J, 2)  # shift 3
ALONG_E = along_f(E, 3)  # shift 4
C = on_surface(E) / PHI  # shift 6; the division raises if it leaves a remainder
SWALLOW = on_surface(ALONG_E) / PHI / PHI / J0  # shift 6
M1, M2 = (J0 * d(J1, 2) - J1 * d(J0, 2) for d in (d_z, d_w))  # shift 4


def corners(p: fmpz_mpoly, shift: int, second: int = 1) -> list[Corner]:
    """The exponents of z and of w (or of the variable ``second``)."""
    down = shift if second == 1 else 0
    return sorted({(int(e[0]) - shift, int(e[second]) - down) for e in p.to_dict()})


def hull(points: list[Corner]) -> list[Corner]:
    """Andrew's monotone chain."""

    def half(ordered: list[Corner]) -> list[Corner]:
        chain: list[Corner] = []
        for x, y in ordered:
            while len(chain) > 1 and (
                (chain[-1][0] - chain[-2][0]) * (y - chain[-2][1])
                <= (chain[-1][1] - chain[-2][1]) * (x - chain[-2][0])
            ):
                chain.pop()
            chain.append((x, y))
        return chain[:-1]

    ordered = sorted(set(points))
    return half(ordered) + half(ordered[::-1])


def doubled_area(points: list[Corner]) -> int:
    ring = hull(points)
    return sum(x[0] * y[1] - x[1] * y[0] for x, y in pairwise([*ring, ring[0]]))


def mixed_volume(p: list[Corner], q: list[Corner]) -> int:
    both = [(x[0] + y[0], x[1] + y[1]) for x in p for y in q]
    return (doubled_area(both) - doubled_area(p) - doubled_area(q)) // 2


def square_less_constant(p: fmpz_mpoly) -> fmpz_mpoly:
    """J1² (p − s) on the surface, for a squared length p of shift 1; shift 5."""
    return on_surface(p) - 7 * J1 * J1 * Z * W


@pytest.mark.parametrize(
    ("first", "second", "degrees", "exponent"),
    [
        ((J, 2), (E, 3), ((2, 2), (3, 3)), 9),
        ((J0, 2), (J1, 2), ((2, 1), (1, 2)), 2),
        ((PHI, 1), (GAMMA, 1), ((1, 1), (1, 1)), 2),
        ((M1, 4), (M2, 4), ((3, 3), (3, 3)), 10),
        ((C, 6), (SWALLOW, 6), ((5, 4), (4, 4)), 16),
        ((C, 6), (square_less_constant(F), 5), ((5, 4), (4, 4)), 20),
        ((C, 6), (square_less_constant(G), 5), ((5, 4), (4, 4)), 20),
    ],
    ids=["J,E", "J0,J1", "phi,gamma", "M1,M2", "C,W", "C,K of f", "C,K of g"],
)
def test_newton_polygons_give_the_power_of_the_circular_factor(
    first: tuple[fmpz_mpoly, int],
    second: tuple[fmpz_mpoly, int],
    degrees: tuple[Corner, Corner],
    exponent: int,
) -> None:
    """For every geometry: (N) of the page, with symmetric polygons as wide as the formal degrees."""
    polygons = [hull(corners(*form)) for form in (first, second)]
    for polygon, (in_z, in_w) in zip(polygons, degrees, strict=True):
        assert {(-x, -y) for x, y in polygon} == set(polygon)
        assert (max(x for x, _ in polygon), max(y for _, y in polygon)) == (in_z, in_w)
    (a, b), (c, d) = degrees
    formal = 4 * (a * d + b * c)
    assert formal - mixed_volume(*polygons) == 2 * exponent


def test_the_degree_of_the_eliminant_in_the_length() -> None:
    """Theorem 6: the resultant has degree 12 in L, 2 of them those of q."""
    polygon_j, polygon_e = (
        [(-2, 0), (2, 0), (1, 1), (-1, 1)],
        [(-3, 0), (3, 0), (3, 1), (2, 2), (-2, 2), (-3, 1)],
    )
    for p, shift, polygon in ((J, 2, polygon_j), (E, 3, polygon_e)):
        assert set(hull([*polygon, *corners(p, shift, second=2)])) == set(polygon)
    assert mixed_volume(polygon_j, polygon_e) == 12


@pytest.mark.parametrize("z", [1, -1])
@pytest.mark.parametrize("w", [1, -1])
def test_the_orders_where_leg_f_is_stationary_at_every_length(z: int, w: int) -> None:
    """Theorem 16: C and W have order 2 at least where w and m z are parallel to a."""
    place = {"z": z, "w": w}
    assert F_ALPHA.subs(place) == 0 == PHI.subs(place)
    for p in (C, SWALLOW):
        assert all(q.subs(place) == 0 for q in (p, p.derivative(0), p.derivative(1)))


def quadratic(direction: tuple[int, int]) -> fmpz_poly:
    """Its roots u are the two directions of the fixed leg parallel to this one."""
    x, y = direction
    return fmpz_poly([y, -2 * x, -y])


def times(p: tuple[int, int], q: tuple[int, int]) -> tuple[int, int]:
    """The product of complex integers."""
    return p[0] * q[0] - p[1] * q[1], p[0] * q[1] + p[1] * q[0]


def test_the_permanent_poses_are_sixteen_different_ones() -> None:
    """Theorem 16: Z = A · (w w′ s)², for one manipulator, with ten different roots; h is rational."""
    slice_map = SliceMap.of(Manipulator(7, 2, 5, 14, 15, 13), fixed_leg=3)
    f, g = slice_map.f, slice_map.g
    j, _ = (reduced(p, 1, 1) for p in slice_map.trigonometric)
    rows: list[dict[tuple[int, ...], object]] = [{}, {}]
    for (i, k, m, n, power, omega), c in j.to_dict().items():
        rows[power][i, k, m, n, 0, omega] = c
    j0, j1 = (TRIG.from_dict(row) for row in rows)
    pairs = [(j0, (2, 1)), (j1, (1, 2))], [(slopes(leg)[1], (1, 1)) for leg in (f, g)]
    whole, parallel = (resultant(*(half_angles(p, d, 1, 1) for p, d in pair)) for pair in pairs)
    assert (whole.degree, parallel.degree) == (20, 8)
    circular = fmpz_poly([1, 0, 1])
    parallel_legs = parallel.polynomial.a / circular**2
    (x, y), (v, w) = times((f.m, f.n), (g.ax, g.ay)), times((g.m, g.n), (f.ax, f.ay))
    concurrent = quadratic(times((x - v, y - w), (f.m - g.m, g.n - f.n)))
    doubled = quadratic((f.ax, f.ay)) * quadratic((g.ax, g.ay)) * concurrent
    product = circular**2 * parallel_legs * doubled**2
    assert whole.polynomial.a == product / product.content() * (
        1 if whole.polynomial.a[20] * product[20] > 0 else -1
    )
    assert simple_and_finite(
        QuadraticPoly.rational(parallel_legs * doubled), 10, apart_from=[QuadraticPoly.rational(circular)]
    )


def test_the_divisions_by_phi_are_exact() -> None:
    """Theorem 15, with the numbers of terms that the page names."""
    assert (len(C.to_dict()), len(SWALLOW.to_dict())) == (436, 156)
    assert on_surface(E) == C * PHI
    assert on_surface(ALONG_E) == SWALLOW * PHI * PHI * J0
    # at a place of its own: L makes J vanish, and E is φ C / J1²
    place = {"z": 3, "w": -2, "a": 5, "n": 2, "N": 7, "b": 1, "B": 4}
    j0, j1, c, phi = (Fraction(int(p.subs(place).leading_coefficient())) for p in (J0, J1, C, PHI))
    e = sum(
        Fraction(int(row.subs(place).leading_coefficient())) * (-j0 / j1) ** k
        for k, row in enumerate(by_length(E))
    )
    assert j1 * j1 * e == phi * c


def orders_in_m(p: fmpz_mpoly, shift: int, degree: int) -> dict[int, int]:
    """Power of z → the least power of m.

    m and n occur as often as m̄, n̄ and z do, and all lengths together have the degree.
    """
    orders: dict[int, int] = {}
    for (in_z, _, _, a, n, _, b, b_bar), _ in p.to_dict().items():
        power = int(in_z) - shift
        twice = power + degree - int(a) - int(b) - int(b_bar)
        assert twice % 2 == 0
        orders[power] = min(orders.get(power, degree), twice // 2 - int(n))
    return orders


def orders_in_n(p: fmpz_mpoly, shift: int) -> dict[int, int]:
    orders: dict[int, int] = {}
    for powers in p.to_dict():
        power = int(powers[0]) - shift
        orders[power] = min(orders.get(power, int(powers[4])), int(powers[4]))
    return orders


def orders_in_side(p: fmpz_mpoly, shift: int) -> dict[int, int]:
    """Power of z → the least power of ā − b̄, which is that of a − B with a real a."""
    orders: dict[int, int] = {}
    order = 0
    while not p.is_zero():
        for powers in p.compose(Z, W, L, A, N, N_BAR, B, A).to_dict():
            orders.setdefault(int(powers[0]) - shift, order)
        p, order = p.derivative(7), order + 1
    return orders


@pytest.mark.parametrize(
    ("p", "shift", "degree", "least"),
    [
        (C, 6, 8, {5: 2, 4: 1, 3: 1, 2: 1}),
        (SWALLOW, 6, 8, {4: 1, 2: 1}),
        (M1, 4, 5, {3: 1}),
        (M2, 4, 5, {3: 1}),
    ],
    ids=["C", "W", "M1", "M2"],
)
def test_the_orders_of_sides_in_the_forms_of_the_census(
    p: fmpz_mpoly, shift: int, degree: int, least: dict[int, int]
) -> None:
    for orders in (orders_in_m(p, shift, degree), orders_in_n(p, shift), orders_in_side(p, shift)):
        assert max(orders) == max(least)
        assert all(orders[power] >= least.get(power, 0) for power in orders)
        assert p is not SWALLOW or all(power % 2 == 0 for power in orders)


@pytest.mark.parametrize("place", [{"n": 0}, {"b": 5}], ids=["n", "a - b"])
def test_no_side_divides_the_permanent_poses(place: dict[str, int]) -> None:
    """Z is not 0 where n or a − b is. With m and n exchanged, and a and b, it is the same up to its sign."""
    place = {"w": 2, "a": 5, "n": 3, "N": 7, "b": 11, "B": 4, **place}
    j0, j1 = J0.subs(place), J1.subs(place) / Z
    assert j1.degrees()[0] == 2
    assert j0.gcd(j1).is_constant()
