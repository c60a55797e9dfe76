"""Tables of slices, and what their short and full certificates prove."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any

import pytest
from flint import arb, fmpq, fmpq_poly, fmpz, fmpz_poly, nmod_poly

from rpr_solver import (
    EXAMPLES,
    InputError,
    JointPoint,
    Manipulator,
    PoseKind,
    eliminate,
    solve_slice,
    table_document,
)
from rpr_solver.model.joint_points import ClassifiedPoint
from rpr_solver.slices.slice_table import SliceCertificate, SliceTable, full_certificate
from tests.support.families import family
from tests.support.shapes import misfits
from tests.support.shared import eliminant_of

CERTIFICATE: SliceCertificate = {
    "eliminant_degree": 24,
    "real_roots": 2,
    "factors": [],
    "method": "balls",
}
CUSPS = (
    JointPoint(2, ("-31.4509403281135", "-129.006918092045", "25.2233542007524", "1.00000000000000e-20")),
    JointPoint(2, ("180.000000000000", "0", "3.5", "40")),
)
SWALLOWTAIL = {"kind": "swallowtail", "alpha_deg": "0", "theta2_deg": "90", "l1": "1", "l3": "2"}
CURVE = {"kind": "curve", "equation": "alpha = 0"}
TABLE = SliceTable(2, Fraction(61, 3), 15, CUSPS, (CURVE, SWALLOWTAIL), CERTIFICATE)
EMPTY = SliceTable(1, Fraction(7, 2), 20, (), (), CERTIFICATE)


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


def test_the_document_has_the_length_by_the_name_of_the_leg() -> None:
    document = TABLE.to_json()
    assert list(document) == ["l2", "count", "cusps", "degenerate_points", "certificate"]
    assert (document["l2"], document["count"]) == ("61/3", 2)
    assert document["cusps"][0] == {
        "alpha_deg": "-31.4509403281135",
        "theta2_deg": "-129.006918092045",
        "l1": "25.2233542007524",
        "l3": "1.00000000000000e-20",
    }
    assert document["degenerate_points"] == [CURVE, SWALLOWTAIL]
    assert document["certificate"] == CERTIFICATE
    assert EMPTY.to_json() | {"certificate": None} == {
        "l1": "3.5", "count": 0, "cusps": [], "degenerate_points": [], "certificate": None
    }  # fmt: skip


def test_changes_of_the_document_leave_the_table_as_it_is() -> None:
    document = TABLE.to_json()
    document["degenerate_points"][0]["kind"] = "cusp"
    document["cusps"][0].clear()
    document["certificate"]["method"] = "guess"
    assert TABLE.to_json() == replace(TABLE).to_json()
    assert CURVE["kind"] == "curve"
    assert CERTIFICATE["method"] == "balls"


def test_cusps_have_rows_with_numbers_and_then_degenerate_points_without() -> None:
    rows = TABLE.rows()
    assert [(row["kind"], row["cusp"]) for row in rows] == [
        ("cusp", 1),
        ("cusp", 2),
        ("curve", None),
        ("swallowtail", None),
    ]
    assert {row["l2"] for row in rows} == {61 / 3}
    assert {row["l2_text"] for row in rows} == {"61/3"}
    assert (rows[0]["alpha_deg"], rows[0]["alpha_deg_text"]) == (-31.4509403281135, "-31.4509403281135")
    assert (rows[0]["l3"], rows[0]["l3_text"]) == (1e-20, "1.00000000000000e-20")
    assert (rows[3]["theta2_deg"], rows[3]["l1"]) == (90.0, 1.0)
    assert rows[2].keys() == {"l2", "l2_text", "kind", "cusp", "equation"}
    assert EMPTY.rows() == []


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({}, "<SliceTable L2=20.333333…: 2 cusps and 2 degenerate, 15 digits>"),
        ({"degenerate_points": ()}, "<SliceTable L2=20.333333…: 2 cusps, 15 digits>"),
        (
            {"cusps": CUSPS[:1], "degenerate_points": (), "digits": 90},
            "<SliceTable L2=20.333333…: 1 cusp, 90 digits>",
        ),
        (
            {"cusps": (), "length": Fraction(10)},
            "<SliceTable L2=10: 0 cusps and 2 degenerate, 15 digits>",
        ),
    ],
)
def test_in_short_it_is_its_counts(changes: dict[str, Any], text: str) -> None:
    table = replace(TABLE, length=Fraction(20333333333333, 10**12))
    assert repr(replace(table, **changes)) == text


def test_a_notebook_shows_the_counts_and_a_line_for_each_row() -> None:
    html = TABLE._repr_html_()
    assert "SliceTable L2=61/3: 2 cusps and 2 degenerate, 15 digits" in html
    assert html.count("<tr>") == 1 + len(TABLE.rows())
    assert html.index("<td>cusp</td>") < html.index("<td>curve</td>") < html.index("<td>swallowtail</td>")
    assert "<table>" not in EMPTY._repr_html_()


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
def test_a_certificate_has_what_is_declared_and_nothing_else(name: str) -> None:
    assert list(misfits(table(name)["certificate"], SliceCertificate)) == []


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


@pytest.mark.parametrize("name", SLICES)
def test_balls_settle_a_slice_only_if_all_roots_are_simple(name: str) -> None:
    certificate = table(name)["certificate"]
    multiplicities = {x["multiplicity"] for x in certificate["factors"] if x["origin"] == "cusps"}
    if certificate["method"] == "balls":
        assert multiplicities == {1}
        assert table(name)["degenerate_points"] == []
    else:
        assert certificate["method"] == "exact"


def test_both_methods_are_met() -> None:
    assert {table(name)["certificate"]["method"] for name in SLICES} == {"balls", "exact"}


@pytest.mark.parametrize("name", SLICES)
def test_a_certificate_does_not_depend_on_the_digits(name: str) -> None:
    assert table(name, 60)["certificate"] == table(name)["certificate"]


def test_a_real_root_of_q_for_each_cusp_of_a_generic_slice() -> None:
    """Above every real root lies one cusp, whatever its side."""
    for name in ("balls", "leg 2", "no cusp"):
        assert table(name)["certificate"]["real_roots"] == table(name)["count"]


def test_a_slice_over_the_integers() -> None:
    document = table_document(EXAMPLES["zein-flat"], 10, digits=15, certificate="full")
    [part] = document["slices"]
    full = part["certificate"]["full"]
    coefficients = [int(c) for c in full["polynomial"]["coefficients"]]
    q = fmpz_poly(coefficients)
    assert (q.degree(), "omega" in full["polynomial"]) == (24, False)
    prime = int(full["squarefree"]["prime"])
    assert fmpz(prime).is_prime()
    modulo = nmod_poly(coefficients, prime)
    assert modulo.gcd(modulo.derivative()).degree() == 0
    real = [root for root, _ in q.complex_roots() if root.imag == 0]
    assert len(real) == len(full["real_roots"]) == part["count"]
    for root in full["real_roots"]:
        low, high = (Fraction(root[end]) for end in ("lower", "upper"))
        below, above = (fmpq_poly(q)(fmpq(*x.as_integer_ratio())) for x in (low, high))
        assert below * above < 0
    assert full["boxes"][0]["l2"] == {"centre": part["cusps"][0]["l2"], "radius": "5e-14"}


def test_the_rest_of_the_document_is_as_usual() -> None:
    short, full = (
        table_document(EXAMPLES["innocenti"], ["14.98", 0], digits=15, certificate=name)
        for name in ("short", "full")
    )
    assert full["slices"][0]["certificate"].pop("full")["polynomial"]["omega"].startswith("sqrt(")
    assert full == short
    with pytest.raises(InputError, match="certificate"):
        table_document(EXAMPLES["innocenti"], "14.98", certificate="long")


@pytest.mark.parametrize("name", ["both flat", "congruent"])
def test_slices_with_multiple_roots_have_no_prime(name: str) -> None:
    eliminant = eliminate(family(name))
    table = solve_slice(eliminant, 3, 15)
    full = full_certificate(eliminant, Fraction(3), [cusp.to_json() for cusp in table.cusps])
    assert full["squarefree"] is None
    assert [root["multiplicity"] > 1 for root in full["real_roots"]] == [True] * len(full["real_roots"])
