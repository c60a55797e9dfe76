"""The conversation of a client with a service about one question, job or batch.

Questions are known by their content, so repeating any request is safe.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self
from urllib.parse import quote, urlsplit

import httpx

from rpr_solver.contract import Progress, silent
from service.client.bodies import Answer, Asked, Body, M
from service.client.connection import Call, Connection
from service.errors import JobInterrupted, ServiceError
from service.schemas.resources import Batch, address, is_batch

_ACTIVE = ("queued", "running")
_USUAL_PORT = 8000
_FIRST_WAIT = 1
_TRIES = 5
_LONGEST_RETRY = 10.0
_PAUSE, _LONGEST_PAUSE = 0.05, 0.5
_BROKEN_OFF = 150.0  # a service that was killed forgets the submission that it received within two minutes
_IN_PROGRESS, _IN_PROGRESS_PAUSE = "submission-in-progress", 2.0


def path_of(job_id: str) -> str:
    """Returns the path of a job or a batch, whatever the id is made of."""
    return address(quote(job_id, safe=""))


class Conversation:
    """One question, job or batch; as a context, it is withdrawn when the program is interrupted.

    Attributes:
        connection: the connection to the service.
        job: the job that is awaited, if there is one.
    """

    def __init__(
        self, connection: Connection, on_progress: Progress = silent, batch: Batch | None = None
    ) -> None:
        self.connection = connection
        self.job = None if batch is None else batch.model_dump(mode="json", exclude_unset=True)
        self._on_progress = on_progress
        self._outcome_unknown = ""
        self._is_reached = False

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, _kind: object, error: BaseException | None, _trace: object) -> None:
        if error is None or not (isinstance(error, GeneratorExit) or self.connection.is_interruption(error)):
            return
        interrupted = await self.connection.withdraw(self.withdraw())
        if isinstance(error, KeyboardInterrupt) and interrupted is not None:
            raise interrupted from None

    async def answer(self, asked: Asked[M], callback_url: str | None = None) -> Answer[M]:
        """Post a question and wait for its answer."""
        response = await self.post(asked, f"wait={_FIRST_WAIT}", callback_url)
        if self.job is not None:
            response = await self.result_of_job()
        return Answer(response.content, asked.model)

    async def post(self, asked: Asked[M], prefer: str, callback_url: str | None = None) -> httpx.Response:
        """Post a question; unless the answer is known, there is a job afterwards."""
        url = self.connection.url
        self._outcome_unknown = _continues(asked.question.job_request().job_id, url, "may continue")
        body = asked.question.body() | ({} if callback_url is None else {"callback_url": callback_url})
        response = await self.send(Call("POST", asked.path, body, prefer=prefer))
        self._outcome_unknown = ""
        self.job = None if response.status_code == httpx.codes.OK else as_object(response)
        return response

    async def submit(self, body: Body, key: str, callback_url: str | None) -> Batch:
        """Submit a batch. It is created only once, even if connections break, because it has a key."""
        self._outcome_unknown = (
            f"the batch may not have been accepted; sent again with the key {key} it is the same"
        )
        query = "" if callback_url is None else f"?callback_url={quote(callback_url, safe='')}"
        call = Call("POST", f"/v1/batches{query}", body=body, key=key)
        patience = _BROKEN_OFF
        while True:
            try:
                self.job = await self.object(call)
            except ServiceError as error:
                if error.problem != _IN_PROGRESS or patience <= 0:
                    raise
                patience -= _IN_PROGRESS_PAUSE
                await self.connection.sleep(_IN_PROGRESS_PAUSE)
            else:
                self._outcome_unknown = ""
                return Batch.model_validate(self.job)

    async def result(self, job_id: str, accept: str) -> bytes:
        """Wait for a job and get its result."""
        links = (await self.end(job_id))["links"]
        path = links.get("result") or links["results"]
        return (await self.send(Call("GET", path, accept=accept))).content

    async def result_of_job(self) -> httpx.Response:
        """Wait for the job of this question and get its result."""
        assert self.job is not None
        links = self.job["links"]
        await self._end(self.job)
        self.job = None
        return await self.send(Call("GET", links["result"]))

    async def end(self, job_id: str) -> dict[str, Any]:
        """Wait for a job or a batch; returns its state."""
        return await self._end(await self.object(Call("GET", path_of(job_id))))

    async def _end(self, job: dict[str, Any]) -> dict[str, Any]:
        pause = _PAUSE
        while job["status"] in _ACTIVE:
            self._on_progress(*_progress(job))
            await self.connection.sleep(pause)
            pause = min(1.5 * pause, _LONGEST_PAUSE)
            job = await self.object(Call("GET", job["links"]["self"]))
        self._on_progress(*_progress(job))
        return job

    async def withdraw(self) -> JobInterrupted:
        """Withdraw the question or the batch; returns what became of its job."""
        job, url = self.job, self.connection.url
        if job is None:  # no response has named it
            return JobInterrupted(self._outcome_unknown)
        try:
            path = job["links"]["self"]
            job = as_object(await self.send(Call("DELETE", path), tries=1))
        except ServiceError:
            return JobInterrupted(_continues(job["id"], url))
        if job["status"] != "canceled":
            return JobInterrupted(_continues(job["id"], url))
        if not is_batch(job["id"]):
            return JobInterrupted(f"job {job['id']} is canceled")
        done, total = _progress(job)
        rest = f"{done} of its {total} items are done; {_fetch(job['id'], url)} prints them"
        return JobInterrupted(f"batch {job['id']} is canceled; {rest}")

    async def object(self, call: Call) -> dict[str, Any]:
        """Send a request; returns the JSON object in the response."""
        return as_object(await self.send(call))

    async def send(self, call: Call, tries: int = _TRIES) -> httpx.Response:
        """Send a request, again while the service is briefly unavailable.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        for left in reversed(range(tries)):
            try:
                response = await self.connection.send(call)
            except httpx.HTTPError as error:
                await self._pause_after(error, left)
                continue
            if await self.is_final(response, left):
                return response
        raise AssertionError("the last try ends")

    async def _pause_after(self, error: httpx.HTTPError, left: int) -> None:
        """Pause after a connection that broke, while tries are left.

        Raises:
            ServiceError: there are none, or the service has never answered.
        """
        if isinstance(error, httpx.ConnectError) and not (self._is_reached and left):
            raise ServiceError(
                f"no service answers at {self.connection.url}: {error}{self._hint()}"
            ) from None
        if not left:
            raise ServiceError(f"{self.connection.url}: {error or type(error).__name__}") from None
        await self.connection.sleep(0.2 * 2 ** max(0, _TRIES - 1 - left))

    def _hint(self) -> str:
        """What to do about a service on this computer that does not run."""
        address = urlsplit(self.connection.url)
        if address.hostname not in ("127.0.0.1", "localhost", "::1"):
            return ""
        port = "" if address.port in (None, _USUAL_PORT) else f" --port {address.port}"
        return f"; `rpr-cusps serve{port}` starts one"

    async def is_final(self, response: httpx.Response, left: int) -> bool:
        """Returns whether this is the answer; pauses if the service is busy, while tries are left.

        Raises:
            ServiceError: the service refused or failed.
        """
        self._is_reached = True
        if response.status_code in (429, 503) and left:
            await self.connection.sleep(_retry_after(response))
            return False
        if response.is_error:
            raise _refusal(response)
        return True


