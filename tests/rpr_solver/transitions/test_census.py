"""The census: known transitions, agreement with slices, invariances, every degenerate family."""

from collections import Counter
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from functools import partial
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import (
    EXAMPLES,
    Census,
    Manipulator,
    census,
    eliminate,
    exact_str,
    solve_slice,
)
from rpr_solver.transitions.survey import survey
from tests.support.discriminant import candidate_lengths
from tests.support.families import FAMILIES, family
from tests.support.sampling import long, sample
from tests.support.shared import census_of, eliminant_of
from tests.support.strategies import examples, lengths, manipulators, unless_refused

slow = partial(pytest.param, marks=pytest.mark.slow)
DEAR_FAMILIES = ("isosceles, irrational", "d1 = a2x", "congruent, mirrored", "similar, mirrored", "isosceles")


def count_at(document: Census, length: Fraction) -> int:
    return document.counts[sum(Fraction(t.length) < length for t in document.transitions)]


def test_the_first_manipulators_largest_transitions() -> None:
    """The article's section IV.3: four cusps for every L1 beyond 31."""
    known = [
        ("26.7863808709", 6, 8), ("28.0948944789", 8, 10), ("28.1074306006", 10, 8), ("28.2578652083", 8, 6),
        ("30.7403750266", 6, 8), ("30.7792617125", 8, 6), ("30.9469140343", 6, 4),
    ]  # fmt: skip
    document = census_of(EXAMPLES["innocenti"])
    largest = document.transitions[-len(known) :]
    rounded = [(f"{Decimal(t.length):.10f}", t.count_before, t.count_after) for t in largest]
    assert rounded == known
    assert all(len(t.length.replace(".", "").lstrip("0")) == 30 for t in document.transitions)
    assert count_at(document, Fraction("28.1")) == 10
    assert document.counts[-1] == 4
    assert max(document.counts) == 10


@pytest.mark.parametrize("fixed_leg", [1, long(2), slow(3)])
@pytest.mark.parametrize(
    "name", [long("innocenti"), "zein-flat", long("twelve-cusps"), long("fourteen-cusps")]
)
def test_generic_events_change_the_count_by_two(name: str, fixed_leg: int) -> None:
    document = census_of(EXAMPLES[name], fixed_leg)
    for t in document.transitions:
        assert t.kind in ("swallowtail", "lips", "beak-to-beak")
        assert abs(t.count_after - t.count_before) == 2


def test_windows_narrower_than_any_scan_are_found() -> None:
    ends = [Fraction(t.length) for t in census_of(EXAMPLES["innocenti"]).transitions]
    gaps = [b - a for a, b in pairwise(ends)]
    assert min(gaps) < Fraction(1, 10**8)
    narrow = gaps.index(min(gaps))
    inside = (ends[narrow] + ends[narrow + 1]) / 2
    eliminant = eliminant_of(EXAMPLES["innocenti"])
    outside = ends[narrow] - min(gaps)
    assert solve_slice(eliminant, inside, 15).count == solve_slice(eliminant, outside, 15).count + 2


@pytest.mark.parametrize(
    ("name", "fixed_leg"),
    [
        *(long(name, 1) if name in DEAR_FAMILIES else (name, 1) for name in FAMILIES),
        *(long(name, 2 + i % 2) for i, name in enumerate(FAMILIES)),
    ],
)
def test_every_family_agrees_with_its_slices(name: str, fixed_leg: int) -> None:
    manipulator = family(name)
    document = census_of(manipulator, fixed_leg)
    eliminant = eliminant_of(manipulator, fixed_leg)
    ends = [Fraction(0), *(Fraction(t.length) for t in document.transitions)]
    middles = [(a + b) / 2 for a, b in pairwise(ends)]
    for length in [*middles[::3], ends[-1] + 1, Fraction(7, 5), Fraction(61, 3)]:
        assert solve_slice(eliminant, length, 15).count == count_at(document, length)


SHARED_ANGLES = {
    "right angles": (family("right angles"), 1),
    "right angles, at the third leg": (family("right angles"), 3),
    "similar, mirrored": (family("similar, mirrored"), 1),
    "isosceles, equal bases": (Manipulator(*map(Fraction, (2, 1, -4, 2, 4, 4))), 1),
    "isosceles, equal bases, 180 deg": (Manipulator(*map(Fraction, (-4, -2, 5, 4, 2, 2))), 2),
}
"""Manipulators with a platform angle at which all poses are degenerate."""


@pytest.mark.parametrize("name", sample(SHARED_ANGLES, 1, 3))
def test_degenerate_angles_leave_isolated_events(name: str) -> None:
    m, fixed_leg = SHARED_ANGLES[name]
    document = census_of(m, fixed_leg)
    assert document.certificate["method"] == "events"
    assert all(t.events and t.kind != "unclassified" for t in document.transitions)
    eliminant = eliminate(m, fixed_leg)
    ends = [Fraction(0), *(Fraction(t.length) for t in document.transitions)]
    for length in [*((a + b) / 2 for a, b in pairwise(ends)), ends[-1] + 1, ends[-1] * 7]:
        assert solve_slice(eliminant, length, 15).count == count_at(document, length)


