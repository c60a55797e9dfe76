"""The clients: :class:`AsyncServiceClient`, and :class:`ServiceClient`, which is the same without `await`."""

from __future__ import annotations

import inspect
import re
from collections.abc import AsyncGenerator, Callable, Coroutine, Generator, Iterable, Mapping
from contextlib import aclosing, closing
from functools import update_wrapper
from pathlib import Path
from typing import Any, BinaryIO, ClassVar, Concatenate, ParamSpec, Self, TypeVar
from uuid import uuid4

from rpr_solver.contract import Progress, silent
from service.client.bodies import Answer, Asked, Body, Item, M, body_of_file, body_of_items
from service.client.connection import BlockingConnection, Call, Connection, finished
from service.client.conversation import Conversation, path_of
from service.client.results import ItemResult, ResultReader, slices_of
from service.schemas.resources import Batch, Job, JobList, ListedJob, ListedStatus
from service.schemas.tables import CuspTable

P = ParamSpec("P")
T = TypeVar("T")


class AsyncJobClient:
    """The jobs and batches of one service: their state, lists, results and end."""

    _connection_type: ClassVar[type[Connection]] = Connection

    def __init__(self, url: str, *, with_key: bool = True) -> None:
        self.url = url
        self._connection = self._connection_type(url, with_key=with_key)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.aclose()

    async def aclose(self) -> None:
        """Close the connections, as the end of `async with` does."""
        await self._connection.close()

    async def wait(self, batch_id: str, on_progress: Progress = silent) -> Batch:
        """Waits for the end of a batch; `on_progress(done, total)` follows it.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        return Batch.model_validate(await Conversation(self._connection, on_progress).end(batch_id))

    async def version(self) -> dict[str, Any]:
        """Returns the versions of the service and of its solver."""
        return await self._object("GET", "/v1/version")

    async def batch(self, batch_id: str) -> Batch:
        """Returns the state of a batch, with the numbers of its items by state."""
        return Batch.model_validate(await self.job(batch_id))

    async def job(self, job_id: str) -> dict[str, Any]:
        """Returns the state of a job, or of a batch."""
        return await self._object("GET", path_of(job_id))

    def jobs(self, status: ListedStatus | None = None) -> AsyncGenerator[ListedJob, None]:
        """Yields the jobs that the caller may see, the newest first; `status`: those in this state only."""
        return self._list("/v1/jobs", status)

    def batches(self, status: ListedStatus | None = None) -> AsyncGenerator[ListedJob, None]:
        """Yields the batches that the caller may see, as :meth:`jobs` does."""
        return self._list("/v1/batches", status)

    async def result(
        self, job_id: str, accept: str = "application/json", on_progress: Progress = silent
    ) -> bytes:
        """Waits for a job and returns its result in a media type."""
        return await Conversation(self._connection, on_progress).result(job_id, accept)

    async def cancel(self, job_id: str, *, force: bool = False) -> dict[str, Any]:
        """Withdraws a question or a batch and returns its state; a job continues if other keys want it,
        unless an operator ends it by `force`."""
        return await self._object("DELETE", path_of(job_id) + ("?force=true" if force else ""))

    async def _list(self, path: str, status: ListedStatus | None) -> AsyncGenerator[ListedJob, None]:
        following: str | None = f"{path}?status={status}" if status else path
        while following is not None:
            page = JobList.model_validate(await self._object("GET", following))
            for item in page.items:
                yield item
            following = page.next

    async def _object(self, method: str, path: str) -> dict[str, Any]:
        return await Conversation(self._connection).object(Call(method, path))


class AsyncServiceClient(AsyncJobClient):
    """A client of one service, on asyncio or trio; with the key `RPR_CUSPS_API_KEY`, if that is set and
    wanted.

    Raises:
        ServiceError: the URL is not an HTTP address.
    """

    async def ask(
        self, asked: Asked[M], on_progress: Progress = silent, *, callback_url: str | None = None
    ) -> Answer[M]:
        """Post a question and wait for its answer; `on_progress(done, total)` follows its job.

        A task that is canceled withdraws its question, and so does Ctrl-C, after which
        :class:`JobInterrupted` says what became of the job. Unless the answer is known already, the end
        of the job is also reported to `callback_url`.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        async with Conversation(self._connection, on_progress) as conversation:
            return await conversation.answer(asked, callback_url)

    async def begin(self, asked: Asked[M], *, callback_url: str | None = None) -> Answer[M] | Job:
        """Post a question without waiting: returns its answer if that is known, else its job.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        conversation = Conversation(self._connection)
        response = await conversation.post(asked, "respond-async", callback_url)
        if conversation.job is None:
            return Answer(response.content, asked.model)
        return Job.model_validate(conversation.job)

    async def slices(self, asked: Asked[CuspTable]) -> AsyncGenerator[Mapping[str, Any], None]:
        """Yields the slices of a table in the order of the question, each once all before it are computed.

        Those that the service knew before, and all after them, come with the whole table. An interruption, or
        the end of the iteration before all came, withdraws the question.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        async with (
            Conversation(self._connection) as conversation,
            aclosing(slices_of(conversation, asked)) as slices,
        ):
            async for part in slices:
                yield part

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

    async def _submit(self, body: Body, callback_url: str | None, key: str | None) -> Batch:
        with closing(body):
            async with Conversation(self._connection) as conversation:
                return await conversation.submit(body, key or str(uuid4()), callback_url)

    async def ask_all(
        self, items: Iterable[Item], on_progress: Progress = silent
    ) -> AsyncGenerator[ItemResult, None]:
        """Submit questions as a batch, and yield their results as :meth:`results` does.

        An interruption, or the end of the iteration before all came, cancels the batch; the latter with
        `await` only if the iteration is an `async with aclosing(…)`.

        Raises:
            InputError: naming the item that cannot be sent.
            ServiceError: the service refused, failed, or cannot be reached.
        """
        async with aclosing(self.watch(await self.submit(items), on_progress)) as results:
            async for result in results:
                yield result

    async def watch(self, batch: Batch, on_progress: Progress = silent) -> AsyncGenerator[ItemResult, None]:
        """Yields all results of a batch that was just submitted, and cancels it as :meth:`ask_all` does.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        async with (
            Conversation(self._connection, batch=batch),
            aclosing(self.results(batch.id, on_progress)) as results,
        ):
            async for result in results:
                yield result

    def results(
        self,
        batch_id: str,
        on_progress: Progress = silent,
        *,
        wait: bool = True,
        after: int = -1,
    ) -> AsyncGenerator[ItemResult, None]:
        """Yields the results of a batch in the order of its items, as they are computed, even if another
        client submitted it; a failed item has a problem.

        Args:
            batch_id: the id of the batch.
            on_progress: called as `on_progress(received, total)`.
            wait: until all are done; otherwise only those that are done now.
            after: only items after this position.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        reader = ResultReader(self._connection, batch_id, on_progress, wait=wait, after=after)
        return reader.results()


