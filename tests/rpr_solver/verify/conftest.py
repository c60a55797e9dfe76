"""What the verifier finds anew, whatever a document claims: once for many tests of the same slices."""

from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any

import pytest

from rpr_solver.verify import censuses, curves, margins, regions
from rpr_solver.verify.core.numbers import Geometry
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.cusps import Slice
from rpr_solver.verify.events import Events
from rpr_solver.verify.special_points import SpecialPoints


@lru_cache(maxsize=64)
def _found(geometry: Geometry, fixed: int, bits: int) -> Events:
    return Events(Surface(geometry, fixed), bits)


@pytest.fixture
def events_are_found_once(monkeypatch: pytest.MonkeyPatch) -> None:
    def events(surface: Surface, bits: int) -> Events:
        return _found(surface.geometry, surface.fixed, bits)

    for module in (censuses, curves, margins):
        monkeypatch.setattr(module, "Events", events)


@pytest.fixture(scope="module")
def slices_are_found_once() -> Iterator[None]:
    """Lines of a slice, its cusps and other special points, and the pieces of J = 0."""
    found: dict[object, Any] = {}

    def once(name: str, find: Callable[[SpecialPoints], object]) -> property:
        def known(points: SpecialPoints) -> object:
            key = name, points.surface.geometry, points.surface.fixed, points.length
            if key not in found:
                found[key] = find(points)
            return found[key]

        return property(known)

    with pytest.MonkeyPatch.context() as monkeypatch:
        for name in ("slice", "_topology", "_turnings", "_closed"):
            monkeypatch.setattr(SpecialPoints, name, once(name, vars(SpecialPoints)[name].func))
        monkeypatch.setattr(Slice, "cusps", lru_cache(maxsize=64)(Slice.cusps))
        traced = lru_cache(maxsize=64)(regions.traced)
        monkeypatch.setattr(regions, "traced", lambda front, start: list(traced(front, start)))
        yield
