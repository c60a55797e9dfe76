"""The report of the audit: audits of all sorts give just the objects that are declared, and they add up."""

from collections import Counter
from functools import cache
from typing import Any, get_type_hints

import pytest

from rpr_solver import EXAMPLES, ArticleTable, Manipulator, article_table
from rpr_solver.article.report import AuditReport, CoupleReport, FactorReport
from tests.support.families import family
from tests.support.shapes import misfits

SLICES = {
    "a slice with h = 0": (EXAMPLES["zein-flat"], 10),
    "an irrational h": (EXAMPLES["innocenti"], 27),
    "a rational h": (family("right angles"), 5),
    "a degenerate couple": (Manipulator(2, -4, 4, 1, 4, 3, orientation="cw"), 1),
}


@cache
def audited(name: str) -> ArticleTable:
    manipulator, length = SLICES[name]
    return article_table(manipulator, length, digits=15)


def report(name: str) -> dict[str, Any]:
    """As it stands in the document."""
    audit: dict[str, Any] = audited(name).to_json()["audit"]
    return audit


@pytest.mark.parametrize("name", SLICES)
def test_an_audit_has_what_is_declared_and_nothing_else(name: str) -> None:
    assert list(misfits(report(name), AuditReport)) == []


@pytest.mark.parametrize("name", SLICES)
def test_the_factors_make_up_the_degree_of_the_eliminant(name: str) -> None:
    audit = report(name)
    assert sum(x["degree"] * x["multiplicity"] for x in audit["factors"]) == audit["eliminant_degree"] == 96
    for factor in audit["factors"]:
        degrees = [x["degree"] * x["multiplicity"] for x in factor["irreducible"]]
        assert sum(degrees) == factor["degree"], factor["origin"]


@pytest.mark.parametrize("name", SLICES)
def test_a_couple_has_one_of_three_verdicts_and_its_reason(name: str) -> None:
    couples = [couple for factor in report(name)["factors"] for couple in factor["couples"]]
    assert couples
    assert {couple["verdict"] for couple in couples} <= {"kept", "degenerate", "rejected"}
    assert all(couple["reason"] for couple in couples)
    verdicts = Counter(couple["verdict"] for couple in couples)
    table = audited(name).table
    assert (verdicts["kept"], verdicts["degenerate"]) == (table.count, len(table.degenerate_points))


def test_the_slices_show_all_that_a_report_can_say() -> None:
    reports = [report(name) for name in SLICES]
    factors = [factor for x in reports for factor in x["factors"]]
    verdicts = {couple["verdict"] for factor in factors for couple in factor["couples"]}
    assert verdicts == {"kept", "degenerate", "rejected"}
    assert {x["h"].split(",")[0].split(";")[0] for x in reports} == {"symbolic", "rational"}


@pytest.mark.parametrize(
    ("change", "place"),
    [
        ({"holds": "yes"}, ".conjecture.holds"),
        ({"holds": True, "why": ""}, ".conjecture.why"),
        ({}, ".conjecture.holds"),
    ],
)
def test_another_object_would_be_noticed(change: dict[str, object], place: str) -> None:
    audit = report("a slice with h = 0")
    answer = {"answer": audit["conjecture"]["answer"]}
    assert any(
        x.startswith(place) for x in misfits({**audit, "conjecture": {**answer, **change}}, AuditReport)
    )


def test_the_members_of_a_couple_are_those_of_the_document() -> None:
    assert list(get_type_hints(CoupleReport)) == ["alpha_deg", "theta1_deg", "verdict", "reason"]
    factor = report("an irrational h")["factors"][0]
    assert list(factor) == list(get_type_hints(FactorReport))