class _BlockingClient(AsyncServiceClient):
    """The same methods over a connection that blocks: they never suspend, and need no event loop."""

    _connection_type = BlockingConnection


def _blocking(
    method: Callable[Concatenate[AsyncServiceClient, P], Coroutine[Any, Any, T]],
) -> Callable[Concatenate[ServiceClient, P], T]:
    def call(self: ServiceClient, /, *args: P.args, **kwargs: P.kwargs) -> T:
        return finished(method(self._client, *args, **kwargs))

    return _like(method, call)


def _iterating(
    method: Callable[Concatenate[AsyncServiceClient, P], AsyncGenerator[T, None]],
) -> Callable[Concatenate[ServiceClient, P], Generator[T, None, None]]:
    def call(self: ServiceClient, /, *args: P.args, **kwargs: P.kwargs) -> Generator[T, None, None]:
        return _each(method(self._client, *args, **kwargs))

    return _like(method, call)


def _like(method: Callable[..., Any], call: Callable[P, T]) -> Callable[P, T]:
    """Returns a method of the one client with the name, texts and types of that of the other."""
    update_wrapper(call, method)
    call.__qualname__ = f"ServiceClient.{method.__name__}"
    signature = inspect.signature(method)
    returns = re.sub(
        r"^AsyncGenerator\[(.*), None\]$", r"Generator[\1, None, None]", signature.return_annotation
    )
    call.__signature__ = signature.replace(return_annotation=returns)  # type: ignore[attr-defined]
    return call


def _each(items: AsyncGenerator[T, None]) -> Generator[T, None, None]:
    """Yields the items; an exception that is thrown in is passed on to the asynchronous generator."""
    step = items.__anext__()
    while True:
        try:
            item = finished(step)
        except StopAsyncIteration:
            return
        try:
            yield item
        except GeneratorExit:
            finished(items.aclose())
            raise
        except BaseException as error:
            step = items.athrow(error)
        else:
            step = items.__anext__()


class ServiceClient:
    """A client of one service; with the key `RPR_CUSPS_API_KEY`, if that is set and wanted.

    Raises:
        ServiceError: the URL is not an HTTP address.
    """

    def __init__(self, url: str, *, with_key: bool = True) -> None:
        self.url = url
        self._client = _BlockingClient(url, with_key=with_key)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the connections, as the end of `with` does."""
        finished(self._client.aclose())

    ask = _blocking(AsyncServiceClient.ask)
    begin = _blocking(AsyncServiceClient.begin)
    slices = _iterating(AsyncServiceClient.slices)
    submit = _blocking(AsyncServiceClient.submit)
    submit_file = _blocking(AsyncServiceClient.submit_file)
    watch = _iterating(AsyncServiceClient.watch)
    results = _iterating(AsyncServiceClient.results)
    wait = _blocking(AsyncServiceClient.wait)
    version = _blocking(AsyncServiceClient.version)
    batch = _blocking(AsyncServiceClient.batch)
    job = _blocking(AsyncServiceClient.job)
    jobs = _iterating(AsyncServiceClient.jobs)
    batches = _iterating(AsyncServiceClient.batches)
    result = _blocking(AsyncServiceClient.result)
    cancel = _blocking(AsyncServiceClient.cancel)

    def ask_all(
        self, items: Iterable[Item], on_progress: Progress = silent
    ) -> Generator[ItemResult, None, None]:
        """As in the other client, but the questions are submitted at the call."""
        return self.watch(self.submit(items), on_progress)

    ask_all.__doc__ = AsyncServiceClient.ask_all.__doc__
