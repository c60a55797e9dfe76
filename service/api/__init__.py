"""The HTTP API."""

from service.api.settings import KeysPolicy, Settings, read_prefix

__all__ = [
    "KeysPolicy",
    "Settings",
    "read_prefix",
]
