"""Connections to Redis, with timeouts for both the API and the workers."""

from __future__ import annotations

import random
import re
import ssl
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any, TypeVar, cast
from urllib.parse import parse_qs, urlsplit

from redis import Redis
from redis.backoff import ExponentialBackoff
from redis.connection import SSLConnection
from redis.exceptions import (
    AuthenticationError,
    AuthorizationError,
    NoPermissionError,
    RedisError,
    ResponseError,
)
from redis.exceptions import ConnectionError as RedisConnectionError
from redis.exceptions import TimeoutError as RedisTimeoutError
from redis.retry import Retry

from worker.settings import ConnectionSettings

T = TypeVar("T")

SOCKET_TIMEOUT = 4.0
"""Seconds; longer than any blocking command of a worker. A server that hangs is noticed
after three times this."""

NO_EVICTION = "noeviction"

_OWN_FAULTS = ("ERR", "WRONGTYPE", "NOSCRIPT", "EXECABORT")
_OTHER_SERVER = re.compile(r"(ERR )?unknown command\b|.*\bin a cluster node\b", re.DOTALL)  # or a Sentinel
_CODE = re.compile(r"[A-Z]+")
_IN_SCRIPT = re.compile(r"-(?:MISCONF|OOM|READONLY|NOREPLICAS|NOPERM)\b")
_FIRST_PAUSE, _LONGEST_PAUSE = 0.1, 5.0
_PASSWORD_HINT = (
    "; give its password in the file that RPR_CUSPS_REDIS_PASSWORD_FILE names, or in RPR_CUSPS_REDIS_URL, as "
    "redis://:PASSWORD@HOST"
)
_TLS_TIMEOUT = 4.0  # a server without TLS waits for ever for the end of what it takes for a command


class UnreachableError(Exception):
    """No server that could keep a queue answers; the message is for the user, and has no password in it.

    Attributes:
        may_pass: whether another try may succeed: the server is not there yet, its name is not known yet, or
            it loads its data. A wrong address, password or certificate does not mend itself.
    """

    def __init__(self, message: str, *, may_pass: bool = False) -> None:
        super().__init__(message)
        self.may_pass = may_pass


class _Retry(Retry):
    """Retries `lost` times after a lost connection, and `unanswered` times after a time-out."""

    def __init__(self, lost: int, unanswered: int) -> None:
        super().__init__(ExponentialBackoff(cap=0.5, base=0.02), lost)
        self._unanswered = unanswered

    def call_with_retry(
        self,
        do: Callable[[], T],
        fail: Callable[..., Any],
        is_retryable: Callable[[Exception], bool] | None = None,
        with_failure_count: bool = False,
    ) -> T:
        """Do something, again and again."""
        left = self._unanswered

        def may_retry(error: Exception) -> bool:
            nonlocal left
            left -= isinstance(error, RedisTimeoutError | TimeoutError)
            return left >= 0 and (is_retryable is None or is_retryable(error))

        return super().call_with_retry(do, fail, may_retry, with_failure_count)


def connect(url: str, *, max_connections: int = 256, timeout: float | None = None) -> Redis:
    """Return a client for `url` (`redis://`, `rediss://` or `unix://`); connects at first use.

    Args:
        url: the address.
        max_connections: the size of the pool.
        timeout: how long one answer may take, in seconds, after which an error comes at once. Without it,
            `SOCKET_TIMEOUT` and a second try.

    Raises:
        ValueError: the address cannot be understood, or the file with the password not be read.
    """
    check_address(url)
    seconds = SOCKET_TIMEOUT if timeout is None else timeout
    over_network: dict[str, Any] = {"socket_connect_timeout": min(3.0, seconds), "socket_keepalive": True}
    return Redis.from_url(
        url,
        max_connections=max_connections,
        socket_timeout=seconds,
        protocol=2,
        driver_info=None,  # looking up the client's own version costs a millisecond per connection
        **({} if url.startswith("unix:") else over_network),
        **password(url),
        retry=_Retry(lost=3, unanswered=1 if timeout is None else 0),
    )


