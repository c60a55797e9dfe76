"""Programs forked from one process that has loaded them all; to load them takes longer than most answers.

Such a program is as `python -m MODULE` or `python -c PROGRAM` after their imports, and what `serve` starts is
forked from what it has. Tests of how programs start have them start in full.

The template forks twice, so that the child is an orphan, whom its subreaper adopts: the caller.
"""

from __future__ import annotations

import atexit
import contextlib
import gc
import json
import os
import runpy
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from ctypes import CDLL
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any
from unittest.mock import patch

from setproctitle import setproctitle

from worker.limits import CONSTANT
from worker.process.processes import die_with_parent
from worker.process.programs import Program

ROOT = Path(__file__).parents[2]
_LOADED = (
    *("tests.support.template", "worker.process.worker", "service.stack.api_process", "service.stack.serve"),
    *("service.client", "service.cli.arguments", "service.cli.output", "rpr_solver.slices.cusp_table"),
)
_PATIENCE = 60.0  # seconds until the template has loaded everything
_MOST_BYTES = 1 << 17  # of a request; a message must fit into the buffer of a socket
_MOST_DESCRIPTORS = 8
_MOMENT = 0.002
_one_at_a_time = threading.Lock()
_start_in_full = Program.start


def _adopt_orphans() -> None:
    """Have this process become the parent of descendants whose parent ends."""
    CDLL(None).prctl(36, 1, 0, 0, 0)  # PR_SET_CHILD_SUBREAPER


class Adopted:
    """A child that another process forked for us."""

    def __init__(self, pid: int) -> None:
        self.pid = pid
        self._status: int | None = None

    def poll(self) -> int | None:
        """The exit status, negative for a signal; None while it runs."""
        if self._status is None:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            self._status = os.waitstatus_to_exitcode(status) if pid else None
        return self._status

    def wait(self, timeout: float | None = None) -> int:
        """The exit status, once there is one.

        Raises:
            subprocess.TimeoutExpired: there is none yet.
        """
        end = None if timeout is None else time.monotonic() + timeout
        while (status := self.poll()) is None:
            if end is not None and time.monotonic() > end:
                raise subprocess.TimeoutExpired(str(self.pid), timeout or 0.0)
            time.sleep(_MOMENT)
        return status

    def send_signal(self, sig: int) -> None:
        """Send a signal, unless the process has ended."""
        if self.poll() is None:
            os.kill(self.pid, sig)

    def terminate(self) -> None:
        """Send SIGTERM."""
        self.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        """Send SIGKILL."""
        self.send_signal(signal.SIGKILL)


class Template:
    """The process that has loaded some programs; all calls must come from the thread that made it."""

    def __init__(self, control: socket.socket, process: subprocess.Popen[Any] | Adopted) -> None:
        self._control, self._process = control, process
        control.settimeout(_PATIENCE)

    @classmethod
    def of(cls, root: Path) -> Template:
        """The template of a tree."""
        _adopt_orphans()
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        inherited = {name: value for name, value in os.environ.items() if not name.startswith("RPR_CUSPS_")}
        variables = {**inherited, "PYTHONPATH": str(root)}
        code = "import sys; from tests.support.template import serve_forks; sys.exit(serve_forks())"
        with theirs:
            process = subprocess.Popen(
                [sys.executable, "-c", code, str(os.getpid()), str(theirs.fileno())],
                env=variables,
                cwd=root,
                stdin=subprocess.DEVNULL,
                start_new_session=True,
                pass_fds=[theirs.fileno()],
            )
        return cls(ours, process)

    def start(self, program: Program) -> subprocess.Popen[Any] | Adopted:
        """Start a program by a fork."""
        parts = [program.module, list(program.arguments), dict(program.environment)]
        request = json.dumps(parts).encode()
        if len(request) > _MOST_BYTES:
            return _start_in_full(program)
        socket.send_fds(self._control, [request], list(program.descriptors))
        return Adopted(int(self._control.recv(32)))

    def close(self) -> None:
        """End the process; its children are ours."""
        self._control.close()
        self._process.kill()
        self._process.wait()


def serve_forks() -> int:
    """Load everything, and fork a program for each request until the caller is gone."""
    parent, descriptor = map(int, sys.argv[1:])
    die_with_parent(parent)
    for module in _LOADED:
        import_module(module)
    horse: Any = import_module("worker.process.horse")
    horse.load_solver()
    horse.NICENESS = 0  # a busy computer would leave nothing to them
    read_constants_from_the_environment()
    return _forks(socket.socket(fileno=descriptor))


def read_constants_from_the_environment() -> None:
    """Make settings of all constants: so tests give them to the processes that they start."""
    for model in import_module("service.cli.serve").models():
        for field in model.model_fields.values():
            field.metadata = [mark for mark in field.metadata if mark is not CONSTANT]


