from __future__ import annotations

import socket
from collections.abc import Iterator

import pytest
from redis import Redis
from redis import exceptions as errors
from redis._parsers.base import BaseParser

from worker.connection import UnreachableError, address, check, connect, is_refusal


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
        with pytest.raises(UnreachableError, match="file that RPR_CUSPS_REDIS_PASSWORD_FILE names"):
            check(f"redis://127.0.0.1:{port}/0")
    finally:
        redis.config_set("requirepass", "")


@pytest.mark.parametrize("url", ["redis://h/notanumber", "rediss://h/0/1", "redis://user:12/secret@h/0"])
def test_a_database_is_a_number(url: str) -> None:
    with pytest.raises(ValueError, match=r"^the database in the URL must be a number") as told:
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


@pytest.mark.parametrize(
    ("text", "refused"),
    [
        ("MISCONF Redis is configured to save RDB snapshots", True),
        ("OOM command not allowed when used memory > 'maxmemory'", True),
        ("LOADING Redis is loading the dataset in memory", True),
        ("ERR Error running script (call to f_1): @user_script:9: @user_script: 9: -MISCONF Redis", True),
        ("ERR unknown command 'SET', with args beginning with: 'cusps:trial' '1'", True),
        ("ERR Script attempted to access a non local key in a cluster node script: f_1, on line 1.", True),
        ("ERR value is not an integer or out of range", False),
        ("NOSCRIPT No matching script.", False),
    ],
)
def test_what_is_a_refusal(text: str, refused: bool) -> None:
    error = BaseParser.parse_error(text)
    assert is_refusal(error) == refused
    error.args = (f"Command # 1 (SET x READONLY 1) of pipeline caused error: {error.args[0]}",)
    assert is_refusal(error) == refused


def test_a_server_that_is_away_or_hangs_refuses_and_a_wrong_argument_is_ours() -> None:
    assert is_refusal(errors.ConnectionError("refused"))
    assert is_refusal(errors.TimeoutError("timed out"))
    assert not is_refusal(errors.DataError("a set"))
    assert not is_refusal(ValueError("x"))
