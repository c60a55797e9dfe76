"""Cusp curves: names, ends, samples; against the census, slices, and a walk in floating point."""

import json
from collections import Counter
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import (
    EXAMPLES,
    Census,
    CuspCurves,
    Manipulator,
    cusp_curves,
    cusp_table,
    eliminate,
)
from tests.rpr_solver.curves.long_run import failures, lengths_beside
from tests.support.families import FAMILIES, family
from tests.support.sampling import long
from tests.support.shared import census_of, curves_of
from tests.support.strategies import examples, manipulators, unless_refused

INNOCENTI = EXAMPLES["innocenti"]
FAMILY_LEGS = [(name, i % 3 + 1) for i, name in enumerate(FAMILIES)]
QUICK = ("similar",)


def alive(curves: CuspCurves, length: Fraction) -> int:
    """The number of curves that pass a length, by their ends."""
    return sum(
        Fraction(c.start.length or 0) < length and (c.stop.length is None or length < Fraction(c.stop.length))
        for c in curves.curves
    )


def check_ends(curves: CuspCurves) -> None:
    """Joins are mutual and at one length; names are unique and in the order of birth."""
    by_name = {c.name: c for c in curves.curves}
    assert list(by_name) == [f"C{i + 1}" for i in range(len(curves.curves))]
    starts = [Fraction(c.start.length or 0) for c in curves.curves]
    assert starts == sorted(starts)
    for c in curves.curves:
        for side in ("start", "stop"):
            end = getattr(c, side)
            if end.joins is not None:
                other = getattr(by_name[end.joins], side)
                assert (other.joins, other.length, other.kind) == (c.name, end.length, end.kind)


def agrees_with(curves: CuspCurves, whole: Census) -> None:
    ends = [Fraction(0), *(Fraction(t.length) for t in whole.transitions)]
    middles = [*((a + b) / 2 for a, b in pairwise(ends)), ends[-1] + 1]
    assert [alive(curves, length) for length in middles] == list(whole.counts)


@pytest.mark.parametrize(
    ("name", "fixed_leg"),
    [
        long("innocenti", 1),
        ("zein-flat", 3),
        long("fourteen-cusps", 2),
    ],
)
def test_generic_curves_begin_and_end_in_pairs(name: str, fixed_leg: int) -> None:
    curves = curves_of(EXAMPLES[name], fixed_leg)
    check_ends(curves)
    agrees_with(curves, census_of(EXAMPLES[name], fixed_leg))
    ends = [end for c in curves.curves for end in (c.start, c.stop)]
    assert all((end.kind == "open") == (end.joins is None) for end in ends)
    assert all(len(end.events) == (end.kind != "open") for end in ends)


def test_curves_that_nearly_are_one_are_followed_apart() -> None:
    """Within 2e-6 of similar triangles cusps are close to each other on the whole way, and events too."""
    m = Manipulator("8.5", "1.9575", "22.4147", "60.6333", "166.563", "160.5")
    curves = cusp_curves(m, digits=15)
    agrees_with(curves, census_of(m))
    ends = [end for c in curves.curves for end in (c.start, c.stop)]
    assert all(end.joins is not None for end in ends)


def test_the_first_manipulators_curves() -> None:
    """Twelve pairs are born; four cusps remain for every L1 beyond the last transition."""
    curves = curves_of(INNOCENTI)
    assert len(curves.curves) == 24
    assert [c.name for c in curves.curves if c.stop.length is None] == ["C2", "C8", "C16", "C18"]
    ten = [c for c in curves.curves if alive(replace(curves, curves=(c,)), Fraction("28.1"))]
    assert len(ten) == 10
    short = next(c for c in ten if c.name == "C22")
    assert (short.start.kind, short.stop.kind) == ("beak-to-beak", "swallowtail")
    assert (short.start.joins, short.stop.joins) == ("C21", "C6")


@pytest.mark.parametrize(
    ("name", "fixed_leg"),
    [x if x[0] in QUICK else long(*x) for x in FAMILY_LEGS],
)
def test_every_family_agrees_with_its_census(name: str, fixed_leg: int) -> None:
    curves = curves_of(family(name), fixed_leg)
    check_ends(curves)
    agrees_with(curves, census_of(family(name), fixed_leg))


