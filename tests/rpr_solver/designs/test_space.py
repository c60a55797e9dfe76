"""What varies in a design: bounds, roundings, ties between lengths, and triangles that are too flat."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, InputError, Manipulator
from rpr_solver.designs.space import TIES, Space, is_nearly_special

INNOCENTI = EXAMPLES["innocenti"]
PLACES = st.lists(st.floats(0, 1), min_size=6, max_size=6)


def squares(m: Manipulator) -> tuple[list[Fraction], list[Fraction]]:
    """The squared sides |A1A2|, |A2A3|, |A3A1| of the base, and those of the platform."""
    base = [m.a2x**2, (m.a2x - m.a3x) ** 2 + m.a3y**2, m.a3x**2 + m.a3y**2]
    return base, [m.d1**2, m.d2**2, m.d3**2]


HOLDS = {
    "isosceles-1": lambda base, platform: base[0] == base[2] and platform[0] == platform[2],
    "isosceles-2": lambda base, platform: base[0] == base[1] and platform[0] == platform[1],
    "isosceles-3": lambda base, platform: base[1] == base[2] and platform[1] == platform[2],
    "similar": lambda base, platform: len({x / y for x, y in zip(base, platform, strict=True)}) == 1,
    "congruent": lambda base, platform: base == platform,
    "mirror": lambda base, platform: base == platform,
}


@given(place=PLACES, decimals=st.integers(0, 6))
def test_a_candidate_is_within_its_bounds_and_has_few_decimals(place: list[float], decimals: int) -> None:
    space = Space.of(INNOCENTI, "15%", decimals=decimals)
    found = space.manipulator(place)
    assert found is not None
    for name, (low, high) in space.bounds.items():
        x = getattr(found, name)
        assert low <= x <= high
        assert (x * 10**decimals).denominator == 1


@given(place=PLACES, family=st.sampled_from(sorted(TIES)))
def test_a_tie_holds_exactly(place: list[float], family: str) -> None:
    space = Space.of(INNOCENTI, "15%", family=family)
    found = space.manipulator(place[: len(space.names)])
    assert found is not None
    assert HOLDS[family](*squares(found))
    assert space.place(found) == pytest.approx(space.place(found))
    again = space.manipulator(space.place(found))
    assert again == found


def test_the_mirror_image_is_no_copy() -> None:
    for family, orientation in (("congruent", "ccw"), ("mirror", "cw")):
        found = Space.of(INNOCENTI, "15%", family=family).manipulator([0.5] * 3)
        assert found is not None
        assert found.orientation == orientation


def test_what_is_fixed_keeps_its_value() -> None:
    space = Space.of(INNOCENTI, "15%", fixed=["a2x", "d3"], decimals=0)
    found = space.manipulator([0.9] * 4)
    assert found is not None
    assert (found.a2x, found.d3) == (INNOCENTI.a2x, INNOCENTI.d3)
    bounded = Space.of(INNOCENTI, {"a3x": (-2, "2.5")})
    assert bounded.names == ("a3x",)
    assert bounded.place(INNOCENTI) == [pytest.approx(2 / 4.5)]


def test_flat_triangles_are_left_out() -> None:
    wide = {"d3": ("0.1", "33.579")}
    assert Space.of(INNOCENTI, wide).manipulator([0.9999]) is None
    assert Space.of(INNOCENTI, wide, min_height=0).manipulator([0.9999]) is not None
    flat = Space.of(INNOCENTI, {"d3": ("33.57", "33.58")}, decimals=12, min_height=0)
    assert flat.manipulator([0.999]) is not None
    assert flat.manipulator([1 - 1e-6]) is None, "a ten-thousandth of the longest side is needed always"
    assert Space.of(INNOCENTI, "1%", min_height=8).manipulator([0.5] * 6) is not None
    assert Space.of(INNOCENTI, "1%", min_height="8.5").manipulator([0.5] * 6) is None


@pytest.mark.parametrize(
    ("sides", "is_bad"),
    [
        ((4, 5, 3), False),  # congruent
        ((8, 10, 6), False),  # similar
        ((5, 3, 4), False),  # congruent, with the corners in another order
        ((4, 5, "3.0000001"), True),
        (("4.0000004", "5.0000005", "3.0000003"), True),  # similar, and nearly congruent
        ((8, 10, "6.000002"), True),
        (("3.0000001", 4, 5), True),
        ((4, 5, "3.00001"), False),
        ((8, 10, "6.0001"), False),
    ],
)
def test_what_is_nearly_but_not_quite_congruent_or_similar_is_left_out(
    sides: tuple[int | str, int | str, int | str], is_bad: bool
) -> None:
    """Their censuses would take longer the nearer they are; the start is examined all the same."""
    near = Manipulator(4, 0, 3, *sides)
    assert is_nearly_special(near) == is_bad
    space = Space.of(near, {"a3x": (0, 1)})
    assert (space.manipulator([0.0]) is None) == is_bad
    moved = space.manipulator([0.5])
    assert moved is not None
    assert not is_nearly_special(moved)


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"vary": "15"}, "vary"),
        ({"vary": "150%"}, "vary"),
        ({"vary": {"d4": (1, 2)}}, "vary.d4"),
        ({"vary": {"d1": (2, 1)}}, "vary.d1"),
        ({"vary": {"d1": 2}}, "vary.d1"),
        ({"vary": {"d1": (2, 2)}}, "vary"),
        ({"fixed": ["b1"]}, "fixed"),
        ({"decimals": 13}, "decimals"),
        ({"min_height": -1}, "min_height"),
        ({"family": "right"}, "family"),
    ],
)
def test_what_is_wrong_is_named(options: dict[str, object], field: str) -> None:
    with pytest.raises(InputError) as caught:
        Space.of(INNOCENTI, **options)  # type: ignore[arg-type]
    assert [problem.field for problem in caught.value.problems] == [field]
