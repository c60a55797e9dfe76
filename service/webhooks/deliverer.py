"""Delivers what is due, in the API processes: any number of them share the work.

The API processes deliver, not the workers: they face the network anyway, and so a slow receiver delays no
computation. One thread claims, a few send. A process that is killed leaves its deliveries to the others, or
to its successor, once their lease is over.

No receiver may delay the others: hosts take turns, each has only a share of the senders, and one that did not
answer in time is left alone for a while.

An attempt is a signed POST to a checked address; only the head of the answer is read.
"""

from __future__ import annotations

import asyncio
import base64
import hmac
import json
import logging
import random
import socket
import ssl
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from email.utils import parsedate_to_datetime
from functools import partial

import httpcore
from redis import Redis
from redis.exceptions import RedisError

from rpr_solver.errors import InputError, clipped
from service import __version__
from service.webhooks.callbacks import Callbacks, Delivery, DeliveryAttempt, State
from service.webhooks.target import SecretError, Target, WebhookSettings, fits, is_allowed, target_of
from worker.answers.kinds import is_batch
from worker.jobs.view import JobView
from worker.settings import WorkerSettings

_MOST_ADDRESSES = 6


class RefusedError(Exception):
    """The host has no address that may be reached."""


@dataclass(frozen=True)
class Answer:
    """The head of an answer; `retry_after` in seconds."""

    status: int
    retry_after: float | None


def signature(secrets: Iterable[bytes], message_id: str, timestamp: int, body: bytes) -> str:
    """Returns the signatures of a message, one of each secret, after the Standard Webhooks specification.

    >>> signature([b"secret"], "msg_1", 1, b"{}")
    'v1,kW+83cjD04uWm7Qber/sPiCRVJ9ljbsrg8ALKAx2qMc='
    """
    content = f"{message_id}.{timestamp}.".encode() + body
    digests = (hmac.digest(secret, content, "sha256") for secret in secrets)
    return " ".join(f"v1,{base64.b64encode(digest).decode()}" for digest in digests)


def post(target: Target, message_id: str, body: bytes, settings: WebhookSettings) -> Answer:
    """Send a message once, within the time-out for the whole attempt. Redirects are not followed.

    Raises:
        RefusedError: the address may not be reached.
        SecretError: there is nothing to sign with.
        httpcore.NetworkError, httpcore.ProtocolError, httpcore.TimeoutException, OSError: no answer came.
    """
    now = int(time.time())
    headers = {
        "Host": target.authority,
        "Content-Type": "application/json",
        "Content-Length": str(len(body)),
        "User-Agent": f"rpr-cusps/{__version__}",
        "webhook-id": message_id,
        "webhook-timestamp": str(now),
        "webhook-signature": signature(settings.secrets(), message_id, now, body),
    }
    return asyncio.run(_exchanged(target, headers, body, settings))


async def _exchanged(
    target: Target, headers: Mapping[str, str], body: bytes, settings: WebhookSettings
) -> Answer:
    url = httpcore.URL(
        scheme=target.scheme.encode(),
        host=target.host.encode(),
        port=target.port,
        target=target.path.encode(),
    )
    context = ssl.create_default_context() if target.scheme == "https" else None
    backend = _Backend(settings, target.scheme)
    try:
        async with (
            asyncio.timeout(settings.webhook_timeout_seconds),
            httpcore.AsyncConnectionPool(ssl_context=context, network_backend=backend) as pool,
            pool.stream("POST", url, headers=list(headers.items()), content=body) as response,
        ):
            fields = {name.lower(): value for name, value in response.headers}
            return Answer(response.status, _seconds(fields))
    except TimeoutError:
        raise httpcore.ReadTimeout("the attempt exceeded its time limit") from None


def _seconds(fields: Mapping[bytes, bytes]) -> float | None:
    text = fields.get(b"retry-after", b"").decode("latin-1").strip()
    if text.isascii() and text.isdigit():
        return float(text[:9])
    try:
        return max(0.0, parsedate_to_datetime(text).timestamp() - time.time())
    except (ValueError, TypeError, OverflowError):
        return None


