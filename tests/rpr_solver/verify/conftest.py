"""The verifier's events of a manipulator, found once for many tests."""

from functools import lru_cache

import pytest

from rpr_solver.verify import censuses, curves, margins
from rpr_solver.verify.core.numbers import Geometry
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.events import Events


@lru_cache(maxsize=64)
def _found(geometry: Geometry, fixed: int, bits: int) -> Events:
    return Events(Surface(geometry, fixed), bits)


@pytest.fixture
def events_are_found_once(monkeypatch: pytest.MonkeyPatch) -> None:
    def events(surface: Surface, bits: int) -> Events:
        return _found(surface.geometry, surface.fixed, bits)

    for module in (censuses, curves, margins):
        monkeypatch.setattr(module, "Events", events)
