"""The items of a batch in its body: one line each, or the elements of an array."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping
from io import TextIOWrapper
from typing import IO, Literal

from rpr_solver.errors import InputError
from service.api.problems import ProblemError, ProblemType
from service.schemas.document import JsonError, parse_json

Sent = bytes | Mapping[str, str]
"""An item as it is sent: the text of a JSON object, or the cells of a row by their columns."""

CheckSize = Callable[[int], None]
"""Refuses the next item if it has this number of bytes or more."""

_BLOCK = 64 << 10
"""Characters that are read at first; an item that continues is read again with twice as many."""


def lines(body: IO[bytes], longest: int, check: CheckSize) -> Iterator[tuple[int, bytes]]:
    """Yields the lines of a body with their numbers, from 1, without those that are empty.

    Args:
        body: the file.
        longest: the bytes of an item at most.
        check: called with the size of a line that has more.
    """
    number = 0
    while line := body.readline(longest + 2):
        number += 1
        if len(line) > longest + 1:
            check(len(line))
        if line.strip():
            yield number, line.rstrip(b"\n")


class Elements:
    """The elements of `{"items": […]}`, or of an array alone.

    The `json` of the standard library finds where an element ends; whether it is strict JSON is asked when
    it is read as a question, so that a fault in it is the problem of one item.

    Args:
        body: the file.
        longest: the bytes of an item at most.
        check: called with the size of an element that has more.

    Attributes:
        callback_url: the member of that name beside the items, as it was sent; None without one.
    """

    def __init__(self, body: IO[bytes], longest: int, check: CheckSize) -> None:
        self.callback_url: object = None
        self._values = _Values(body, longest, check)

    def __iter__(self) -> Iterator[bytes]:
        """Yields the elements.

        Raises:
            ProblemError: this is no such object or array.
        """
        mark = self._values.mark()
        if mark == "[":
            yield from self._items()
        elif mark == "{":
            yield from self._members()
        else:
            raise _no_items()
        if self._values.mark():
            raise invalid("it continues after the items")

    def _members(self) -> Iterator[bytes]:
        values, has_items = self._values, False
        while True:
            name = values.value("its first member" if not has_items else "a member after the items")
            if values.mark() != ":":
                raise invalid("a member has no value")
            if name == b'"items"' and not has_items and values.mark() == "[":
                yield from self._items()
                has_items = True
            elif name == b'"callback_url"' and self.callback_url is None:
                self.callback_url = _value(values.value("callback_url"))
            elif not has_items:
                raise _no_items()
            else:
                detail = 'has members beside "items" and one "callback_url"; leave them out'
                raise ProblemError.of_input(InputError.of("body", detail))
            mark = values.mark()
            if mark == "}" and has_items:
                return
            if mark != ",":
                raise invalid("it ends before the object of the items does") if has_items else _no_items()

    def _items(self) -> Iterator[bytes]:
        values, count = self._values, 0
        if values.next_is("]"):
            return
        while True:
            yield values.value(f"items[{count}]")
            mark = values.mark()
            if mark == "]":
                return
            if mark != ",":
                raise invalid(f"it ends within items[{count}], or something follows this item but a comma")
            count += 1


_SPACE = re.compile("[ \\t\\r\\n]*")
_DECODER = json.JSONDecoder(parse_float=str, parse_int=str, parse_constant=str, strict=False)
_NEAR_THE_END = 12  # characters: what is left of a literal or an escape that is cut


class _Values:
    """Values and marks of JSON, read one after the other; of the body one item is in memory, and a block."""

    def __init__(self, body: IO[bytes], longest: int, check: CheckSize) -> None:
        self._file = TextIOWrapper(body, "utf-8", errors="surrogateescape", newline="")
        self._longest, self._check = longest, check
        self._text, self._at = "", 0
        self._line = 1  # where the text begins

    def mark(self) -> str:
        """Returns the next character but white space, and moves past it; empty at the end."""
        found = self._look()
        self._at += len(found)
        return found

    def next_is(self, mark: str) -> bool:
        """Whether this is the next character but white space; moves past it."""
        is_it = self._look() == mark
        self._at += is_it
        return is_it

    def value(self, name: str) -> bytes:
        """Returns the text of the next value, and moves past it.

        Raises:
            ProblemError: it has no end, or this is no JSON.
        """
        self._look()
        while True:
            fault = None
            try:
                _, end = _DECODER.raw_decode(self._text, self._at)
            except json.JSONDecodeError as error:
                fault, end = error, error.pos
                if error.msg.startswith("Unterminated string"):
                    end = len(self._text)
            except RecursionError:
                raise invalid(f"{name} is nested too deeply") from None
            # a fault, or the end of a number, may come from the end of what is read
            if end < len(self._text) - _NEAR_THE_END or not self._read():
                break
        if fault is not None:
            line = self._line + self._text.count("\n", 0, fault.pos)
            raise invalid(f"{name} is not JSON: {fault.msg} in line {line}")
        text, self._at = self._text[self._at : end], end
        return text.encode("utf-8", "surrogateescape")

    def _look(self) -> str:
        while True:
            space = _SPACE.match(self._text, self._at)
            assert space is not None
            self._at = space.end()
            if self._at < len(self._text) or not self._read():
                return self._text[self._at : self._at + 1]

    def _read(self) -> bool:
        """Read on: as much again as is left; returns False at the end of the body.

        The work for a value is that of some four times its length, since what is read doubles.
        """
        left = len(self._text) - self._at
        if left > self._longest:
            self._check(left)
        more = self._file.read(max(_BLOCK, left))
        if more:
            self._line += self._text.count("\n", 0, self._at)
            self._text, self._at = self._text[self._at :] + more, 0
        return bool(more)


def _value(text: bytes) -> object:
    try:
        return parse_json(text)
    except JsonError:
        raise invalid("callback_url is no string") from None


def _no_items() -> ProblemError:
    return ProblemError.of_input(
        InputError.of("body", 'does not begin with {"items": […; send that, an array, or NDJSON')
    )


def invalid(detail: str, form: Literal["JSON", "CSV"] = "JSON") -> ProblemError:
    """Returns the problem of a body that is not of its form."""
    text = f"The body is not valid {form}: {detail}."
    return ProblemError(ProblemType[f"INVALID_{form}"], text, errors=[("body", text)])