class _Backend(httpcore.AnyIOBackend):
    """Connects to the address that was checked, so that a second look at the name cannot give another."""

    def __init__(self, settings: WebhookSettings, scheme: str) -> None:
        self._is_allowed = partial(is_allowed, networks=settings.webhook_networks, scheme=scheme)
        self._seconds = settings.webhook_timeout_seconds

    async def connect_tcp(
        self,
        host: str,
        port: int,
        timeout: float | None = None,  # noqa: ARG002  # the limit of the whole attempt counts
        local_address: str | None = None,
        socket_options: Iterable[httpcore.SOCKET_OPTION] | None = None,
    ) -> httpcore.AsyncNetworkStream:
        addresses = await _look_up(host, port)
        allowed = list(filter(self._is_allowed, addresses))[:_MOST_ADDRESSES]
        if not allowed:
            raise RefusedError(f"{host} is {addresses[0]}, which the settings do not allow")
        share = self._seconds / len(allowed)
        for address in allowed[:-1]:
            with suppress(httpcore.ConnectError, httpcore.ConnectTimeout):
                return await super().connect_tcp(address, port, share, local_address, socket_options)
        return await super().connect_tcp(allowed[-1], port, share, local_address, socket_options)


async def _look_up(host: str, port: int) -> list[str]:
    """Returns the addresses of a host, each once. A thread asks the system's resolver, which knows no limit.

    Raises:
        ConnectTimeout: it takes longer than the attempt may.
        OSError: there are none.
    """
    answer: Future[list[str]] = Future()
    answer.set_running_or_notify_cancel()  # so that a late answer finds it as it is

    def ask() -> None:
        try:
            found = socket.getaddrinfo(host.encode(), port, type=socket.SOCK_STREAM)
            answer.set_result(list(dict.fromkeys(str(entry[4][0]) for entry in found)))
        except Exception as error:
            answer.set_exception(error)

    threading.Thread(target=ask, name="look-up", daemon=True).start()
    try:
        return await asyncio.wrap_future(answer)
    except asyncio.CancelledError:
        raise httpcore.ConnectTimeout(f"the name {host} was not resolved in time") from None


log = logging.getLogger("rpr_cusps.service")

_SENDERS = 8
_MAX_PER_HOST = 2
_MAX_PER_PATTERN = 4  # the owner of a domain can create any number of names in it
_REST_FACTOR = 3.0  # of a host that did not answer in time, in time-outs
_POLL_PAUSE = 0.5  # seconds between two looks at what is due
_MAX_RETRY_AFTER = 86400.0  # seconds
_JITTER = 0.2

LEASE_MARGIN = 20.0
"""Seconds beyond the time-out of an attempt, for a computer that is busy."""

DocumentOf = Callable[[JobView], Mapping[str, object]]
"""Gives the document of a job or a batch."""


