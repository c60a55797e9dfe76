from __future__ import annotations

import pytest

from service.api.answers.answer import Preferences, parse_prefer


@pytest.mark.parametrize(
    ("headers", "expected"),
    [
        ([], Preferences()),
        (["wait=10"], Preferences(wait=10)),
        (["respond-async, wait=10"], Preferences(True, 10)),
        (["respond-async", "wait=10"], Preferences(True, 10)),
        (["Respond-Async; foo=bar, WAIT = 5"], Preferences(True, 5)),
        (["wait=1, wait=9"], Preferences(wait=1)),
        (['wait="7"'], Preferences(wait=7)),
        (['foo="respond-async, wait=3"'], Preferences()),
        (['foo; bar="a;b,wait=3"; x, wait=4'], Preferences(wait=4)),
        (["wait=-1"], Preferences()),
        (["wait=1.5"], Preferences()),
        (["wait="], Preferences()),
        (["wait=٣"], Preferences()),
        ([", ,"], Preferences()),
        (['"', "wait=2"], Preferences(wait=2)),
    ],
)
def test_prefer(headers: list[str], expected: Preferences) -> None:
    assert parse_prefer(headers) == expected


def test_a_long_wait_is_read_in_no_time() -> None:
    assert parse_prefer(["wait=" + "9" * 60_000]).wait is not None


@pytest.mark.parametrize("header", ['"' * 60_000, ";" * 60_000, 'a="' * 20_000, "\\" * 60_000])
def test_hostile_headers_are_read_in_no_time(header: str) -> None:
    assert parse_prefer([header]) == Preferences()
