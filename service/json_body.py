"""Request bodies: bounded, strict JSON in which every number is kept as it was written."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import NoReturn

from starlette.requests import Request

from service.problems import ProblemError, ProblemType

MAX_DEPTH = 32
"""No document of the contract is nested as deeply as this."""

JSON_TYPES = "application/json"


class JsonNumber(str):
    """The text of a JSON number. It differs from a JSON string by its type only."""

    __slots__ = ()


def parse_json(body: bytes) -> object:
    """Parse strict JSON (RFC 8259). Numbers become :class:`JsonNumber`, with every digit that was sent.

    Raises:
        ProblemError: 400; not UTF-8, not JSON, a key given twice, or nested too deeply.

    >>> parse_json(b'{"d1": 17.040}')
    {'d1': '17.040'}
    """
    try:
        text = body.decode("utf-8")
    except UnicodeDecodeError as error:
        raise _bad(f"The body is not valid UTF-8: byte {error.start} cannot be decoded.") from None
    try:
        value: object = json.loads(
            text,
            parse_float=JsonNumber,
            parse_int=JsonNumber,
            parse_constant=_refuse_constant,
            object_pairs_hook=_object,
        )
    except json.JSONDecodeError as error:
        raise _bad(
            f"The body is not valid JSON: {error.msg} at line {error.lineno}, column {error.colno}."
        ) from None
    except RecursionError:
        raise _too_deep() from None
    _check_depth(value)
    return value


async def read_json_body(request: Request, max_bytes: int) -> bytes:
    """Read the body of a request, for :func:`parse_json` (which may take long, so not in the event loop).

    Raises:
        ProblemError: 415 for another content type, 413 for a body over the limit.
    """
    _check_headers(request)
    declared = request.headers.get("content-length", "")
    if declared.isascii() and declared.isdigit() and (len(declared) > 18 or int(declared) > max_bytes):
        raise _too_large(max_bytes, f"{declared[:40]} bytes were announced")
    chunks: list[bytes] = []
    size = 0
    async for chunk in request.stream():
        size += len(chunk)
        if size > max_bytes:
            raise _too_large(max_bytes, f"more than {max_bytes} bytes were sent")
        chunks.append(chunk)
    return b"".join(chunks)


def _check_headers(request: Request) -> None:
    sent = request.headers.get("content-type")
    media_type = (sent or "").partition(";")[0].strip().lower()
    is_json = media_type == JSON_TYPES or (
        media_type.startswith("application/") and media_type.endswith("+json")
    )
    if not is_json:
        what = "has no Content-Type" if sent is None else f"is sent as {sent[:100]!r}"
        raise ProblemError(
            ProblemType.UNSUPPORTED_MEDIA_TYPE,
            f"The body {what}; send it as application/json.",
            headers={"Accept-Post": JSON_TYPES},
        )
    encoding = request.headers.get("content-encoding", "identity").strip().lower()
    if encoding not in ("", "identity"):
        raise ProblemError(
            ProblemType.UNSUPPORTED_MEDIA_TYPE,
            f"The body is sent with Content-Encoding {encoding[:100]!r}; send it without one.",
            headers={"Accept-Encoding": "identity"},
        )


def _object(pairs: list[tuple[str, object]]) -> dict[str, object]:
    found = dict(pairs)
    if len(found) < len(pairs):
        seen: set[str] = set()
        for key, _ in pairs:
            if key in seen:
                raise _bad(f"The key {key[:100]!r} is given twice in one object.", field=key)
            seen.add(key)
    return found


def _refuse_constant(name: str) -> NoReturn:
    raise _bad(f"{name} is not a JSON number; every number must be finite.")


def _check_depth(value: object) -> None:
    level: list[object] = [value]
    for _ in range(MAX_DEPTH):
        level = [child for parent in level for child in _children(parent)]
        if not level:
            return
    raise _too_deep()


def _children(value: object) -> Iterator[object]:
    if isinstance(value, dict):
        yield from (child for child in value.values() if isinstance(child, dict | list))
    elif isinstance(value, list):
        yield from (child for child in value if isinstance(child, dict | list))


def _bad(detail: str, field: str = "body") -> ProblemError:
    return ProblemError(ProblemType.INVALID_JSON, detail, errors=[(field[:100], detail)])


def _too_deep() -> ProblemError:
    return _bad(f"The body is nested more than {MAX_DEPTH} levels deep.")


def _too_large(limit: int, sent: str) -> ProblemError:
    return ProblemError(
        ProblemType.BODY_TOO_LARGE,
        f"The body may have at most {limit} bytes (limit max_body_bytes); {sent}.",
        errors=[("body", f"limit max_body_bytes is {limit}; {sent}")],
        headers={"Connection": "close"},
    )
