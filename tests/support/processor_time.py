"""The processor time of each test, of its process and all that descend from it: `pytest --processor-time`.

Unlike the time that passes, it says what a test costs on a busy machine, too. Processes of fixtures that
start with a test count for the tests during which they run.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Generator
from typing import Any

import pytest

from tests.support.processes import PROC

_PROPERTY = "processor_seconds"
_TICKS = os.sysconf("SC_CLK_TCK")
_SHOWN = 25
_spent: Counter[str] = Counter()
_until_now: list[float] = []


def spent() -> float:
    """Seconds of this process and its descendants, of those that have ended included."""
    ticks: dict[int, int] = {}
    children: dict[int, list[int]] = {}
    for name in filter(str.isdecimal, os.listdir(PROC)):  # noqa: PTH208 - it is done after each test
        try:
            with open(f"{PROC}/{name}/stat", "rb") as file:  # noqa: PTH123
                fields = file.read().rpartition(b")")[2].split()
        except (FileNotFoundError, ProcessLookupError):
            continue
        ticks[int(name)] = sum(map(int, fields[11:15]))
        children.setdefault(int(fields[1]), []).append(int(name))
    family = [os.getpid()]
    for process in family:
        family += children.get(process, [])
    return sum(ticks.get(process, 0) for process in family) / _TICKS


def pytest_collection_finish() -> None:
    _until_now.append(spent())


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_teardown(item: pytest.Item) -> Generator[None, Any, Any]:
    try:
        return (yield)
    finally:
        _until_now.append(spent())
        item.user_properties.append((_PROPERTY, round(_until_now[-1] - _until_now[-2], 2)))


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    if report.when == "teardown":
        _spent[report.nodeid] += dict(report.user_properties).get(_PROPERTY, 0)


def pytest_terminal_summary(terminalreporter: Any) -> None:
    files: Counter[str] = Counter()
    for test, seconds in _spent.items():
        files[test.partition("::")[0]] += seconds
    terminalreporter.section(f"processor time: {sum(files.values()):.1f} s")
    for name, seconds in [*files.most_common(_SHOWN), *_spent.most_common(_SHOWN)]:
        terminalreporter.write_line(f"{seconds:7.2f} s  {name}")
