"""What a client and the service say to each other, without a connection: the same for `httpx` and `await`.

A talk is a generator: it yields calls and pauses, gets responses (or the error of a call), and returns its
outcome. Questions are known by their content, so repeating any call is safe.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias, TypeVar

import httpx

from service.client.questions import Answer, Asked, M
from service.errors import JobInterrupted, ServiceError

T = TypeVar("T")

OnProgress = Callable[[int, int], None]

ACTIVE = ("queued", "running")
_FIRST_WAIT = 1
_TRIES = 5
_LONGEST_RETRY = 10.0
_PAUSE, _LONGEST_PAUSE = 0.05, 0.5


@dataclass(frozen=True)
class Call:
    """An HTTP request."""

    method: str
    path: str
    json: object = None
    accept: str = "application/json"
    prefer: str | None = None

    @property
    def options(self) -> dict[str, Any]:
        """The further arguments of `httpx`."""
        headers = {"Accept": self.accept, **({"Prefer": self.prefer} if self.prefer else {})}
        return {"json": self.json, "headers": headers}


@dataclass(frozen=True)
class Pause:
    """Seconds to wait."""

    seconds: float


Talk: TypeAlias = Generator[Call | Pause, httpx.Response | None, T]


def silent(_done: int, _total: int) -> None:
    """Progress that nobody follows."""


class Conversation:
    """The talk about one question or job; it knows the job while it is awaited."""

    def __init__(self, url: str, on_progress: OnProgress = silent) -> None:
        self.url = url
        self.on_progress = on_progress
        self.job: Mapping[str, Any] | None = None
        self._posted = ""

    def answer(self, asked: Asked[M]) -> Talk[Answer[M]]:
        """Post a question and wait for its answer."""
        answer = yield from self.posted(asked, f"wait={_FIRST_WAIT}")
        if self.job is None:
            return Answer(answer.content, asked.model)
        return Answer((yield from self.awaited()).content, asked.model)

    def posted(self, asked: Asked[M], prefer: str) -> Talk[httpx.Response]:
        """Post a question; unless the answer is known, it has a job then."""
        self._posted = asked.question.job_request().job_id
        answer = yield from self.sent(Call("POST", asked.path, asked.question.body(), prefer=prefer))
        self._posted = ""
        self.job = None if answer.status_code == 200 else as_object(answer)
        return answer

    def result(self, job_id: str, accept: str) -> Talk[bytes]:
        """Wait for a job and get its result."""
        job = as_object((yield from self.sent(Call("GET", f"/v1/jobs/{job_id}"))))
        yield from self._ended(job)
        return (yield from self.sent(Call("GET", job["links"]["result"], accept=accept))).content

    def withdrawn(self) -> Talk[JobInterrupted]:
        """Withdraw the question; returns what became of its job."""
        job = self.job
        if job is None:  # the service has not told its job, whose id is known nevertheless
            return JobInterrupted(self._goes_on(self._posted, "may go on") if self._posted else "")
        try:
            path = job["links"].get("cancel") or job["links"]["self"]
            job = as_object((yield from self.sent(Call("DELETE", path), tries=1)))
        except ServiceError:
            return JobInterrupted(self._goes_on(job["id"]))
        is_canceled = job["status"] == "canceled"
        return JobInterrupted(f"job {job['id']} is canceled" if is_canceled else self._goes_on(job["id"]))

    def _goes_on(self, job_id: str, verb: str = "goes on") -> str:
        return f"job {job_id} {verb}; `rpr-cusps fetch {job_id} --url {self.url}` comes back to it"

    def sent(self, call: Call, tries: int = _TRIES) -> Talk[httpx.Response]:
        """Send a request, again while the service is briefly unavailable.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        for left in reversed(range(tries)):
            try:
                answer = yield call
            except httpx.ConnectError as error:
                raise ServiceError(f"no service answers at {self.url}: {error}") from None
            except httpx.HTTPError as error:
                if not left:
                    raise ServiceError(f"{self.url}: {error or type(error).__name__}") from None
                yield Pause(0.2 * 2 ** (tries - 1 - left))
                continue
            assert answer is not None
            if answer.status_code in (429, 503) and left:
                yield Pause(_retry_after(answer))
                continue
            break
        assert answer is not None
        if answer.status_code >= 400:
            raise _refusal(answer)
        return answer

    def awaited(self) -> Talk[httpx.Response]:
        """Wait for the job and get its result."""
        assert self.job is not None
        links = self.job["links"]
        yield from self._ended(self.job)
        self.job = None
        return (yield from self.sent(Call("GET", links["result"])))

    def _ended(self, job: Mapping[str, Any]) -> Talk[None]:
        pause = _PAUSE
        while job["status"] in ACTIVE:
            self.on_progress(job["progress"]["done"], job["progress"]["total"])
            yield Pause(pause)
            pause = min(1.5 * pause, _LONGEST_PAUSE)
            job = as_object((yield from self.sent(Call("GET", job["links"]["self"]))))
        self.on_progress(job["progress"]["done"], job["progress"]["total"])


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
