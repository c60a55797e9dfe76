"""Slices of a table as they are computed: server-sent events, put into the order that was asked."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from service.client.questions import Asked
from service.schemas.tables import CuspTable, CuspTableRequest

EVENTS: Mapping[str, Any] = {"params": {"known": "true"}, "headers": {"Accept": "text/event-stream"}}
"""What a request for the events of a job says: that slices which were known before are wanted too."""


def lengths_of(asked: Asked[CuspTable]) -> tuple[str, Sequence[str]]:
    """Returns the name of the fixed leg's length, and the lengths of the slices in the order asked."""
    question = asked.question
    assert isinstance(question, CuspTableRequest)
    return f"l{question.fixed_leg}", question.content()["l1"]


class SliceEvents:
    """Reads the lines of an event stream.

    >>> events = SliceEvents()
    >>> lines = ("id: 1-0", "event: slice", 'data: {"l1": "2", "slice": {"count": 4}}', "")
    >>> list(filter(None, map(events.line, lines)))
    [('2', {'count': 4})]
    """

    def __init__(self) -> None:
        self._fields: dict[str, str] = {}

    def line(self, line: str) -> tuple[str, Mapping[str, Any]] | None:
        """Take a line; returns the length and the slice once their event is complete."""
        if line:
            name, _, value = line.partition(":")
            self._fields[name] = value.removeprefix(" ")
            return None
        fields, self._fields = self._fields, {}
        if fields.get("event") != "slice":
            return None
        data = json.loads(fields["data"])
        # one that has expired meanwhile is not sent
        return None if data.get("slice") is None else (data["l1"], data["slice"])


class InOrder:
    """Holds slices back until those before them are there.

    >>> slices = InOrder(["1", "2", "3"])
    >>> [list(slices.take(length, {"l1": length})) for length in ("2", "1", "3")]
    [[], [{'l1': '1'}, {'l1': '2'}], [{'l1': '3'}]]
    """

    def __init__(self, lengths: Sequence[str]) -> None:
        self._left = iter(lengths)
        self._next = next(self._left, None)
        self._held: dict[str, Mapping[str, Any]] = {}

    def take(self, length: str, part: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
        """Take a slice; yields all that are ready."""
        self._held.setdefault(length, part)
        while self._next in self._held:
            yield self._held[self._next]
            self._next = next(self._left, None)
