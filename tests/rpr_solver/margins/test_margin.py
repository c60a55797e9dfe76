"""Margins: proved from below, refuted from above, and what both mean for exact counts."""

import random
from fractions import Fraction
from functools import cache

import pytest

from rpr_solver import (
    EXAMPLES,
    InputError,
    Manipulator,
    Margin,
    Requirement,
    census,
    check,
    cusp_table,
    margin,
)
from rpr_solver.contract import LENGTHS
from rpr_solver.exact.decimals import rounded_up
from rpr_solver.margins.estimates import nearest
from rpr_solver.margins.exclusion import exclude
from rpr_solver.margins.problems import validity
from rpr_solver.margins.subjects import Ray, RequirementHolds, SliceCount, Subject, WindowExists
from tests.support.sampling import long

INNOCENTI = EXAMPLES["innocenti"]
ONES = (Fraction(1),) * 6


def count(manipulator: Manipulator, length: object, leg: int = 1) -> int:
    """The exact number of cusps of a slice."""
    return cusp_table(manipulator, length, fixed_leg=leg, digits=15)[0].count  # type: ignore[arg-type]


def moved(manipulator: Manipulator, steps: list[Fraction]) -> Manipulator:
    """The geometry with other lengths."""
    values = {g: getattr(manipulator, g) + step for g, step in zip(LENGTHS, steps, strict=True)}
    return Manipulator(**{**manipulator.to_dict(), **values})


@cache
def searched(name: str = "innocenti", length: str = "28.1") -> Margin:
    """How far a slice keeps its number of cusps, for several tests."""
    return margin(EXAMPLES[name], length, most_boxes=20_000)


@cache
def refuted() -> Margin:
    """A tolerance at L1 = 28.1 that is a little too large."""
    return margin(INNOCENTI, "28.1", tolerance="0.0007")


def is_proved(subject: Subject, radius: Fraction, most_boxes: int) -> bool:
    """Whether the property is proved within a radius."""
    tasks = subject.problems(radius, ONES)
    return tasks is not None and all(
        exclude(problem, most_boxes, zones=zones).proved for problem, zones in tasks
    )


@pytest.mark.parametrize(
    ("name", "length", "cusps", "least"),
    [
        ("innocenti", "28.1", 10, "6.0e-4"),
        long("innocenti", "27", 8, "0.070"),
        long("sixteen-cusps", "14.46845", 16, "8.1e-7"),
    ],
)
def test_a_slice_is_proved_nearly_as_far_as_it_is_refuted(
    name: str, length: str, cusps: int, least: str
) -> None:
    answer = searched(name, length)
    assert answer.count == cusps
    assert answer.proved is not None
    assert answer.proved >= Fraction(least)
    example = answer.counterexample
    assert example is not None
    assert answer.first_order is not None
    assert answer.proved < example.radius <= Fraction(answer.first_order.radius) * Fraction("1.01")
    assert count(example.manipulator, example.found.length) == example.found.cusps != cusps
    steps = [abs(getattr(example.manipulator, g) - getattr(EXAMPLES[name], g)) for g in LENGTHS]
    assert max(steps) == example.radius


def test_a_window_of_7e_minus_9_refutes() -> None:
    """At L1 = 17 two transitions pass the slice one after the other, so no sampling finds the count."""
    subject = SliceCount(INNOCENTI, 1, Fraction(17))
    estimate, nearest = subject.estimate(ONES), subject.nearest(ONES)[0]
    assert estimate is not None
    ray = Ray(subject, INNOCENTI, ONES, nearest, validity(INNOCENTI, ONES))
    example = ray.beyond()
    assert example is not None
    assert example.radius < Fraction(estimate.radius) * Fraction("1.01")
    assert count(example.manipulator, 17) == 8 != subject.count()
    assert count(ray.at(example.radius + Fraction(1, 10**6)), 17) == 6


def test_the_nearest_degenerate_geometry_may_belong_to_no_transition_of_the_given_one() -> None:
    manipulator = Manipulator("-7.6", 18, "0.6", "23.2", "10.8", "20.7", "cw")
    subject = SliceCount(manipulator, 3, Fraction("36.9"))
    near = subject.nearest(ONES)
    radii = [estimate.radius for estimate in near]
    assert radii == sorted(radii)
    example = next(filter(None, (Ray(subject, manipulator, ONES, one, None).beyond() for one in near)))
    assert count(example.manipulator, "36.9", 3) == example.found.cusps != subject.count()
    weights = (Fraction(0), *ONES[1:])
    assert subject.nearest(weights)[0].change[0] == 0
    assert subject.nearest(weights)[0].radius >= radii[0]