def patient(redis: Redis) -> Redis:
    """Returns a client with connections of its own, which waits half a minute for a server that is away.

    So what was computed meanwhile is not lost.
    """
    pool = redis.connection_pool
    options = {**pool.connection_kwargs, "retry": _Retry(lost=70, unanswered=7)}
    return Redis(connection_pool=type(pool)(connection_class=pool.connection_class, **options))


def password(url: str) -> dict[str, Any]:
    """Returns the option with the password of RPR_CUSPS_REDIS_PASSWORD_FILE, if `url` needs it.

    Raises:
        ValueError: the file cannot be read.
    """
    path = ConnectionSettings().redis_password_file
    if path is None or url.startswith("unix:") or has_password(url):
        return {}
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not UTF-8"
        raise ValueError(f"RPR_CUSPS_REDIS_PASSWORD_FILE: {str(path)!r} cannot be read ({reason})") from None
    if not lines or not lines[0]:
        raise ValueError(f"RPR_CUSPS_REDIS_PASSWORD_FILE: the first line of {str(path)!r} is empty")
    return {"password": lines[0]}


def has_password(url: str) -> bool:
    """Whether an address has a password in it."""
    parts = urlsplit(url)
    return parts.password is not None or "password" in parse_qs(parts.query)


def check(url: str) -> None:
    """Have the server at `url` answer once.

    Raises:
        UnreachableError: it does not, or cannot keep a queue, or the address cannot be understood.
    """
    try:
        with connect(url, timeout=_TLS_TIMEOUT if url.startswith("rediss:") else None) as redis:
            redis.ping()
            fault = _unfitness(redis)
    except (RedisError, ValueError) as error:
        hint = _tls_hint(error) if url.startswith("rediss:") else ""
        hint = _PASSWORD_HINT if isinstance(error, AuthenticationError) else hint
        raise UnreachableError(
            f"cannot reach Redis: {error}{hint}", may_pass=_may_pass(error, url)
        ) from error
    if fault is not None:
        raise UnreachableError(f"cannot use this Redis: {fault}")


def _unfitness(redis: Redis) -> str | None:
    """Returns why a server cannot keep a queue, if so; one that refuses to say it is trusted."""
    try:
        server = cast("Mapping[str, Any]", redis.info("server"))
        copies = cast("Mapping[str, Any]", redis.info("replication"))
    except NoPermissionError:
        return None
    mode = server.get("redis_mode") or server.get("server_mode")  # as Redis calls it, and as Valkey does
    if mode == "cluster":
        return "it is a node of a Redis Cluster, which spreads keys; give a single server, without a cluster"
    if mode == "sentinel":
        return "it is a Sentinel, which keeps no data; give the address of the server that it watches"
    if copies.get("role") == "slave":
        primary = f"{copies.get('master_host')}:{copies.get('master_port')}"
        return f"it is a replica, which takes no data; give the address of its primary, {primary}"
    return None


def _may_pass(error: Exception, url: str) -> bool:
    """Whether the same may succeed later, and nothing but time is needed."""
    cause = error.__cause__ or error.__context__
    if isinstance(cause, FileNotFoundError):
        return url.startswith("unix:")  # the socket of a server comes by itself, a certificate does not
    if isinstance(cause, PermissionError) or isinstance(error, AuthenticationError | AuthorizationError):
        return False
    if isinstance(cause, ssl.SSLError):
        return isinstance(cause, ssl.SSLEOFError)  # it was ending, or there is only a proxy yet
    return isinstance(error, RedisConnectionError | RedisTimeoutError)


