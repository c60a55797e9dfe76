"""The fixed list of forgeries: each is refused, or its false claim is named in the first line."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from rpr_solver import verify_document
from rpr_solver.verify import censuses, documents
from tests.rpr_solver.verify import (  # noqa: F401 (theirs go to the list)
    margin_forgeries,
    more_forgeries,
    shape_forgeries,
)
from tests.rpr_solver.verify.forgeries import _BASES, FORGERIES, Forgery, base, first_line
from tests.rpr_solver.verify.test_paths import FORGERIES as OF_PATHS
from tests.rpr_solver.verify.test_paths import NAMED
from tests.rpr_solver.verify.test_singular_curves import FORGERIES as OF_SINGULAR_CURVES
from tests.rpr_solver.verify.test_singular_curves import (
    OF_ALIKE,
    OF_BEAK,
    OF_FLAT,
    OF_FOLDS,
    OF_LINES,
    OF_NODES,
)
from tests.support.sampling import long

VERIFIER = Path(censuses.__file__).parent
pytestmark = pytest.mark.usefixtures("events_are_found_once")


def test_there_are_enough_of_all_kinds() -> None:
    assert len(FORGERIES) >= 150
    assert len({forgery.name for forgery in FORGERIES}) == len(FORGERIES)
    assert {forgery.base for forgery in FORGERIES} | {"nodes"} == set(_BASES)


EXPENSIVE = {
    *("curves", "full curves", "printed alike", "refuted window"),
    *("margin of a requirement", "margin of a window", "margin of an open range"),
    *("a length of 0", "mirrored, with limits", "a narrow window", "a quadruple pose", "no crossing"),
    *("the last event", "mirrored table", "short margin", "always singular", "a kind that is not found"),
}
"""Documents that take a second and more to make or to verify: with `--long` only."""

DEAR = {
    *("triangles that are almost mirrored", "triangles that are almost similar", "a wider tolerance"),
    *("a proof for a range beyond its own", "a transition hidden beside a length of 0", "a chain less"),
    *("a geometry that has the window", "two transitions that are printed alike as one", "a curve less"),
    *("a curve that passes a quadruple pose as two", "a curve that passes the last quadruple pose"),
}
"""Forgeries that take as long, where another of the same claim does not: with `--long` only."""


@pytest.mark.parametrize("name", [long(name) if name in EXPENSIVE else name for name in _BASES])
def test_the_documents_they_begin_with_are_accepted_and_all_claims_are_named_without_any_work(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    verification = verify_document(base(name))
    assert verification.accepted
    made = [(claim.at, claim.claim) for claim in verification.claims]
    assert len(set(made)) == len(made)
    monkeypatch.setattr(documents, "UNITS_OF_A_CHARACTER", 0)
    without_work = verify_document(base(name))
    assert [(claim.at, claim.claim) for claim in without_work.claims] == made
    assert not without_work.refused
    proved = {(claim.at, claim.claim) for claim in verification.claims if claim.established}
    assert {(claim.at, claim.claim) for claim in without_work.claims if claim.established} <= proved


def sampled() -> list[Any]:
    """Every sixth of each base runs always; of expensive ones the first, of poses, which are cheap, all."""
    seen: Counter[str] = Counter()
    cases = []
    for forgery in FORGERIES:
        every = {"poses": 1}.get(forgery.base, 1000 if forgery.base in EXPENSIVE else 6)
        runs = seen[forgery.base] % every == 0 and forgery.name not in DEAR
        marks = [] if runs else [pytest.mark.long]
        cases.append(pytest.param(forgery, id=forgery.name, marks=marks))
        seen[forgery.base] += 1
    return cases


@pytest.mark.parametrize("forgery", sampled())
def test_a_forgery_is_refused_or_its_claim_named(forgery: Forgery) -> None:
    line = first_line(forgery.document())
    assert line.startswith(("REFUSED: ", "NOT ESTABLISHED")), line
    assert forgery.at in line.replace("/*", "/0") or forgery.at in line, (forgery.at, line)


def test_each_hypothesis_of_a_claim_has_a_forgery_that_violates_it() -> None:
    page = (Path(__file__).parents[3] / "docs" / "verify.md").read_text(encoding="utf-8")
    section = page.partition("## Why it is sound\n")[2].partition("### What stays open\n")[0]
    rows = [line.strip("| ").split(" | ") for line in section.splitlines() if line.startswith("| ")]
    hypotheses = [row for row in rows if row[0] != "hypothesis"]
    assert len(hypotheses) > 60
    names = {forgery.name for forgery in FORGERIES} | set(OF_PATHS) | set(NAMED)
    names |= set(OF_SINGULAR_CURVES) | set(OF_FLAT) | set(OF_BEAK)
    names |= {*OF_NODES, *OF_FOLDS, *OF_LINES, *OF_ALIKE}
    for hypothesis, where, violated in hypotheses:
        assert set(re.findall("`([^`]+)`", violated)) <= names, hypothesis
        for module in re.findall(r"`([a-z/_]+)`", where):
            assert (VERIFIER / f"{module}.py").is_file(), module
