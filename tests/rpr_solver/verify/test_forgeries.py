"""The fixed list of forgeries: each is refused, or its false claim is named in the first line."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rpr_solver import verify_document
from rpr_solver.verify import censuses, checks, curves
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.events import Events
from tests.rpr_solver.verify.forgeries import _BASES, FORGERIES, Forgery, base, first_line

VERIFIER = Path(censuses.__file__).parent
KNOWN: dict[tuple[str, int, int], Events] = {}


@pytest.fixture(autouse=True)
def _the_events_of_a_manipulator_are_found_once(monkeypatch: pytest.MonkeyPatch) -> None:
    def found(surface: Surface, bits: int) -> Events:
        key = (surface.geometry.hash, surface.fixed, bits)
        if key not in KNOWN:
            KNOWN[key] = Events(surface, bits)
        return KNOWN[key]

    for module in (censuses, checks, curves):
        monkeypatch.setattr(module, "Events", found)


def test_there_are_enough_of_all_kinds() -> None:
    assert len(FORGERIES) >= 150
    assert len({forgery.name for forgery in FORGERIES}) == len(FORGERIES)
    assert {forgery.base for forgery in FORGERIES} | {"nodes"} == set(_BASES)


@pytest.mark.parametrize("name", _BASES)
def test_the_documents_they_begin_with_are_accepted(name: str) -> None:
    assert verify_document(base(name)).accepted


@pytest.mark.parametrize("forgery", FORGERIES, ids=lambda forgery: forgery.name)
def test_a_forgery_is_refused_or_its_claim_named(forgery: Forgery) -> None:
    line = first_line(forgery.document())
    assert line.startswith(("REFUSED: ", "NOT ESTABLISHED")) or forgery.at.endswith("aspects"), line
    assert forgery.at in line.replace("/*", "/0") or forgery.at in line, (forgery.at, line)


def test_each_hypothesis_of_a_claim_has_a_forgery_that_violates_it() -> None:
    page = (Path(__file__).parents[3] / "docs" / "verify.md").read_text(encoding="utf-8")
    section = page.partition("## Why it is sound\n")[2].partition("### What stays open\n")[0]
    rows = [line.strip("| ").split(" | ") for line in section.splitlines() if line.startswith("| ")]
    hypotheses = [row for row in rows if row[0] != "hypothesis"]
    assert len(hypotheses) > 60
    names = {forgery.name for forgery in FORGERIES}
    for hypothesis, where, violated in hypotheses:
        assert violated.strip("`") in names, hypothesis
        for module in re.findall(r"`([a-z/_]+)`", where):
            assert (VERIFIER / f"{module}.py").is_file(), module
