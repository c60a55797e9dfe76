"""Tables of slices, and what their certificates say."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cache
from typing import Any

import pytest
from flint import arb

from rpr_solver import (
    EXAMPLES,
    JointPoint,
    Manipulator,
    PoseKind,
    solve_slice,
)
from rpr_solver.model.joint_points import ClassifiedPoint
from rpr_solver.slices.slice_table import SliceCertificate, SliceTable
from tests.support.families import family
from tests.support.newton import Slice
from tests.support.shared import eliminant_of

CERTIFICATE: SliceCertificate = {
    "eliminant_degree": 24, "real_roots": 2, "factors": [], "method": "balls", "nonzero": ["v"]
}  # fmt: skip
SWALLOWTAIL = {"kind": "swallowtail", "alpha_deg": "0", "theta2_deg": "90", "l1": "1", "l3": "2"}
CURVE = {"kind": "curve", "equation": "alpha = 0"}


def point(kind: PoseKind, theta: arb, alpha: arb, name: str) -> ClassifiedPoint:
    return ClassifiedPoint(kind, theta, alpha, JointPoint(1, (name, "2", "3", "4")))


def table_of(*points: ClassifiedPoint) -> SliceTable:
    return SliceTable.of(1, Fraction(5), 15, CERTIFICATE, points, [CURVE])


def test_points_ascend_by_the_fixed_leg_s_angle_then_by_alpha() -> None:
    """Angles that balls do not tell apart count as equal."""
    a, b, c, d = (
        point(PoseKind.CUSP, arb(theta, 1e-6), arb(alpha), name)
        for theta, alpha, name in ((-3, 9, "a"), (5, -8, "b"), (5, 1, "c"), (7, -9, "d"))
    )
    for order in ((a, b, c, d), (d, c, b, a), (c, a, d, b)):
        table = table_of(*order)
        assert [x.alpha_deg for x in table.cusps] == ["a", "b", "c", "d"]


def test_cusps_are_told_from_other_points() -> None:
    kinds = [PoseKind.CUSP, PoseKind.NODE, PoseKind.CUSP, PoseKind.SWALLOWTAIL]
    table = table_of(*(point(kind, arb(0), arb(0), name) for kind, name in zip(kinds, "abcd", strict=True)))
    assert [x.alpha_deg for x in table.cusps] == ["a", "c"]
    assert list(table.degenerate_points) == [
        CURVE,
        {"kind": "node", "alpha_deg": "b", "theta1_deg": "2", "l2": "3", "l3": "4"},
        {"kind": "swallowtail", "alpha_deg": "d", "theta1_deg": "2", "l2": "3", "l3": "4"},
    ]
    assert {type(x["kind"]) for x in table.degenerate_points} == {str}
    assert table.certificate == CERTIFICATE


SLICES = {
    "balls": (EXAMPLES["zein-flat"], 1, 10),
    "leg 2": (EXAMPLES["zein-flat"], 2, 10),
    "no cusp": (EXAMPLES["zein-flat"], 1, "0.1"),
    "number fields": (family("right angles"), 2, 1),
    "a flat manipulator": (family("both flat"), 1, 3),
    "a swallowtail": (Manipulator(2, -4, 4, 1, 4, 3, orientation="cw"), 1, 1),
    "a shared curve": (family("congruent"), 1, 5),
}


@cache
def table(name: str, digits: int = 15) -> dict[str, Any]:
    manipulator, leg, length = SLICES[name]
    return solve_slice(eliminant_of(manipulator, leg), length, digits).to_json()


@pytest.mark.parametrize("name", SLICES)
def test_the_factors_are_those_of_a_form_of_degree_48(name: str) -> None:
    certificate = table(name)["certificate"]
    parts = {True: 0, False: 0}
    for factor in certificate["factors"]:
        parts[factor["origin"] == "cusps"] += factor["degree"] * factor["multiplicity"]
    assert parts[True] == certificate["eliminant_degree"]
    if name == "a shared curve":
        assert parts[False] == 0
    else:
        assert parts == {True: 24, False: 24}


def test_what_is_named_is_not_0_at_any_cusp() -> None:
    """In floats, by formulas of their own, in units of the longest side; by both methods."""
    methods = set()
    for name, (manipulator, leg, length) in SLICES.items():
        answer = table(name)
        assert answer["certificate"]["nonzero"] == ["v", "grad_J", "v_grad_E"]
        local = Slice(manipulator, float(Fraction(length)))
        for cusp in answer["cusps"] if leg == 1 else ():
            at = math.radians(float(cusp["alpha_deg"])), math.radians(float(cusp["theta1_deg"]))
            legs = [local.derivatives(n, at) for n in (0, 1)]
            n, f = max(enumerate(legs), key=lambda pair: math.hypot(pair[1][1][0], pair[1][0][1]))
            _, (j, e) = local.system(n, at)
            assert math.hypot(f[1][0], f[0][1]) > 1e-6
            assert math.hypot(*j) > 1e-6
            assert abs(f[1][0] * e[1] - f[0][1] * e[0]) > 1e-6
            methods.add(answer["certificate"]["method"])
    assert methods == {"balls", "exact"}
