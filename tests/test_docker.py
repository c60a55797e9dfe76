from __future__ import annotations

import os
import re
import stat
import subprocess
from pathlib import Path
from typing import Any

import pytest
import yaml

from service.cli.serve import unknown_settings

DOCKER = Path(__file__).parents[1] / "docker"


@pytest.fixture(scope="module")
def compose() -> dict[str, Any]:
    found: dict[str, Any] = yaml.safe_load((DOCKER / "compose.yaml").read_text())
    return found


def test_only_the_api_is_published_and_only_here(compose: dict[str, Any]) -> None:
    ports = {name: service["ports"] for name, service in compose["services"].items() if "ports" in service}
    assert ports == {"api": ["127.0.0.1:${API_PORT:-8000}:8000"]}


def test_everything_is_contained(compose: dict[str, Any]) -> None:
    for service in compose["services"].values():
        assert service["read_only"] is True
        assert service["cap_drop"] == ["ALL"]
        assert service["security_opt"] == ["no-new-privileges:true"]
        assert {"mem_limit", "cpus"} <= service.keys()
    assert compose["services"]["redis"]["user"].startswith("999:"), "the others: as in the image"
    assert compose["networks"]["inside"] == {"internal": True}


def test_the_queue_is_durable_and_forgets_nothing(compose: dict[str, Any]) -> None:
    *_, program = compose["services"]["redis"]["command"]
    assert "--appendonly yes" in program
    assert "--maxmemory-policy noeviction" in program
    assert compose["services"]["redis"]["volumes"]


def test_the_password_is_a_file_and_on_no_command_line(compose: dict[str, Any], tmp_path: Path) -> None:
    shell, option, program = compose["services"]["redis"]["command"]
    (tmp_path / "password").write_text("secret\n")
    program = program.replace("$$", "$").replace("/run/secrets/redis_password", str(tmp_path / "password"))
    program = program.replace("/tmp/valkey.conf", str(tmp_path / "conf")).replace(
        "exec valkey-server", "echo"
    )
    done = subprocess.run([shell, option, program], capture_output=True, text=True, check=True)
    assert "secret" not in done.stdout
    assert (tmp_path / "conf").read_text() == "requirepass secret\n"
    assert (tmp_path / "conf").stat().st_mode & 0o777 == 0o600
    for name in ("api", "worker"):
        environment = compose["services"][name]["environment"]
        assert environment["RPR_CUSPS_REDIS_PASSWORD_FILE"] == "/run/secrets/redis_password"
        assert not list(unknown_settings(environment))


@pytest.mark.parametrize("mask", [0o022, 0o077, 0o000])
@pytest.mark.parametrize("user", [0, 65534])
def test_the_password_can_be_read_in_the_containers_and_by_no_other_user(
    compose: dict[str, Any], tmp_path_factory: pytest.TempPathFactory, user: int, mask: int
) -> None:
    if os.geteuid() != 0:
        if user == 0:
            pytest.skip("needs root")
        user = os.geteuid()
    work = tmp_path_factory.mktemp("work")
    (work / "docker").mkdir()
    for path in (work, work / "docker"):
        os.chown(path, user, user)
        path.chmod(0o755)
    head = re.findall(r"^#   (?!docker compose)(.*)$", (DOCKER / "compose.yaml").read_text(), re.MULTILINE)
    assert len(head) == 2
    subprocess.run(["sh", "-ec", "\n".join(head)], cwd=work, user=user, umask=mask, check=True)

    file = work / "docker" / compose["secrets"]["redis_password"]["file"]
    ignored = (DOCKER.parent / ".gitignore").read_text().splitlines()
    assert f"{file.parent.relative_to(work)}/" in ignored
    assert stat.S_IMODE(file.parent.stat().st_mode) == 0o700
    assert stat.S_IMODE(file.stat().st_mode) == 0o444, "whatever user a container has"
    assert re.fullmatch("[0-9a-f]{64}\n", file.read_text())
    if os.geteuid() == 0:
        with file.open() as secret:  # opened again as the file alone, without its directories, as a mount is
            read = ["cat", f"/proc/self/fd/{secret.fileno()}"]
            for uid, group in ((999, 1000), (999, 999)):
                options = {"user": uid, "group": group, "extra_groups": [], "pass_fds": [secret.fileno()]}
                subprocess.run(read, check=True, stdout=subprocess.DEVNULL, **options)  # type: ignore[call-overload]


def test_everything_that_the_image_copies_exists() -> None:
    ignored = (DOCKER / "Dockerfile.dockerignore").read_text().splitlines()
    sent = {line.removeprefix("!") for line in ignored if line.startswith("!")}
    for line in re.findall(r"^COPY (?!--from)(.*)$", (DOCKER / "Dockerfile").read_text(), re.MULTILINE):
        for source in line.split()[:-1]:
            assert {source, source.split("/")[0]} & sent
            assert (DOCKER.parent / source).exists(), f"{source} is copied but is not there"
