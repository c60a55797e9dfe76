"""The client for programs with an event loop, on asyncio or trio."""

from __future__ import annotations

from collections.abc import AsyncGenerator, AsyncIterator, Iterable, Mapping
from contextlib import aclosing, closing
from pathlib import Path
from typing import Any, BinaryIO, Self, TypeVar

import anyio
import httpx

from service.client.bodies import Body, Item, Later, body_of_file, body_of_items
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

_FAREWELL = 2.0


class AsyncServiceClient:
    """As :class:`service.client.ServiceClient`, with `await`.

    Raises:
        ServiceError: the URL is not an HTTP address.
    """

    def __init__(self, url: str, *, with_key: bool = True) -> None:
        self.url = url
        self._http = httpx.AsyncClient(**connection(url, with_key=with_key))

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.aclose()

    async def aclose(self) -> None:
        """Close the connections, as the end of `async with` does."""
        await self._http.aclose()

    async def ask(
        self, asked: Asked[M], on_progress: OnProgress = silent, *, callback_url: str | None = None
    ) -> Answer[M]:
        """Post a question and wait for its answer; `on_progress(done, total)` follows its job.

        A task that is canceled withdraws its question. Unless the answer is known already, its end is told
        to `callback_url` too.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        talk = Conversation(self.url, on_progress)
        try:
            return await self._drive(talk.answer(asked, callback_url))
        except anyio.get_cancelled_exc_class():
            await self._withdraw(talk)
            raise

    async def begin(self, asked: Asked[M], *, callback_url: str | None = None) -> Answer[M] | Job:
        """Post a question without waiting: returns its answer if that is known, else its job.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        talk = Conversation(self.url)
        answer = await self._drive(talk.posted(asked, "respond-async", callback_url))
        return Answer(answer.content, asked.model) if talk.job is None else Job.model_validate(talk.job)

    async def slices(self, asked: Asked[CuspTable]) -> AsyncIterator[Mapping[str, Any]]:
        """Yields the slices of a table in the order asked, each as soon as those before it are there.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        leg, lengths = lengths_of(asked)
        ready = InOrder(lengths)
        talk = Conversation(self.url)
        try:
            answer = await self._drive(talk.posted(asked, "respond-async"))
            if talk.job is not None:
                async for length, part in self._events(talk.job["links"]["events"]):
                    for ready_part in ready.take(length, part):
                        yield ready_part
                answer = await self._drive(talk.awaited())
        except anyio.get_cancelled_exc_class():
            await self._withdraw(talk)
            raise
        for part in as_object(answer)["slices"]:
            for ready_part in ready.take(part[leg], part):
                yield ready_part

    async def submit(
        self, items: Iterable[Item], *, callback_url: str | None = None, key: str | None = None
    ) -> Batch:
        """Submit questions as a batch, without waiting. They are sent as they are taken from `items`.

        The `Idempotency-Key` is made here, so that a submission whose answer was lost is sent again without
        being computed twice. With a `key` of your own, that also holds if your program was ended meanwhile.

        Raises:
            InputError: naming the item that cannot be sent.
            ServiceError: the service refused, failed, or cannot be reached.
        """
        return await self._submit(body_of_items(items), callback_url, key)

    async def submit_file(
        self, file: Path | BinaryIO, *, callback_url: str | None = None, key: str | None = None
    ) -> Batch:
        """Submit a file as a batch, as :meth:`submit` does: a JSON array, NDJSON, or CSV of geometries.

        Raises:
            InputError: the file cannot be read.
            ServiceError: the service refused, failed, or cannot be reached.
        """
        return await self._submit(body_of_file(file), callback_url, key)

    async def ask_all(
        self, items: Iterable[Item], on_progress: OnProgress = silent, *, as_done: bool = False
    ) -> AsyncGenerator[ItemResult, None]:
        """Submit questions as a batch, and yield their results as :meth:`results` does.

        A task that is canceled cancels the batch; so does the end of the iteration before all came, if it is
        an `async with aclosing(…)`.

        Raises:
            InputError: naming the item that cannot be sent.
            ServiceError: the service refused, failed, or cannot be reached.
        """
        async with aclosing(self.watch(await self.submit(items), on_progress, as_done=as_done)) as results:
            async for result in results:
                yield result

    async def watch(
        self, batch: Batch, on_progress: OnProgress = silent, *, as_done: bool = False
    ) -> AsyncGenerator[ItemResult, None]:
        """Yields all results of a batch that was just submitted, and cancels it as :meth:`ask_all` does.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        talk = Conversation.about(self.url, batch)
        try:
            async with aclosing(self.results(batch.id, on_progress, as_done=as_done)) as results:
                async for result in results:
                    yield result
        except (anyio.get_cancelled_exc_class(), GeneratorExit):
            await self._withdraw(talk)
            raise

    async def results(
        self,
        batch_id: str,
        on_progress: OnProgress = silent,
        *,
        wait: bool = True,
        as_done: bool = False,
        after: int = -1,
    ) -> AsyncGenerator[ItemResult, None]:
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
        await self._drive(reading.begun())
        while not reading.is_complete:
            call = reading.call
            try:
                async with self._http.stream(call.method, call.path, **call.options) as response:
                    if response.status_code != 200:
                        await response.aread()
                    else:
                        async for piece in response.aiter_bytes():
                            for result in reading.taken(piece):
                                yield result
            except httpx.HTTPError:
                await self._drive(reading.broken())
            else:
                await self._drive(reading.ended(response))

    async def wait(self, batch_id: str, on_progress: OnProgress = silent) -> Batch:
        """Waits for the end of a batch; `on_progress(done, total)` follows it.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        return Batch.model_validate(await self._drive(Conversation(self.url, on_progress).ended(batch_id)))

    async def version(self) -> dict[str, Any]:
        """Returns the versions of the service and of its solver."""
        return as_object(await self._drive(Conversation(self.url).sent(Call("GET", "/version"))))

    async def batch(self, batch_id: str) -> Batch:
        """Returns the state of a batch, with the numbers of its items by state."""
        return Batch.model_validate(await self.job(batch_id))

    async def job(self, job_id: str) -> dict[str, Any]:
        """Returns the state of a job, or of a batch."""
        return as_object(await self._drive(Conversation(self.url).sent(Call("GET", address(job_id)))))

    def jobs(self, status: ListedStatus | None = None) -> AsyncIterator[ListedJob]:
        """Yields the jobs that the caller may see, the newest first; `status`: those in this state only."""
        return self._list("/v1/jobs", status)

    def batches(self, status: ListedStatus | None = None) -> AsyncIterator[ListedJob]:
        """Yields the batches that the caller may see, as :meth:`jobs` does."""
        return self._list("/v1/batches", status)

    async def result(
        self, job_id: str, accept: str = "application/json", on_progress: OnProgress = silent
    ) -> bytes:
        """Waits for a job and returns its result in a media type."""
        return await self._drive(Conversation(self.url, on_progress).result(job_id, accept))

    async def cancel(self, job_id: str, *, force: bool = False) -> dict[str, Any]:
        """Withdraws from a job or a batch and returns its state; a job goes on if others wait for it, unless
        an operator ends it by `force`."""
        path = address(job_id) + ("?force=true" if force else "")
        return as_object(await self._drive(Conversation(self.url).sent(Call("DELETE", path))))

    async def _list(self, path: str, status: ListedStatus | None) -> AsyncIterator[ListedJob]:
        page = await self._drive(Conversation(self.url).listed(path, status))
        while True:
            for item in page.items:
                yield item
            if page.next is None:
                return
            page = await self._drive(Conversation(self.url).listed(page.next, None))

    async def _submit(self, body: Body, callback_url: str | None, key: str | None) -> Batch:
        with closing(body):
            return await self._drive(Conversation(self.url).submitted(body, key or new_key(), callback_url))

    async def _withdraw(self, talk: Conversation) -> None:
        with anyio.CancelScope(shield=True), anyio.move_on_after(_FAREWELL):
            await self._drive(talk.withdrawn())

    async def _events(self, path: str) -> AsyncIterator[tuple[str, Mapping[str, Any]]]:
        events = SliceEvents()
        try:
            async with self._http.stream("GET", path, **EVENTS) as response:
                if response.status_code == 200:
                    async for line in response.aiter_lines():
                        if (data := events.line(line)) is not None:
                            yield data
        except httpx.HTTPError:
            return  # the result has all slices

    async def _drive(self, talk: Talk[T]) -> T:
        reply: httpx.Response | None = None
        try:
            step = next(talk)
            while True:
                try:
                    if isinstance(step, Pause):
                        await anyio.sleep(step.seconds)
                        reply = None
                    else:
                        content = None if step.body is None else Later(step.body)
                        reply = await self._http.request(
                            step.method, step.path, content=content, **step.options
                        )
                except httpx.HTTPError as error:
                    step = talk.throw(error)
                else:
                    step = talk.send(reply)
        except StopIteration as end:
            value: T = end.value
            return value
