"""The reference for one slice: by balls where its eliminant is generic, else over number fields."""

from __future__ import annotations

from fractions import Fraction
from functools import cache

import mpmath as mp
import pytest
from flint import arb, ctx, fmpz_poly

from rpr_solver import EXAMPLES, Manipulator, PoseKind, SliceTable, solve_slice
from rpr_solver.article.couples import CouplePoses, CuspBalls
from rpr_solver.exact.factors import ExactRoot, exact_roots, norm_factors
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import RealRoot, ball_of, real_roots
from rpr_solver.model.jets import HalfTangent
from rpr_solver.model.joint_points import ExactPose
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.reference import ReferenceSlice, SliceForms, poses_above
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


FIELD_BITS = 200
[ORIGIN] = exact_roots(norm_factors(QuadraticPoly.rational([0, 1])))
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


# a flat manipulator: four quadruple poses with all on one line


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


# what is left out


# the parts
