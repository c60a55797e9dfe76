"""A small HTTP client of the service."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, Self

import httpx
from pydantic import Field, SecretStr
from pydantic_settings import BaseSettings, SettingsConfigDict

from service.errors import ServiceError

_FIRST_WAIT = 1
_TRIES = 5
_LOOPBACK = ("127.0.0.1", "localhost", "::1")
_TIMEOUT = httpx.Timeout(60.0, connect=5.0)


class ClientSettings(BaseSettings):
    """What a client reads from the environment, since others can see a command line."""

    model_config = SettingsConfigDict(env_prefix="RPR_CUSPS_", frozen=True, extra="ignore")

    api_key: SecretStr | None = Field(default=None, description="API key that `rpr-cusps solve --url` sends")


class ServiceClient:
    """A client of one service; with the key `RPR_CUSPS_API_KEY`, if that is set and wanted.

    Raises:
        ServiceError: the URL is not an HTTP address.
    """

    def __init__(self, url: str, *, with_key: bool = True) -> None:
        self.url = url
        try:
            parsed = httpx.URL(url)
        except (httpx.InvalidURL, TypeError) as error:
            raise ServiceError(f"{url!r} is not an address: {error}", is_input=True) from None
        if parsed.scheme not in ("http", "https") or not parsed.host:
            raise ServiceError(
                f"{url!r} is not an HTTP address; give for example http://127.0.0.1:8000", is_input=True
            )
        # proxies of the environment are not for this machine
        key = ClientSettings().api_key if with_key else None
        self._http = httpx.Client(
            base_url=url,
            headers={} if key is None else {"Authorization": f"Bearer {key.get_secret_value()}"},
            timeout=_TIMEOUT,
            trust_env=parsed.host not in _LOOPBACK,
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._http.close()

    def cusp_table(
        self, request: Mapping[str, object], on_progress: Callable[[int, int], None]
    ) -> dict[str, Any]:
        """Post a request and wait for its table; `on_progress(done, total)` follows the job.

        An interrupt (Ctrl-C) withdraws the request.

        Raises:
            ServiceError: the service refused, failed, or cannot be reached.
        """
        answer = self._send("POST", "/v1/cusp-tables", json=dict(request), prefer=f"wait={_FIRST_WAIT}")
        if answer.status_code == 200:
            return _object(answer)
        job = _object(answer)
        try:
            return self._followed(job, on_progress)
        except KeyboardInterrupt:
            with suppress(ServiceError):
                self._send("DELETE", job["links"].get("cancel") or job["links"]["self"])
            raise

    def _followed(self, job: Mapping[str, Any], on_progress: Callable[[int, int], None]) -> dict[str, Any]:
        pause = 0.05
        while job["status"] in ("queued", "running"):
            on_progress(job["progress"]["done"], job["progress"]["total"])
            time.sleep(pause)
            pause = min(1.5 * pause, 0.5)
            job = _object(self._send("GET", job["links"]["self"]))
        on_progress(job["progress"]["done"], job["progress"]["total"])
        return _object(self._send("GET", job["links"]["result"]))

    def _send(
        self, method: str, path: str, *, json: object = None, prefer: str | None = None
    ) -> httpx.Response:
        """Send a request, with retries while the service is briefly unavailable."""
        headers = {"Accept": "application/json", **({"Prefer": prefer} if prefer else {})}
        for attempt in range(_TRIES):
            try:
                answer = self._http.request(method, path, json=json, headers=headers)
            except httpx.ConnectError as error:
                raise ServiceError(f"no service answers at {self.url}: {error}") from None
            except httpx.HTTPError as error:
                if attempt + 1 < _TRIES:
                    time.sleep(0.2 * 2**attempt)
                    continue
                raise ServiceError(f"{self.url}: {error or type(error).__name__}") from None
            if answer.status_code in (429, 503) and attempt + 1 < _TRIES:
                time.sleep(_retry_after(answer))
                continue
            break
        if answer.status_code >= 400:
            raise ServiceError(_detail(answer), is_input=answer.status_code < 500)
        return answer


def _object(answer: httpx.Response) -> dict[str, Any]:
    try:
        document = answer.json()
    except ValueError:
        document = None
    if not isinstance(document, dict):
        raise ServiceError(f"{answer.url} does not answer as an rpr-cusps service")
    return document


def _detail(answer: httpx.Response) -> str:
    try:
        document = answer.json()
        return str(document["detail"])
    except (ValueError, KeyError, TypeError):
        return f"{answer.url} answers {answer.status_code} {answer.reason_phrase}"


def _retry_after(answer: httpx.Response) -> float:
    value = answer.headers.get("retry-after", "")
    return min(10.0, float(value)) if value.isdigit() else 1.0
