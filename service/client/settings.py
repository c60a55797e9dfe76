"""Where a client connects, and with which key."""

from __future__ import annotations

from typing import Any

import httpx
from pydantic import Field, SecretStr
from pydantic_settings import BaseSettings, SettingsConfigDict

from service.errors import ServiceError

_LOOPBACK = ("127.0.0.1", "localhost", "::1")
_TIMEOUT = httpx.Timeout(60.0, connect=5.0)


class ClientSettings(BaseSettings):
    """What a client reads from the environment, since others can see a command line."""

    model_config = SettingsConfigDict(env_prefix="RPR_CUSPS_", frozen=True, extra="ignore")

    api_key: SecretStr | None = Field(default=None, description="API key that clients and `--url` send")


def connection(url: str, *, with_key: bool) -> dict[str, Any]:
    """Returns the arguments of an HTTP client.

    Raises:
        ServiceError: the URL is not an HTTP address.
    """
    try:
        parsed = httpx.URL(url)
    except (httpx.InvalidURL, TypeError) as error:
        raise ServiceError(f"{url!r} is not an address: {error}", is_input=True) from None
    if parsed.scheme not in ("http", "https") or not parsed.host:
        raise ServiceError(
            f"{url!r} is not an HTTP address; give for example http://127.0.0.1:8000", is_input=True
        )
    key = ClientSettings().api_key if with_key else None
    return {
        "base_url": url,
        "headers": {} if key is None else {"Authorization": f"Bearer {key.get_secret_value()}"},
        "timeout": _TIMEOUT,
        "trust_env": parsed.host not in _LOOPBACK,  # proxies of the environment are not for this machine
    }
