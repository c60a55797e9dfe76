from __future__ import annotations

import socket
from collections.abc import Iterator

import pytest
from redis import Redis

from worker.connection import UnreachableError, address, check, connect


@pytest.fixture
def port(redis: Redis) -> Iterator[int]:
    """A port on which the server listens, without TLS."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        number: int = free.getsockname()[1]
    redis.config_set("port", number)
    yield number
    redis.config_set("port", 0)


def test_a_server_that_answers(port: int) -> None:
    check(f"redis://127.0.0.1:{port}/3")


def test_a_server_without_tls_is_told(port: int) -> None:
    with pytest.raises(UnreachableError, match=r"cannot reach Redis: .*; perhaps it speaks no TLS"):
        check(f"rediss://127.0.0.1:{port}/0")


def test_a_wrong_password_is_told_but_not_shown(redis: Redis, port: int) -> None:
    redis.config_set("requirepass", "right")
    try:
        with pytest.raises(UnreachableError, match=r"cannot reach Redis: invalid username-password") as told:
            check(f"redis://:secret@127.0.0.1:{port}/0")
        assert "secret" not in str(told.value)
    finally:
        redis.config_set("requirepass", "")


@pytest.mark.parametrize("url", ["redis://h/notanumber", "rediss://h/0/1", "redis://user:12/secret@h/0"])
def test_a_database_is_a_number(url: str) -> None:
    with pytest.raises(ValueError, match=r"^the database in the address must be a number") as told:
        connect(url)
    assert "secret" not in str(told.value)


@pytest.mark.parametrize("url", ["redis://:secret#1@h/0", "redis://:secret/1@h/0", "redis://:secret?1@h/0"])
def test_an_address_that_cannot_be_read_is_not_shown(url: str) -> None:
    with pytest.raises(ValueError, match=r"is written %2F") as told:
        connect(url)
    assert "secret" not in str(told.value)


@pytest.mark.parametrize(
    ("url", "shown"),
    [
        ("redis://user:secret@h:1234/5", "redis://h:1234/5"),
        ("rediss://:secret@h", "rediss://h:6379/0"),
        ("redis://[::1]:7000/1?password=secret", "redis://[::1]:7000/1"),
        ("unix://user:secret@/run/v.sock?db=2", "unix:///run/v.sock?db=2"),
    ],
)
def test_an_address_is_shown_without_the_password(url: str, shown: str) -> None:
    with connect(url) as client:
        assert address(client) == shown
