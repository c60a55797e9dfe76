"""Real processes: started, inspected, and ended with their test."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from tests.support.template import ROOT, Forked
from worker.connection import connect

T = TypeVar("T")

Process = subprocess.Popen[Any]

PROC = Path("/proc")
"""Where Linux tells of its processes."""

PATIENCE = 60.0
"""Seconds to wait for a condition: far more than it takes, even on a busy machine."""


@contextmanager
def started(
    command: Sequence[str], *, in_full: bool = False, tree: Path = ROOT, **options: Any
) -> Iterator[Process]:
    """A child process with the options of `Popen`, in a new session that ends with the block.

    One of our programs is forked from a process that has loaded those of the tree, unless it is to be started
    in full.
    """
    options = {"cwd": ROOT, "env": None, **options}
    with _signals_not_ignored():
        if sys.platform == "linux" and not in_full and _is_ours(command):
            process: Process = Forked(tree, command, **options)
        else:
            process = subprocess.Popen(command, start_new_session=True, **options)
    try:
        yield process
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
        process.wait(PATIENCE)
        for stream in (process.stdin, process.stdout, process.stderr):
            if stream is not None:
                stream.close()


def _is_ours(command: Sequence[str]) -> bool:
    """Whether it is `python -c` or `python -m` with a module of ours."""
    program, option, what, *_ = [*map(str, command), "", ""]
    ours = ("service", "worker", "tests")
    return program == sys.executable and (
        option == "-c" or (option == "-m" and what.partition(".")[0] in ours)
    )


def completed(
    command: Sequence[str], env: dict[str, str], stdin: str = "", patience: float = PATIENCE, **options: Any
) -> subprocess.CompletedProcess[str]:
    """Returns the outcome of a child process that ends by itself."""
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    with started(command, env=env, text=True, **pipes, **options) as process:
        out, err = process.communicate(stdin, timeout=patience)
    return subprocess.CompletedProcess(command, process.returncode, out, err)


@contextmanager
def _signals_not_ignored() -> Iterator[None]:
    """Children inherit ignored signals (SIGINT and SIGHUP by `nohup … &`), but no handlers."""
    interrupt = signal.signal(signal.SIGINT, signal.default_int_handler)
    hang_up = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, interrupt)
        signal.signal(signal.SIGHUP, hang_up)


@dataclass
class Workers:
    """Starts worker processes, and ends them with the test."""

    url: str
    log: Path
    processes: list[Process] = field(default_factory=list)
    root: Path = ROOT
    _running: ExitStack = field(default_factory=ExitStack)

    def start(self, duty: str = "all", **settings: object) -> Process:
        """Starts a worker and waits until it is ready; settings as in `WorkerSettings`."""
        return self.start_odd("worker", "--duty", duty, **settings)

    def start_odd(self, module: str, *arguments: str, **settings: object) -> Process:
        """Starts it by another module than `worker`."""
        name = f"test-{os.getpid()}-{len(self.processes)}-{time.monotonic_ns()}"
        variables = environment(**{"log_level": "WARNING", **settings})
        command = [sys.executable, "-m", module, *arguments, "--redis-url", self.url, "--name", name]
        with self.log.open("ab") as log:
            begun = started(command, tree=self.root, env=variables, stderr=log)
            process = self._running.enter_context(begun)
        self.processes.append(process)
        with connect(self.url) as client:
            until(lambda: client.hget(f"rq:worker:{name}", "state") == b"idle")
        return process

    def alive(self) -> list[Process]:
        """Those that have not ended."""
        return [process for process in self.processes if process.poll() is None]

    def stop(self) -> None:
        """End all workers in an orderly way."""
        with self._running:
            for process in self.processes:
                process.terminate()
            for process in self.processes:
                process.wait(PATIENCE)


def environment(**settings: object) -> dict[str, str]:
    """Returns the environment of a child process: these settings alone, and the path to the hard tasks."""
    inherited = {key: value for key, value in os.environ.items() if not key.startswith("RPR_CUSPS_")}
    paths = [*filter(None, [os.environ.get("PYTHONPATH")]), str(ROOT)]
    given = {f"RPR_CUSPS_{name.upper()}": str(value) for name, value in settings.items()}
    return {**inherited, "PYTHONPATH": os.pathsep.join(paths), **given}


def until(condition: Callable[[], T]) -> T:
    """Waits until a condition holds; returns its value."""
    end = time.monotonic() + PATIENCE
    while not (value := condition()):
        assert time.monotonic() < end, "the condition did not hold in time"
        time.sleep(0.02)
    return value


@contextmanager
def stopped(pid: int) -> Iterator[None]:
    """A process gets no processor meanwhile."""
    os.kill(pid, signal.SIGSTOP)
    try:
        yield
    finally:
        os.kill(pid, signal.SIGCONT)


def is_running(pid: int) -> bool:
    """Whether a process is running; a zombie is not."""
    if (PROC / "self").exists():  # `ps` costs a hundred times as much, and many tests wait for an end
        try:
            _, _, state = (PROC / str(pid) / "stat").read_text().rpartition(")")
        except (FileNotFoundError, ProcessLookupError):
            return False
        return state.split()[0] not in ("Z", "X")
    done = subprocess.run(["ps", "-o", "stat=", "-p", str(pid)], capture_output=True, text=True, check=False)
    return bool(done.stdout.strip()) and not done.stdout.strip().startswith("Z")


def descendants(pid: int) -> list[int]:
    """Returns the descendants of a process."""
    table = subprocess.run(["ps", "-eo", "pid=,ppid="], capture_output=True, text=True, check=True).stdout
    pairs = [(int(child), int(parent)) for child, parent in (line.split() for line in table.splitlines())]
    family = [pid]
    for parent in family:
        family += [child for child, its_parent in pairs if its_parent == parent]
    return [child for child in family[1:] if is_running(child)]
