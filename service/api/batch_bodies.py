"""The items of a batch, cut from a body while it is received: one line each, or the elements of an array."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any, Protocol

from rpr_solver.errors import InputError
from service.api.problems import ProblemError, ProblemType
from service.schemas.exact_json import JsonError, parse_json

_CALLBACK = rb'"callback_url"\s*:\s*("(?:[^"\\]|\\.)*"|[\w.+-]+)\s*'
_BEGIN = re.compile(rb'\s*(?:(\[)|\{\s*(?:%s,\s*)?"items"\s*:\s*\[)' % _CALLBACK)
_END = re.compile(rb",\s*%s\}" % _CALLBACK)
_TOKEN = re.compile(rb'"(?:[^"\\]|\\.)*+"|["\[\]{},]', re.DOTALL)
_SPACE = b" \t\r\n"
_LONGEST_BEGIN = 16_000


Sent = bytes | Mapping[str, Any]
"""An item as it is sent: the text of a JSON object, or its members."""


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
    """Newline-delimited items; empty lines are skipped."""

    def __init__(self) -> None:
        self._rest = b""

    @property
    def held(self) -> int:
        """The bytes that are kept until their item is complete."""
        return len(self._rest)

    def feed(self, piece: bytes) -> Iterator[bytes]:
        """Yields the lines that are complete with the next piece of the body."""
        *lines, self._rest = (self._rest + piece).split(b"\n")
        return (line for line in lines if line.strip(_SPACE))

    def end(self) -> Iterator[bytes]:
        """Yields the last line, if it does not end in a newline."""
        return (line for line in (self._rest,) if line.strip(_SPACE))


class Elements:
    """The elements of `{"items": […]}`, or of an array alone.

    Attributes:
        callback_url: the member of that name beside the items, as it was sent; None without one.
    """

    def __init__(self) -> None:
        self.callback_url: object = None
        self._text = b""
        self._at = 0  # up to where the text was looked at
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
            ProblemError: the body is not complete, or goes on after the items.
        """
        if self._state == "before":
            raise _no_items()
        if self._state == "inside":
            raise _invalid(f"it ends within items[{self._count}]")
        rest = self._text.strip(_SPACE)
        if rest == (b"}" if self._is_object else b""):
            return iter(())
        if self._is_object and self.callback_url is None and (match := _END.fullmatch(rest)):
            self.callback_url = _value(match[1])
            return iter(())
        if self._is_object and rest.startswith(b","):
            detail = 'has members beside "items" and one "callback_url"; leave them out'
            raise ProblemError.of_input(InputError.of("body", detail))
        raise _invalid("it goes on after the items, or ends before their object does")

    def _begin(self) -> None:
        match = _BEGIN.match(self._text)
        if match is not None:
            self._state, self._is_object = "inside", match[1] is None
            self.callback_url = None if match[2] is None else _value(match[2])
            self._text = self._text[match.end() :]
        elif len(self._text) > _LONGEST_BEGIN:
            raise _no_items()

    def _elements(self) -> Iterator[bytes]:
        start = 0
        for match in _TOKEN.finditer(self._text, self._at):
            token = match[0]
            if token == b'"':  # a string that is not complete
                self._at = match.start()
                break
            self._at = match.end()
            if token in (b"[", b"{"):
                self._depth += 1
            elif self._depth and token in (b"]", b"}"):
                self._depth -= 1
            elif not self._depth and token in (b",", b"]"):
                element = self._text[start : match.start()].strip(_SPACE)
                start = match.end()
                is_over = token == b"]"
                if element:
                    self._count += 1
                    yield element
                elif not is_over or self._count:
                    raise _invalid(f"items[{self._count}] is missing before {token.decode()!r}")
                if is_over:
                    self._state = "after"
                    break
            elif not self._depth and token == b"}":
                raise _invalid(f"items[{self._count}] has a closing brace too many")
        else:
            self._at = len(self._text)
        self._text, self._at = self._text[start:], self._at - start


def _value(text: bytes) -> object:
    try:
        return parse_json(text)
    except JsonError:
        raise _invalid("callback_url is no string") from None


def _no_items() -> ProblemError:
    return ProblemError.of_input(
        InputError.of("body", 'does not begin with {"items": […; send that, an array, or NDJSON')
    )


def _invalid(detail: str) -> ProblemError:
    text = f"The body is not valid JSON: {detail}."
    return ProblemError(ProblemType.INVALID_JSON, text, errors=[("body", text)])
