"""Requirements over ranges of slices, with and without joint limits, against slices solved one by one."""

from collections import Counter
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import (
    EXAMPLES,
    CheckReport,
    InputError,
    Manipulator,
    Requirement,
    census,
    check,
    solve_slice,
)
from tests.support.families import family
from tests.support.sampling import long
from tests.support.shared import census_of, eliminant_of
from tests.support.strategies import examples, manipulators, unless_refused

INNOCENTI = EXAMPLES["innocenti"]
SIMILAR = Manipulator.from_json({"a2x": 30, "a3x": 0, "a3y": 40, "d1": 15, "d2": 25, "d3": 20})


def count_within(m: Manipulator, requirement: Requirement, length: Fraction) -> int:
    """The cusps of one slice within the limits, from its table."""
    free = [leg for leg in (1, 2, 3) if leg != requirement.fixed_leg]
    table = solve_slice(eliminant_of(m, requirement.fixed_leg), length, 20)

    def inside(leg: int, text: str) -> bool:
        low, high = requirement.limits.get(leg, (None, None))
        return (low is None or Fraction(text) > low) and (high is None or Fraction(text) < high)

    return sum(all(inside(leg, getattr(c, f"l{leg}")) for leg in free) for c in table.cusps)


def reported(report: CheckReport, length: Fraction) -> int:
    [interval] = [
        x
        for x in report.intervals
        if Fraction(x.start) < length and (x.stop is None or length < Fraction(x.stop))
    ]
    return interval.count


def test_at_most_eight_cusps_holds_only_below_28() -> None:
    below = check(INNOCENTI, Requirement(start=Fraction(1), stop=Fraction(28), max_cusps=8))
    assert below.passed
    assert (below.intervals[0].start, below.intervals[-1].stop) == ("1", "28")
    whole = check(INNOCENTI, Requirement(max_cusps=8))
    assert not whole.passed
    [violation] = whole.violations
    assert violation.start.startswith("28.0948944788774")
    assert violation.count == len(violation.cusps) == 10
    assert Fraction(violation.start) < violation.example < Fraction(violation.stop or 0)


@pytest.mark.long
def test_at_least_one_cusp() -> None:
    assert check(INNOCENTI, Requirement(start=Fraction(1), min_cusps=1)).passed
    report = check(INNOCENTI, Requirement(start=Fraction(1, 10), min_cusps=1))
    assert [v.count for v in report.violations] == [0]
    assert report.violations[0].stop is not None


@pytest.mark.quick
def test_cusp_free_for_every_length() -> None:
    for leg in (1, 2, 3):
        report = check(SIMILAR, Requirement(fixed_leg=leg, max_cusps=0))
        assert report.passed
        assert report.to_json()["intervals"] == [{"from": "0", "to": None, "count": 0}]


def test_a_bound_exactly_at_a_rational_transition() -> None:
    folded = Manipulator.from_json(
        {"a2x": 2, "a3x": -4, "a3y": 4, "d1": 1, "d2": 4, "d3": 3, "orientation": "cw"}
    )
    report = check(folded, Requirement(start=Fraction(1), stop=Fraction(11, 10), min_cusps=0))
    assert [(x.start, x.stop, x.count) for x in report.intervals] == [("1", "1.1", 6)]


@pytest.mark.slow
def test_a_range_that_begins_right_beside_a_transition() -> None:
    last = Fraction(census_of(INNOCENTI, digits=80).transitions[-1].length)
    beside = (last * (1 + sign * Fraction(1, 10**40)) for sign in (-1, 1))
    below, above = (check(INNOCENTI, Requirement(start=x, max_cusps=4)) for x in beside)
    assert (below.passed, above.passed) == (False, True)
    [violation] = below.violations
    assert violation.count == 6
    assert below.requirement.start < violation.example < last


@pytest.mark.parametrize(
    ("fixed_leg", "limits"),
    [
        long(1, {2: (Fraction(5), Fraction(40)), 3: (Fraction(5), Fraction(40))}),
        (2, {3: (None, Fraction(30))}),
        long(3, {1: (Fraction(25), None), 2: (Fraction(0), Fraction(33))}),
    ],
)
def test_joint_limits(fixed_leg: int, limits: dict[int, tuple[Fraction | None, Fraction | None]]) -> None:
    requirement = Requirement(fixed_leg, Fraction(26), Fraction(31), max_cusps=0, limits=limits)
    report = check(INNOCENTI, requirement, digits=20)
    assert len(report.intervals) > 1
    for n in range(1, 40, 3):
        length = 26 + Fraction(n, 8)
        assert reported(report, length) == count_within(INNOCENTI, requirement, length)


