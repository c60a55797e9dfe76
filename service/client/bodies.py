"""What a client asks; its answer; and the body of a batch: items as lines, or a file unchanged."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from pathlib import Path
from tempfile import SpooledTemporaryFile
from typing import Any, BinaryIO, Generic, Self, TypeVar

from pydantic import BaseModel, RootModel

from rpr_solver.errors import InputError
from service.schemas.answers import CSV, JSON, NDJSON, ascii_bytes, joined
from service.schemas.questions import Question

M = TypeVar("M", bound=BaseModel)


@dataclass(frozen=True)
class Asked(Generic[M]):
    """A question, and the model of its answer.

    Attributes:
        name: what the item of a batch is called, which its result repeats; nothing to a question alone.
    """

    question: Question
    model: type[M]
    name: str | None = None

    @property
    def path(self) -> str:
        """Where it is posted."""
        return self.question.path

    def named(self, name: str) -> Asked[M]:
        """Returns the same question with a name for its place in a batch."""
        return replace(self, name=name)

    @classmethod
    def of(cls, question: Question) -> Asked[Any]:
        """Returns a question that was read before."""
        return Asked(question, question.answer)


@dataclass(frozen=True)
class Answer(Generic[M]):
    """A document, as the service sent it.

    Attributes:
        content: compact JSON.
        model: the model of the document.
    """

    content: bytes
    model: type[M]

    @cached_property
    def document(self) -> dict[str, Any]:
        """The document, its members in their order."""
        document: dict[str, Any] = json.loads(self.content)
        return document

    @cached_property
    def typed(self) -> M:
        """The document as a model; of a question with answers of two forms, that of its own."""
        found = self.model.model_validate_json(self.content)
        typed: M = found.root if isinstance(found, RootModel) else found
        return typed


Item = Asked[Any] | Mapping[str, Any]
"""A question, or an item in the words of the service: `{"id": …, "kind": …, "request": …}`."""

_PIECE = 64 << 10
_IN_MEMORY = 1 << 20
_MARK = b"\xef\xbb\xbf"
_IS_JSON = re.compile(rb'\s*(\[|\{\s*"(items|callback_url)"\s*:)')


class Body:
    """A body that can be sent again: what was taken from its source is kept, on disk once it is large.

    >>> body = Body(iter([b"one", b"two"]), "text/plain")
    >>> list(body), list(body)
    ([b'one', b'two'], [b'onetwo'])
    >>> body.close()
    """

    def __init__(self, pieces: Iterable[bytes], media_type: str, opened: BinaryIO | None = None) -> None:
        """A body of these pieces; `opened` is a file that is closed with it."""
        self.media_type = media_type
        self._opened = opened
        self._pieces = iter(pieces)
        self._kept = SpooledTemporaryFile(max_size=_IN_MEMORY)  # noqa: SIM115  # closed by `close`
        self._size = 0
        self._fault: BaseException | None = None

    def __iter__(self) -> Iterator[bytes]:
        """Yields all of it, from the beginning."""
        place = 0
        while place < self._size:
            self._kept.seek(place)
            piece = self._kept.read(_PIECE)
            place += len(piece)
            yield piece
        while piece := self._next():
            self._kept.seek(self._size)
            self._kept.write(piece)
            self._size += len(piece)
            yield piece

    def _next(self) -> bytes:
        if self._fault is not None:  # a source that failed is not at its end
            raise self._fault
        try:
            return next(self._pieces, b"")
        except BaseException as error:
            self._fault = error
            raise

    def close(self) -> None:
        """Forget what was kept."""
        self._kept.close()
        if self._opened is not None:
            self._opened.close()


class Later:
    """A body for an event loop."""

    def __init__(self, body: Body) -> None:
        self._pieces = iter(body)

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> bytes:
        """Returns the next piece."""
        piece = next(self._pieces, None)
        if piece is None:
            raise StopAsyncIteration
        return piece


def body_of_items(items: Iterable[Item]) -> Body:
    """Returns questions as the body of a batch, one a line; they are taken as they are sent."""
    return Body(joined(_line(index, item) for index, item in enumerate(items)), NDJSON)


def body_of_file(file: Path | BinaryIO) -> Body:
    """Returns a file as the body of a batch: a JSON array, NDJSON, or CSV, recognised by its beginning.

    Raises:
        InputError: it cannot be read.
    """
    try:
        stream = file.open("rb") if isinstance(file, Path) else file
        first = stream.read(_PIECE).removeprefix(_MARK)
    except OSError as error:
        raise _unreadable(file, error) from None
    return Body(
        chain([first] if first else [], _rest(file, stream)),
        form_of(first),
        None if stream is file else stream,
    )


def form_of(beginning: bytes) -> str:
    """Returns the media type of a batch that begins so.

    >>> [form_of(text) for text in (b' [{"kind"', b'{ "items": [', b'{"kind": "poses"', b"a2x,a3x")]
    ['application/json', 'application/json', 'application/x-ndjson', 'text/csv']
    """
    if _IS_JSON.match(beginning):
        return JSON
    return NDJSON if beginning.lstrip().startswith(b"{") else CSV


def _rest(file: Path | BinaryIO, stream: BinaryIO) -> Iterator[bytes]:
    try:
        while piece := stream.read(_PIECE):
            yield piece
    except OSError as error:
        raise _unreadable(file, error) from None


def _unreadable(file: Path | BinaryIO, error: OSError) -> InputError:
    name = str(file) if isinstance(file, Path) else "standard input"
    return InputError.of(
        "FILE", f"{name!r} cannot be read ({error.strerror}); give a file with a batch, or -"
    )


def _line(index: int, item: Item) -> bytes:
    if isinstance(item, Asked):
        item = _item_of(item, index)
    try:
        return ascii_bytes(item) + b"\n"
    except (TypeError, ValueError) as error:
        raise InputError.of(f"items[{index}]", f"cannot be written as JSON: {error}") from None


def _item_of(asked: Asked[Any], index: int) -> Mapping[str, Any]:
    question = asked.question
    for name, given in (("deadline", question.deadline_seconds), ("callback_url", question.callback_url)):
        if given is not None:
            raise InputError.of(f"items[{index}]", f"has a {name}, which is not allowed in items; omit it")
    named = {} if asked.name is None else {"id": asked.name}
    return {**named, "kind": question.kind.name, "request": question.body()}
