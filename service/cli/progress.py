"""The progress of a computation, on stderr if that is a terminal."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import rpr_solver
from rpr_solver.contract import silent


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
    from rich.console import Console  # only a terminal needs it, and a start is to be quick
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
