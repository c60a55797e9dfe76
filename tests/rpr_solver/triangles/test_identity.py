"""Special shapes nearby in the head of documents: random machines at distances from 1/10 to 10⁻⁴⁰ of each."""

from __future__ import annotations

from fractions import Fraction
from math import isqrt
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import Manipulator
from rpr_solver.triangles import Geometry, Triangle, near_shapes, own_shapes, read_geometry
from rpr_solver.triangles.identity import may_be_near
from rpr_solver.verify.geometry import Geometry as VerifiedGeometry
from rpr_solver.verify.special_shapes import NEAR, near_claims
from tests.support.triangle_spellings import geometries

EXPONENTS = st.sampled_from([1, 2, 3, 4, 5, 8, 12, 16, 30, 40])
BASE: tuple[Fraction, Fraction, Fraction] = (Fraction(144), Fraction(106), Fraction(130))
"""The squared sides of (0, 0), (12, 0), (7, 9), which is near nothing."""


def rounded_root(square: Fraction, digits: int) -> Fraction:
    """The square root, rounded down to so many digits after the point."""
    return Fraction(isqrt(square.numerator * 100**digits // square.denominator), 10**digits)


def changed(squares: tuple[Fraction, Fraction, Fraction], change: Fraction) -> Triangle:
    a, b, c = squares
    return Triangle((a, b * (1 + change) ** 2, c), "ccw")


def machine(name: str, change: Fraction, factor: Fraction) -> Geometry:
    """A geometry with one side changed by a fraction, of what has exactly the named shape."""
    a, b, c = BASE
    base = Triangle(BASE, "ccw")
    if name in ("similar", "congruent", "mirrored"):
        scale = factor**2 if name == "similar" else Fraction(1)
        platform = changed((scale * a, scale * b, scale * c), change)
        return Geometry(base, platform.mirrored() if name == "mirrored" else platform)
    squares = {
        "isosceles": (Fraction(25), Fraction(25), Fraction(49)),
        "equilateral": (factor, factor, factor),
        "right isosceles": (factor, factor, 2 * factor),
        "flat": (Fraction(9), Fraction(64), Fraction(25)),
    }[name]
    return Geometry(base, changed(squares, -abs(change) if name == "flat" else change))


SHAPES = ("similar", "congruent", "mirrored", "isosceles", "right isosceles", "equilateral", "flat")


@given(st.sampled_from(SHAPES), EXPONENTS, st.integers(1, 9), st.sampled_from([1, -1]), st.integers(2, 5))
def test_each_shape_is_named_within_its_distance_alone(
    name: str, exponent: int, digit: int, sign: int, factor: int
) -> None:
    change = Fraction(sign * digit, 10**exponent)
    geometry = machine(name, change, Fraction(factor))
    head = Manipulator.of(geometry).identity_json()
    found = {shape["shape"]: shape for shape in head.get("near", ())}
    # to one side of a pair, half the change of their quotient; congruent ones have that of the side
    expected = {
        "congruent": abs(1 / (1 + change) - 1),
        "mirrored": abs(1 / (1 + change) - 1),
        "flat": 8 * abs(change) / (16 - 8 * abs(change)),
    }.get(name, abs(change) / (2 + change))
    assert (name in found) == (expected < Fraction(1, 1000))
    if name not in found:
        return
    assert abs(Fraction(found[name]["distance"]) / expected - 1) < Fraction(51, 1000)
    exact = read_geometry(found[name]["spelling"])
    assert name in {shape for shape, _ in own_shapes(exact)}


@given(geometries())
def test_what_doubles_call_far_is_far(geometry: Geometry) -> None:
    assert may_be_near(geometry.to_json()) or not near_shapes(geometry)


@pytest.mark.parametrize("scale", ["1e-200", "1e-60", "1", "1e90", "1e200"])
def test_shapes_are_near_at_any_size(scale: str) -> None:
    size = Fraction(scale)
    lengths = [size * x for x in (30, 0, Fraction(400001, 10000), 15, 25, 20)]
    near = Manipulator(*lengths).identity_json()["near"]
    assert (near[0]["shape"], near[0]["distance"]) == ("similar", "0.0000012")


def test_corners_that_nearly_coincide_are_not_taken_for_far() -> None:
    tiny = Fraction(1, 10**30)
    manipulator = Manipulator(1, 1 + 2 * tiny, tiny, 1, "1.5", "1.00000000001")
    shapes = {shape["shape"] for shape in manipulator.identity_json()["near"]}
    assert "isosceles" in shapes


@given(st.sampled_from(SHAPES), EXPONENTS, st.integers(1, 9), st.integers(2, 5))
def test_distances_are_verified(name: str, exponent: int, digit: int, factor: int) -> None:
    platform = machine(name, Fraction(digit, 10**exponent), Fraction(factor**2)).platform
    sides = [rounded_root(square, 45) for square in platform.squares]
    manipulator = Manipulator(12, 7, 9, *sides, orientation=platform.sense)
    head: dict[str, Any] = manipulator.identity_json()
    if "near" not in head:
        return
    geometry = VerifiedGeometry.read(head["geometry"], "/geometry")
    for claim in near_claims(geometry, NEAR(head["near"], "/near")):
        assert claim.status == "proved", claim
    for shape in head["near"]:
        wrong = {**shape, "distance": "0.00097" if shape["distance"] != "0.00097" else "0.00050"}
        [claim] = near_claims(geometry, NEAR([wrong], "/near"))
        assert claim.status == "refused"


@given(st.sampled_from(SHAPES), st.integers(3, 7))
def test_what_is_exactly_special_is_not_near_it(name: str, factor: int) -> None:
    exact = machine(name, Fraction(0), Fraction(factor))
    assert name in {shape for shape, _ in own_shapes(exact)}
    assert "near" not in Manipulator.of(exact).identity_json()