def as_object(response: httpx.Response) -> dict[str, Any]:
    """Returns the JSON object in a response.

    Raises:
        ServiceError: it has something else.
    """
    try:
        document = response.json()
    except ValueError:
        document = None
    if not isinstance(document, dict):
        raise ServiceError(f"{response.url} does not answer as an rpr-cusps service")
    return document


def _continues(job_id: str, url: str, verb: str = "continues") -> str:
    what = "batch" if is_batch(job_id) else "job"
    return f"{what} {job_id} {verb}; {_fetch(job_id, url)} prints its answer"


def _fetch(job_id: str, url: str) -> str:
    return f"`rpr-cusps fetch {job_id} --url {url}`"


def _progress(job: Mapping[str, Any]) -> tuple[int, int]:
    return job["progress"]["done"], job["progress"]["total"]


def _refusal(response: httpx.Response) -> ServiceError:
    status = response.status_code
    detail, problem = f"{response.url} answers {status} {response.reason_phrase}", ""
    try:
        document = response.json()
        detail, problem = str(document["detail"]), str(document["type"]).rpartition("/")[2]
    except (ValueError, KeyError, TypeError):
        pass  # not from the service, perhaps from a proxy before it
    return ServiceError(detail, is_input=status < 500, status=status, problem=problem)


def _retry_after(response: httpx.Response) -> float:
    value = response.headers.get("retry-after", "")
    return min(_LONGEST_RETRY, float(value)) if value.isdigit() else 1.0
