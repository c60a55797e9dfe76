"""When a work horse loads numpy."""

from __future__ import annotations

import pytest

from worker.process import preload


def test_numpy_is_loaded_once_many_slices_are_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    loaded: list[int] = []
    monkeypatch.setattr(preload, "load_numpy", lambda: loaded.append(1))
    expected = preload.ExpectedSlices()
    expected.add(63)
    assert not loaded
    expected.add(1)
    expected.add(1000)
    assert loaded == [1]
