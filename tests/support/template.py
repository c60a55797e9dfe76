"""Workers forked from one process that has loaded all they need; each by itself would take half a second.

After its imports such a worker is `python -m worker`. Tests of `serve`, of the pool and of the commands start
theirs in full.
"""

from __future__ import annotations

import atexit
import gc
import json
import os
import select
import signal
import socket
import subprocess
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import import_module

_MOST = 1 << 20  # bytes of a request: arguments and an environment


class Forked:
    """A process that another one forked for us, with the interface of `subprocess.Popen`."""

    def __init__(self, pid: int, ending: int) -> None:
        self.pid = pid
        self.returncode: int | None = None
        self._ending = ending

    def poll(self) -> int | None:
        return self._look(0)

    def wait(self, timeout: float | None = None) -> int:
        code = self._look(timeout)
        if code is None:
            raise subprocess.TimeoutExpired(str(self.pid), timeout or 0)
        return code

    def send_signal(self, number: int) -> None:
        if self.poll() is None:
            os.kill(self.pid, number)

    def terminate(self) -> None:
        self.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        self.send_signal(signal.SIGKILL)

    def _look(self, timeout: float | None) -> int | None:
        if self.returncode is None and select.select([self._ending], [], [], timeout)[0]:
            self.returncode = int(os.read(self._ending, 16))  # nothing: the template itself is dead
            os.close(self._ending)
        return self.returncode


class Template:
    """The process that has loaded a worker, as those see it that have it forked."""

    def __init__(self, environment: Mapping[str, str], directory: str) -> None:
        self._control, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        command = [sys.executable, "-m", __name__, str(theirs.fileno())]
        with theirs:
            self._process = subprocess.Popen(
                command,
                env=dict(environment),
                cwd=directory,
                stdin=subprocess.DEVNULL,
                start_new_session=True,
                pass_fds=[theirs.fileno()],
            )

    def fork(self, arguments: Sequence[str], environment: Mapping[str, str], stderr: int) -> Forked:
        """Returns a new worker in a session of its own."""
        ending, theirs = os.pipe()
        request = json.dumps([list(arguments), dict(environment)]).encode()
        assert len(request) < _MOST
        try:
            socket.send_fds(self._control, [request], [stderr, theirs])
        finally:
            os.close(theirs)
        return Forked(int(self._control.recv(16)), ending)

    def close(self) -> None:
        """End the process; workers that it forked are left to those who asked for them."""
        self._control.close()
        self._process.wait()


@cache
def template(directory: str) -> Template:
    """The template of this process of pytest."""
    inherited = {name: value for name, value in os.environ.items() if not name.startswith("RPR_CUSPS_")}
    made = Template(inherited, directory)
    atexit.register(made.close)
    return made


def main() -> int:
    """Load a worker, and fork one for each request until nobody is left to ask."""
    control = socket.socket(fileno=int(sys.argv[1]))
    program = import_module("worker.__main__")
    import_module("worker.process.horse").load_solver()
    gc.freeze()
    woken, wakes = os.pipe()
    os.set_blocking(wakes, False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    signal.set_wakeup_fd(wakes)
    endings: dict[int, int] = {}
    while True:
        ready, _, _ = select.select([control, woken], [], [])
        if woken in ready:
            os.read(woken, 1 << 10)
            _reap(endings)
        if control not in ready:
            continue
        request, descriptors, _, _ = socket.recv_fds(control, _MOST, 2)
        if not request:
            return 0
        stderr, ending = descriptors
        if pid := os.fork():
            os.close(stderr)
            endings[pid] = ending
            control.send(str(pid).encode())
            continue
        control.close()
        for fd in (ending, woken, wakes, *endings.values()):
            os.close(fd)
        _become(*json.loads(request), stderr)
        status: int = program.main()
        return status


def _reap(endings: dict[int, int]) -> None:
    while endings:
        pid, status = os.waitpid(-1, os.WNOHANG)
        if not pid:
            return
        with os.fdopen(endings.pop(pid), "w") as ending:
            ending.write(str(os.waitstatus_to_exitcode(status)))


def _become(arguments: Sequence[str], environment: Mapping[str, str], stderr: int) -> None:
    """Be a process of one's own, as if it had just been started with these arguments."""
    os.setsid()
    signal.set_wakeup_fd(-1)
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # `nohup … &` has it ignored
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    os.environ.clear()
    os.environ.update(environment)
    os.dup2(stderr, 2)
    os.close(stderr)
    sys.argv[1:] = arguments


if __name__ == "__main__":
    sys.exit(main())
