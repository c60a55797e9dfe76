"""The order of events: what is equal stands together, by proof, and what is not is told apart."""

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from itertools import groupby

import pytest
from flint import arb, fmpq, fmpq_poly
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, Manipulator
from rpr_solver.errors import Unproved
from rpr_solver.exact.number_field import Algebraic, Field
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import real_roots
from rpr_solver.model.classify import PoseKind
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.transitions.event_systems import EventSystems
from rpr_solver.transitions.event_types import Event, Landmark
from rpr_solver.transitions.events import BallEvent, events, limit_events
from rpr_solver.transitions.order import _is_image, grouped
from rpr_solver.transitions.symmetries import symmetries
from tests.support.families import family

RATIONALS = Field.rationals()


def field_of(*coefficients: int) -> Field:
    """ℚ of the greatest real root."""
    return Field(real_roots(QuadraticPoly.rational(list(coefficients)))[-1])


ROOT_TWO = field_of(-2, 0, 1)
BOTH = field_of(1, 0, -10, 0, 1)
"""ℚ(√2 + √3)."""


def in_both(text: str) -> Algebraic:
    """√2 or √3 by the generator g: √2 = (g³ − 9 g) / 2, √3 = (11 g − g³) / 2."""
    coefficients = {"√2": [0, fmpq(-9, 2), 0, fmpq(1, 2)], "√3": [0, fmpq(11, 2), 0, fmpq(-1, 2)]}[text]
    return BOTH(fmpq_poly(coefficients))


def rational(x: Fraction | int) -> Landmark:
    return Landmark(RATIONALS(Fraction(x)))


@cache
def events_of(m: Manipulator, fixed_leg: int) -> list[Event]:
    return list(events(EventSystems.of(SliceMap.of(m, fixed_leg))))


@given(
    st.lists(
        st.tuples(st.sampled_from(["ℚ", "√2", "√2 again", "√3"]), st.fractions(1, 3, max_denominator=3)),
        max_size=8,
    )
)
def test_lengths_ascend_and_equal_ones_are_together(pairs: list[tuple[str, Fraction]]) -> None:
    """Multiples of 1, √2 and √3: their squares tell the order."""
    units = {
        "ℚ": (RATIONALS(1), 1),
        "√2": (ROOT_TWO.generator, 2),
        "√2 again": (in_both("√2"), 2),
        "√3": (in_both("√3"), 3),
    }
    squares = {}
    for name, factor in pairs:
        unit, square = units[name]
        event = Landmark(unit * unit.field(factor))
        squares[id(event)] = (event, square * factor**2)
    groups = grouped([event for event, _ in squares.values()])
    result = [[squares[id(event)][1] for event in group] for group in groups]
    expected = [list(same) for _, same in groupby(sorted(square for _, square in squares.values()))]
    assert result == expected


@pytest.mark.parametrize("exponent", [20, 300, 1900])
def test_lengths_nearer_than_a_float_can_tell_are_told_apart(exponent: int) -> None:
    little = Fraction(1, 10**exponent)
    below, at, above = rational(1 - little), rational(1), rational(1 + little)
    assert grouped([above, at, below]) == [[below], [at], [above]]
    root = Landmark(ROOT_TWO.generator)
    beside = Landmark(in_both("√2") + BOTH(little))
    assert grouped([beside, root]) == [[root], [beside]]


@dataclass(frozen=True)
class Blurred:
    """An event whose balls all hold 1."""

    pose: None = None
    exact_length: Algebraic | None = None
    lasting: bool = False

    def scaled_length(self, bits: int) -> arb:
        return arb(1, arb(2) ** -bits)


def test_lengths_that_are_neither_equal_nor_apart_are_refused() -> None:
    with pytest.raises(Unproved, match="could not be proved to be one"):
        grouped([Blurred(), Blurred()])
    assert len(grouped([Blurred(), rational(2)])) == 2
    assert len(grouped([Blurred(exact_length=RATIONALS(1)), rational(1)])) == 1


@pytest.mark.parametrize(("m", "fixed_leg"), [(EXAMPLES["zein-flat"], 1), (family("isosceles"), 1)])
def test_events_of_asymmetric_slices_have_lengths_of_their_own(m: Manipulator, fixed_leg: int) -> None:
    """Isosceles triangles too, where the leg that is held is not at the apex."""
    assert symmetries(SliceMap.of(m, fixed_leg)) == ()
    groups = grouped(events_of(m, fixed_leg))
    assert all(len(group) == 1 for group in groups)


def test_mirror_images_stand_together() -> None:
    """Held at the apex: each event off the mirror has an image, at the same length and of the same kind."""
    m = family("isosceles")
    groups = grouped(events_of(m, 3))
    pairs = [group for group in groups if len(group) > 1]
    assert pairs
    for first, second in pairs:
        assert first.pose
        assert second.pose
        assert first.pose.kind is second.pose.kind
        ours, theirs = (event.pose.coordinates(256) for event in (first, second))  # type: ignore[union-attr]
        # the free legs change places
        assert ours[2].overlaps(theirs[3])
        assert ours[3].overlaps(theirs[2])
        assert not ours[2].overlaps(ours[3])
    lengths = [float(group[0].scaled_length(64).mid()) for group in groups]
    assert lengths == sorted(lengths)
    assert len(set(lengths)) == len(lengths)


def test_a_mirror_image_is_one_event_and_no_other() -> None:
    own = events_of(family("isosceles"), 3)
    [first, second] = next(group for group in grouped(own) if len(group) == 2)
    assert isinstance(first, BallEvent)
    assert isinstance(second, BallEvent)
    mirror = symmetries(SliceMap.of(family("isosceles"), 3))[0]
    assert _is_image(mirror, first, second)
    assert _is_image(mirror, second, first)
    assert not _is_image(mirror, first, first)
    assert not _is_image(mirror, replace(first, kind=PoseKind.HIGHER), second)
    others = (x for x in own if isinstance(x, BallEvent) and x not in (first, second))
    assert not any(_is_image(mirror, first, x) for x in others)


TWINS = [
    (Manipulator(*map(Fraction, ("22.5", "-6.3", "-8.4", "15", "20", "7"))), 1),
    (Manipulator(*map(Fraction, (5, 0, 12, 5, 12, 13)), orientation="cw"), 3),
]
"""Symmetries of another kind: a leg becomes a sum of both; base and platform change places."""


@pytest.mark.parametrize(("m", "fixed_leg"), TWINS)
def test_twins_of_less_visible_symmetries_stand_together(m: Manipulator, fixed_leg: int) -> None:
    groups = grouped(events_of(m, fixed_leg))
    assert sum(len(group) == 2 for group in groups) >= 5
    assert all(group[0].pose.kind is group[1].pose.kind for group in groups if len(group) == 2)  # type: ignore[union-attr]


def test_equal_limits_of_mirrored_legs_are_met_together() -> None:
    slice_map = SliceMap.of(family("isosceles"), 3)
    systems = EventSystems.of(slice_map)
    both = [list(limit_events(systems, leg, Fraction(10**4))) for leg in (slice_map.f, slice_map.g)]
    assert both[0]
    groups = grouped([*both[0], *both[1]])
    assert all(len(group) == 2 for group in groups)
    first, second = next(pair for pair in groups if all(isinstance(x, BallEvent) for x in pair))
    assert isinstance(first, BallEvent)
    assert isinstance(second, BallEvent)
    unlike = replace(second, system=replace(second.system, limit=None))
    assert not any(_is_image(symmetry, first, unlike) for symmetry in symmetries(slice_map))
