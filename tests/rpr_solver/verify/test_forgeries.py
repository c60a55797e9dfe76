"""The fixed list of forgeries: each is refused, or its false claim is named in the first line."""

from __future__ import annotations

import pytest

from rpr_solver import verify_document
from rpr_solver.verify import censuses, checks, curves
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.events import Events
from tests.rpr_solver.verify.forgeries import _BASES, FORGERIES, Forgery, base, first_line

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
