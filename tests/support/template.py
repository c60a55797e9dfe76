"""Programs forked from one process that has loaded them all; to load them takes longer than most answers.

Such a program is as `python -m MODULE` or `python -c PROGRAM` after their imports, and `serve` forks what it
starts from what it has. Tests of how programs start have them start in full.
"""

from __future__ import annotations

import atexit
import os
import runpy
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any
from unittest.mock import patch

from worker.process import programs
from worker.process.processes import adopt_orphans
from worker.process.programs import Adopted, Process, Program, Say, Template

ROOT = Path(__file__).parents[2]
_LOADED = (
    *("tests.support.template", "worker.process.worker", "service.stack.api_process", "service.stack.serve"),
    *("service.client", "service.cli.arguments", "service.cli.output", "rpr_solver.slices.cusp_table"),
)
_one_at_a_time = threading.Lock()


@cache
def _template(root: Path) -> Template:
    """The template of a tree, for this process of pytest: it is the parent of what is forked."""
    variables = {name: value for name, value in os.environ.items() if not name.startswith("RPR_CUSPS_")}
    with patch.dict(os.environ, {**variables, "PYTHONPATH": str(root)}, clear=True):
        made = Template(_LOADED, print)
    atexit.register(made.close)
    return made


def forked(program: Program, root: Path = ROOT) -> Process:
    """Forks a program of a tree."""
    with _one_at_a_time:
        return _template(root).start(program)


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
    """Give this process a template that has loaded the same; returns the status of that one, None here."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    me = os.getpid()
    if not (pid := os.fork()):
        ours.close()
        os.setsid()
        sys.argv[1:] = ["--parent-pid", str(me), str(theirs.fileno())]
        return programs.main()
    theirs.close()
    adopt_orphans()

    def take_it(self: Template, _modules: Sequence[str], say: Say) -> None:
        self._say, self._control, self._process = say, ours, Adopted(pid)

    Template.__init__ = take_it  # type: ignore[method-assign]
    return None
