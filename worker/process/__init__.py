"""Processes of workers, and what the operating system gives them."""

from worker.process.processes import (
    die_with_parent,
    end_process,
    on_stop_signals,
    raise_file_limit,
    stop_signals_held,
    usable_cores,
    usable_memory,
)

__all__ = [
    "die_with_parent",
    "end_process",
    "on_stop_signals",
    "raise_file_limit",
    "stop_signals_held",
    "usable_cores",
    "usable_memory",
]
