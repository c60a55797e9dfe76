"""Text on stdout and stderr, whatever these are: not UTF-8, full, or closed; and progress on a terminal."""

from __future__ import annotations

import codecs
import io
import os
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import TextIO

import rpr_solver
from rpr_solver.contract import silent

_SPELLED = {
    "α": "alpha",
    "θ": "theta",
    "ω": "omega",
    "∞": "inf",
    "→": "->",
    "…": "...",
    "·": "*",
    "√": "sqrt",
    "−": "-",
    "–": "-",
    "±": "+-",
    "≤": "<=",
    "≥": ">=",
    "≠": "!=",
    "×": "x",
    "°": " deg",
    "²": "^2",
    "³": "^3",
    "ℚ": "Q",
    "ℤ": "Z",
    "ℝ": "R",
    "’": "'",
}
_ERRORS = "rpr-cusps.spelled"
_SERVICES = ("rpr-cusps serve", "rpr-cusps worker")


class OutputError(Exception):
    """What the command prints cannot be written; the message is for the user."""


def spelled(text: str) -> str:
    """Returns text in ASCII, with mathematical signs in words.

    >>> spelled("θ1 → ∞")
    'theta1 -> inf'
    """
    return "".join(c if c.isascii() else _SPELLED.get(c) or _escaped(c) for c in text)


def prepare() -> None:
    """Let stdout and stderr take every character: what their encoding lacks is spelled out."""
    codecs.register_error(_ERRORS, _spell)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=_ERRORS)


def is_unicode(stream: TextIO) -> bool:
    """Whether a stream can take every character."""
    return (getattr(stream, "encoding", None) or "utf-8").lower().startswith("utf")


def stdout() -> TextIO:
    """Returns the stream.

    Raises:
        OutputError: it is closed.
    """
    if sys.stdout is None:
        raise OutputError("stdout is closed; nothing can be printed")
    return sys.stdout


def write(text: str) -> None:
    """Print text as it is.

    Raises:
        OutputError: it cannot be written.
    """
    try:
        stdout().writelines(text.splitlines(keepends=True))
    except BrokenPipeError:
        raise
    except OSError as error:
        raise _cannot(error) from None


def columns(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yields rows as lines, in columns as wide as their widest cell."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        yield "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()


def write_columns(rows: Sequence[Sequence[str]]) -> None:
    """Print rows in columns.

    Raises:
        OutputError: it cannot be written.
    """
    write("".join(line + "\n" for line in columns(rows)))


def flush() -> None:
    """Hand over all that was printed.

    Raises:
        OutputError: it cannot be written.
    """
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        raise _cannot(error) from None


@contextmanager
def unbroken() -> Iterator[None]:
    """Hold back a first Ctrl-C until the block has ended, so that no line is cut; a second one ends it."""
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    presses = 0

    def count(_number: int, _frame: FrameType | None) -> None:
        nonlocal presses
        presses += 1
        if presses > 1:
            raise KeyboardInterrupt

    signal.signal(signal.SIGINT, count)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if presses:
        raise KeyboardInterrupt


def discard() -> None:
    """Keep the interpreter's last flush from failing too."""
    if sys.stdout is not None:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def say(text: str) -> None:
    """Print a line for people on stderr, if there is one; that of a service is a line of its log."""
    program, _, message = text.partition(": ")
    if program in _SERVICES:
        from worker.logs import program_line

        text = program_line(program, message)
    if sys.stderr is not None:
        print(text, file=sys.stderr, flush=True)


def _cannot(error: OSError) -> OutputError:
    return OutputError(f"cannot write to stdout: {error.strerror}")


def _spell(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(spelled, error.object[error.start : error.end])), error.end


def _escaped(character: str) -> str:
    return character.encode("ascii", "backslashreplace").decode()


@dataclass
class Stages:
    """Progress that never runs backwards: where the known work grows, a new stage begins.

    >>> stages = Stages()
    >>> [stages.at(*p) for p in ((0, 1), (4, 6), (53, 54), (45, 491), (46, 491))]
    [(1, 0, 1), (1, 4, 6), (1, 53, 54), (2, 45, 491), (2, 46, 491)]
    """

    number: int = 1
    _done: int = 0
    _total: int = 1

    def at(self, done: int, total: int) -> tuple[int, int, int]:
        """Returns the stage, and its progress."""
        if done * self._total < self._done * total:
            self.number += 1
        self._done, self._total = done, total
        return self.number, done, total


@contextmanager
def progress_bar(
    total: int, what: str = "slices", *, is_streamed: bool = False
) -> Iterator[rpr_solver.Progress]:
    """A progress bar; gives the callback that moves it.

    Results that are streamed to a terminal show the progress themselves, and a bar would cut their lines.
    """
    shown = sys.stderr is not None and sys.stderr.isatty()
    if not shown or (is_streamed and sys.stdout is not None and sys.stdout.isatty()):
        yield silent
        return
    from rich.console import Console  # only a terminal needs it, and the start must be quick
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    bar = Progress(
        *(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()),
        console=Console(stderr=True),
        transient=True,
        redirect_stdout=False,  # it would go to stderr
    )
    with bar as progress:
        task = progress.add_task(what, total=total)
        stages = Stages()

        def move(done: int, total: int) -> None:
            stage, completed, of = stages.at(done, total)
            name = what if stage == 1 else f"{what}, stage {stage}"
            progress.update(task, description=name, completed=completed, total=of)

        yield move