@pytest.mark.long
@pytest.mark.parametrize("fixed_leg", [1, 2, 3])
@pytest.mark.parametrize("sides", [(8, 4, 3, 8, 5, 5), (6, 3, 4, 6, 5, 5)])
def test_mirrored_congruent_isosceles_triangles_have_all_curves(
    sides: tuple[int, ...], fixed_leg: int
) -> None:
    """Their poses are symmetric, so curves meet in pairs, beside curves of singular poses that stay."""
    m = Manipulator(*sides, orientation="cw")
    curves = curves_of(m, fixed_leg)
    check_ends(curves)
    agrees_with(curves, census_of(m, fixed_leg))


@pytest.mark.long
def test_a_cusp_that_passes_a_degenerate_pose_begins_a_new_curve() -> None:
    """With leg 2 fixed the right-angled manipulator has six cusps near L2 = 16, and five and a node at it."""
    curves = curves_of(family("right angles"), 2)
    ended = [c for c in curves.curves if c.stop.length == "16.0000000000000000000000000000"]
    begun = [c for c in curves.curves if c.start.length == "16.0000000000000000000000000000"]
    assert len(ended) == len(begun) == 1
    assert ended[0].stop.kind == begun[0].start.kind == "node"
    at = curves.sampled([Fraction(16)])
    assert sum(len(c.points) for c in at.curves) == 5
    assert not any(c.points for c in at.curves if c in (*ended, *begun))


@pytest.mark.long
def test_cusps_at_a_pose_that_is_the_same_for_every_length_have_one_curve() -> None:
    curves = cusp_curves(Manipulator(6, 3, 4, 6, 5, 5, "cw"), fixed_leg=2, digits=15)
    ends = [(c.start.kind, c.stop.kind) for c in curves.curves]
    assert ends == [("open", "open")] * 2 + [("node", "open")] * 4
    still = curves.curves[0]
    assert {p.point.coordinates[:2] for p in still.points} == {("0", "0")}


@pytest.mark.long
def test_a_quadruple_point_at_an_irrational_length_is_passed_by_no_curve() -> None:
    curves = curves_of(family("flat base"), 1)
    assert not any("undecided" in (c.start.kind, c.stop.kind) for c in curves.curves)
    [ended] = [c for c in curves.curves if c.stop.kind == "quadruple"]
    [begun] = [c for c in curves.curves if c.start.kind == "quadruple"]
    assert ended.stop.length == begun.start.length
    assert [p.kind for p in ended.stop.events] == ["quadruple"]


def test_points_are_the_cusps_of_the_slices() -> None:
    lengths = [Fraction("14.98"), Fraction("28.1"), Fraction(100)]
    curves = curves_of(INNOCENTI).sampled(lengths)
    for table in cusp_table(INNOCENTI, lengths, digits=30):
        points = [p for c in curves.curves for p in c.points if p.length == table.length]
        assert sorted(p.cusp for p in points) == list(range(1, table.count + 1))
        assert all(p.point == table.cusps[p.cusp - 1] for p in points)


def test_names_do_not_depend_on_what_is_asked_for() -> None:
    whole = curves_of(INNOCENTI)
    lengths = [Fraction(26) + Fraction(i, 2) for i in range(9)]
    together = whole.sampled(lengths)
    for length in lengths[::4]:
        alone = whole.sampled([length]).within(length - 1, length + 1)
        assert {c.name: p.cusp for c in alone.curves for p in c.points} == {
            c.name: p.cusp for c in together.curves for p in c.points if p.length == length
        }


@pytest.mark.slow
@pytest.mark.parametrize("exponent", [12, long(60)])
def test_slices_right_beside_transitions(exponent: int) -> None:
    """The cusps that merge there are followed as far as they are distinct."""
    precise = census_of(INNOCENTI, digits=80)
    whole = curves_of(INNOCENTI)
    for transition in (precise.transitions[-1], precise.transitions[-2], precise.transitions[2]):
        at = Fraction(transition.length)
        below, above = (at * (1 + sign * Fraction(1, 10**exponent)) for sign in (-1, 1))
        curves = whole.sampled([below, above])
        for length, count in ((below, transition.count_before), (above, transition.count_after)):
            passing = [c for c in curves.curves if any(p.length == length for p in c.points)]
            assert len(passing) == count
            for c in passing:
                assert Fraction(c.start.length or 0) <= length * (1 + Fraction(1, 10**29))
                assert c.stop.length is None or Fraction(c.stop.length) >= length * (1 - Fraction(1, 10**29))