@pytest.mark.long
def test_a_margin_finer_than_doubles_is_refuted_without_a_proof() -> None:
    """Just beyond a transition; at 1e-9 of it the margin is proved, at 1e-14 no box could be."""
    [transition, *_] = census(INNOCENTI, digits=30).transitions
    near = (Fraction(transition.length) * (1 + Fraction(1, 10**k)) for k in (9, 14))
    wide, fine = (margin(INNOCENTI, rounded_up(length, 25)) for length in near)
    assert wide.proved is not None
    assert (fine.proved, fine.boxes) == (None, 0)
    assert fine.counterexample is not None
    assert fine.counterexample.radius < Fraction(1, 10**13)


def test_a_requirement_with_joint_limits() -> None:
    limited = Requirement(start=21, stop=26, max_cusps=6, limits={"l2": (2, 60)})
    assert is_proved(RequirementHolds(INNOCENTI, limited), Fraction("0.01"), 20_000)


def test_a_requirement_without_an_upper_end() -> None:
    subject = RequirementHolds(INNOCENTI, Requirement(start=45, max_cusps=4))
    tasks = subject.problems(Fraction("0.1"), ONES)
    assert tasks is not None
    (near, _), (far, _) = tasks
    assert (near.inverse, far.inverse) == (False, True)
    assert exclude(near, 6_000).proved
    assert exclude(far, 6_000).proved


@pytest.mark.parametrize(
    ("radius", "requirement", "holds"),
    [
        ("0.002", Requirement(start="30.9", stop=33, max_cusps=6), True),
        long("0.002", Requirement(start="30.9", stop=33, max_cusps=6, limits={"l2": (5, 60)}), True),
        ("0.03", Requirement(start="30.9", stop=33, max_cusps=6), False),  # a swallowtail comes in
        long("0.001", Requirement(start=28, stop="28.2", max_cusps=10, min_cusps=8), True),
        ("0.0001", Requirement(start="14.5", stop="14.7", max_cusps=8, min_cusps=6), False),  # their order
    ],
)
def test_transitions_may_move_within_the_range(radius: str, requirement: Requirement, holds: bool) -> None:
    subject = RequirementHolds(INNOCENTI, requirement)
    assert subject.count() is None
    assert subject.obstacle() is None
    assert is_proved(subject, Fraction(radius), 20_000) == holds
    if holds:
        rng = random.Random(1)
        corner = moved(INNOCENTI, [Fraction(radius) * rng.choice((-1, 1)) for _ in LENGTHS])
        assert check(corner, requirement).passed


def test_a_document_says_that_transitions_were_located() -> None:
    requirement = Requirement(start="26.5", stop=27, max_cusps=8)
    answer = margin(INNOCENTI, requirement=requirement, tolerance="0.002")
    assert (answer.verdict, answer.count) == ("proved", None)
    assert answer.to_json()["certificate"]["method"] == "exclusion, transitions located"


@pytest.mark.long
@pytest.mark.parametrize(
    ("start", "stop", "most", "least"), [("26.5", 27, 8, "0.05"), (9, 21, 8, "0.001"), (0, None, 10, "0.001")]
)
def test_a_requirement_with_transitions_has_a_proved_radius(
    start: str | int, stop: int | None, most: int, least: str
) -> None:
    requirement = Requirement(start=start, stop=stop, max_cusps=most)
    answer = margin(INNOCENTI, requirement=requirement)
    assert answer.proved is not None
    assert answer.proved >= Fraction(least)
    rng = random.Random(most)
    for _ in range(3):
        corner = moved(INNOCENTI, [answer.proved * rng.choice((-1, 1)) for _ in LENGTHS])
        assert check(corner, requirement).passed


def test_a_requirement_that_cannot_be_proved_for_others_says_why() -> None:
    for limits, degenerate, words in (
        ({"l2": (30, 35)}, "allowed", "passes a joint limit within the range"),
        ({"l2": (5, 60)}, "refused", "beyond the joint limits"),
    ):
        asked = Requirement(start="28.9", stop=29, max_cusps=10, limits=limits, degenerate=degenerate)
        assert words in (RequirementHolds(INNOCENTI, asked).obstacle() or "")
    asked = Requirement(start="28.9", stop=29, max_cusps=10, limits={"l2": (30, 35)})
    answer = margin(INNOCENTI, requirement=asked, tolerance="0.001")
    assert (answer.verdict, answer.boxes) == ("open", 0)
    assert "at L1 = 28.98" in (answer.reason or "")


