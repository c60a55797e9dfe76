"""The image of J = 0 by pieces: waves, pieces, runs, crossings and regions, against floats and each other."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import pairwise
from math import cos, sin
from random import Random

import pytest

from rpr_solver import Manipulator, SingularCurves, singular_curves
from rpr_solver.verify import arrangement as arrangements
from rpr_solver.verify.arrangement import Arrangement
from rpr_solver.verify.claims import OpenError
from rpr_solver.verify.core.schema import Document, read_document
from rpr_solver.verify.core.system import Surface, Trig
from rpr_solver.verify.courses import Stretch, Touching, wave_of
from rpr_solver.verify.folded import picture_of
from rpr_solver.verify.fronts import BITS, ONE, TURN, Front, Patch, Series, Wave
from rpr_solver.verify.images import OUTSIDE, is_simple
from rpr_solver.verify.mirrored import shape_of
from rpr_solver.verify.pieces import Patches, Piece, piece_between
from rpr_solver.verify.regions import Regions
from rpr_solver.verify.singular_curves import _Curves
from rpr_solver.verify.tips import Corners, Tip, tip_of, tips_of
from tests.support.families import family

SLICE = Manipulator(9, 4, 11, 14, 15, 13), 12, 3
"""Two components that cross each other, and one of them itself."""


@cache
def drawn() -> SingularCurves:
    manipulator, length, leg = SLICE
    return singular_curves(manipulator, length, fixed_leg=leg)


@cache
def regions() -> Regions:
    document: Document = read_document(drawn().to_json())
    return _Curves(document).regions


@cache
def arrangement() -> Arrangement:
    return regions().image()


def front() -> Front:
    return arrangement().chains[0][0].piece.front


def pieces(chain: int = 0) -> list[Piece]:
    return [leaf.piece for leaf in arrangement().chains[chain]]


def value(p: Trig, omega: float, alpha: float, theta: float) -> float:
    ca, sa, ct, st = cos(alpha), sin(alpha), cos(theta), sin(theta)
    return sum((a + b * omega) * ca**i * sa**j * ct**k * st**m for (i, j, k, m), (a, b) in p.items())


def test_waves_have_the_values_of_their_polynomial_and_bounds_of_their_derivatives() -> None:
    system = regions().points.slice.system
    draw, omega = Random(45), system.ring.radicand**0.5 if system.ring.radicand != 1 else 1.0
    for p in (system.singular, *(leg.squared for leg in system.legs)):
        wave = Wave.of(p, system.ring)
        for _ in range(5):
            alpha, theta = draw.uniform(-3, 3), draw.uniform(-3, 3)
            at = [front().phases(int((alpha + d) * ONE), int(theta * ONE)) for d in (-1e-4, 0, 1e-4)]
            low, here, high = (wave.jet(phases) for phases in at)
            assert here[0] / ONE == pytest.approx(value(p, omega, alpha, theta) / 2.0**wave.shift, abs=1e-9)
            assert (high[0] - low[0]) / ONE / 2e-4 == pytest.approx(here[1] / ONE, abs=1e-6)
            assert (high[1] - low[1]) / ONE / 2e-4 == pytest.approx(here[3] / ONE, abs=1e-6)
            assert (high[2] - low[2]) / ONE / 2e-4 == pytest.approx(here[4] / ONE, abs=1e-6)
            assert max(map(abs, here[1:3])) <= wave.norms[1]
            assert max(map(abs, here[3:])) <= wave.norms[2]
            assert abs(high[3] - low[3]) / ONE <= 2e-4 * wave.norms[3] / ONE


def test_pieces_hold_the_whole_curve() -> None:
    unit, shifts = regions().points.slice.system.unit, [leg.shift for leg in front().legs]
    found = [pieces(n) for n in range(len(arrangement().chains))]
    for chain in found:
        assert all(x.ends[1] == y.ends[0] for x, y in pairwise(chain))
        assert chain[-1].ends[1].image == pytest.approx(chain[0].ends[0].image, rel=1e-30)
    boxes = [[x / ONE for x in piece.box] for chain in found for piece in chain]
    for strand in drawn().strands:
        for lengths in zip(strand.first, strand.second, strict=True):
            x, y = ((length * unit) ** 2 / 2.0**shift for length, shift in zip(lengths, shifts, strict=True))
            assert any(a - 1e-9 < x < b + 1e-9 and c - 1e-9 < y < d + 1e-9 for a, b, c, d in boxes)


def test_a_piece_is_not_proved_where_it_bends_too_much_or_leads_backwards() -> None:
    chain = pieces()
    assert piece_between(front(), chain[0].ends[0], chain[0].ends[1]) is not None
    assert piece_between(front(), chain[0].ends[1], chain[0].ends[0]) is None
    assert piece_between(front(), chain[0].ends[0], chain[60].ends[1]) is None


def test_a_piece_is_cut_where_it_is_on_the_curve() -> None:
    first, last = pieces()[3].halves
    assert (first.ends[0], last.ends[1]) == pieces()[3].ends
    assert first.ends[1] == last.ends[0]
    assert all(half.reach < pieces()[3].reach for half in (first, last))


def test_a_run_is_simple_without_a_cusp_and_a_disc_about_a_cusp_has_no_image_twice() -> None:
    chain = pieces()
    at = [k for k, piece in enumerate(chain) if piece.cusps]
    assert len(frozenset().union(*(piece.cusps for piece in chain))) >= 2
    assert not is_simple([chain[at[0]]])
    assert not is_simple(chain)
    k = next(k for k in range(len(chain) - 1) if not chain[k].cusps | chain[k + 1].cusps)
    assert is_simple(chain[k : k + 2])
    for alpha, theta, _ in front().cusps:
        patch = Patch.about(front(), (alpha, theta), ONE >> 10)
        assert patch is not None
        assert patch.holds((alpha + TURN, theta), ONE >> 12)
        assert not patch.holds((alpha, theta), ONE >> 10)


def test_no_disc_with_two_poses_of_a_crossing_is_proved() -> None:
    for crossing in arrangement().crossings:
        (a, t), (b, u) = (leaf.piece.middle for leaf in crossing.leaves)
        reach = abs(a - b) + abs(t - u)
        assert Patch.about(front(), ((a + b) // 2, (t + u) // 2), reach) is None
        assert not arrangement().patches.hold(*(leaf.piece for leaf in crossing.leaves))


def crossings_of_chords() -> int:
    """The crossings of the images of all strands, by the chords of their samples."""
    rows = [
        (strand, k, *pair)
        for strand, row in enumerate(drawn().strands)
        for k, pair in enumerate(pairwise(zip(row.first, row.second, strict=True)))
    ]

    def side(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> bool:
        return (b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0])

    return sum(
        side(a, b, c) != side(a, b, d) and side(c, d, a) != side(c, d, b)
        for n, (s, i, a, b) in enumerate(rows)
        for t, k, c, d in rows[:n]
        if s != t or abs(i - k) > 1
    )


def test_crossings_and_regions_are_those_of_the_drawing() -> None:
    found = arrangement()
    assert len(found.crossings) == crossings_of_chords()
    assert found.number == len(drawn().regions)
    assert {leaf.chain for crossing in found.crossings for leaf in crossing.leaves} == {0, 1}


def test_the_sides_wind_as_often_as_half_of_the_poses() -> None:
    found = Arrangement([pieces(n) for n in range(2)], Patches())
    sides = [found.region(point) for point in regions().scaled_points()]
    found.complete()
    assert found.classes == found.number
    winding = {found.root(OUTSIDE): 0}
    edges = {side[:2] for side in found.sides if side != OUTSIDE}
    while len(winding) < found.number:
        for edge in edges:
            right, left = found.root((*edge, False)), found.root((*edge, True))
            if right in winding:
                assert winding.setdefault(left, winding[right] + 1) == winding[right] + 1
            elif left in winding:
                winding[right] = winding[left] - 1
    assert [2 * winding[found.root(side)] for side in sides] == [x.poses for x in drawn().regions]


def test_a_point_on_the_image_is_in_no_region_and_without_lines_nothing_is_complete(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = Arrangement([pieces(0)], Patches())
    x, y = pieces()[5].ends[0].image
    with pytest.raises(OpenError):
        found.region((Fraction(x, 1 << BITS), Fraction(y, 1 << BITS)))
    monkeypatch.setattr(arrangements, "_hits", lambda *_: iter(()))
    with pytest.raises(OpenError, match="too near"):
        Arrangement([pieces(0)], Patches()).complete()


def of_family(name: str, length: str) -> Regions:
    return _Curves(read_document(singular_curves(family(name), length).to_json())).regions


def test_a_tip_is_proved_in_the_directions_of_the_curve_alone() -> None:
    own = of_family("both flat", "31.6")
    front = Front.of(own.points.slice.system, own.cusps)
    leaving, coming = tips_of(front)[0, 0]
    assert leaving.ends[0] is leaving.node is coming.ends[1]
    x, y = leaving.arm.way
    assert tip_of(replace(leaving.arm, way=(x - y / 10, y + x / 10)), leaving.node, 12) is None
    assert Corners().hold(leaving, coming)
    assert not Corners().hold(leaving, leaving)
    tip, piece = leaving.halves
    assert isinstance(tip, Tip)
    assert isinstance(piece, Piece)
    assert Corners().hold(tip, piece)
    [(low, high, bottom, top), (a, b, c, d)] = (part.box for part in (leaving, tip))
    assert low <= a <= b <= high
    assert bottom <= c <= d <= top


@pytest.mark.parametrize(("name", "leg"), [("similar", 2), ("similar", 3), ("congruent, mirrored", 1)])
def test_a_tangent_of_a_bend_is_one_of_its_image(name: str, leg: int) -> None:
    """Also where the squares of both legs are divided by different powers of 2."""
    shape = shape_of(Surface(read_document(singular_curves(family(name), 20).to_json()).geometry, leg))
    assert shape is not None
    picture = picture_of(shape, Fraction(20))
    bends = [piece for chain in picture.chains for piece in chain if piece.course.is_bend]
    assert bends
    for piece in bends:
        (a, b), (x, y) = ([series.terms[k] / ONE for series in rows] for k, rows in _slopes(piece))
        assert a * y - b * x == pytest.approx(0, abs=1e-9)
        assert abs(x) + abs(y) > 1e-3


def _slopes(piece: Stretch) -> list[tuple[int, tuple[Series, Series]]]:
    """The image with the number of its derivative's term, and the tangent."""
    return [(1, piece.image), (0, piece.tangents)]


def test_tiny_numbers_are_no_waves_of_size_1() -> None:
    """Their errors are not small then."""
    with pytest.raises(OpenError, match="too long"):
        wave_of({(0, 0): Fraction(1, 3 << 200)})
    small = wave_of({(0, 0): Fraction(1, 3 << 200)}, 0)
    assert small.terms == ((0, 0, ONE // (3 << 200), 0),)


def test_a_bend_is_held_to_meet_a_fold_only_where_both_end() -> None:
    shape = shape_of(of_family("similar", "31.6").surface)
    assert shape is not None
    fold, _, bend = picture_of(shape, Fraction("31.6")).chains
    node = bend[0].ends[0]
    k = next(k for k, piece in enumerate(fold) if piece.ends[0] is node)
    here, there = bend[0], fold[k]
    while not Touching().hold(here, there):
        here, there = here.towards(node), there.towards(node)
    assert Touching().hold(bend[0], bend[-1])
    assert not Touching().hold(here, fold[k + 1])
    assert not Touching().hold(fold[k], fold[k - 1])
