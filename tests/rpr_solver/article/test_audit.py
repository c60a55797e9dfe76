"""The article's algorithm: the factors of its eliminant, and the same cusps as the solver's."""

from __future__ import annotations

from collections import Counter
from fractions import Fraction
from functools import cache
from typing import Any

import pytest
from hypothesis import given

from rpr_solver import (
    EXAMPLES,
    ArticleTable,
    Manipulator,
    SolverError,
    article_table,
    eliminate,
    solve_slice,
)
from tests.support.families import family
from tests.support.reference import CASES
from tests.support.strategies import examples, lengths, manipulators

QUICK = ("flat-base", "congruent")
SAMPLED = (*QUICK, "innocenti", "rational-h", "both-flat", "similar", "sixteen-cusps")
VECTORS = [
    pytest.param(
        case["geometry"],
        item,
        id=f"{case['name']}-{item['l1']}",
        marks=pytest.mark.long
        if n or case["name"] not in SAMPLED
        else []
        if case["name"] in QUICK
        else pytest.mark.slow,
    )
    for case in CASES
    for n, item in enumerate(case["slices"])
]


def test_the_articles_factorisation() -> None:
    """L1 = 14.98: 96 = 24 + quadratics and a quartic to their powers; Q is irreducible over Q(h)."""
    audit: Any = article_table(EXAMPLES["innocenti"], "14.98", digits=15).audit
    shape = [(row["degree"], row["multiplicity"]) for row in audit["factors"]]
    assert shape == [(2, 18), (2, 2), (2, 2), (2, 4), (4, 2), (2, 2), (2, 2), (2, 2), (24, 1)]
    assert sum(degree * times for degree, times in shape) == 96 == audit["eliminant_degree"]
    assert audit["factors"][-1]["irreducible"] == [{"degree": 24, "multiplicity": 1}]
    verdicts = {row["origin"]: {c["verdict"] for c in row["couples"]} for row in audit["factors"]}
    assert verdicts.pop("Q") == {"kept"}
    assert set.union(*verdicts.values()) == {"rejected"}
    reasons = {c["reason"] for row in audit["factors"][:-1] for c in row["couples"]}
    assert any(reason.startswith("leg 2 has length zero") for reason in reasons)
    assert any("adjugate's first column vanishes" in reason for reason in reasons)
    assert any("adjugate's first row vanishes" in reason for reason in reasons)
    assert audit["conjecture"]["holds"]


@pytest.mark.parametrize(("geometry", "expected"), VECTORS)
def test_both_methods_agree(geometry: dict[str, str], expected: dict[str, Any]) -> None:
    m = Manipulator.from_json(geometry)
    truth = solve_slice(eliminate(m), Fraction(expected["l1"]), 90)
    if any(point["kind"] == "curve" for point in truth.degenerate_points):
        with pytest.raises(SolverError, match="vanishes identically"):
            article_table(m, expected["l1"])
        return
    ours = article_table(m, expected["l1"])
    assert ours.count == expected["count"]
    assert ours.cusps == truth.cusps
    assert ours.table.degenerate_points == truth.degenerate_points
    assert ours.audit["conjecture"]["holds"]  # type: ignore[index]
    document = ours.to_json()
    assert (document["method"], document["l1"], document["count"]) == ("article", expected["l1"], truth.count)


@pytest.mark.long
def test_a_thousand_digits() -> None:
    truth = solve_slice(eliminate(EXAMPLES["innocenti"]), Fraction("14.98"), 1000)
    assert article_table(EXAMPLES["innocenti"], "14.98", digits=1000).cusps == truth.cusps


def test_a_swallowtail_at_theta1_180_is_not_lost() -> None:
    m = Manipulator(*map(Fraction, (2, -4, 4, 1, 4, 3)), orientation="cw")
    ours, truth = article_table(m, 1, digits=30), solve_slice(eliminate(m), Fraction(1), 30)
    assert ours.table.degenerate_points == truth.degenerate_points
    assert ours.table.degenerate_points[0]["theta1_deg"].startswith("180.0")
    assert ours.cusps == truth.cusps


@pytest.mark.slow
@given(manipulators(size=6, denominators=(1,)), lengths(size=8, denominators=(1, 2)))
@examples(4)
def test_both_methods_agree_on_special_geometries(m: Manipulator, length: Fraction) -> None:
    truth = solve_slice(eliminate(m), length, 20)
    try:
        ours = article_table(m, length, digits=20)
    except SolverError:
        assert any(point["kind"] == "curve" for point in truth.degenerate_points)
        return
    assert (ours.cusps, ours.table.degenerate_points) == (truth.cusps, truth.degenerate_points)
    assert ours.audit["conjecture"]["holds"]  # type: ignore[index]


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
