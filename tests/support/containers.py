"""An installation by docker/compose.yaml, with Docker or Podman, in a copy of the files of its image."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from service.client import ServiceClient

ROOT = Path(__file__).parents[2]
SOURCES = ("docker", "pyproject.toml", "setup.py", "README.md", "LICENSE", "rpr_solver", "worker", "service")
PATIENCE = 180.0
MISSING = "needs Docker with Compose, or Podman with podman-compose"


@cache
def engine() -> tuple[str, ...] | None:
    """The engine that runs containers here and its command for Compose, or None."""
    if _works("docker", "info") and _works("docker", "compose", "version"):
        return "docker", "docker", "compose"
    if _works("podman", "info") and shutil.which("podman-compose"):
        return "podman", "podman-compose"
    return None


def _works(*command: str) -> bool:
    try:
        return subprocess.run(command, capture_output=True, check=False).returncode == 0
    except FileNotFoundError:
        return False


def called(command: Sequence[str], **options: Any) -> str:
    """Returns what a command writes to stdout; fails with what it says."""
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, f"{' '.join(command)}: {done.stdout[-2000:]}{done.stderr[-4000:]}"
    return done.stdout


@dataclass
class Installation:
    """The containers of one project of Compose.

    Attributes:
        folder: the copy of the files.
        project: the name of the project, in the names of all its containers.
        port: of the API, on this computer.
        key: an API key.
        more: further files for Compose, beside compose.yaml.
        workers: the number of ordinary workers.
    """

    folder: Path
    project: str
    port: int
    key: str = ""
    more: tuple[str, ...] = ()
    workers: int = 2

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    @property
    def environment(self) -> dict[str, str]:
        return {**os.environ, "COMPOSE_PROJECT_NAME": self.project, "API_PORT": str(self.port)}

    def engine(self, *words: str) -> str:
        """Call the engine; returns what it writes."""
        found = engine()
        assert found is not None
        return called([found[0], *words])

    def compose(self, *words: str) -> str:
        """Call Compose; returns what it writes."""
        found = engine()
        assert found is not None
        files = [word for file in ("docker/compose.yaml", *self.more) for word in ("-f", file)]
        return called([*found[1:], *files, *words], cwd=self.folder, env=self.environment)

    def up(self) -> None:
        """Start what is not running, replace what has changed, and wait until questions are answered."""
        self.compose("up", "-d", "--scale", f"worker={self.workers}")
        self.ready()

    def down(self, *words: str) -> None:
        """Stop and remove all containers; with `--volumes`, what they kept, too."""
        # podman-compose forgets the further ones of a service that was scaled; the others depend on Redis
        for name in sorted(self.names(), key=lambda name: "redis" in name):
            self.engine("stop", "-t", "15", name)
            self.engine("rm", "-f", name)
        self.compose("down", *words)

    def names(self, service: str = "") -> list[str]:
        """The names of the containers, or of those of a service; also of those that ended."""
        label = "label=com.docker.compose"
        filters = ["--filter", f"{label}.project={self.project}"]
        if service:
            filters += ["--filter", f"{label}.service={service}"]
        return self.engine("ps", "-a", "--format", "{{.Names}}", *filters).split()

    def inspect(self, name: str) -> dict[str, Any]:
        """What the engine says of a container or an image."""
        found: list[dict[str, Any]] = json.loads(self.engine("inspect", name))
        return found[0]

    def is_healthy(self, name: str) -> bool:
        """Whether the health check of a container passes now, however long it takes on a busy computer."""
        form, *words = self.inspect(name)["Config"]["Healthcheck"]["Test"]
        command = words if form == "CMD" else ["sh", "-c", *words]
        return _works((engine() or "")[0], "exec", name, *command)

    def ready(self) -> None:
        """Wait until every container is healthy."""
        end = time.monotonic() + PATIENCE
        while ill := [name for name in self.names() if not self.is_healthy(name)]:
            assert time.monotonic() < end, f"not healthy: {', '.join(ill)}"
            time.sleep(0.5)

    def kill(self, name: str) -> None:
        """End the processes of a container by SIGKILL, as from outside; its init then ends, too."""
        subprocess.run(
            [(engine() or "")[0], "exec", name, "sh", "-c", "kill -9 -1"], capture_output=True, check=False
        )

    def logs(self, name: str) -> list[str]:
        """The lines of a container's log, without remarks of the engine itself."""
        command = [(engine() or "")[0], "logs", name]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        return [line for line in (done.stdout + done.stderr).splitlines() if not line.startswith("time=")]

    def starts(self, name: str) -> str:
        """When a container was started last."""
        return str(self.inspect(name)["State"]["StartedAt"])

    def client(self) -> ServiceClient:
        """A client with the key."""
        os.environ["RPR_CUSPS_API_KEY"] = self.key
        try:
            return ServiceClient(self.url)
        finally:
            del os.environ["RPR_CUSPS_API_KEY"]


def copied(folder: Path, sources: Path = ROOT) -> Path:
    """Copy the files of the image; returns the folder."""
    for name in SOURCES:
        if (sources / name).is_dir():
            leave = shutil.ignore_patterns("__pycache__", "secrets")
            shutil.copytree(sources / name, folder / name, ignore=leave)
        else:
            shutil.copy(sources / name, folder / name)
    return folder