def test_a_cusp_that_may_pass_a_joint_limit_is_no_proof() -> None:
    table = census(INNOCENTI, start=21, stop=26, digits=15)
    assert table.counts == (6,)
    bound = cusp_table(INNOCENTI, 23, digits=15)[0].cusps[0].l2
    length = rounded_up(Fraction(bound) + Fraction(1, 50), 6)
    requirement = Requirement(start="22.9999", stop="23.0001", max_cusps=6, limits={"l2": (length, None)})
    subject = RequirementHolds(INNOCENTI, requirement)
    assert not is_proved(subject, Fraction("0.1"), 1_200)
    assert nearest(INNOCENTI, 1, [Fraction(23)], ONES, [(0, length)])[0].radius < 0.1


def test_the_window_of_ten_cusps_exists_within_a_tolerance_that_moves_it() -> None:
    answer = margin(INNOCENTI, window="28.1", tolerance="0.01", most_boxes=20_000)
    assert (answer.verdict, answer.count) == ("proved", 10)
    rng = random.Random(3)
    other = moved(INNOCENTI, [Fraction(rng.randrange(-1000, 1001), 100_000) for _ in LENGTHS])
    assert 10 in census(other, start=27, stop=29, digits=15).counts
    subject = WindowExists(INNOCENTI, 1, Fraction("28.1"))
    estimate = subject.estimate(ONES)
    assert estimate is not None
    assert 0.29 < estimate.radius < 0.31


def test_all_exact_counts_in_proved_boxes_are_the_same() -> None:
    rng = random.Random(4)
    for manipulator, leg, length, radius in (
        (INNOCENTI, 1, "27", Fraction("0.07")),
        (INNOCENTI, 2, "12", Fraction("0.02")),
        (EXAMPLES["twelve-cusps"], 3, "20", Fraction("0.02")),
    ):
        subject = SliceCount(manipulator, leg, Fraction(length))
        assert is_proved(subject, radius, 40_000)
        for sample in range(6):
            shares = [rng.choice((-1, 1)) if sample % 2 else rng.uniform(-1, 1) for _ in LENGTHS]
            steps = [radius * Fraction(str(round(share, 6))) for share in shares]
            assert count(moved(manipulator, steps), length, leg) == subject.count()


@pytest.mark.parametrize(("length", "start"), [("28.1", "6.1e-4"), long("27", "0.0725")])
def test_no_proof_beyond_a_counterexample(length: str, start: str) -> None:
    subject = SliceCount(INNOCENTI, 1, Fraction(length))
    for factor in ("1", "3"):
        assert not is_proved(subject, Fraction(start) * Fraction(factor), 1_200)


def test_a_tolerance_is_refuted_by_a_geometry_within_it() -> None:
    answer = refuted()
    assert answer.verdict == "refuted"
    example = answer.counterexample
    assert example is not None
    assert example.radius <= 1
    assert count(example.manipulator, "28.1") == example.found.cusps == 8
    for g in LENGTHS:
        assert abs(getattr(example.manipulator, g) - getattr(INNOCENTI, g)) <= Fraction("0.0007")


@pytest.mark.long
def test_margins_scale_with_the_manipulator() -> None:
    whole = searched()
    twice = Manipulator(*(2 * getattr(INNOCENTI, g) for g in LENGTHS))
    doubled = margin(twice, Fraction("56.2"), most_boxes=20_000)
    assert whole.proved is not None
    assert doubled.proved is not None
    assert doubled.first_order.radius == pytest.approx(2 * whole.first_order.radius)  # type: ignore[union-attr]
    assert abs(doubled.proved - 2 * whole.proved) < whole.proved / 100


