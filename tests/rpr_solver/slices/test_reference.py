"""The reference for one slice: by balls where its eliminant is generic, else over number fields."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction
from functools import cache
from math import isqrt

import mpmath as mp
import pytest
from flint import arb, ctx, fmpz_poly

from rpr_solver import EXAMPLES, Manipulator, PoseKind, SliceTable, SolverError, solve_slice
from rpr_solver.article.couples import CouplePoses, CuspBalls
from rpr_solver.exact.biform import BiForm, T, U
from rpr_solver.exact.factors import ExactRoot, exact_roots, norm_factors
from rpr_solver.exact.number_field import Field
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import RealRoot, ball_of, real_roots
from rpr_solver.model.jets import HalfTangent, Pose
from rpr_solver.model.joint_points import ExactPose, cos_sin
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.reference import Curve, ReferenceSlice, SliceForms, poses_above
from tests.support.article import coalescence, pose, singularity
from tests.support.families import family
from tests.support.newton import count_cusps
from tests.support.sampling import long
from tests.support.shared import eliminant_of


def slice_of(m: Manipulator, length: str, digits: int = 20, leg: int = 1) -> ReferenceSlice:
    return ReferenceSlice(eliminant_of(m, leg), Fraction(length), digits)


def method(table: SliceTable) -> str:
    return table.certificate["method"]


@pytest.mark.parametrize(
    ("name", "length"),
    [("congruent, mirrored", "9"), pytest.param("similar, mirrored", "7/2", marks=pytest.mark.long)],
)
def test_number_fields_and_balls_lead_to_the_same_cusps(
    name: str, length: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """To the last digit, where balls are not allowed to say anything."""
    own = slice_of(family(name), length).solve()
    assert own.count > 0
    monkeypatch.setattr(ReferenceSlice, "_by_balls", lambda *_: None)
    exact = slice_of(family(name), length).solve()
    assert exact.to_json()["cusps"] == own.to_json()["cusps"]
    assert exact.degenerate_points == own.degenerate_points
    assert (method(exact), exact.certificate["factors"]) == ("exact", own.certificate["factors"])


@pytest.mark.parametrize(
    ("a2x", "degree", "length"), [(30, 1, "17"), long(30, 1, "43"), long(-30, 0, "17"), long(-30, 0, "43")]
)
def test_where_a_leg_closes_stretched_along_its_base_line_poses_are_looked_at_exactly(
    a2x: int, degree: int, length: str
) -> None:
    """L1 = |A1A2| ± |B1B2|, so that leg 2 closes at θ1 = 0, or at 180° where u is infinite."""
    m = Manipulator(*map(Fraction, (a2x, 11, 27, 13, 9, 4)))
    common = slice_of(m, length)._touching()
    assert common is not None
    assert common.degree == degree
    assert degree == 0 or common(0, arb(0)) == 0
    table = slice_of(m, length).solve()
    assert method(table) == "exact"
    assert table.count == len(count_cusps(m, float(length), starts=10))
    beside = Fraction(length) + Fraction(1, 10**9)
    assert slice_of(m, str(beside))._touching() is None
    assert method(solve_slice(eliminant_of(m), beside, 15)) == "balls"


def test_a_generic_slice_is_proved_to_be_one() -> None:
    swallowtail = Manipulator(*map(Fraction, (2, -4, 4, 1, 4, 3)), orientation="cw")
    for m, length, generic in (
        (EXAMPLES["zein-flat"], "10", True),
        (EXAMPLES["zein-flat"], "17", False),
        (swallowtail, "1", False),
        (swallowtail, "1.000001", True),
        (family("similar"), "5", False),
        (family("congruent"), "5", False),
    ):
        assert slice_of(m, length).is_generic == generic


def test_a_root_that_could_be_spurious_is_not_generic() -> None:
    """Polynomials of degree 24 with simple roots, one of them at a known factor's."""

    def is_generic(q: fmpz_poly) -> bool:
        x = slice_of(EXAMPLES["zein-flat"], "10")
        x.q = QuadraticPoly.rational(q)
        return x.is_generic

    known = slice_of(EXAMPLES["zein-flat"], "10")
    f = known.slice_map.f
    assert is_generic(fmpz_poly([-2, *[0] * 23, 1]))
    for factor in (f.collinear.a, f.closed(known.scaled).a, fmpz_poly([1, 0, 1])):
        assert not is_generic(factor * fmpz_poly([-2, *[0] * (23 - factor.degree()), 1]))


