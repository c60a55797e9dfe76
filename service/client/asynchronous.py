"""The client for programs with an event loop, on asyncio or trio."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping
from typing import Any, Self, TypeVar

import anyio
import httpx

from service.client.conversation import Call, Conversation, OnProgress, Pause, Talk, as_object, silent
from service.client.questions import Answer, Asked, M
from service.client.settings import connection
from service.client.streams import InOrder, SliceEvents, lengths_of
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

    async def ask(self, asked: Asked[M], on_progress: OnProgress = silent) -> Answer[M]:
        """Post a question and wait for its answer; `on_progress(done, total)` follows its job.

        A task that is canceled withdraws its question.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        talk = Conversation(self.url, on_progress)
        try:
            return await self._drive(talk.answer(asked))
        except anyio.get_cancelled_exc_class():
            await self._withdraw(talk)
            raise

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

    async def version(self) -> dict[str, Any]:
        """Returns the versions of the service and of its solver."""
        return as_object(await self._drive(Conversation(self.url).sent(Call("GET", "/version"))))

    async def job(self, job_id: str) -> dict[str, Any]:
        """Returns the state of a job."""
        return as_object(await self._drive(Conversation(self.url).sent(Call("GET", f"/v1/jobs/{job_id}"))))

    async def result(
        self, job_id: str, accept: str = "application/json", on_progress: OnProgress = silent
    ) -> bytes:
        """Waits for a job and returns its result in a media type."""
        return await self._drive(Conversation(self.url, on_progress).result(job_id, accept))

    async def cancel(self, job_id: str) -> dict[str, Any]:
        """Withdraws from a job and returns its state; it goes on if others wait for it."""
        call = Call("DELETE", f"/v1/jobs/{job_id}")
        return as_object(await self._drive(Conversation(self.url).sent(call)))

    async def _withdraw(self, talk: Conversation) -> None:
        with anyio.CancelScope(shield=True), anyio.move_on_after(_FAREWELL):
            await self._drive(talk.withdrawn())

    async def _events(self, path: str) -> AsyncIterator[tuple[str, Mapping[str, Any]]]:
        events = SliceEvents()
        try:
            async with self._http.stream("GET", path, headers={"Accept": "text/event-stream"}) as response:
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
                        reply = await self._http.request(step.method, step.path, **step.options)
                except httpx.HTTPError as error:
                    step = talk.throw(error)
                else:
                    step = talk.send(reply)
        except StopIteration as end:
            value: T = end.value
            return value