@pytest.mark.long
def test_margins_of_mirrored_and_relabelled_manipulators_agree() -> None:
    m = INNOCENTI
    mirrored = Manipulator(m.a2x, m.a3x, -m.a3y, m.d1, m.d2, m.d3, "cw")
    # legs 1 and 2 change places: the base is turned by 180°
    relabelled = Manipulator(m.a2x, m.a2x - m.a3x, -m.a3y, m.d1, m.d3, m.d2, "cw")
    answers = [
        margin(m, "28.1", most_boxes=6_000, weights={"a2x": 0}),
        margin(mirrored, "28.1", most_boxes=6_000, weights={"a2x": 0}),
        margin(relabelled, "28.1", fixed_leg=2, most_boxes=6_000, weights={"a2x": 0}),
    ]
    first = answers[0]
    assert first.proved is not None
    for answer in answers[1:]:
        assert answer.proved == first.proved
        assert answer.count == first.count
        assert answer.first_order.radius == pytest.approx(first.first_order.radius)  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("manipulator", "words"),
    [
        (Manipulator(30, 0, 40, 15, 25, 20), "degenerate poses (node)"),
        (Manipulator(30, 0, 40, 30, 50, 40), "degenerate poses (curve, node)"),
        (Manipulator(30, 10, 0, 30, 20, 10), "degenerate poses (curve, higher, quadruple)"),
        (EXAMPLES["zein-flat"], "no manipulator"),
    ],
)
def test_special_families_have_no_margin_and_it_is_said_why(manipulator: Manipulator, words: str) -> None:
    answer = margin(manipulator, 10)
    assert answer.proved == 0
    assert words in (answer.reason or "")
    assert answer.boxes == 0
    assert margin(manipulator, 10, tolerance="0.001").verdict == "open"


def test_a_flat_platform_with_exact_sides_has_a_margin() -> None:
    answer = margin(EXAMPLES["zein-flat"], "34.5", weights={"d1": 0, "d2": 0, "d3": 0}, most_boxes=6_000)
    assert answer.proved is not None
    assert answer.proved > Fraction("0.28")


def test_a_requirement_that_does_not_hold_has_no_margin() -> None:
    answer = margin(INNOCENTI, requirement=Requirement(start=27, stop=29, max_cusps=8))
    assert (answer.proved, answer.reason) == (0, "the manipulator does not satisfy the requirement")


def test_the_search_ends_when_it_is_told_to() -> None:
    asked: list[int] = []

    def may_go_on() -> bool:
        asked.append(1)
        return len(asked) < 5

    answer = margin(INNOCENTI, 17, may_go_on=may_go_on)
    assert answer.proved is None
    assert answer.boxes < 20_000


def test_validity_is_the_radius_of_the_first_flat_platform() -> None:
    assert validity(Manipulator(20, 5, 15, "9.592", "8.544", "16.689"), ONES) == Fraction("1.447") / 3
    assert validity(INNOCENTI, (*ONES[:3], *(Fraction(0),) * 3)) == 10
    assert validity(INNOCENTI, (Fraction(1), *(Fraction(0),) * 5)) == Fraction("15.91")
    assert validity(INNOCENTI, (*(Fraction(0),) * 5, Fraction(1))) == Fraction("12.74")
    # a3x = 0 is exact: A3 falls on A1 where a3y is 0
    assert validity(INNOCENTI, (*(Fraction(0),) * 2, Fraction(1), *(Fraction(0),) * 3)) == 10
    # a3y = 0 is exact: A3 falls on A1 at a3x = 0, and on A2 at a3x = a2x
    for a3x, radius in ((6, 6), (-3, Fraction("0.5"))):
        flat = Manipulator("-2.5", a3x, 0, 12, 18, 20)
        assert validity(flat, (Fraction(0), Fraction(1), *(Fraction(0),) * 4)) == radius


def refused(**arguments: object) -> str:
    """The message for arguments."""
    with pytest.raises(InputError) as caught:
        margin(INNOCENTI, **arguments)  # type: ignore[arg-type]
    return str(caught.value)


def test_bad_input_is_named() -> None:
    assert "exactly one of length, requirement and window" in refused()
    assert "exactly one" in refused(length=5, window=6)
    assert refused(length=0).startswith("l1: is 0")
    assert refused(length=5, tolerance=-1).startswith("tolerance: is -1")
    assert refused(length=5, tolerance={"d4": 1}).startswith("tolerance.d4: unknown")
    assert refused(length=5, weights={"d1": "x"}).startswith("weights.d1")
    assert refused(length=5, tolerance=0).startswith("tolerance: is 0")
    assert "all 0" in refused(length=5, weights=dict.fromkeys(LENGTHS, 0))