@pytest.mark.parametrize(
    ("name", "length"),
    [("congruent, mirrored", "9"), ("similar", "5"), ("both flat", "3")],
)
def test_a_slice_that_is_decided_exactly_accounts_for_the_whole_resultant(name: str, length: str) -> None:
    table = slice_of(family(name), length).solve()
    assert method(table) == "exact"
    assert sum(f["degree"] * f["multiplicity"] for f in table.certificate["factors"]) == 48
    assert table.certificate["eliminant_degree"] == 24


@pytest.mark.parametrize(
    ("leg", "origins"),
    [
        (1, ["L2=0", "leg 1 along A1A2"]),
        (2, ["L1=0", "leg 2 along A1A2"]),
        (3, ["L1=0", "leg 3 along A1A3"]),
    ],
)
def test_known_factors_are_named_by_the_leg_that_closes(leg: int, origins: list[str]) -> None:
    """The leg f of the slice map: the first of the free ones."""
    factors = solve_slice(eliminant_of(EXAMPLES["zein-flat"], leg), 10, 15).certificate["factors"]
    shapes = [(2, 1), (2, 2), (2, 9), (24, 1)]
    expected = zip(shapes, [*origins, "circular", "cusps"], strict=True)
    assert [((f["degree"], f["multiplicity"]), f["origin"]) for f in factors] == list(expected)


def test_roots_at_infinity_are_accounted_for() -> None:
    """The swallowtail at L1 = 1 lies at u = ∞, twice."""
    certificate = (
        slice_of(Manipulator(*map(Fraction, (2, -4, 4, 1, 4, 3)), orientation="cw"), "1").solve().certificate
    )
    cusps = [(f["degree"], f["multiplicity"]) for f in certificate["factors"] if f["origin"] == "cusps"]
    assert cusps == [(22, 1), (1, 2)]
    assert certificate["eliminant_degree"] == 24


def test_where_a_curve_is_shared_the_known_factors_are_not_claimed() -> None:
    certificate = slice_of(family("congruent"), "5").solve().certificate
    assert {f["origin"] for f in certificate["factors"]} <= {"cusps"}
    assert method(slice_of(family("congruent"), "5").solve()) == "exact"


BITS = 400
IRRATIONAL = Manipulator(*map(Fraction, (7, 3, 5, 4, 5, 6)), orientation="cw")
SLICES = {"flat": (EXAMPLES["zein-flat"], "10"), "triangle": (IRRATIONAL, "5/2")}


@cache
def roots_of(name: str) -> list[RealRoot]:
    m, length = SLICES[name]
    eliminant = eliminant_of(m)
    return real_roots(eliminant.at(Fraction(length) * eliminant.slice_map.scale))


def poses_of(name: str, bits: int = BITS) -> CouplePoses:
    m, length = SLICES[name]
    slice_map = eliminant_of(m).slice_map
    return CouplePoses(slice_map, Fraction(length) * slice_map.scale, bits)


def cusps_of(name: str) -> list[tuple[arb, HalfTangent, CuspBalls]]:
    poses, result = poses_of(name), []
    with ctx.workprec(BITS):
        for root in roots_of(name):
            u = root.refined(BITS - 64)
            t = poses.alpha(u)
            assert t is not None
            cusp = poses.cusp(u, t)
            assert cusp is not None
            result.append((u, t, cusp))
    return result


def text(x: arb) -> str:
    """Its middle to forty digits."""
    return str(x.str(40, radius=False))


