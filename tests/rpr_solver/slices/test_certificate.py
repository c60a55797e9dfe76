"""The certificate of a slice: just the members that are declared, which add up, and proofs that prove."""

from functools import cache
from typing import Any

import pytest
from flint import arb

from rpr_solver import EXAMPLES, Manipulator, article_table, solve_slice
from rpr_solver.slices.certificate import SliceCertificate
from tests.support.families import family
from tests.support.shapes import misfits
from tests.support.shared import eliminant_of

SLICES = {
    "balls": (EXAMPLES["zein-flat"], 1, 10),
    "leg 2": (EXAMPLES["zein-flat"], 2, 10),
    "no cusp": (EXAMPLES["zein-flat"], 1, "0.1"),
    "number fields": (family("right angles"), 2, 1),
    "a flat manipulator": (family("both flat"), 1, 3),
    "a swallowtail": (Manipulator(2, -4, 4, 1, 4, 3, orientation="cw"), 1, 1),
    "a shared curve": (family("congruent"), 1, 5),
}
NAMES = {"rank_1", "grad_J", "v_grad_E"}


@cache
def table(name: str, digits: int = 15) -> dict[str, Any]:
    manipulator, leg, length = SLICES[name]
    return solve_slice(eliminant_of(manipulator, leg), length, digits).to_json()


@pytest.mark.parametrize("name", SLICES)
def test_a_certificate_has_what_is_declared_and_nothing_else(name: str) -> None:
    assert list(misfits(table(name)["certificate"], SliceCertificate)) == []


def test_that_of_the_article_has_so_too() -> None:
    certificate = article_table(EXAMPLES["zein-flat"], 10, digits=15).to_json()["certificate"]
    assert list(misfits(certificate, SliceCertificate)) == []
    assert certificate["method"] == "article"


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
def test_every_cusp_has_its_proof(name: str) -> None:
    answer = table(name)
    proofs = answer["certificate"]["proofs"]
    assert len(proofs) == answer["count"]
    for proof in proofs:
        if proof.keys() == NAMES:
            assert not any(arb(ball).contains(0) for ball in proof.values())
        else:
            assert proof.keys() == {"field_degree"}
            assert int(proof["field_degree"]) >= 1


@pytest.mark.parametrize("name", SLICES)
def test_balls_settle_a_slice_only_if_all_roots_are_simple(name: str) -> None:
    certificate = table(name)["certificate"]
    multiplicities = {x["multiplicity"] for x in certificate["factors"] if x["origin"] == "cusps"}
    by_balls = all(proof.keys() == NAMES for proof in certificate["proofs"])
    if certificate["method"] == "balls":
        assert multiplicities == {1}
        assert by_balls
        assert table(name)["degenerate_points"] == []
    else:
        assert certificate["method"] == "exact"


def test_both_methods_and_both_proofs_are_met() -> None:
    certificates = [table(name)["certificate"] for name in SLICES]
    assert {x["method"] for x in certificates} == {"balls", "exact"}
    assert {name for x in certificates for proof in x["proofs"] for name in proof} == {*NAMES, "field_degree"}


@pytest.mark.parametrize("name", ["balls", "number fields"])
def test_more_digits_take_more_bits(name: str) -> None:
    bits = [table(name, digits)["certificate"]["working_bits"] for digits in (15, 60, 200)]
    assert bits == sorted(set(bits))
    assert all(b > 3.3219 * digits for b, digits in zip(bits, (15, 60, 200), strict=True))


def test_a_real_root_of_q_for_each_cusp_of_a_generic_slice() -> None:
    """Above every real root lies one cusp, whatever its side."""
    for name in ("balls", "leg 2", "no cusp"):
        assert table(name)["certificate"]["real_roots"] == table(name)["count"]