class Deliverer:
    """The deliveries of one process.

    Args:
        redis: a client.
        settings: who may be called, and how.
        worker_settings: of the installation.
        document_of: gives the document of a job or a batch.
        margin: seconds after the time-out of an attempt during which nothing repeats it.
    """

    def __init__(
        self,
        redis: Redis,
        settings: WebhookSettings,
        worker_settings: WorkerSettings,
        document_of: DocumentOf,
        margin: float = LEASE_MARGIN,
    ) -> None:
        self._callbacks = Callbacks(redis, worker_settings)
        self._settings = settings
        self._document_of = document_of
        self._lease = settings.webhook_timeout_seconds + margin
        self._rest = _REST_FACTOR * settings.webhook_timeout_seconds
        self._sending: list[str] = []
        self._is_free = threading.Event()

    def run(self, stop: threading.Event) -> None:
        """Deliver what is due until `stop` is set; for a thread of an API process."""
        with ThreadPoolExecutor(_SENDERS, thread_name_prefix="webhooks") as senders:
            while not stop.is_set():
                self._is_free.clear()
                delivery = self._claimed() if len(self._sending) < _SENDERS else None
                if delivery is None:
                    self._is_free.wait(_POLL_PAUSE)
                else:
                    self._sending.append(delivery.host)
                    senders.submit(self._deliver, delivery)

    def _claimed(self) -> Delivery | None:
        try:
            return self._callbacks.claim(self._lease, self._must_wait())
        except RedisError:
            pass
        except Exception:
            log.exception("a search for deliveries failed")
        return None

    def _must_wait(self) -> list[str]:
        """Returns the hosts and patterns that have their share of the senders."""
        hosts = tuple(self._sending)
        full = [host for host, count in Counter(hosts).items() if count >= _MAX_PER_HOST]
        patterns = [pattern for pattern in self._settings.webhook_hosts if pattern.startswith("*.")]
        return full + [p for p in patterns if sum(fits(host, p) for host in hosts) >= _MAX_PER_PATTERN]

    def _deliver(self, delivery: Delivery) -> None:
        try:
            self.attempt(delivery)
        except RedisError:
            pass  # it is due again after its lease
        except Exception:
            log.exception("a delivery failed")
        finally:
            self._sending.remove(delivery.host)
            self._is_free.set()

    def attempt(self, delivery: Delivery) -> None:
        """Make one attempt, and note how it ended."""
        at, status, problem, retry_after = time.time(), None, None, None
        state: State = "pending"
        rest = 0.0
        try:
            target = target_of(delivery.url, self._settings)
            answer = post(target, delivery.id, event_of(delivery, self._document_of), self._settings)
            status, retry_after = answer.status, answer.retry_after
            state, problem = delivery_state(answer)
        except (RefusedError, InputError) as error:
            state, problem = "refused", str(error)
            why = error if isinstance(error, RefusedError) else "the settings do not allow it"
            log.warning("a webhook to %s is refused: %s", delivery.host, why)
        except SecretError as error:
            log.warning("webhooks cannot be signed: RPR_CUSPS_WEBHOOK_SECRET_FILE %s", error)
            problem = "it could not be signed"
        except (httpcore.TimeoutException, TimeoutError) as error:
            problem, rest = _problem_of(error), self._rest
        except (httpcore.NetworkError, httpcore.ProtocolError, OSError) as error:
            problem = _problem_of(error)
        except Exception as error:
            log.exception("a delivery failed")
            problem = type(error).__name__
        delay = 0.0
        if state == "pending":
            pauses = self._settings.webhook_retry_seconds
            if delivery.claim > len(pauses):
                state = "exhausted"
            else:
                delay = pause(pauses[delivery.claim - 1], retry_after)
        self._callbacks.settle(delivery, state, DeliveryAttempt(at, status, problem), delay, rest)


def _problem_of(error: Exception) -> str:
    return clipped(f"{type(error).__name__}: {error}".removesuffix(": "), 200)


def delivery_state(answer: Answer) -> tuple[State, str | None]:
    """Returns how a delivery stands after an answer, and why it did not succeed."""
    if 200 <= answer.status < 300:
        return "delivered", None
    if answer.status == 410:
        return "gone", "the receiver declined further attempts (410)"
    if 300 <= answer.status < 400:
        return "pending", "redirects are not followed"
    return "pending", f"the receiver answered {answer.status}"


def pause(seconds: float, retry_after: float | None) -> float:
    """Returns the time until the next attempt: a little more than planned, or `Retry-After`."""
    return max(seconds * random.uniform(1, 1 + _JITTER), min(retry_after or 0.0, _MAX_RETRY_AFTER))


def event_type(view: JobView) -> str:
    """Returns the type of the event that a job or a batch has ended."""
    return f"{'batch' if is_batch(view.id) else 'job'}.{view.state}"


def event_of(delivery: Delivery, document_of: DocumentOf) -> bytes:
    """Returns the body, the same at every attempt."""
    job = delivery.job
    event = {"type": event_type(job), "timestamp": job.ended_at, "data": document_of(job)}
    return json.dumps(event, separators=(",", ":"), ensure_ascii=False).encode()
