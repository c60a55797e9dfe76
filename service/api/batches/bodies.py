"""The items of a batch, cut from a body while it is received: one line each, or the elements of an array."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Literal, Protocol

from rpr_solver.errors import InputError
from service.api.problems import ProblemError, ProblemType
from service.schemas.document import JsonError, parse_json

_CALLBACK = rb'"callback_url"\s*:\s*("(?:[^"\\]|\\.)*"|[\w.+-]+)\s*'
_BEGIN = re.compile(rb'\s*(?:(\[)|\{\s*(?:%s,\s*)?"items"\s*:\s*\[)' % _CALLBACK)
_END = re.compile(rb",\s*%s\}" % _CALLBACK)
_MARK = re.compile(rb'["\[\]{},]')
_IN_STRING = re.compile(rb'[^"\\]*+(?:\\.[^"\\]*+)*+', re.DOTALL)
_SPACE = b" \t\r\n"
_LONGEST_BEGIN = 16_000


Sent = bytes | Mapping[str, str]
"""An item as it is sent: the text of a JSON object, or the cells of a row by their columns."""


class Cutter(Protocol):
    """Cuts a body into its items."""

    def feed(self, piece: bytes) -> Iterator[Sent]:
        """Yields the items that are complete with the next piece of the body."""

    def end(self) -> Iterator[Sent]:
        """Yields what is left at the end of the body.

        Raises:
            ProblemError: the body is not complete.
        """

    @property
    def held(self) -> int:
        """The bytes that are kept until their item is complete."""


class Lines:
    """Newline-delimited items; empty lines are skipped.

    Attributes:
        number: of the line that was yielded last, from 1, empty ones included.
    """

    def __init__(self) -> None:
        self.number = 0
        self._rest = bytearray()

    @property
    def held(self) -> int:
        """The bytes that are kept until their item is complete."""
        return len(self._rest)

    def feed(self, piece: bytes) -> Iterator[bytes]:
        """Yields the lines that are complete with the next piece of the body."""
        lines, newline, rest = piece.rpartition(b"\n")
        if not newline:
            self._rest += piece
            return iter(())
        complete, self._rest = bytes(self._rest) + lines, bytearray(rest)
        return self._counted(complete.split(b"\n"))

    def end(self) -> Iterator[bytes]:
        """Yields the last line, if it does not end in a newline."""
        return self._counted([bytes(self._rest)])

    def _counted(self, lines: Iterable[bytes]) -> Iterator[bytes]:
        for line in lines:
            self.number += 1
            if line.strip(_SPACE):
                yield line


class Elements:
    """The elements of `{"items": […]}`, or of an array alone.

    Each byte is read once, however the body is split into pieces: it remembers its position, within a string
    too.

    Attributes:
        callback_url: the member of that name beside the items, as it was sent; None without one.
    """

    def __init__(self) -> None:
        self.callback_url: object = None
        self._text = bytearray()
        self._at = 0  # up to where the text was looked at
        self._is_in_string = False
        self._depth = 0
        self._state = "before"
        self._is_object = False
        self._count = 0

    @property
    def held(self) -> int:
        """The bytes that are kept until their item is complete."""
        return len(self._text)

    def feed(self, piece: bytes) -> Iterator[bytes]:
        """Yields the elements that are complete with the next piece of the body.

        Raises:
            ProblemError: this is no such object.
        """
        self._text += piece
        if self._state == "before":
            self._begin()
        if self._state == "inside":
            yield from self._elements()

    def end(self) -> Iterator[bytes]:
        """Yields nothing: the last element ends before the array does.

        Raises:
            ProblemError: the body is incomplete, or continues after the items.
        """
        if self._state == "before":
            raise _no_items()
        if self._state == "inside":
            raise invalid(f"it ends within items[{self._count}]")
        rest = bytes(self._text).strip(_SPACE)
        if rest == (b"}" if self._is_object else b""):
            return iter(())
        if self._is_object and self.callback_url is None and (match := _END.fullmatch(rest)):
            self.callback_url = _value(match[1])
            return iter(())
        if self._is_object and rest.startswith(b","):
            detail = 'has members beside "items" and one "callback_url"; leave them out'
            raise ProblemError.of_input(InputError.of("body", detail))
        raise invalid("it continues after the items, or ends before their object does")

    def _begin(self) -> None:
        mark = self._next_mark()
        while mark not in (b"", b"["):
            mark = self._next_mark()
        if self._at > _LONGEST_BEGIN:
            raise _no_items()
        if mark:
            match = _BEGIN.fullmatch(bytes(self._text[: self._at]))
            if match is None:
                raise _no_items()
            self._state, self._is_object = "inside", match[1] is None
            self.callback_url = None if match[2] is None else _value(match[2])
            self._drop(self._at)

    def _elements(self) -> Iterator[bytes]:
        start = 0
        while mark := self._next_mark():
            if mark in b"[{":
                self._depth += 1
            elif self._depth and mark in b"]}":
                self._depth -= 1
            elif not self._depth and mark in b",]":
                element = bytes(self._text[start : self._at - 1]).strip(_SPACE)
                start = self._at
                if element:
                    self._count += 1
                    yield element
                elif mark == b"," or self._count:
                    raise invalid(f"items[{self._count}] is missing before {mark.decode()!r}")
                if mark == b"]":
                    self._state = "after"
                    break
            elif not self._depth and mark == b"}":
                raise invalid(f"items[{self._count}] has an extra closing brace")
        self._drop(start)

    def _next_mark(self) -> bytes:
        """Returns the next mark outside strings, and moves past it; empty if none was received yet."""
        while True:
            if self._is_in_string:
                inside = _IN_STRING.match(self._text, self._at)
                self._at = self._at if inside is None else inside.end()
                # at the end of the received bytes, or at a backslash without its next character
                if self._text[self._at : self._at + 1] != b'"':
                    return b""
                self._at += 1
                self._is_in_string = False
            match = _MARK.search(self._text, self._at)
            if match is None:
                self._at = len(self._text)
                return b""
            self._at = match.end()
            mark = self._text[match.start() : self._at]
            if mark != b'"':
                return bytes(mark)
            self._is_in_string = True

    def _drop(self, count: int) -> None:
        del self._text[:count]
        self._at -= count


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
