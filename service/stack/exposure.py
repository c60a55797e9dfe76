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


def keys_policy(listener: socket.socket, asked: KeysPolicy) -> KeysPolicy:
    """Returns whether the service asks for keys."""
    return "always" if asked == "auto" and not is_loopback(listener) else asked


def check_keys(listener: socket.socket, redis_url: str, where: str) -> None:
    """Have a service that asks for keys have one; `where` is the option that finds them, for the message.

    Raises:
        StackError: there is none.
    """
    try:
        with connect(redis_url) as redis:
            keys = KeyStore(redis, WorkerSettings().key_prefix).all().values()
    except RedisError as error:
        raise StackError(f"cannot read the keys from Redis: {error}") from error
    if not any(key.state(time.time()) == "valid" for key in keys):
        raise StackError(
            f"on {listener.getsockname()[0]} the service asks for keys, and there is none yet: make one with "
            f"`rpr-cusps keys create NAME{where}`, or let everyone in with --insecure"
        )