@pytest.mark.parametrize("name", SLICES)
def test_above_every_root_lies_a_cusp_of_the_article(name: str) -> None:
    m, length = SLICES[name]
    cusps = cusps_of(name)
    assert len(cusps) == {"flat": 4, "triangle": 6}[name]
    with mp.workdps(38):
        for _, _, cusp in cusps:
            at = pose(m, length, text(cusp.alpha_deg), text(cusp.theta_deg))
            assert abs(singularity(m, at)) < mp.mpf(10) ** -30
            assert abs(coalescence(m, at)) < mp.mpf(10) ** -30
            for own, ball in zip(at.lengths[1:], (cusp.first, cusp.second), strict=True):
                assert abs(own - mp.mpf(text(ball))) < mp.mpf(10) ** -30


@pytest.mark.parametrize("name", SLICES)
def test_angles_are_those_of_the_half_tangents(name: str) -> None:
    for u, t, cusp in cusps_of(name):
        for degrees, tangent in (
            (cusp.theta_deg, float(u)),
            (cusp.alpha_deg, float(t.numerator / t.denominator)),
        ):
            assert float(degrees) == pytest.approx(math.degrees(2 * math.atan(tangent)))


@pytest.mark.parametrize("name", SLICES)
def test_balls_are_as_thin_as_the_precision_allows(name: str) -> None:
    for _, t, cusp in cusps_of(name):
        balls = (t.numerator, t.denominator, cusp.alpha_deg, cusp.theta_deg, cusp.first, cusp.second)
        assert min(x.rel_accuracy_bits() for x in balls) > BITS // 2


def test_a_wide_root_has_no_pose() -> None:
    """Over u ± 1/10 the subresultant may vanish; over u ± 1/2 it may be no cusp."""
    poses = poses_of("flat")
    with ctx.workprec(BITS):
        for root in roots_of("flat"):
            u = root.refined(100)
            assert poses.alpha(arb(u.mid(), 0.1)) is None
            t = poses.alpha(u)
            assert t is not None
            assert poses.cusp(arb(u.mid(), 0.5), t) is None


def test_what_is_uncertain_is_no_cusp() -> None:
    """The true pose, with one half tangent or the other known too roughly, or with α about 180°."""
    poses = poses_of("triangle")
    with ctx.workprec(BITS):
        for u, t, _ in cusps_of("triangle"):
            wide = HalfTangent(arb(t.numerator.mid(), abs(t.numerator).upper()), t.denominator)
            assert poses.cusp(u, wide) is None
            assert poses.cusp(u, HalfTangent(t.numerator, arb(0, abs(t.denominator).upper()))) is None


def test_a_half_turn_of_the_platform_is_left_to_number_fields() -> None:
    """A regular pose far from all conditions: only its α = 180° speaks against it."""
    poses = poses_of("triangle")
    with ctx.workprec(BITS):
        u = arb(1) / 3
        assert poses.cusp(u, HalfTangent(arb(1), arb(1) / 1000)) is not None
        assert poses.cusp(u, HalfTangent(arb(1), arb(0))) is None


FIELD_BITS = 200
[ORIGIN] = exact_roots(norm_factors(QuadraticPoly.rational([0, 1])))
RATIONALS = Field.rationals()
SWALLOWTAIL = Manipulator(*map(Fraction, (2, -4, 4, 1, 4, 3)), orientation="cw")
"""One swallowtail at L1 = 1, at θ = 180°."""


def forms_of(m: Manipulator, length: Fraction | int, leg: int = 1) -> SliceForms:
    slice_map = SliceMap.of(m, leg)
    return SliceForms.of(slice_map, length * slice_map.scale)


def exact_roots_of(m: Manipulator, length: Fraction | int) -> list[ExactRoot]:
    eliminant = eliminant_of(m)
    return list(exact_roots(norm_factors(eliminant.at(length * eliminant.slice_map.scale))))


def ball(x: arb | Fraction) -> arb:
    return ball_of(x) if isinstance(x, Fraction) else x


