"""The fixed list of forgeries: each is refused, or its false claim is named in the first line."""

from __future__ import annotations

import pytest

from rpr_solver import verify_document
from rpr_solver.verify import full_censuses
from rpr_solver.verify.events import EventBox, ProvedEvent, proved_event
from rpr_solver.verify.surface import Surface
from tests.rpr_solver.verify.forgeries import _BASES, FORGERIES, Forgery, base, first_line

KNOWN: dict[tuple[str, EventBox], ProvedEvent | None] = {}


@pytest.fixture(autouse=True)
def _each_box_is_proved_once(monkeypatch: pytest.MonkeyPatch) -> None:
    def proved(surface: Surface, box: EventBox) -> ProvedEvent | None:
        key = (surface.geometry.hash, box)
        if key not in KNOWN:
            KNOWN[key] = proved_event(surface, box)
        return KNOWN[key]

    monkeypatch.setattr(full_censuses, "proved_event", proved)


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
