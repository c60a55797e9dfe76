from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

DOCKER = Path(__file__).parents[1] / "docker"


@pytest.fixture(scope="module")
def compose() -> dict[str, Any]:
    found: dict[str, Any] = yaml.safe_load((DOCKER / "compose.yaml").read_text())
    return found


def test_only_the_api_is_published_and_only_here(compose: dict[str, Any]) -> None:
    ports = {name: service["ports"] for name, service in compose["services"].items() if "ports" in service}
    assert ports == {"api": ["127.0.0.1:8000:8000"]}


def test_all_is_started_in_order_and_given_time_to_stop(compose: dict[str, Any]) -> None:
    services = compose["services"]
    assert set(services) == {"redis", "api", "worker"}
    for name, service in services.items():
        assert "stop_grace_period" in service
        if name != "redis":
            assert service["depends_on"]["redis"]["condition"] == "service_healthy"
            assert service["image"] == "rpr-cusps"


def test_the_queue_is_durable_and_forgets_nothing(compose: dict[str, Any]) -> None:
    command = compose["services"]["redis"]["command"]
    assert "--appendonly yes" in command
    assert "--maxmemory-policy noeviction" in command
    assert compose["services"]["redis"]["volumes"]


def test_the_healthcheck_of_the_worker_is_a_program(compose: dict[str, Any]) -> None:
    *_, program = compose["services"]["worker"]["healthcheck"]["test"]
    compile(program, "healthcheck", "exec")


def test_the_image_installs_from_the_constraints_and_is_not_run_by_root() -> None:
    text = (DOCKER / "Dockerfile").read_text()
    stages = text.split("FROM python:")[1:]
    assert len(stages) == 2
    assert len({stage.split()[0] for stage in stages}) == 1, "both stages have the same base"
    assert "--constraint constraints.txt" in stages[0]
    assert re.search(r"^USER 999:999$", stages[1], re.MULTILINE)
    assert "HEALTHCHECK" in stages[1]


def test_everything_that_the_image_copies_exists() -> None:
    ignored = (DOCKER / "Dockerfile.dockerignore").read_text().splitlines()
    sent = {line.removeprefix("!") for line in ignored if line.startswith("!")}
    for line in re.findall(r"^COPY (?!--from)(.*)$", (DOCKER / "Dockerfile").read_text(), re.MULTILINE):
        for source in line.split()[:-1]:
            assert source.split("/")[0] in sent
            assert (DOCKER.parent / source).exists(), f"{source} is copied but is not there"