def degrees(poses: Iterable[ExactPose]) -> list[tuple[PoseKind, int, int]]:
    """Kind, α and θ, of poses at whole degrees."""
    result = []
    for x in poses:
        a, t = (ball.unique_fmpz() for ball in x.coordinates(FIELD_BITS)[:2])
        assert a is not None
        assert t is not None
        result.append((x.kind, int(a), int(t)))
    return sorted(result)


# a flat manipulator: four quadruple poses with all on one line


FLAT = family("both flat")
LENGTH = 3


def flat_poses(unit: Fraction = Fraction(1)) -> list[ExactPose]:
    """All lengths times a unit."""
    m = Manipulator(*(getattr(FLAT, name) * unit for name in ("a2x", "a3x", "a3y", "d1", "d2", "d3")))
    forms = forms_of(m, LENGTH * unit)
    return [x for root in (ORIGIN, None) for x in poses_above(forms, root)]


def test_both_half_turns_are_found() -> None:
    quadruple = PoseKind.QUADRUPLE
    assert degrees(flat_poses()) == [(quadruple, a, t) for a in (0, 180) for t in (0, 180)]


@pytest.mark.parametrize("unit", [Fraction(1), Fraction(2, 7)])
def test_rational_lengths_are_exact(unit: Fraction) -> None:
    """On a line a leg is the distance of two numbers."""
    for x in flat_poses(unit):
        [(_, alpha, theta)] = degrees([x])
        b1 = LENGTH if theta == 0 else -LENGTH
        side = 1 if alpha == 0 else -1
        expected = abs(b1 + 7 * side - 20) * unit, abs(b1 + 16 * side - 6) * unit
        assert tuple(x.coordinates(FIELD_BITS)[2:]) == expected


def test_a_closed_leg_has_the_length_zero() -> None:
    """L1 = 13, B1B2 = 7 and A1A2 = 20: at α = θ = 0 the second leg closes."""
    poses = list(poses_above(forms_of(FLAT, 13), ORIGIN))
    closed = [x for x in poses if x.local.squared_lengths()[0].is_zero]
    assert [x.coordinates(FIELD_BITS)[2] for x in closed] == [0]


# a swallowtail, and cusps beside it


@cache
def poses_of_the_swallowtail() -> list[ExactPose]:
    """The swallowtail lies at θ = 180°, where u has no value."""
    forms = forms_of(SWALLOWTAIL, 1)
    return [x for root in (*exact_roots_of(SWALLOWTAIL, 1), None) for x in poses_above(forms, root)]


@pytest.mark.long
def test_a_slice_with_a_swallowtail() -> None:
    """Every pose with J = E = 0; the article's conditions hold there, though at θ = 180° they say 0 = 0."""
    poses = poses_of_the_swallowtail()
    assert sorted(x.kind for x in poses) == [PoseKind.CUSP] * 4 + [PoseKind.SWALLOWTAIL]
    assert [bool(x.coordinates(FIELD_BITS)[1] == 180) for x in poses] == [False] * 4 + [True]
    with mp.workdps(38), ctx.workprec(FIELD_BITS):
        for x in poses:
            balls = tuple(map(ball, x.coordinates(FIELD_BITS)))
            alpha, theta, *free = (b.str(40, radius=False) for b in balls)
            at = pose(SWALLOWTAIL, "1", alpha, theta)
            assert abs(singularity(SWALLOWTAIL, at)) < mp.mpf(10) ** -30
            if x.kind is PoseKind.CUSP:
                assert abs(coalescence(SWALLOWTAIL, at)) < mp.mpf(10) ** -30
            for own, text in zip(at.lengths[1:], free, strict=True):
                assert abs(own - mp.mpf(text)) < mp.mpf(10) ** -30


@pytest.mark.long
def test_irrational_lengths_are_not_called_rational() -> None:
    for x in poses_of_the_swallowtail():
        for length, square in zip(x.coordinates(FIELD_BITS)[2:], x.local.squared_lengths(), strict=True):
            value = square.rational
            assert isinstance(length, arb) == (value is None or not is_square(value))


