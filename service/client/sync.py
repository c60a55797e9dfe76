"""The client that waits."""

from __future__ import annotations

import time
from collections.abc import Generator, Iterator, Mapping
from typing import Any, Self, TypeVar

import httpx

from service.client.conversation import Call, Conversation, OnProgress, Pause, Talk, as_object, silent
from service.client.questions import Answer, Asked, M
from service.client.settings import connection
from service.client.streams import InOrder, SliceEvents, lengths_of
from service.schemas.tables import CuspTable

T = TypeVar("T")


class ServiceClient:
    """A client of one service; with the key `RPR_CUSPS_API_KEY`, if that is set and wanted.

    Raises:
        ServiceError: the URL is not an HTTP address.
    """

    def __init__(self, url: str, *, with_key: bool = True) -> None:
        self.url = url
        self._http = httpx.Client(**connection(url, with_key=with_key))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the connections, as the end of `with` does."""
        self._http.close()

    def ask(self, asked: Asked[M], on_progress: OnProgress = silent) -> Answer[M]:
        """Post a question and wait for its answer; `on_progress(done, total)` follows its job.

        An interrupt (Ctrl-C) withdraws the question; :class:`JobInterrupted` says what became of the job.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        talk = Conversation(self.url, on_progress)
        try:
            return self._drive(talk.answer(asked))
        except KeyboardInterrupt:
            raise self._drive(talk.withdrawn()) from None

    def slices(self, asked: Asked[CuspTable]) -> Generator[Mapping[str, Any], None, None]:
        """Yields the slices of a table in the order asked, each as soon as those before it are there.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        leg, lengths = lengths_of(asked)
        ready = InOrder(lengths)
        talk = Conversation(self.url)
        try:
            answer = self._drive(talk.posted(asked, "respond-async"))
            if talk.job is not None:
                for length, part in self._events(talk.job["links"]["events"]):
                    yield from ready.take(length, part)
                answer = self._drive(talk.awaited())
        except KeyboardInterrupt:
            raise self._drive(talk.withdrawn()) from None
        except GeneratorExit:
            self._drive(talk.withdrawn())
            raise
        for part in as_object(answer)["slices"]:
            yield from ready.take(part[leg], part)

    def version(self) -> dict[str, Any]:
        """Returns the versions of the service and of its solver."""
        return as_object(self._drive(Conversation(self.url).sent(Call("GET", "/version"))))

    def job(self, job_id: str) -> dict[str, Any]:
        """Returns the state of a job."""
        return as_object(self._drive(Conversation(self.url).sent(Call("GET", f"/v1/jobs/{job_id}"))))

    def result(
        self, job_id: str, accept: str = "application/json", on_progress: OnProgress = silent
    ) -> bytes:
        """Waits for a job and returns its result in a media type."""
        return self._drive(Conversation(self.url, on_progress).result(job_id, accept))

    def cancel(self, job_id: str) -> dict[str, Any]:
        """Withdraws from a job and returns its state; it goes on if others wait for it."""
        return as_object(self._drive(Conversation(self.url).sent(Call("DELETE", f"/v1/jobs/{job_id}"))))

    def _events(self, path: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
        events = SliceEvents()
        try:
            with self._http.stream("GET", path, headers={"Accept": "text/event-stream"}) as response:
                if response.status_code == 200:
                    yield from filter(None, map(events.line, response.iter_lines()))
        except httpx.HTTPError:
            return  # the result has all slices

    def _drive(self, talk: Talk[T]) -> T:
        reply: httpx.Response | None = None
        try:
            step = next(talk)
            while True:
                try:
                    if isinstance(step, Pause):
                        time.sleep(step.seconds)
                        reply = None
                    else:
                        reply = self._http.request(step.method, step.path, **step.options)
                except httpx.HTTPError as error:
                    step = talk.throw(error)
                else:
                    step = talk.send(reply)
        except StopIteration as end:
            value: T = end.value
            return value
