"""The client that waits."""

from __future__ import annotations

import time
from collections.abc import Generator, Iterable, Iterator, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any, BinaryIO, Self, TypeVar

import httpx

from service.client.bodies import Body, Item, body_of_file, body_of_items
from service.client.conversation import (
    Call,
    Conversation,
    OnProgress,
    Pause,
    Talk,
    address,
    as_object,
    new_key,
    silent,
)
from service.client.questions import Answer, Asked, M
from service.client.results import ItemResult, Reading
from service.client.settings import connection
from service.client.streams import EVENTS, InOrder, SliceEvents, lengths_of
from service.schemas.batches import Batch
from service.schemas.job_list import ListedJob, ListedStatus
from service.schemas.jobs import Job
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

    def ask(
        self, asked: Asked[M], on_progress: OnProgress = silent, *, callback_url: str | None = None
    ) -> Answer[M]:
        """Post a question and wait for its answer; `on_progress(done, total)` follows its job.

        An interrupt (Ctrl-C) withdraws the question; :class:`JobInterrupted` says what became of the job.
        Unless the answer is known already, its end is told to `callback_url` too.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        talk = Conversation(self.url, on_progress)
        try:
            return self._drive(talk.answer(asked, callback_url))
        except KeyboardInterrupt:
            raise self._drive(talk.withdrawn()) from None

    def begin(self, asked: Asked[M], *, callback_url: str | None = None) -> Answer[M] | Job:
        """Post a question without waiting: returns its answer if that is known, else its job.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        talk = Conversation(self.url)
        answer = self._drive(talk.posted(asked, "respond-async", callback_url))
        return Answer(answer.content, asked.model) if talk.job is None else Job.model_validate(talk.job)

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

    def submit(
        self, items: Iterable[Item], *, callback_url: str | None = None, key: str | None = None
    ) -> Batch:
        """Submit questions as a batch, without waiting. They are sent as they are taken from `items`.

        The `Idempotency-Key` is made here, so that a submission whose answer was lost is sent again without
        being computed twice. With a `key` of your own, that also holds if your program was ended meanwhile.

        Raises:
            InputError: naming the item that cannot be sent.
            ServiceError: the service refused, failed, or cannot be reached.
        """
        return self._submit(body_of_items(items), callback_url, key)

    def submit_file(
        self, file: Path | BinaryIO, *, callback_url: str | None = None, key: str | None = None
    ) -> Batch:
        """Submit a file as a batch, as :meth:`submit` does: a JSON array, NDJSON, or CSV of geometries.

        Raises:
            InputError: the file cannot be read.
            ServiceError: the service refused, failed, or cannot be reached.
        """
        return self._submit(body_of_file(file), callback_url, key)

    def ask_all(
        self, items: Iterable[Item], on_progress: OnProgress = silent, *, as_done: bool = False
    ) -> Generator[ItemResult, None, None]:
        """Submit questions as a batch, and yield their results as :meth:`results` does.

        An interrupt while it waits, or the end of the iteration before all came, cancels the batch.

        Raises:
            InputError: naming the item that cannot be sent.
            ServiceError: the service refused, failed, or cannot be reached.
        """
        return self.watch(self.submit(items), on_progress, as_done=as_done)

    def watch(
        self, batch: Batch, on_progress: OnProgress = silent, *, as_done: bool = False
    ) -> Generator[ItemResult, None, None]:
        """Yields all results of a batch that was just submitted, and cancels it as :meth:`ask_all` does.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        talk = Conversation.about(self.url, batch)
        try:
            yield from self.results(batch.id, on_progress, as_done=as_done)
        except KeyboardInterrupt:
            raise self._drive(talk.withdrawn()) from None
        except GeneratorExit:
            self._drive(talk.withdrawn())
            raise

    def results(
        self,
        batch_id: str,
        on_progress: OnProgress = silent,
        *,
        wait: bool = True,
        as_done: bool = False,
        after: int = -1,
    ) -> Generator[ItemResult, None, None]:
        """Yields the results of a batch, as they come, whoever submitted it; one that failed has a problem.

        Args:
            batch_id: the id of the batch.
            on_progress: called as `on_progress(received, total)`.
            wait: until all are there; otherwise what is done now.
            as_done: in the order in which they are done, instead of that of the items.
            after: only items after this position, in the order of the items.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        reading = Reading(
            self.url, batch_id, wait=wait, as_done=as_done, after=after, on_progress=on_progress
        )
        self._drive(reading.begun())
        while not reading.is_complete:
            call = reading.call
            try:
                with self._http.stream(call.method, call.path, **call.options) as response:
                    if response.status_code != 200:
                        response.read()
                    else:
                        for piece in response.iter_bytes():
                            yield from reading.taken(piece)
            except httpx.HTTPError:
                self._drive(reading.broken())
            else:
                self._drive(reading.ended(response))

    def wait(self, batch_id: str, on_progress: OnProgress = silent) -> Batch:
        """Waits for the end of a batch; `on_progress(done, total)` follows it.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        return Batch.model_validate(self._drive(Conversation(self.url, on_progress).ended(batch_id)))

    def version(self) -> dict[str, Any]:
        """Returns the versions of the service and of its solver."""
        return as_object(self._drive(Conversation(self.url).sent(Call("GET", "/version"))))

    def batch(self, batch_id: str) -> Batch:
        """Returns the state of a batch, with the numbers of its items by state."""
        return Batch.model_validate(self.job(batch_id))

    def job(self, job_id: str) -> dict[str, Any]:
        """Returns the state of a job, or of a batch."""
        return as_object(self._drive(Conversation(self.url).sent(Call("GET", address(job_id)))))

    def jobs(self, status: ListedStatus | None = None) -> Iterator[ListedJob]:
        """Yields the jobs that the caller may see, the newest first; `status`: those in this state only."""
        return self._list("/v1/jobs", status)

    def batches(self, status: ListedStatus | None = None) -> Iterator[ListedJob]:
        """Yields the batches that the caller may see, as :meth:`jobs` does."""
        return self._list("/v1/batches", status)

    def result(
        self, job_id: str, accept: str = "application/json", on_progress: OnProgress = silent
    ) -> bytes:
        """Waits for a job and returns its result in a media type."""
        return self._drive(Conversation(self.url, on_progress).result(job_id, accept))

    def cancel(self, job_id: str, *, force: bool = False) -> dict[str, Any]:
        """Withdraws from a job or a batch and returns its state; a job goes on if others wait for it, unless
        an operator ends it by `force`."""
        path = address(job_id) + ("?force=true" if force else "")
        return as_object(self._drive(Conversation(self.url).sent(Call("DELETE", path))))

    def _list(self, path: str, status: ListedStatus | None) -> Iterator[ListedJob]:
        page = self._drive(Conversation(self.url).listed(path, status))
        while True:
            yield from page.items
            if page.next is None:
                return
            page = self._drive(Conversation(self.url).listed(page.next, None))

    def _submit(self, body: Body, callback_url: str | None, key: str | None) -> Batch:
        talk = Conversation(self.url)
        with closing(body):
            try:
                return self._drive(talk.submitted(body, key or new_key(), callback_url))
            except KeyboardInterrupt:
                raise self._drive(talk.withdrawn()) from None

    def _events(self, path: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
        events = SliceEvents()
        try:
            with self._http.stream("GET", path, **EVENTS) as response:
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
                        reply = self._http.request(step.method, step.path, content=step.body, **step.options)
                except httpx.HTTPError as error:
                    step = talk.throw(error)
                else:
                    step = talk.send(reply)
        except StopIteration as end:
            value: T = end.value
            return value
