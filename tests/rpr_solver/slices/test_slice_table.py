"""The answer to a slice: its document, its rows for a data frame, and what a notebook shows."""

from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

from rpr_solver import JointPoint
from rpr_solver.slices.certificate import SliceCertificate
from rpr_solver.slices.slice_table import SliceTable

CERTIFICATE: SliceCertificate = {
    "eliminant_degree": 24,
    "real_roots": 2,
    "factors": [],
    "method": "balls",
    "working_bits": 300,
    "proofs": [],
}
CUSPS = (
    JointPoint(2, ("-31.4509403281135", "-129.006918092045", "25.2233542007524", "1.00000000000000e-20")),
    JointPoint(2, ("180.000000000000", "0", "3.5", "40")),
)
SWALLOWTAIL = {"kind": "swallowtail", "alpha_deg": "0", "theta2_deg": "90", "l1": "1", "l3": "2"}
CURVE = {"kind": "curve", "equation": "alpha = 0"}
TABLE = SliceTable(2, Fraction(61, 3), 15, CUSPS, (CURVE, SWALLOWTAIL), CERTIFICATE)
EMPTY = SliceTable(1, Fraction(7, 2), 20, (), (), CERTIFICATE)


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