@pytest.mark.parametrize(
    ("name", "fixed_leg"),
    [long("right angles", 1), ("right angles", 3), long("both flat", 2), long("congruent, mirrored", 1)],
)
def test_joint_limits_of_degenerate_manipulators(name: str, fixed_leg: int) -> None:
    first, second = (leg for leg in (1, 2, 3) if leg != fixed_leg)
    limits = {first: (None, Fraction(9)), second: (Fraction(2), None)}
    requirement = Requirement(fixed_leg, max_cusps=0, limits=limits)
    report = check(family(name), requirement, digits=20)
    for length in (Fraction(n * n, 50) + Fraction(1, 997) for n in range(1, 40)):
        assert reported(report, length) == count_within(family(name), requirement, length)


@pytest.mark.quick
def test_windows_narrower_than_any_sampling_are_found() -> None:
    """Limits 1e-25 round the leg at a swallowtail: two cusps are within them for lengths of 1e-25."""
    document = census(EXAMPLES["zein-flat"], start=37, stop=38, digits=50)
    [swallowtail] = [event for t in document.transitions for event in t.events]
    leg, little = Fraction(swallowtail.point.l2), Fraction(1, 10**25)
    limits = {2: (leg - little, leg + little)}
    report = check(EXAMPLES["zein-flat"], Requirement(1, 37, 38, max_cusps=1, limits=limits), digits=60)
    [window] = report.violations
    assert window.count == 2
    assert 0 < Fraction(window.stop or 0) - Fraction(window.start) < Fraction(1, 10**24)


@pytest.mark.slow
@pytest.mark.hypothesis
def test_limits_agree_with_slices() -> None:
    answers = Counter[str]()

    @given(manipulators(size=15, denominators=(1, 2)), st.integers(5, 30), st.data())
    @examples(3)
    def agree(m: Manipulator, limit: int, data: st.DataObject) -> None:
        requirement = Requirement(stop=Fraction(40), max_cusps=0, limits={2: (None, Fraction(limit))})
        report = unless_refused(lambda: check(m, requirement, digits=20), answers)
        for n in data.draw(st.lists(st.integers(1, 3999), min_size=4, max_size=4)):
            length = Fraction(n, 100)
            assert reported(report, length) == count_within(m, requirement, length)

    agree()
    assert answers["refused"] <= answers["given"] / 4


def test_requirements_survive_json() -> None:
    requirement = Requirement(2, Fraction(1, 3), Fraction(9), 4, 1, {3: (None, Fraction(5, 2))}, "refused")
    assert repr(requirement).endswith("degenerate='refused')")
    assert Requirement.from_json(requirement.to_json()) == requirement


@pytest.mark.parametrize(
    ("obj", "fields"),
    [
        ({}, ["requirement.max_cusps"]),
        ({"max_cusps": -1}, ["requirement.max_cusps"]),
        ({"max_cusps": "1.5"}, ["requirement.max_cusps"]),
        ({"max_cusps": 1, "fixed_leg": 4}, ["requirement.fixed_leg"]),
        ({"max_cusps": 1, "range": {"from": 5, "to": 5}}, ["requirement.stop"]),
        ({"max_cusps": 1, "range": {"from": -1}}, ["requirement.start"]),
        ({"max_cusps": 1, "range": {"from": 1.5}}, ["requirement.range.from"]),
        ({"max_cusps": 1, "limits": {"l1": {"min": 2}}}, ["requirement.limits.l1"]),
        ({"max_cusps": 1, "limits": {"l2": {"min": 2, "max": 1}}}, ["requirement.limits.l2.max"]),
        ({"max_cusps": 1, "limits": {"l9": {}}}, ["requirement.limits"]),
        ({"max_cusps": 1, "degenerate": "never"}, ["requirement.degenerate"]),
    ],
)
def test_bad_requirements_are_named(obj: dict[str, object], fields: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        Requirement.from_json(obj)
    assert [p.field for p in caught.value.problems] == fields