class Search:
    """Looks for the server at an address until it answers, with growing pauses; says once that it waits.

    It does so in a thread, so that a process that is to stop need not wait for the end of a try.

    Args:
        url: the address.
        tell: receives the message that it waits.
        judge: judges the server once it answers.

    Attributes:
        is_waiting: whether it was not there at the first try.
        is_reached: whether it is there.
        problem: why waiting is of no use, or what `judge` has raised.
    """

    def __init__(
        self, url: str, tell: Callable[[str], object], judge: Callable[[], object] = lambda: None
    ) -> None:
        self.is_waiting = self.is_reached = False
        self.problem: Exception | None = None
        self._url, self._tell, self._judge = url, tell, judge
        threading.Thread(target=self._run, daemon=True).start()

    @property
    def is_over(self) -> bool:
        """Whether the server is there, or waiting is of no use."""
        return self.is_reached or self.problem is not None

    def _run(self) -> None:
        try:
            self._look()
            self._judge()
            self.is_reached = True
        except Exception as error:
            self.problem = error

    def _look(self) -> None:
        pause = _FIRST_PAUSE
        while True:
            try:
                return check(self._url)
            except UnreachableError as error:
                if not error.may_pass:
                    raise
                if not self.is_waiting:
                    self._tell(f"{error}; waiting for it")
                    self.is_waiting = True
            time.sleep(pause * random.uniform(0.5, 1.0))  # not all of a machine at the same time
            pause = min(2 * pause, _LONGEST_PAUSE)


def _tls_hint(error: Exception) -> str:
    if isinstance(error, RedisTimeoutError) or "WRONG_VERSION_NUMBER" in str(error):
        return "; perhaps it speaks no TLS, then the address begins with redis://"
    if "CERTIFICATE_VERIFY_FAILED" in str(error):
        return "; the certificate of its authority is given as ?ssl_ca_certs=FILE at the end of the address"
    return ""


def is_refusal(error: Exception) -> bool:
    """Whether Redis is away, hangs, or accepts no commands or data at the moment; else the fault is ours."""
    if isinstance(error, RedisConnectionError | RedisTimeoutError):
        return True
    if not isinstance(error, ResponseError):
        return False
    text = str(error).rpartition("caused error: ")[2]  # redis-py quotes the command of a pipeline before it
    code = error.status_code or text.partition(" ")[0]
    return (
        bool(_CODE.fullmatch(code) and code not in _OWN_FAULTS)
        or bool(_IN_SCRIPT.search(text))
        or bool(_OTHER_SERVER.match(text))
    )


def eviction_warning(redis: Redis) -> str | None:
    """Returns what is wrong with the eviction policy of Redis, if anything, or if Redis may not say it.

    Raises:
        RedisError: Redis cannot be reached.
    """
    try:
        memory = cast("Mapping[str, Any]", redis.info("memory"))
    except NoPermissionError:
        return None
    policy = str(memory.get("maxmemory_policy", NO_EVICTION))
    if policy == NO_EVICTION:
        return None
    return (
        f"Redis evicts keys when its memory is full (maxmemory-policy {policy}), so jobs and results may get "
        f"lost; set maxmemory-policy {NO_EVICTION}."
    )


def address(redis: Redis) -> str:
    """Where a client connects to, without user and password."""
    options = redis.connection_pool.connection_kwargs
    if "path" in options:
        return f"unix://{options['path']}?db={options.get('db', 0)}"
    scheme = "rediss" if issubclass(redis.connection_pool.connection_class, SSLConnection) else "redis"
    host = str(options.get("host", "localhost"))
    host = f"[{host}]" if ":" in host else host
    return f"{scheme}://{host}:{options.get('port', 6379)}/{options.get('db', 0)}"


def check_address(url: str) -> None:
    """Refuse URLs that redis-py would silently misread, or quote with a part of the password."""
    try:
        parts = urlsplit(url)
        _ = parts.port
    except ValueError:
        raise ValueError(
            "the URL is not of the form redis://[user:password@]host[:port][/database]; in a password / is "
            "written %2F, # %23 and ? %3F"
        ) from None
    if parts.scheme in ("redis", "rediss") and not re.fullmatch(r"/?[0-9]*", parts.path):
        raise ValueError("the database in the URL must be a number, as in redis://127.0.0.1:6379/0")
