"""Redis with a password, a user or a certificate."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
import pytest
from redis import Redis

from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import PATIENCE, completed, descendants, environment, started, until
from tests.support.service_server import GEOMETRY
from tests.support.tls import Certificates, tls_front
from worker.connection import UnreachableError, check

SECRET = "open-sesame"
QUESTION = {"geometry": GEOMETRY, "l1": 14.98, "digits": 15}
USER = (
    *("on", f">{SECRET}", "resetkeys", "~cusps:*", "~rq:*", "resetchannels", "&rq:*"),
    *("+@all", "-@admin", "-@dangerous", "+info"),
)


@pytest.fixture
def user(redis: Redis) -> Iterator[str]:
    """A user of Redis who may do what docs/access.md says, and no more."""
    redis.execute_command("ACL", "SETUSER", "cusps", *USER)
    yield "cusps"
    redis.execute_command("ACL", "DELUSER", "cusps")


@pytest.fixture(scope="module")
def certificates(tmp_path_factory: pytest.TempPathFactory) -> Certificates:
    return Certificates(tmp_path_factory.mktemp("certificates"))


@pytest.fixture
def port(valkey: EmbeddedValkey, certificates: Certificates) -> Iterator[int]:
    """The port of the Redis with TLS."""
    with tls_front(valkey.url.removeprefix("unix://"), certificates) as number:
        yield number


def address(port: int, certificates: Certificates, user: str = "") -> str:
    files = {"ssl_ca_certs": "authority.pem", "ssl_certfile": "client.pem", "ssl_keyfile": "client.key"}
    query = "&".join(f"{name}={certificates[file]}" for name, file in files.items())
    return f"rediss://{user and f'{user}@'}127.0.0.1:{port}/0?{query}"


def test_tls_a_user_and_a_password_nobody_sees(
    user: str, port: int, certificates: Certificates, tmp_path: Path
) -> None:
    """Redis requires TLS with a client certificate, a user and a password. Service and worker run, and the
    password is in no command line and no log.
    """
    (tmp_path / "password").write_text(f"{SECRET}\n")
    variables = environment(
        redis_url=address(port, certificates, user),
        redis_password_file=tmp_path / "password",
        log_level="DEBUG",
    )
    log = tmp_path / "log"
    command = [sys.executable, "-m", "service", "serve", "--port", "0", "--workers", "1"]
    with log.open("wb") as out, started(command, env=variables, stdout=-1, stderr=out, text=True) as process:
        assert process.stdout is not None
        base = process.stdout.readline().split()[4]
        answer = httpx.post(
            f"{base}/v1/cusp-tables", json=QUESTION, headers={"Prefer": "wait=30"}, timeout=PATIENCE
        )
        assert answer.json()["slices"][0]["count"] == 6
        assert httpx.get(f"{base}/readyz").json()["status"] == "ready"
        for pid in (process.pid, *descendants(process.pid)):
            if os.path.exists(f"/proc/{pid}/cmdline"):  # noqa: PTH110
                assert SECRET not in Path(f"/proc/{pid}/cmdline").read_text()
        process.terminate()
        process.wait(PATIENCE)
    assert SECRET not in log.read_text()


@contextmanager
def served(variables: dict[str, str]) -> Iterator[str]:
    """`serve` without workers; gives its address."""
    command = [sys.executable, "-m", "service", "serve", "--port", "0", "--workers", "0"]
    with started(command, env=variables, stdout=-1, stderr=subprocess.DEVNULL, text=True) as process:
        assert process.stdout is not None
        yield process.stdout.readline().split()[4]
        process.terminate()
        process.wait(PATIENCE)


def test_the_password_and_a_key_are_replaced(
    user: str, redis: Redis, port: int, certificates: Certificates, tmp_path: Path
) -> None:
    """The password of Redis and an API key are replaced, as docs/operating.md says. The old ones hold until
    the new ones are in use, and are refused then. No request is refused in between.
    """
    file = tmp_path / "password"
    file.write_text(f"{SECRET}\n")
    variables = environment(redis_url=address(port, certificates, user), redis_password_file=file)

    def command(*words: str) -> subprocess.CompletedProcess[str]:
        return completed([sys.executable, "-m", "service", *words], variables)

    def answer(base: str, key: str) -> int:
        return httpx.get(f"{base}/v1/jobs", headers={"Authorization": f"Bearer {key}"}).status_code

    old = command("keys", "create", "rig").stdout.split()[-1]
    with served(variables) as base:
        assert answer(base, old) == 200
        new = command("keys", "create", "rig-2").stdout.split()[-1]
        until(lambda: answer(base, new) == 200)
        assert answer(base, old) == 200
        assert command("keys", "revoke", "rig").returncode == 0
        until(lambda: answer(base, old) == 401)

        redis.execute_command("ACL", "SETUSER", user, ">another")
        assert answer(base, new) == 200
        file.write_text("another\n")
        with served(variables) as second:
            assert answer(second, new) == 200
    redis.execute_command("ACL", "SETUSER", user, f"<{SECRET}")
    assert command("keys", "list").returncode == 0
    file.write_text(f"{SECRET}\n")
    refused = command("keys", "list")
    assert refused.returncode == 3
    assert SECRET not in refused.stderr


def test_a_password_is_not_taken_from_the_command_line() -> None:
    """The password of Redis is given on the command line. The command refuses, and names the settings for
    it."""
    for command in ("worker", "keys list"):
        url = f"redis://:{SECRET}@127.0.0.1:1/0"
        refused = completed(
            [sys.executable, "-m", "service", *command.split(), "--redis-url", url], environment()
        )
        assert refused.returncode == 2
        assert "RPR_CUSPS_REDIS_URL, or the password in the file" in refused.stderr
        assert SECRET not in refused.stderr


def test_a_server_with_the_wrong_certificate(
    port: int, certificates: Certificates, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Redis has a certificate of an unknown authority or for another name, or requires a client certificate.
    The connection is refused within 5 s, with the reason.
    """
    others = Certificates(tmp_path_factory.mktemp("others"))
    url = address(port, certificates)
    wrong = {
        url.replace(certificates["authority.pem"], others["authority.pem"]): "ssl_ca_certs=FILE",
        f"rediss://127.0.0.1:{port}/0": "ssl_ca_certs=FILE",
        f"rediss://127.0.0.1:{port}/0?ssl_ca_certs={certificates['authority.pem']}": "cannot reach Redis",
        url.replace("client.pem", "nothing.pem"): "cannot reach Redis",
        url.replace("127.0.0.1", "localhost"): "ssl_ca_certs=FILE",
    }
    for bad, reason in wrong.items():
        start = time.monotonic()
        with pytest.raises(UnreachableError, match=reason):
            check(bad)
        assert time.monotonic() - start < PATIENCE / 2  # whatever else the machine does
    check(url)


@pytest.mark.long
def test_a_tls_server_that_hangs() -> None:
    """Redis with TLS accepts connections, but does not answer. A start fails within 5 s, with the reason."""
    with socket.create_server(("127.0.0.1", 0)) as silent:
        start = time.monotonic()
        with pytest.raises(UnreachableError, match="cannot reach Redis"):
            check(f"rediss://127.0.0.1:{silent.getsockname()[1]}/0")
        assert time.monotonic() - start < PATIENCE / 2
