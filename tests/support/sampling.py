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


def seeds(each_time: int, number: int = 200, at_once: int = 25) -> list[Any]:
    """Ranges of random seeds: a few that run each time, and all up to a number with `--long`."""
    starts = range(0, number, at_once)
    first = [range(each_time)] if each_time else []
    return [*first, *(long(range(k, min(k + at_once, number)), id=f"from-{k}") for k in starts)]


def _marked(case: Any) -> Any:
    if hasattr(case, "marks"):
        return pytest.param(*case.values, id=case.id, marks=[*case.marks, pytest.mark.long])
    return long(*(case if isinstance(case, tuple) else (case,)))
