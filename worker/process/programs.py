"""Our programs as child processes: started in full, or forked from one process that has loaded them all.

A program by itself takes most of a second to load what it needs, and each holds a copy of it. The template
loads it once, and forks a child for each request. It forks twice, so that the child is an orphan, whom its
subreaper adopts: the caller. Nothing but the next start depends on the template then, and without it, or on
a system without subreapers, programs are started in full.
"""

from __future__ import annotations

import contextlib
import gc
import json
import os
import select
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

from setproctitle import setproctitle

from worker.process.processes import adopt_orphans, die_with_parent

# Unlike `-m`, this does not import a directory with the name of a package from the current directory; and it
# collects no garbage while modules are loaded, which would take a tenth of the start.
_PROGRAM = (
    "import gc, importlib, sys; gc.disable(); sys.path.append(sys.argv.pop(1)); "
    "program = importlib.import_module(sys.argv.pop(1)); gc.enable(); sys.exit(program.main())"
)
COMPUTING = "worker.__main__"
"""The module of the program that needs the solver."""
_FEW_ARENAS = {"MALLOC_ARENA_MAX": "2"}
"""Or else glibc spreads what some forty threads need over one arena each, and its memory grows for hours."""
_FIRST_PATIENCE, _PATIENCE = 30.0, 3.0  # seconds until the template has loaded everything, or just forks
_MOST_BYTES = 1 << 17  # of a request; a message must fit into the buffer of a socket
_MOST_DESCRIPTORS = 8
_EARLY = b" early"  # not all is loaded yet
_MOMENT = 0.002


@dataclass(frozen=True)
class Program:
    """``main()`` of one of our modules as a process.

    Attributes:
        module: its name.
        arguments: of its command line. Where there are ``descriptors``, their numbers are appended.
        environment: all of it.
        descriptors: of open files that it inherits.
    """

    module: str
    arguments: Sequence[str] = ()
    environment: Mapping[str, str] = field(default_factory=lambda: dict(os.environ))
    descriptors: Sequence[int] = ()

    def start(self) -> Process:
        """Start it in full, in a session of its own: Ctrl-C on a terminal reaches the caller alone."""
        return subprocess.Popen(
            python_program(self.module, *self.arguments, *map(str, self.descriptors)),
            env={**_FEW_ARENAS, **self.environment},
            stdin=subprocess.DEVNULL,
            start_new_session=True,
            pass_fds=self.descriptors,
        )


def python_program(module: str, *arguments: str) -> list[str]:
    """Returns the command that runs `main` of one of our modules."""
    return [sys.executable, "-P", "-c", _PROGRAM, str(Path(__file__).parents[2]), module, *arguments]


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


Process = subprocess.Popen[Any] | Adopted
"""A process that was started in full, or forked for us."""

Start = Callable[[Program], Process]
Say = Callable[[str], object]


class Template:
    """The process that has loaded some programs; all calls must come from the thread that made it.

    Args:
        modules: those of the programs.
        say: reports that it is of no use any more.
    """

    def __init__(self, modules: Sequence[str], say: Say) -> None:
        self._say = say
        self._process: Process | None = None
        if not adopt_orphans():
            return
        self._control, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._control.settimeout(_FIRST_PATIENCE)
        with theirs, contextlib.suppress(OSError):
            arguments = ("--parent-pid", str(os.getpid()), *modules)
            self._process = Program(__name__, arguments, descriptors=(theirs.fileno(),)).start()

    def start(self, program: Program) -> Process:
        """Start a program, by a fork if that is possible."""
        if self._process is not None:
            try:
                return self._forked(program)
            except (OSError, ValueError) as error:
                self._say(f"cannot fork a loaded process ({error}); starting programs in full")
                self.close()
        return program.start()

    def processes(self) -> list[Process]:
        """The process of the template, while there is one."""
        return [] if self._process is None else [self._process]

    def close(self) -> None:
        """End the process; its children are ours."""
        if self._process is not None:
            self._control.close()
            self._process.kill()
            self._process.wait()
            self._process = None

    def _forked(self, program: Program) -> Process:
        request = json.dumps([program.module, list(program.arguments), dict(program.environment)]).encode()
        if len(request) > _MOST_BYTES:
            return program.start()
        socket.send_fds(self._control, [request], list(program.descriptors))
        pid, _, early = self._control.recv(32).partition(b" ")
        self._control.settimeout(_FIRST_PATIENCE if early else _PATIENCE)
        return Adopted(int(pid))


def main() -> int:
    """Load the programs, and fork one for each request until the caller is gone.

    One that computes nothing is forked as soon as it is loaded, while the solver is not yet.
    """
    _, parent, *modules, descriptor = sys.argv[1:]
    die_with_parent(int(parent))
    control = socket.socket(fileno=int(descriptor))
    setproctitle("rpr-cusps template")  # it finds its place only before the environment changes
    gc.disable()  # what is loaded is no garbage
    for module in modules:
        try:
            import_module(module)
        except ModuleNotFoundError:
            return 1  # started in full, the program says what it lacks
        is_asked_for = module != COMPUTING and _is_asked_for(control, module)
        if is_asked_for and (status := _answered(control, _EARLY)) is not None:
            return status
    import_module("worker.process.horse").load_solver()
    while (status := _answered(control)) is None:
        pass
    return status


def _is_asked_for(control: socket.socket, module: str) -> bool:
    """Whether a program is what the next request is for, if there is one."""
    if not select.select([control], [], [], 0)[0]:
        return False
    request = control.recv(_MOST_BYTES, socket.MSG_PEEK)
    return bool(request) and json.loads(request)[0] == module


def _answered(control: socket.socket, remark: bytes = b"") -> int | None:
    """Fork what the next request asks for; returns the status of the child, or 0 if the caller is gone."""
    request, descriptors, _, _ = socket.recv_fds(control, _MOST_BYTES, _MOST_DESCRIPTORS)
    if not request:
        return 0
    gc.freeze()
    reads, writes = os.pipe()
    if not (middle := os.fork()):
        os.close(reads)
        _leave_an_orphan(writes)
        os.close(writes)
        control.close()
        gc.enable()
        return _run(request, descriptors)
    for number in (writes, *descriptors):
        os.close(number)
    with open(reads, "rb") as answer:  # noqa: PTH123 - a descriptor
        pid = answer.read()
    os.waitpid(middle, 0)  # from now on the child is the caller's
    control.send(pid + remark)
    return None


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
