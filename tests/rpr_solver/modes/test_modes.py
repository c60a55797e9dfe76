"""Changes of assembly mode against a grid in floats, paths that are replayed, and crossings of folds."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from random import Random
from typing import Any

import pytest

from rpr_solver import (
    EXAMPLES,
    AssemblyModes,
    Change,
    InputError,
    Manipulator,
    Path,
    Requirement,
    assembly_modes,
    check,
    design,
    joint_path,
    margin,
)
from tests.support.families import FAMILIES, family
from tests.support.mode_grid import ModeGrid
from tests.support.motions import Mover, angles_of, apart, legs_of
from tests.support.oracle import free_legs_of, singularity
from tests.support.sampling import long, sample
from tests.support.triangle_spellings import manipulator_with_roots

FIRST = EXAMPLES["innocenti"]
SIZES = (1, 3, 10, 30, 100, 300)


def replayed(answer: AssemblyModes) -> None:
    """The witness joins two poses of one joint vector, is continuous, and keeps what it must, in floats."""
    path = answer.witness
    assert path is not None
    mover, samples = Mover.of(path.manipulator, path.fixed_leg), path.resampled(601).samples
    rows, places = [legs_of(sample) for sample in samples], [angles_of(sample) for sample in samples]
    legs = free_legs_of(path.manipulator, path.fixed_leg)
    for row, (alpha, theta) in zip(rows, places, strict=True):
        length = row[path.fixed_leg - 1]
        own = mover.legs(alpha, theta, length)
        assert max(abs(x - y) for x, y in zip(own, row, strict=True)) < 1e-8 * max(row)
        assert singularity(legs, length, alpha, theta) * path.sign > 0
    assert max(apart(x, y) for x, y in pairwise(places)) < 0.5
    assert rows[0] == rows[-1]
    assert apart(places[0], places[-1]) > 1e-6
    low, high = map(float, answer.span)
    assert all(low * (1 - 1e-9) <= row[answer.fixed_leg - 1] <= high * (1 + 1e-9) for row in rows)
    for leg, (least, most) in answer.limits.items():
        assert least is None or min(row[leg - 1] for row in rows) >= float(least) * (1 - 1e-12)
        assert most is None or max(row[leg - 1] for row in rows) <= float(most) * (1 + 1e-12)


def some_manipulator(random: Random) -> Manipulator:
    if random.random() < 0.4:
        name = random.choice([*FAMILIES, *EXAMPLES])
        return family(name) if name in FAMILIES else EXAMPLES[name]
    while True:
        values = [random.randint(-40, 40) for _ in range(3)] + [random.randint(1, 40) for _ in range(3)]
        try:
            return Manipulator(*values, orientation=random.choice(["ccw", "cw"]))
        except InputError:
            continue


def some_limits(
    random: Random, manipulator: Manipulator, leg: int, length: float
) -> dict[int, tuple[str, str]]:
    """Limits round the joint vector of some pose."""
    legs = Mover.of(manipulator, leg).legs(random.uniform(0, 6.28), random.uniform(0, 6.28), length)
    limits = {}
    for number, own in enumerate(legs, 1):
        width = max(legs) * random.choice([0.1, 0.3, 0.6, 1]) * random.random()
        if number != leg:
            low = max(0.0, own - width * random.random())
            limits[number] = f"{low:.4g}", f"{own + width * random.random() + 0.05 * max(legs):.4g}"
    return limits


def compared(
    count: int,
    seed: int,
    *,
    of_range: bool = False,
    limited: bool = False,
    a_machine: Callable[[Random], Manipulator] = some_manipulator,
) -> Counter[str]:
    """Random questions against the grid: no proof that contradicts it, and all witnesses replayed."""
    found: Counter[str] = Counter()
    for number in range(count):
        random = Random(f"{seed} {number}")
        m, leg = a_machine(random), random.choice([1, 2, 3])
        size = max(map(abs, m.doubles()))
        low = Fraction(f"{random.choice(SIZES) * random.uniform(0.0005, 0.003) * size:.4g}")
        high = Fraction(f"{float(low) * random.uniform(1.01, 2):.4g}") if of_range else low
        limits = some_limits(random, m, leg, float(low)) if limited else {}
        where = (None, (low, high)) if of_range else (low, None)
        answer = assembly_modes(
            m, where[0], between=where[1], limits=limits, fixed_leg=leg, with_regions=False
        )
        found[answer.change] += 1
        bounds = {k: (float(x), float(y)) for k, (x, y) in limits.items()}
        sizes = {"size": 90, "lengths": 16} if of_range else {}
        if answer.change is Change.POSSIBLE:
            replayed(answer)
        elif answer.change is Change.IMPOSSIBLE:
            seen = ModeGrid(m, leg, (float(low), float(high)), bounds, **sizes).change(300, number)
            assert seen is None, (m, leg, low, high, limits, seen)
        else:
            assert answer.reason
    return found


def test_few_slices_agree_with_the_grid() -> None:
    assert compared(4, 1)[Change.POSSIBLE]


@pytest.mark.parametrize(("of_range", "limited"), [(False, False), long(True, False), long(False, True)])
def test_few_manipulators_with_roots_agree_with_the_grid(of_range: bool, limited: bool) -> None:
    assert compared(3, 4, of_range=of_range, limited=limited, a_machine=manipulator_with_roots).total() == 3


@pytest.mark.long
def test_60_manipulators_with_roots_agree_with_the_grid() -> None:
    for of_range, limited in ((False, False), (True, False), (False, True)):
        found = compared(20, 5, of_range=of_range, limited=limited, a_machine=manipulator_with_roots)
        assert found.total() == 20


def test_few_slices_within_limits_agree_with_the_grid() -> None:
    assert compared(6, 2, limited=True)[Change.IMPOSSIBLE]


def test_few_ranges_agree_with_the_grid() -> None:
    assert compared(2, 3, of_range=True)[Change.POSSIBLE]


@pytest.mark.long
def test_300_slices_agree_with_the_grid() -> None:
    found = compared(300, 4)
    assert found[Change.UNDECIDED] <= 15


@pytest.mark.long
def test_100_ranges_agree_with_the_grid() -> None:
    found = compared(100, 5, of_range=True)
    assert found[Change.UNDECIDED] <= 15


@pytest.mark.long
def test_100_questions_with_limits_agree_with_the_grid() -> None:
    found = compared(80, 6, limited=True) + compared(20, 7, of_range=True, limited=True)
    assert found[Change.UNDECIDED] <= 15


def test_a_nearly_flat_platform_is_decided() -> None:
    """The tangents of its folds are nearly in the kernel: even poses far apart are hard to tell apart."""
    m, limits = Manipulator(3, -15, 20, 15, 13, "27.9999"), {2: (23.426, 25.74)}
    exact = {"l2": ("23.426", "25.740")}
    answer = assembly_modes(m, "35.76", limits=exact, with_regions=False)
    assert answer.change is Change.IMPOSSIBLE
    assert ModeGrid(m, 1, (35.76, 35.76), limits).change(300, 1) is None


@pytest.mark.quick
@pytest.mark.parametrize(("length", "change"), [("0.1", Change.IMPOSSIBLE), ("0.2", Change.POSSIBLE)])
def test_slices_on_both_sides_of_the_first_transition(length: str, change: Change) -> None:
    answer = assembly_modes(FIRST, length)
    assert answer.change is change
    assert answer.regions is not None
    joined = [group for region in answer.regions for group in region.joined or () if len(group) > 1]
    assert bool(joined) == (change is Change.POSSIBLE)


@pytest.mark.parametrize(
    ("manipulator", "leg"),
    sample(
        [
            (manipulator, leg)
            for manipulator in (family("similar"), family("congruent"), Manipulator(4, 12, 0, 2, 4, 6))
            for leg in (1, 2, 3)
        ],
        *(0, 4, 8),
    ),
)
def test_similar_triangles_never_change(manipulator: Manipulator, leg: int) -> None:
    assert manipulator.geometry.is_similar
    answers = [
        assembly_modes(manipulator, 7, fixed_leg=leg),
        assembly_modes(manipulator, between=(7, 9), fixed_leg=leg, with_regions=False),
        assembly_modes(manipulator, 7, fixed_leg=leg, limits={f"l{leg % 3 + 1}": (1, 9)}),
    ]
    assert {answer.change for answer in answers} == {Change.IMPOSSIBLE}
    assert answers[0].regions is not None
    assert all(len(group) == 1 for region in answers[0].regions for group in region.joined or ())
    assert ModeGrid(manipulator, leg, (7.0, 7.0), {}).change(300, 1) is None


@pytest.mark.quick
@pytest.mark.parametrize("ends", [("1e300", "2e300"), ("1e-300", "2e-300"), ("1e300", None)])
def test_limits_that_no_pose_keeps(ends: tuple[str, str | None]) -> None:
    assert assembly_modes(FIRST, 27, limits={"l2": ends}).change is Change.IMPOSSIBLE


@pytest.mark.parametrize(
    "asked",
    [
        {"between": (27, "27." + "0" * 350 + "1")},
        long({"length": "1e300"}),
        long({"between": ("1e-300", "1e300")}),
    ],
)
def test_lengths_of_any_size_are_answered(asked: dict[str, Any]) -> None:
    assert assembly_modes(FIRST, **asked, with_regions=False).change in Change


def test_the_poses_of_a_region_are_joined_as_paths_say() -> None:
    answer = assembly_modes(FIRST, 27)
    assert answer.regions is not None
    for region in answer.regions[:2]:
        assert sorted(k for group in region.joined or () for k in group) == list(range(1, region.poses + 1))
        for group in region.joined or ():
            for one, other in pairwise(group):
                assert isinstance(joint_path(FIRST, *region.lengths, one, other), Path)
        first = [group[0] for group in region.joined or ()]
        for one, other in pairwise(first):
            assert not joint_path(FIRST, *region.lengths, one, other)


def test_a_range_joins_poses_that_its_slices_do_not() -> None:
    """As the paths page shows: poses 2 and 4 of (27, 25.7, 9.2) are joined with leg 1 up to 30."""
    held, free = (
        [region for region in answer.regions or () if region.lengths[0] == 27]
        for answer in (assembly_modes(FIRST, 27), assembly_modes(FIRST, between=(27, 30)))
    )
    assert [region.lengths for region in held] == [region.lengths for region in free]
    assert any(len(x.joined or ()) > len(y.joined or ()) for x, y in zip(held, free, strict=True))


def test_a_cusp_within_the_limits_decides() -> None:
    [low, high] = (
        assembly_modes(FIRST, 27, limits={"l2": ends}, with_regions=False) for ends in ((5, 10), (33, 34))
    )
    assert low.change is Change.POSSIBLE
    replayed(low)
    assert high.change is not Change.POSSIBLE or high.witness is not None


@pytest.mark.parametrize(
    ("start", "limits", "change"),
    [
        (45, {"l2": (None, 20)}, Change.IMPOSSIBLE),
        (25, {"l2": (None, 20)}, Change.POSSIBLE),
        (45, {"l2": (30, None)}, Change.POSSIBLE),
    ],
)
def test_a_range_without_an_end(start: int, limits: dict[str, Any], change: Change) -> None:
    answer = assembly_modes(FIRST, between=(start, None), limits=limits)
    assert answer.change is change
    assert answer.to_json()["asked"]["range"] == {"from": str(start), "to": None}
    assert (answer.witness is None) == (change is Change.IMPOSSIBLE)
    if answer.witness is not None:
        assert answer.witness.lengths is not None
        assert answer.witness.lengths[0] >= start


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({}, "l1"),
        ({"length": 27, "between": (20, 30)}, "l1"),
        ({"between": (0, 30)}, "between"),
        ({"between": (30, 20)}, "between.to"),
        ({"between": (0, None)}, "between"),
        ({"length": 27, "limits": {"l1": (1, 2)}}, "limits.l1"),
        ({"length": 0}, "l1"),
    ],
)
def test_what_is_no_question_is_refused(options: dict[str, object], field: str) -> None:
    with pytest.raises(InputError) as caught:
        assembly_modes(FIRST, **options)  # type: ignore[arg-type]
    assert [problem.field for problem in caught.value.problems] == [field]


def test_a_check_excludes_or_requires_a_change() -> None:
    for start, stop, change in (("0.05", "0.1", "impossible"), ("20", "25", "possible")):
        for word in ("excluded", "required"):
            report = check(FIRST, Requirement(start=start, stop=stop, mode_change=word), digits=15)
            assert report.to_json()["mode_change"]["change"] == change
            assert report.passed == ((word == "required") == (change == "possible"))
    both = Requirement(start=20, stop=25, max_cusps=0, mode_change="required")
    assert not check(FIRST, both, digits=15)
    assert Requirement.from_json(both.to_json()) == both
    assert "mode_change" not in Requirement(max_cusps=1).to_json()


def test_a_check_excludes_a_change_in_a_range_without_an_upper_end() -> None:
    wish = Requirement(start=45, mode_change="excluded", limits={"l2": (None, 20)})
    report = check(FIRST, wish, digits=15)
    assert report.passed
    asked = report.to_json()["requirement"]["range"]
    assert (asked["from"], asked["to"]) == ("45", None)
    assert not check(FIRST, Requirement(start=20, mode_change="excluded"), digits=15)


@pytest.mark.parametrize(
    "options",
    [{"mode_change": "possible"}, {"start": 0, "mode_change": "required"}, {"start": 0, "stop": None}],
)
def test_a_change_is_required_of_a_range_from_a_length_above_0(options: dict[str, object]) -> None:
    given: dict[str, Any] = {"start": 20, "stop": 25, "mode_change": "excluded", **options}
    with pytest.raises(InputError) as caught:
        Requirement(**given)
    assert [problem.field for problem in caught.value.problems] == ["requirement.mode_change"]


def test_margins_and_designs_refuse_requirements_on_changes() -> None:
    wish = Requirement(start=20, stop=25, mode_change="excluded")
    for ask in (lambda: margin(FIRST, requirement=wish), lambda: design(FIRST, "least-change", wish)):
        with pytest.raises(InputError, match=r"requirement\.mode_change"):
            ask()