def is_square(x: Fraction) -> bool:
    return all(isqrt(n) ** 2 == n for n in (x.numerator, x.denominator))


# what is left out


def test_ordinary_poses_are_left_out() -> None:
    """θ = 0 puts leg 1 along A1A2: ∇f = 0 at a pose there, so J = E = 0, and it is no more than that."""
    assert list(poses_above(forms_of(EXAMPLES["zein-flat"], 10), ORIGIN)) == []
    assert list(poses_above(forms_of(EXAMPLES["zein-flat"], 10), None)) == []


def test_poses_on_a_shared_curve_are_left_out() -> None:
    """α = 0, then α = 180°, and then θ = 0, on which both poses lie, of a flat manipulator."""
    forms = forms_of(FLAT, LENGTH)
    quadruple = PoseKind.QUADRUPLE
    assert degrees(poses_above(replace(forms, shared=(Curve(T),)), ORIGIN)) == [(quadruple, 180, 0)]
    assert degrees(poses_above(replace(forms, shared=(Curve(None),)), ORIGIN)) == [(quadruple, 0, 0)]
    assert degrees(poses_above(replace(forms, shared=(Curve(U),)), ORIGIN)) == []


def test_a_line_of_poses_is_refused() -> None:
    forms = forms_of(EXAMPLES["zein-flat"], 10)
    u = BiForm.of(U, forms.slice_map.radicand, 0, 1)
    on_a_line = replace(forms, singular=forms.singular * u, coalescence=forms.coalescence * u)
    with pytest.raises(SolverError, match="line theta = const"):
        list(poses_above(on_a_line, ORIGIN))


# the parts


@pytest.mark.parametrize("leg", [1, 2, 3])
@pytest.mark.parametrize("t", [Fraction(1, 2), None])
def test_jets_at_a_rational_pose(leg: int, t: Fraction | None) -> None:
    """f and g by the corners of the platform, with ω = 1 as in every rational manipulator."""
    slice_map = SliceMap.of(family("similar"), leg)
    u, length = Fraction(-2, 3), Fraction(7)
    cos_a, sin_a = (Fraction(-1), Fraction(0)) if t is None else (Fraction(3, 5), Fraction(4, 5))
    x, y = length * Fraction(5, 13), length * Fraction(-12, 13)
    angles = (cos_sin(None if half is None else RATIONALS(half), RATIONALS, 1) for half in (t, u))
    at = Pose(*(x for pair in angles for x in pair), RATIONALS(length), RATIONALS(1))
    local = ExactPose.of(slice_map, at).local
    for leg_map, square in zip((slice_map.f, slice_map.g), local.squared_lengths(), strict=True):
        along = x + cos_a * leg_map.m - sin_a * leg_map.n - leg_map.ax
        across = y + sin_a * leg_map.m + cos_a * leg_map.n - leg_map.ay
        assert square.rational == along**2 + across**2
    assert local.f.order == local.g.order == 4


def test_coordinates_hold_irrational_numbers() -> None:
    """A pose at tan(α/2) = √2 and tan(θ/2) = −√2, with L = √2."""
    [_, root] = exact_roots(norm_factors(QuadraticPoly(fmpz_poly([-2, 0, 1]), fmpz_poly([0]), 1)))
    u, one = root.in_field()
    slice_map = SliceMap.of(family("similar"))
    x = ExactPose.of(slice_map, Pose(*cos_sin(u, u.field, 1), *cos_sin(-u, u.field, 1), u, one))
    with ctx.workprec(FIELD_BITS):
        angle = 2 * arb(2).sqrt().atan() * 180 / arb.pi()
        squares = [square.ball(FIELD_BITS) for square in x.local.squared_lengths()]
        lengths = [square.sqrt() / slice_map.scale_ball() for square in squares]
        own = map(ball, x.coordinates(FIELD_BITS))
        for got, expected in zip(own, (angle, -angle, *lengths), strict=True):
            assert got.overlaps(expected)
            assert got.rel_accuracy_bits() > FIELD_BITS - 40