@pytest.mark.long
def test_beside_an_end_that_is_undecided_each_cusp_is_on_one_curve() -> None:
    """Beside similar triangles, where tubes lead through the lengths at which curves are cut."""
    m = Manipulator(30, 0, "40.01", 15, 25, 20)
    whole = cusp_curves(m, digits=15)
    ends = {end.length for c in whole.curves for end in (c.start, c.stop) if end.kind.value == "undecided"}
    assert ends
    lengths = lengths_beside({Fraction(text) for text in ends if text})
    assert list(failures(whole, eliminate(m, 1), lengths)) == []


def test_the_farthest_slices_are_reached() -> None:
    lengths = [Fraction(1, 10**20), Fraction(10**12)]
    curves = curves_of(INNOCENTI).sampled(lengths)
    assert [[p.length for p in c.points] for c in curves.curves if c.points] == [[Fraction(10**12)]] * 4


def test_a_part_of_the_range() -> None:
    whole = curves_of(INNOCENTI)
    part = whole.within(Fraction("28.1"), Fraction("28.2"))
    assert (part.range.start, part.range.stop) == (Fraction("28.1"), Fraction("28.2"))
    assert {c.name for c in part.curves} <= {c.name for c in whole.curves}
    assert len(part.curves) == 10
    lengths = whole.spread(4, Fraction("28.1"), Fraction("28.2"))
    assert all(Fraction("28.1") < x < Fraction("28.2") for x in lengths)
    assert len(lengths) == 8
    assert len(whole.within(Fraction(40), None).curves) == 4
    assert all(40 < x < 80 for x in whole.spread(5, Fraction(40)))


@pytest.mark.slow
def test_a_part_has_the_points_that_are_asked_for() -> None:
    whole = curves_of(EXAMPLES["zein-flat"], digits=15)
    start, stop = Fraction(20), Fraction(21)
    assert whole.part(start, stop) == whole.within(start, stop)
    lengths = [Fraction("20.5"), *whole.spread(1, start, stop)]
    part = whole.part(start, stop, lengths=[Fraction("20.5")], samples=1)
    assert part == whole.sampled(lengths).within(start, stop)
    assert {p.length for curve in part.curves for p in curve.points} == set(lengths)


def test_documents_are_read_back() -> None:
    for leg in (1, 3):
        curves = curves_of(EXAMPLES["zein-flat"], leg)
        assert CuspCurves.from_json(json.loads(json.dumps(curves.to_json()))) == curves


def shape(curves: CuspCurves, factor: int = 1) -> Counter[tuple[object, ...]]:
    """The ends of all curves, at lengths divided by a factor."""

    def length(text: str | None) -> Fraction | None:
        return None if text is None else Fraction(text) / factor

    return Counter(
        (length(c.start.length), c.start.kind, length(c.stop.length), c.stop.kind) for c in curves.curves
    )


@pytest.mark.long
@pytest.mark.timeout(400)
@pytest.mark.hypothesis
def test_scale_and_mirror() -> None:
    answers = Counter[str]()
    factor = 10**7  # it moves the decimal point only

    @given(manipulators(size=6, denominators=(1,)), st.sampled_from([1, 2, 3]))
    @examples(1)
    def agree(m: Manipulator, fixed_leg: int) -> None:
        names = ("a2x", "a3x", "a3y", "d1", "d2", "d3")
        larger = replace(m, **{name: getattr(m, name) * factor for name in names})
        mirrored = replace(m, a3y=-m.a3y, orientation="cw" if m.orientation == "ccw" else "ccw")
        own = unless_refused(lambda: cusp_curves(m, fixed_leg=fixed_leg, digits=15), answers)
        scaled, reflected = (cusp_curves(x, fixed_leg=fixed_leg, digits=15) for x in (larger, mirrored))
        check_ends(own)
        assert shape(own) == shape(scaled, factor) == shape(reflected)
        assert [c.name for c in own.curves] == [c.name for c in scaled.curves]

    agree()
    assert answers["refused"] <= answers["given"] / 4
