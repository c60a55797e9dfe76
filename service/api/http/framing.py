"""Where a request begins and ends, as RFC 9112 has it: what could be read in two ways is refused.

h11 forgives some of what the RFC lets a server forgive. Behind a proxy that forgives differently, one request
could then hide in the body of another. So it is refused here, and its connection is closed.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import h11
from h11._receivebuffer import ReceiveBuffer

NOT_IMPLEMENTED = 501

_LONE = re.compile(rb"\r(?!\n)|(?<!\r)\n")
_ABSOLUTE = re.compile(rb"https?://([^/?#@]+)([/?].*)?", re.IGNORECASE | re.DOTALL)


class StrictConnection(h11.Connection):
    """The server's end of a connection.

    Attributes:
        fault: what is wrong with what the client has sent.
    """

    def __init__(self, max_incomplete_event_size: int) -> None:
        super().__init__(h11.SERVER, max_incomplete_event_size)
        self._lines = _StrictBuffer()
        self._receive_buffer = self._lines
        self.fault: h11.RemoteProtocolError | None = None

    def next_event(self) -> h11.Event | type[h11.NEED_DATA] | type[h11.PAUSED]:
        """Returns the next part of a request.

        Raises:
            RemoteProtocolError: it is not as the RFC has it; also in `fault`.
        """
        self._lines.is_between = self.their_state is h11.IDLE
        try:
            event = super().next_event()
            if not isinstance(event, h11.Request):
                return event
            self._lines.has_skipped = False
            return _in_origin_form(event)
        except h11.RemoteProtocolError as error:
            self.fault = error
            raise


class _StrictBuffer(ReceiveBuffer):
    """What was received and is not read yet.

    Attributes:
        is_between: whether the next request may begin; one empty line before it is skipped (RFC 9112, 2.2).
        has_skipped: whether it was.
    """

    def __init__(self) -> None:
        super().__init__()
        self.is_between = self.has_skipped = False

    def maybe_extract_lines(self) -> list[bytearray] | None:
        """Returns the lines of a head or a trailer once it is complete.

        Raises:
            LocalProtocolError: one of them can be read in two ways.
        """
        if self._may_skip and self._data[:2] == b"\r\n":
            self._extract(2)
            self.has_skipped = True
        if self._data[:2] == b"\r\n":
            self._extract(2)
            return []
        searched = self._multiple_lines_search
        end = self._data.find(b"\r\n\r\n", searched)
        known = len(self._data) - self._data.endswith(b"\r") if end < 0 else end
        if _LONE.search(self._data, searched, known):
            _refuse("a line ends without CR LF, or has a CR in it")
        if end < 0:
            self._multiple_lines_search = max(0, len(self._data) - 3)
            return None
        lines = self._extract(end + 4)[:end].split(b"\r\n")
        _check(lines if self.is_between else (b"", *lines))
        return lines

    def maybe_extract_next_line(self) -> bytearray | None:
        """Returns the line before a chunk once it is there.

        Raises:
            LocalProtocolError: it can be read in two ways.
        """
        line = super().maybe_extract_next_line()
        if line is not None and _LONE.search(line):
            _refuse("the line before a chunk has a CR or LF in it")
        return line

    def is_next_line_obviously_invalid_request_line(self) -> bool:
        """Whether it is clear before its end; a CR may be the beginning of an empty line."""
        is_empty_line = self._may_skip and self._data == b"\r"
        return not is_empty_line and super().is_next_line_obviously_invalid_request_line()

    @property
    def _may_skip(self) -> bool:
        return self.is_between and not self.has_skipped


def _check(lines: Sequence[bytes | bytearray]) -> None:
    """Refuse a head whose body could end at two places (RFC 9112, 5.2, 6.1 and 6.3)."""
    request, *fields = lines
    if any(line[:1] in (b" ", b"\t") for line in fields):
        _refuse("a line of the head begins with white space")
    version = request.rpartition(b" ")[2]
    if version.startswith(b"HTTP/") and not version.startswith(b"HTTP/1."):
        _refuse("its version of HTTP is not 1.1 or 1.0")
    lengths = _values_of(b"content-length", fields)
    if len(lengths) > 1 or not all(length.isdigit() for length in lengths):
        _refuse("Content-Length is not one number")
    codings = [x for value in _values_of(b"transfer-encoding", fields) for x in value.split(b",")]
    if codings and lengths:
        _refuse("it has both Content-Length and Transfer-Encoding")
    if codings:
        _check_codings([coding.strip(b" \t").lower() for coding in codings], bytes(version))


def _values_of(name: bytes, fields: Sequence[bytes | bytearray]) -> Sequence[bytes | bytearray]:
    parts = (line.partition(b":") for line in fields)
    return [value.strip(b" \t") for sent, _, value in parts if sent.lower() == name]


def _check_codings(codings: Sequence[bytes | bytearray], version: bytes) -> None:
    if version == b"HTTP/1.0":
        _refuse("HTTP/1.0 has no Transfer-Encoding")
    if codings[-1] != b"chunked" or codings.count(b"chunked") > 1:
        _refuse("Transfer-Encoding does not end with chunked, once")
    if len(codings) > 1:
        _refuse("the only Transfer-Encoding that is understood is chunked", NOT_IMPLEMENTED)


def _in_origin_form(event: h11.Request) -> h11.Request:
    """Returns a request whose target is a path; a target with a host is that of Host too (RFC 9112, 3.2).

    Raises:
        RemoteProtocolError: the target is of no form.
    """
    target, is_any = event.target, event.method == b"OPTIONS" and event.target == b"*"
    if target.startswith(b"/") or is_any or event.method == b"CONNECT":
        return event
    match = _ABSOLUTE.fullmatch(target)
    if match is None:
        raise h11.RemoteProtocolError("its target is neither a path nor a URL")
    rest = match[2] or b"/"
    others = [field for field in event.headers.raw_items() if field[0].lower() != b"host"]
    return h11.Request(
        method=event.method,
        headers=[(b"Host", match[1]), *others],
        target=rest if rest.startswith(b"/") else b"/" + rest,
        http_version=event.http_version,
    )


def _refuse(why: str, status: int = 400) -> None:
    raise h11.LocalProtocolError(why, error_status_hint=status)
