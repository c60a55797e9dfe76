"""Log lines: the same form in all processes, each with the request or the job that it belongs to."""

from __future__ import annotations

import atexit
import json
import logging
import os
import queue
import sys
import threading
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from datetime import UTC, datetime
from logging.handlers import QueueHandler, QueueListener
from types import MappingProxyType, TracebackType
from typing import Any, Literal, TextIO, cast

LogFormat = Literal["text", "json"]

_WAITING_LINES = 10_000
_LAST_LINES_PATIENCE = 2.0

_subject: ContextVar[Mapping[str, str]] = ContextVar("subject", default=MappingProxyType({}))


@contextmanager
def about(**fields: str) -> Iterator[None]:
    """Give these fields to every line that is logged in the block; empty ones are left out."""
    token = _subject.set({**_subject.get(), **{name: value for name, value in fields.items() if value}})
    try:
        yield
    finally:
        _subject.reset(token)


def subject(name: str) -> str:
    """Returns a field of the lines that are logged here, or an empty text."""
    return _subject.get().get(name, "")


def set_up(level: str, form: LogFormat, *, in_background: bool = False) -> None:
    """Send all log lines of this process to stderr.

    With `in_background`, a thread writes them, so that logging never waits for the reader of stderr; if that
    reader hangs, lines are dropped and counted. A process that forks must not use it.
    """
    handler: logging.Handler = _Background(sys.stderr) if in_background else logging.StreamHandler()
    handler.setFormatter(_formatter(form))
    logging.basicConfig(level=level, handlers=[handler])


def line(logger: str, message: str, form: LogFormat, level: int = logging.WARNING) -> str:
    """Returns a warning as it would be logged, for a process that writes its few lines itself."""
    return _formatter(form).format(_record(logger, message, level))


def asked_form() -> LogFormat:
    """Returns the form that the environment asks for; settings may not be read yet, or be wrong."""
    return "json" if os.environ.get("RPR_CUSPS_LOG_FORMAT", "").strip().lower() == "json" else "text"


def program_line(program: str, message: str, level: int = logging.ERROR) -> str:
    """Returns what a program says of itself: `rpr-cusps serve: MESSAGE`, or an object if it is asked for."""
    if asked_form() == "text":
        return f"{program}: {message}"
    return line(f"rpr_cusps.{program.split()[-1]}", message, "json", level)


def log_uncaught(program: str) -> None:
    """If lines are JSON objects, log warnings and uncaught errors as objects, too."""
    if asked_form() == "text":
        return
    logger, form = f"rpr_cusps.{program.split()[-1]}", _Json()

    def tell(message: str, level: int, exc_info: Any = None) -> None:
        record = _record(logger, message, level)
        record.exc_info = exc_info
        with suppress(OSError, ValueError):
            sys.stderr.write(form.format(record) + "\n")
            sys.stderr.flush()

    def uncaught(
        kind: type[BaseException], error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if not issubclass(kind, SystemExit | KeyboardInterrupt):
            tell(f"uncaught: {kind.__name__}: {error}", logging.CRITICAL, (kind, error, traceback))

    def warned(message: Warning | str, kind: type[Warning], file: str, number: int, *_: Any) -> None:
        tell(f"{kind.__name__}: {message} ({file}, line {number})", logging.WARNING)

    sys.excepthook = uncaught
    threading.excepthook = lambda args: uncaught(args.exc_type, args.exc_value, args.exc_traceback)
    sys.unraisablehook = lambda args: uncaught(args.exc_type, args.exc_value, args.exc_traceback)
    warnings.showwarning = cast(Any, warned)
    if logging.lastResort is not None:
        logging.lastResort.setFormatter(form)


def _record(logger: str, message: str, level: int) -> logging.LogRecord:
    fields = {"name": logger, "levelno": level, "levelname": logging.getLevelName(level), "msg": message}
    return logging.makeLogRecord(fields)


def _formatter(form: LogFormat) -> logging.Formatter:
    return _Json() if form == "json" else _Text()


class _Text(logging.Formatter):
    """`TIME LOGGER LEVEL message name=value …`; a message is one line."""

    def __init__(self) -> None:
        super().__init__("%(asctime)s %(name)s %(levelname)s %(message)s")

    def formatTime(self, record: logging.LogRecord, datefmt: str | None = None) -> str:  # noqa: ARG002, N802
        return _time(record)

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802
        record.message = record.message.replace("\n", r"\n")
        line = super().formatMessage(record)
        return line + "".join(f" {name}={value}" for name, value in _subject.get().items())


class _Json(logging.Formatter):
    """One object a line, with the fields of the subject and those given as `extra={"fields": …}`."""

    def format(self, record: logging.LogRecord) -> str:
        line: dict[str, object] = {
            "time": _time(record),
            "level": record.levelname,
            "logger": record.name,
            "message": record.getMessage(),
            **_subject.get(),
            **getattr(record, "fields", {}),
        }
        if record.exc_info:
            line["exception"] = self.formatException(record.exc_info)
        return json.dumps(line, ensure_ascii=False, default=str)


class _Background(QueueHandler):
    """Hands formatted lines to a thread; drops them while too many wait."""

    def __init__(self, stream: TextIO) -> None:
        self._lines: queue.Queue[logging.LogRecord] = queue.Queue(_WAITING_LINES)
        super().__init__(self._lines)
        self._dropped = 0
        QueueListener(self._lines, logging.StreamHandler(stream)).start()
        atexit.register(self._end)

    def enqueue(self, record: logging.LogRecord) -> None:
        try:
            if self._dropped:
                text = f"{self._dropped} log lines were dropped, because they were not read"
                self._lines.put_nowait(self.prepare(_record(record.name, text, record.levelno)))
                self._dropped = 0
            self._lines.put_nowait(record)
        except queue.Full:
            self._dropped += 1

    def _end(self) -> None:
        with self._lines.all_tasks_done:
            self._lines.all_tasks_done.wait_for(
                lambda: not self._lines.unfinished_tasks, _LAST_LINES_PATIENCE
            )


def _time(record: logging.LogRecord) -> str:
    moment = datetime.fromtimestamp(record.created, UTC)
    return moment.isoformat(timespec="milliseconds").replace("+00:00", "Z")
