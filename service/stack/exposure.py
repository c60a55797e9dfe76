"""Who can reach the service: on an address that other computers reach, it asks for keys."""

from __future__ import annotations

import ipaddress
import socket
import time

from redis.exceptions import RedisError

from service.api.access.key_store import KeyStore
from service.api.settings import KeysPolicy
from service.stack.errors import StackError
from worker.connection import connect
from worker.settings import WorkerSettings


def is_loopback(listener: socket.socket) -> bool:
    """Whether only this computer reaches the address of a listening socket."""
    return ipaddress.ip_address(listener.getsockname()[0].partition("%")[0]).is_loopback


def keys_policy(listener: socket.socket, asked: KeysPolicy, redis_url: str, where: str) -> KeysPolicy:
    """Returns whether the service asks for keys; `where` is the option that finds them, for the message.

    Raises:
        StackError: it would ask for keys, and there is none.
    """
    policy = "always" if asked == "auto" and not is_loopback(listener) else asked
    if policy == "always" and not _has_key(redis_url):
        raise StackError(
            f"on {listener.getsockname()[0]} the service asks for keys, and there is none yet: make one with "
            f"`rpr-cusps keys create NAME{where}`, or let everyone in with --insecure"
        )
    return policy


def _has_key(redis_url: str) -> bool:
    try:
        with connect(redis_url) as redis:
            keys = KeyStore(redis, WorkerSettings().key_prefix).all().values()
    except RedisError as error:
        raise StackError(f"cannot read the keys from Redis: {error}") from error
    return any(key.state(time.time()) == "valid" for key in keys)