@pytest.mark.long
@pytest.mark.parametrize("name", ["similar, mirrored"])
def test_the_discriminant_agrees(name: str) -> None:
    """If both methods apply, the events are among the lengths of the discriminant."""
    m, fixed_leg = SHARED_ANGLES[name]
    candidates = [x.scaled_length(300) for x in candidate_lengths(eliminant_of(m, fixed_leg))]
    found = survey(m, fixed_leg, lambda *_: None)
    changes = [
        group[0].scaled_length(300)
        for group, below, above in zip(found.groups, found.slices, found.slices[1:], strict=False)
        if below.count != above.count
    ]
    assert changes
    assert all(any(length.overlaps(x) for x in candidates) for length in changes)


def test_two_cusps_are_at_the_pose_where_they_merge() -> None:
    m = family("right angles")
    last = census_of(m, 3).transitions[-1]
    assert last.kind == "swallowtail"
    [merged] = last.events
    eliminant = eliminant_of(m, 3)
    table = solve_slice(eliminant, Fraction(last.length) * (1 - Fraction(1, 10**20)), 30)
    near = [
        c
        for c in table.cusps
        if abs(Fraction(c.alpha_deg) - Fraction(merged.point.alpha_deg)) < Fraction(1, 10**6)
        and abs(Fraction(c.l2) - Fraction(merged.point.l2)) < Fraction(1, 10**6)
    ]
    assert len(near) == 2


@pytest.mark.parametrize("name", ["similar", "congruent", "both flat"])
@pytest.mark.parametrize("fixed_leg", [1, long(2), 3])
def test_non_cuspidal_families_have_no_cusp_at_any_length(name: str, fixed_leg: int) -> None:
    assert census_of(family(name), fixed_leg).counts == (0,)


def test_mirror_images_share_their_length() -> None:
    """An isosceles manipulator, the leg at its apex fixed: asymmetric events come in pairs of four cusps."""
    document = census_of(family("isosceles"), 3)
    pairs = [t for t in document.transitions if len(t.events) == 2]
    assert pairs
    assert all(abs(t.count_after - t.count_before) == 4 for t in pairs)
    assert all(len({p.kind for p in t.events}) == 1 for t in pairs)


@pytest.mark.slow
@pytest.mark.hypothesis
def test_counts_agree_with_slices() -> None:
    answers = Counter[str]()

    @given(manipulators(size=20, denominators=(1, 2)), st.sampled_from([1, 2, 3]), st.data())
    @examples(5)
    def agree(m: Manipulator, fixed_leg: int, data: st.DataObject) -> None:
        document = unless_refused(lambda: census(m, fixed_leg=fixed_leg, digits=15), answers)
        eliminant = eliminate(m, fixed_leg)
        for length in data.draw(st.lists(lengths(60), min_size=4, max_size=4)):
            assert solve_slice(eliminant, length, 15).count == count_at(document, length)

    agree()
    assert answers["refused"] <= answers["given"] / 4


@pytest.mark.long
@pytest.mark.timeout(400)
@given(manipulators(size=12), st.sampled_from([1, 2, 3]))
@examples(1)
def test_scale_and_mirror(m: Manipulator, fixed_leg: int) -> None:
    names = ("a2x", "a3x", "a3y", "d1", "d2", "d3")
    factor = 10**7  # it moves the decimal point only
    larger = replace(m, **{name: getattr(m, name) * factor for name in names})
    mirrored = replace(m, a3y=-m.a3y, orientation="cw" if m.orientation == "ccw" else "ccw")
    own, scaled, reflected = (census(x, fixed_leg=fixed_leg, digits=15) for x in (m, larger, mirrored))
    assert own.counts == scaled.counts == reflected.counts
    assert [t.length for t in own.transitions] == [t.length for t in reflected.transitions]
    for a, b in zip(own.transitions, scaled.transitions, strict=True):
        assert (a.kind, Fraction(a.length) * factor) == (b.kind, Fraction(b.length))


@pytest.mark.parametrize("exponent", [long(20), 50])
def test_a_range_may_begin_right_beside_a_transition(exponent: int) -> None:
    last = census_of(EXAMPLES["zein-flat"], digits=80).transitions[-1]
    beside = (Fraction(last.length) * (1 + sign * Fraction(1, 10**exponent)) for sign in (-1, 1))
    below, above = (census(EXAMPLES["zein-flat"], digits=20, start=x) for x in beside)
    assert last.count_before != last.count_after
    assert (below.counts, above.counts) == ((last.count_before, last.count_after), (last.count_after,))
    assert below.to_json()["intervals"][0]["from"] == exact_str(below.range.start)  # type: ignore[index]
