"""A child process that is kept running: started again, after growing delays, whenever it ends or hangs."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from worker.process.os_limits import signal_name

Process = subprocess.Popen[bytes]
Say = Callable[[str], object]

_HEALTHY = 30.0  # seconds after which a process is healthy and its earlier deaths are forgotten
_LONGEST_DELAY = 10.0
_START_PATIENCE = 60.0  # seconds until the first sign of life, while a whole machine may be starting
_BLINK = 2.0  # if more lies between two looks, it was the observer that stood still
_LAST_PATIENCE = 2.0

# Unlike `-m`, this does not import a directory with the name of a package from the current directory; and it
# seeks no garbage in what is loaded, which would take a tenth of the start.
_PROGRAM = (
    "import gc, importlib, sys; gc.disable(); sys.path.append(sys.argv.pop(1)); "
    "program = importlib.import_module(sys.argv.pop(1)); gc.enable(); sys.exit(program.main())"
)


def python_program(module: str, *arguments: str) -> list[str]:
    """Returns the command that runs `main` of one of our modules."""
    return [sys.executable, "-P", "-c", _PROGRAM, str(Path(__file__).parents[2]), module, *arguments]


class Child:
    """A process, judged by its signs of life, not by the process table alone.

    Whatever goes wrong in starting it is told, and tried again. Processes that end with the thread that
    started them need all calls in one thread.
    """

    def __init__(self, what: str, launch: Callable[[], Process], say: Say, patience: float) -> None:
        self.what = what
        self.process: Process | None = None
        self._launch, self._say, self._patience = launch, say, patience
        self._started = self._looked = time.monotonic()
        self._judged_from = 0.0
        self._failures = 0
        self._next_start = 0.0
        self._told = ""
        self._is_killed = False

    def start(self) -> None:
        """Start the process; if that fails, a later look tries again."""
        try:
            process = self._launch()
        except Exception as error:  # whatever it is, it may be over in a moment
            why = "out of memory" if isinstance(error, MemoryError) else error
            if (text := f"cannot start {self.what}: {why}; trying again") != self._told:
                self._say(text)
            self._told = text
            self._delay(is_repeated=True)
        else:
            self.adopt(process)

    def adopt(self, process: Process) -> None:
        """Look after a process that was started elsewhere."""
        self.process, self._started = process, time.monotonic()
        self._is_killed, self._told = False, ""

    def look_after(self, sign: float | None, lost: str | None = None) -> None:
        """Start the process again if it has ended, and kill it if it hangs; takes no time.

        `sign` is when it last did its work (`time.monotonic()`, 0 for not yet), None if nobody can tell at
        present; `lost` says why it can do it no longer, if it ever did.
        """
        now = time.monotonic()
        if now - self._looked > _BLINK:
            self._judged_from = now
        self._looked = now
        if self.process is not None and (code := self.process.poll()) is not None:
            self._note_end(code)
        elif self.process is not None and not self._is_killed and (reason := self._fault(sign, lost)):
            self._say(f"{self.what} {reason}; starting another")
            self.process.kill()
            self._is_killed = True
        if self.process is None and now >= self._next_start:
            self.start()

    def _fault(self, sign: float | None, lost: str | None) -> str | None:
        if sign is None:
            return None
        if lost and sign > self._started:
            return lost
        patience = self._patience if sign > self._started else max(_START_PATIENCE, self._patience)
        silence = time.monotonic() - max(sign, self._started, self._judged_from)
        return f"gives no sign of life for {silence:.0f} s" if silence > patience else None

    def _note_end(self, code: int) -> None:
        if not self._is_killed:
            how = signal_name(-code) if code < 0 else f"exit status {code}"
            self._say(f"{self.what} died ({how}); starting another")
        self.process = None
        self._delay(is_repeated=time.monotonic() - self._started <= _HEALTHY)

    def _delay(self, *, is_repeated: bool) -> None:
        self._failures = self._failures + 1 if is_repeated else 1
        exponent = min(self._failures, 10) - 2
        pause = min(_LONGEST_DELAY, 2.0**exponent) if exponent >= 0 else 0.0
        self._next_start = time.monotonic() + pause if pause else 0.0


def end_all(
    processes: Sequence[tuple[Process, float]], is_hurried: Callable[[], bool] = lambda: False
) -> None:
    """Ask processes to end, and kill each after its patience in seconds; in a hurry, after one second."""
    for process, _ in processes:
        _ask_to_end(process)
    start, end_of_hurry = time.monotonic(), float("inf")
    left = list(processes)
    while left:
        now = time.monotonic()
        if is_hurried() and end_of_hurry == float("inf"):
            end_of_hurry = now + 1.0
            for process, _ in left:
                _ask_to_end(process)
        for process, patience in left:
            if now > min(start + patience, end_of_hurry):
                process.kill()
                with contextlib.suppress(
                    subprocess.TimeoutExpired
                ):  # the kernel keeps it until a disk answers
                    process.wait(_LAST_PATIENCE)
        left = [(p, patience) for p, patience in left if p.poll() is None and now <= start + patience]
        time.sleep(0.01)


def _ask_to_end(process: Process) -> None:
    process.terminate()
    process.send_signal(signal.SIGCONT)  # a stopped process does not hear the other signal
