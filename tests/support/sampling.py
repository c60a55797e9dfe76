"""A test that costs much runs with a sample of its cases each time, and with all of them by `--long`."""

from collections.abc import Iterable
from typing import Any

import pytest


def long(*values: object, **more: Any) -> Any:
    """A case that runs with `--long` only."""
    return pytest.param(*values, marks=pytest.mark.long, **more)


def sample(cases: Iterable[Any], *always: int) -> list[Any]:
    """The cases at the places ``always`` run each time, the others with `--long` only."""
    listed = list(cases)
    assert set(always) <= set(range(len(listed)))
    return [case if k in always else _marked(case) for k, case in enumerate(listed)]


def _marked(case: Any) -> Any:
    if hasattr(case, "marks"):
        return pytest.param(*case.values, id=case.id, marks=[*case.marks, pytest.mark.long])
    return long(*(case if isinstance(case, tuple) else (case,)))