def _forks(control: socket.socket) -> int:
    """Fork what each request asks for; returns in the child its status, and 0 once the caller is gone."""
    setproctitle("template")  # it finds its place only before the environment changes
    gc.freeze()
    while True:
        request, descriptors, _, _ = socket.recv_fds(control, _MOST_BYTES, _MOST_DESCRIPTORS)
        if not request:
            return 0
        reads, writes = os.pipe()
        if not (middle := os.fork()):
            os.close(reads)
            _leave_an_orphan(writes)
            os.close(writes)
            control.close()
            return _run(request, descriptors)
        for number in (writes, *descriptors):
            os.close(number)
        with open(reads, "rb") as answer:  # noqa: PTH123 - a descriptor
            pid = answer.read()
        os.waitpid(middle, 0)  # from now on the child is the caller's
        control.send(pid)


def _leave_an_orphan(writes: int) -> None:
    """Fork again and end; returns in the child, once it is adopted."""
    middle = os.getpid()
    try:
        if pid := os.fork():
            os.write(writes, str(pid).encode())
            os._exit(0)
    except OSError:
        os._exit(1)
    while os.getppid() == middle:
        time.sleep(_MOMENT)


def _run(request: bytes, descriptors: Sequence[int]) -> int:
    module, arguments, environment = json.loads(request)
    os.setsid()
    os.environ.clear()
    os.environ.update(environment)
    sys.argv[1:] = [*arguments, *map(str, descriptors)]
    setproctitle(" ".join(["rpr-cusps", module, *sys.argv[1:]]))
    status: int = import_module(module).main()
    return status


@cache
def _template(root: Path) -> Template:
    """The template of a tree, for this process of pytest: it is the parent of what is forked."""
    made = Template.of(root)
    atexit.register(made.close)
    return made


def forked(program: Program, root: Path = ROOT) -> subprocess.Popen[Any] | Adopted:
    """Forks a program of a tree."""
    with _one_at_a_time:
        return _template(root).start(program)


@contextlib.contextmanager
def starts_forked() -> Iterator[None]:
    """What this process starts meanwhile is forked."""
    with patch.object(Program, "start", forked):
        yield


class Forked(subprocess.Popen[Any]):
    """A program of a tree, forked, with all that its parent can do with one that was started."""

    def __init__(self, root: Path, command: Sequence[str], **options: Any) -> None:
        self._root = root
        super().__init__(command, **options)

    def _execute_child(self, *given: Any) -> None:
        """What `Popen` does between the making of the pipes and their use."""
        command, directory, environment, pipes = (
            given[0],
            given[5],
            given[6] or dict(os.environ),
            given[10:16],
        )
        ends = enumerate((pipes[0], pipes[3], pipes[5]))
        streams = [os.dup(own if end == -1 else end) for own, end in ends]
        try:
            program = Program(__name__, [str(directory), *command[1:]], environment, streams)
            self._begun = forked(program, self._root)
        finally:
            for stream in streams:
                os.close(stream)
            self._close_pipe_fds(*pipes)  # type: ignore[attr-defined]
        self.pid, self._child_created = self._begun.pid, True


def main() -> int:
    """`DIRECTORY -m MODULE|-c PROGRAM [ARGUMENTS…]`, and the descriptors of the three streams."""
    directory, option, what, *arguments = sys.argv[1:-3]
    for number, descriptor in enumerate(map(int, sys.argv[-3:])):
        os.dup2(descriptor, number)
        os.close(descriptor)
    sys.stdin, sys.stdout = open(0), open(1, "w")  # noqa: SIM115
    sys.stderr = open(2, "w", buffering=1, errors="backslashreplace")  # noqa: SIM115
    signal.signal(signal.SIGINT, signal.default_int_handler)  # `nohup … &` has it ignored
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    os.chdir(directory)
    sys.argv = [option, *arguments]
    if any("serve" in word for word in (what, *arguments)) and (status := _own_template()) is not None:
        return status
    if option == "-m":
        runpy.run_module(what, run_name="__main__", alter_sys=True)
    else:
        exec(what, {"__name__": "__main__"})
    return 0


def _own_template() -> int | None:
    """Have what this process starts forked from what it has loaded; returns a fork's status, None here."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    me = os.getpid()
    if not (pid := os.fork()):
        ours.close()
        os.setsid()
        die_with_parent(me)
        return _forks(theirs)
    theirs.close()
    _adopt_orphans()
    template = Template(ours, Adopted(pid))
    Program.start = lambda program: template.start(program)  # type: ignore[assignment, method-assign, return-value]
    return None
