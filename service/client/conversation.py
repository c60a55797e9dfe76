"""What a client and the service say to each other, without a connection: the same for `httpx` and `await`.

A talk is a generator: it yields calls and pauses, gets responses (or the error of a call), and returns its
outcome. Questions are known by their content, so repeating any call is safe.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias, TypeVar
from urllib.parse import quote
from uuid import uuid4

import httpx

from service.client.bodies import Body
from service.client.questions import Answer, Asked, M
from service.errors import JobInterrupted, ServiceError
from service.schemas.batches import Batch, is_batch
from service.schemas.job_list import JobList, ListedStatus

T = TypeVar("T")

OnProgress = Callable[[int, int], None]

ACTIVE = ("queued", "running")
_FIRST_WAIT = 1
_TRIES = 5
_LONGEST_RETRY = 10.0
_PAUSE, _LONGEST_PAUSE = 0.05, 0.5
_CONNECT = 5.0
_BROKEN_OFF = 150.0  # a service that was killed forgets the submission that it received within two minutes
_IN_PROGRESS, _IN_PROGRESS_PAUSE = "submission-in-progress", 2.0


@dataclass(frozen=True)
class Call:
    """An HTTP request; `body` is sent by the client that makes it, `timeout` is in seconds."""

    method: str
    path: str
    json: object = None
    accept: str = "application/json"
    prefer: str | None = None
    body: Body | None = None
    key: str | None = None
    timeout: float | None = None

    @property
    def options(self) -> dict[str, Any]:
        """The further arguments of `httpx`, except the body."""
        fields = {
            "Accept": self.accept,
            "Prefer": self.prefer,
            "Content-Type": None if self.body is None else self.body.media_type,
            "Idempotency-Key": self.key,
        }
        headers = {name: value for name, value in fields.items() if value is not None}
        content = {} if self.json is None else {"json": self.json}
        limit = {} if self.timeout is None else {"timeout": httpx.Timeout(self.timeout, connect=_CONNECT)}
        return {**content, "headers": headers, **limit}


@dataclass(frozen=True)
class Pause:
    """Seconds to wait."""

    seconds: float


Talk: TypeAlias = Generator[Call | Pause, httpx.Response | None, T]


def silent(_done: int, _total: int) -> None:
    """Progress that nobody follows."""


def new_key() -> str:
    """Returns the key of a submission."""
    return str(uuid4())


def address(job_id: str) -> str:
    """Returns the address of a job or a batch."""
    return f"/v1/{'batches' if is_batch(job_id) else 'jobs'}/{quote(job_id, safe='')}"


class Conversation:
    """The talk about one question, job or batch; it knows the job while it is awaited."""

    def __init__(self, url: str, on_progress: OnProgress = silent) -> None:
        self.url = url
        self.on_progress = on_progress
        self.job: Mapping[str, Any] | None = None
        self._unheard = ""
        self._is_reached = False

    @classmethod
    def about(cls, url: str, batch: Batch) -> Conversation:
        """Returns the talk about a batch that was submitted."""
        talk = cls(url)
        talk.job = batch.model_dump(mode="json", exclude_unset=True)
        return talk

    def answer(self, asked: Asked[M], callback_url: str | None = None) -> Talk[Answer[M]]:
        """Post a question and wait for its answer."""
        answer = yield from self.posted(asked, f"wait={_FIRST_WAIT}", callback_url)
        if self.job is None:
            return Answer(answer.content, asked.model)
        return Answer((yield from self.awaited()).content, asked.model)

    def posted(self, asked: Asked[M], prefer: str, callback_url: str | None = None) -> Talk[httpx.Response]:
        """Post a question; unless the answer is known, it has a job then."""
        self._unheard = self._goes_on(asked.question.job_request().job_id, "may go on")
        body = asked.question.body() | ({} if callback_url is None else {"callback_url": callback_url})
        answer = yield from self.sent(Call("POST", asked.path, body, prefer=prefer))
        self._unheard = ""
        self.job = None if answer.status_code == 200 else as_object(answer)
        return answer

    def submitted(self, body: Body, key: str, callback_url: str | None) -> Talk[Batch]:
        """Submit a batch. Whatever breaks, it is made once: it is known by its key."""
        self._unheard = f"the batch may not have been accepted; sent again with the key {key} it is the same"
        query = "" if callback_url is None else f"?callback_url={quote(callback_url, safe='')}"
        call = Call("POST", f"/v1/batches{query}", body=body, key=key)
        patience = _BROKEN_OFF
        while True:
            try:
                self.job = as_object((yield from self.sent(call)))
            except ServiceError as error:
                if error.problem != _IN_PROGRESS or patience <= 0:
                    raise
                patience -= _IN_PROGRESS_PAUSE
                yield Pause(_IN_PROGRESS_PAUSE)
            else:
                self._unheard = ""
                return Batch.model_validate(self.job)

    def result(self, job_id: str, accept: str) -> Talk[bytes]:
        """Wait for a job and get its result."""
        job = yield from self.ended(job_id)
        path = job["links"].get("result") or job["links"]["results"]
        return (yield from self.sent(Call("GET", path, accept=accept))).content

    def listed(self, path: str, status: ListedStatus | None) -> Talk[JobList]:
        """Get a page of jobs or batches: of a list, or the one that another page names as the next."""
        query = f"?status={status}" if status else ""
        return JobList.model_validate(as_object((yield from self.sent(Call("GET", path + query)))))

    def ended(self, job_id: str) -> Talk[Mapping[str, Any]]:
        """Wait for a job or a batch."""
        return (yield from self._ended(as_object((yield from self.sent(Call("GET", address(job_id)))))))

    def withdrawn(self) -> Talk[JobInterrupted]:
        """Withdraw the question or the batch; returns what became of its job."""
        job = self.job
        if job is None:  # the service has not told it
            return JobInterrupted(self._unheard)
        try:
            path = job["links"].get("cancel") or job["links"]["self"]
            job = as_object((yield from self.sent(Call("DELETE", path), tries=1)))
        except ServiceError:
            return JobInterrupted(self._goes_on(job["id"]))
        if job["status"] != "canceled":
            return JobInterrupted(self._goes_on(job["id"]))
        if not is_batch(job["id"]):
            return JobInterrupted(f"job {job['id']} is canceled")
        done = f"{job['done']} of its {job['total']} items are done; {self._fetch(job['id'])} prints them"
        return JobInterrupted(f"batch {job['id']} is canceled; {done}")

    def _goes_on(self, job_id: str, verb: str = "goes on") -> str:
        what = "batch" if is_batch(job_id) else "job"
        return f"{what} {job_id} {verb}; {self._fetch(job_id)} comes back to it"

    def _fetch(self, job_id: str) -> str:
        return f"`rpr-cusps fetch {job_id} --url {self.url}`"

    def sent(self, call: Call, tries: int = _TRIES) -> Talk[httpx.Response]:
        """Send a request, again while the service is briefly unavailable.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        for left in reversed(range(tries)):
            try:
                answer = yield call
            except httpx.HTTPError as error:
                yield from self.broken(error, left)
                continue
            assert answer is not None
            if (yield from self.passed(answer, left)):
                return answer
        raise AssertionError("the last try ends")

    def broken(self, error: httpx.HTTPError, left: int) -> Talk[None]:
        """Pause after a connection that broke, while tries are left.

        Raises:
            ServiceError: there are none, or nobody has ever answered.
        """
        if isinstance(error, httpx.ConnectError) and not (self._is_reached and left):
            raise ServiceError(f"no service answers at {self.url}: {error}") from None
        if not left:
            raise ServiceError(f"{self.url}: {error or type(error).__name__}") from None
        yield Pause(0.2 * 2 ** max(0, _TRIES - 1 - left))

    def passed(self, answer: httpx.Response, left: int) -> Talk[bool]:
        """Returns whether this is the answer; pauses if the service is busy, while tries are left.

        Raises:
            ServiceError: the service refused or failed.
        """
        self._is_reached = True
        if answer.status_code in (429, 503) and left:
            yield Pause(_retry_after(answer))
            return False
        if answer.status_code >= 400:
            raise _refusal(answer)
        return True

    def awaited(self) -> Talk[httpx.Response]:
        """Wait for the job and get its result."""
        assert self.job is not None
        links = self.job["links"]
        yield from self._ended(self.job)
        self.job = None
        return (yield from self.sent(Call("GET", links["result"])))

    def _ended(self, job: Mapping[str, Any]) -> Talk[Mapping[str, Any]]:
        pause = _PAUSE
        while job["status"] in ACTIVE:
            self.on_progress(*_progress(job))
            yield Pause(pause)
            pause = min(1.5 * pause, _LONGEST_PAUSE)
            job = as_object((yield from self.sent(Call("GET", job["links"]["self"]))))
        self.on_progress(*_progress(job))
        return job


def as_object(answer: httpx.Response) -> dict[str, Any]:
    """Returns the JSON object in a response.

    Raises:
        ServiceError: it is none.
    """
    try:
        document = answer.json()
    except ValueError:
        document = None
    if not isinstance(document, dict):
        raise ServiceError(f"{answer.url} does not answer as an rpr-cusps service")
    return document


def _progress(job: Mapping[str, Any]) -> tuple[int, int]:
    counts = job.get("progress", job)  # those of a batch stand beside its state
    return counts["done"], counts["total"]


def _refusal(answer: httpx.Response) -> ServiceError:
    status = answer.status_code
    detail, problem = f"{answer.url} answers {status} {answer.reason_phrase}", ""
    try:
        document = answer.json()
        detail, problem = str(document["detail"]), str(document["type"]).rpartition("/")[2]
    except (ValueError, KeyError, TypeError):
        pass  # not from the service, perhaps from a proxy before it
    return ServiceError(detail, is_input=status < 500, status=status, problem=problem)


def _retry_after(answer: httpx.Response) -> float:
    value = answer.headers.get("retry-after", "")
    return min(_LONGEST_RETRY, float(value)) if value.isdigit() else 1.0
