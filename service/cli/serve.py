"""The whole service, one of its workers, and a demonstration; options of the commands that run or manage it.

They need nothing of the solver. What an installation without a service lacks is imported when a command runs,
so that each prints its help.
"""

from __future__ import annotations

import argparse
import contextlib
import difflib
import logging
import os
import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rpr_solver.errors import InputError
from service.cli.parsers import Command, Parser, whole
from service.errors import ServiceError
from worker.logs import log_uncaught, program_line

if TYPE_CHECKING:
    from pydantic import BaseModel
    from redis import Redis


def add_redis_url(parser: argparse.ArgumentParser, text: str) -> None:
    """Add `--redis-url`."""
    # argparse also converts a default that is a string, so the environment is checked too
    default = os.environ.get("RPR_CUSPS_REDIS_URL") or None
    parser.add_argument(
        "--redis-url",
        action=_FromCommandLine,
        type=_redis_url,
        default=default,
        metavar="URL",
        help=f"{text}; also RPR_CUSPS_REDIS_URL, which may have a password",
    )


class _FromCommandLine(argparse.Action):
    """Refuses a password, which other users of the computer could read in the list of processes."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, *_: Any
    ) -> None:
        from worker.connection import has_password

        if has_password(values):
            raise argparse.ArgumentError(
                self,
                "a password on the command line can be read by others; give the address in "
                "RPR_CUSPS_REDIS_URL, or the password in the file RPR_CUSPS_REDIS_PASSWORD_FILE",
            )
        assert isinstance(parser, Parser)
        parser.note(self, values)
        setattr(namespace, self.dest, values)


def _redis_url(text: str) -> str:
    if not text.startswith(("redis://", "rediss://", "unix://")):
        raise argparse.ArgumentTypeError(
            "the address must begin with redis://, rediss:// or unix://, for example redis://127.0.0.1:6379/0"
        )
    return text


PREFIX = "RPR_CUSPS_"


def models() -> tuple[type[BaseModel], ...]:
    """Returns the models that read settings from the environment."""
    from service.api import Settings  # imported here to keep the start of commands quick
    from service.client import ClientSettings
    from service.schemas.limits import Limits
    from service.webhooks import WebhookSettings
    from worker.settings import ConnectionSettings, WorkerSettings

    ours = (Limits, Settings, WebhookSettings, ClientSettings)
    return *ours, WorkerSettings, ConnectionSettings


def names() -> set[str]:
    """Returns the names of all settings."""
    from worker.limits import is_setting

    fields_of = (model.model_fields.items() for model in models())
    return {PREFIX + name.upper() for fields in fields_of for name, field in fields if is_setting(field)}


def unknown_settings(environment: Mapping[str, str]) -> Iterator[str]:
    """Yields a sentence for each variable that has the prefix of settings, but is not a setting."""
    set_here = sorted(name for name in environment if name.upper().startswith(PREFIX))
    known = names() if set_here else set()
    for name in set_here:
        if name.upper() not in known:
            yield f"{name} is not a setting and has no effect{_hint(name.upper(), known)}"


def warn_of_unknown_settings(command: str) -> None:
    """Say those sentences on stderr, at the start of a process."""
    for sentence in unknown_settings(os.environ):
        print(program_line(f"rpr-cusps {command}", sentence, logging.WARNING), file=sys.stderr)


def _hint(name: str, known: Iterable[str]) -> str:
    words = [other.removeprefix(PREFIX) for other in known]
    near = difflib.get_close_matches(name.removeprefix(PREFIX), words, n=1, cutoff=0.65)
    return f"; did you mean {PREFIX}{near[0]}?" if near else ""


def add_source(parser: argparse.ArgumentParser, which: str = "of the service") -> None:
    """Add `--redis-url` and `--data-dir`."""
    add_redis_url(parser, f"the Redis or Valkey server {which} (default: an embedded one)")
    parser.add_argument(
        "--data-dir",
        type=Path,
        metavar="DIR",
        help="data directory of the embedded Valkey (default: the user's data directory)",
    )


def check_source(args: argparse.Namespace) -> None:
    """Refuse a data directory beside the address of another server.

    Raises:
        InputError: naming it.
    """
    if args.data_dir is not None and args.redis_url is not None:
        other = "--redis-url (or RPR_CUSPS_REDIS_URL) names another server"
        raise InputError.of("--data-dir", f"is of the embedded Valkey, but {other}; leave one of them out")


@contextmanager
def opened(args: argparse.Namespace) -> Iterator[Redis]:
    """A client of the server that is asked for; of a data directory, whether or not its service is running.

    Raises:
        InputError: two servers are asked for.
        ServiceError: it cannot be reached, or fails meanwhile.
    """
    check_source(args)
    from redis.exceptions import RedisError

    from service.errors import NoServerError, StackError
    from service.stack.embedded_valkey import attached
    from worker.connection import UnreachableError, check, connect

    try:
        if args.redis_url is None:
            with attached(args.data_dir) as url, connect(url) as redis:
                yield redis
        else:
            check(args.redis_url)
            with connect(args.redis_url) as redis:
                yield redis
    except (StackError, UnreachableError, RedisError) as error:
        raise ServiceError(str(error), is_input=isinstance(error, NoServerError)) from error


def _configure_serve(parser: argparse.ArgumentParser) -> None:
    """Add the options of `serve`.

    Options:
        --host: address or name to listen on (default: 127.0.0.1); an address that other computers reach
            requires a key
        --insecure: give access to everyone who reaches the address
        --port: port to listen on (default: 8000); 0 chooses a free one
        --workers: number of worker processes; of two or more, one takes small questions only (default: one
            more than cores)
        --root-path: path under which a reverse proxy serves the service, such as /cusps
    """
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--insecure", action="store_true")
    parser.add_argument("--port", type=whole("a port", 65535), default=8000, metavar="N")
    parser.add_argument("--workers", type=whole("a number of workers", 1024), metavar="N")
    parser.add_argument("--root-path", type=_prefix, metavar="PATH")
    add_source(parser, "to use")
    parser.add_argument("--parent-pid", type=int, help=argparse.SUPPRESS)


def _prefix(text: str) -> str:
    from service.api import read_prefix

    try:
        return read_prefix(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _run_serve(args: argparse.Namespace) -> int:
    """Run the whole service: the HTTP API, worker processes and, unless a Redis URL is given, an embedded
    Valkey. Ctrl-C stops everything; queued jobs are resumed at the next start.

    examples:
      rpr-cusps serve
      rpr-cusps serve --port 8080 --workers 8 --data-dir /var/lib/rpr-cusps
      rpr-cusps serve --host 0.0.0.0                 for other computers: first create a key, see keys
      rpr-cusps serve --workers 0 --redis-url redis://queue:6379/0    only the API; see worker

    Settings come from the environment: RPR_CUSPS_MAX_SLICES and the other limits of /v1/limits,
    RPR_CUSPS_DEADLINE_SECONDS (maximum run time of a chunk of a job, in seconds) and more.
    """
    from service.stack.serve import ServeSettings, serve
    from worker.process import die_with_parent, raise_file_limit

    log_uncaught("rpr-cusps serve")
    check_source(args)
    if args.parent_pid is not None:
        die_with_parent(args.parent_pid, signal.SIGTERM)
    raise_file_limit()
    warn_of_unknown_settings("serve")
    options = {option.name: getattr(args, option.name) for option in fields(ServeSettings)}
    return serve(ServeSettings(**options))


_WORKER_FAILED = 1


def _configure_worker(parser: argparse.ArgumentParser) -> None:
    """Add the options of `worker`.

    Options:
        --duty: light: take only chunks of about a second, so that short questions never wait for long ones;
            at least one worker must have the duty all (default: all)
    """
    from worker.settings import DUTIES  # pydantic is slow to load, and `serve` must begin at once

    add_redis_url(parser, "the Redis or Valkey server with the queue")
    parser.add_argument("--duty", choices=DUTIES, default="all")


def _run_worker(args: argparse.Namespace) -> int:
    """Run one worker that takes jobs from a Redis or Valkey server, on this machine or another."""
    from worker.process.program import WorkerError, run_worker

    if args.redis_url is None:
        hint = "give the address of the queue, for example redis://127.0.0.1:6379/0"
        raise InputError.of("--redis-url", f"is missing; {hint}")
    log_uncaught("rpr-cusps worker")
    warn_of_unknown_settings("worker")
    try:
        return run_worker(args.redis_url, duty=args.duty)
    except WorkerError as error:
        print(program_line("rpr-cusps worker", str(error)), file=sys.stderr)
        return _WORKER_FAILED


EXAMPLE, L1 = "innocenti", "14.98"

_STOP_PATIENCE = 15.0


def _configure_demo(parser: argparse.ArgumentParser) -> None:
    """Add the options of `demo`.

    Options:
        --keep: keep the service running until Ctrl-C
    """
    parser.add_argument("--keep", action="store_true")


def _run_demo(args: argparse.Namespace) -> int:
    """Start the whole service on a free port, post the article's first manipulator at L1 = 14.98, print the
    cusp table that a worker computes, and stop everything.
    """
    from rpr_solver import EXAMPLES  # a service needs none of these itself
    from service.cli.compute import report
    from service.cli.output import progress_bar
    from service.cli.pages import write_table
    from service.client import ServiceClient, cusp_table
    from service.errors import EmbeddedError
    from service.stack.embedded_valkey import program

    try:
        program()
    except EmbeddedError as error:
        raise ServiceError(str(error), is_input=True) from None
    with (
        tempfile.TemporaryDirectory(prefix="rpr-cusps-") as directory,
        _service(Path(directory)) as (process, url),
    ):
        _say(f"The service runs at {url}; posting the manipulator {EXAMPLE!r} at L1 = {L1}.")
        with ServiceClient(url, with_key=False) as client, progress_bar(1) as progress:
            asked = cusp_table(EXAMPLES[EXAMPLE], L1)
            table = client.ask(asked, progress).document
        write_table(table, "table")
        sys.stdout.flush()
        if args.keep:
            _say(f"Still serving: {url}/ (documentation at {url}/docs); Ctrl-C stops it.")
            with contextlib.suppress(KeyboardInterrupt):
                process.wait()
        status = report(table)
    _say("Everything is stopped.")
    return status


@contextmanager
def _service(data_dir: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """Run `rpr-cusps serve` on a free port with its data in `data_dir`; gives the process and its address."""
    from worker.process import end_process
    from worker.process.programs import python_program

    environment = {key: value for key, value in os.environ.items() if key != "RPR_CUSPS_REDIS_URL"}
    environment |= {"RPR_CUSPS_ACCESS_LOG": "off", "RPR_CUSPS_REQUIRE_KEYS": "never"}
    process = subprocess.Popen(
        python_program(
            "service.cli.main",
            *("serve", "--port", "0", "--data-dir", str(data_dir), "--parent-pid", str(os.getpid())),
        ),
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,  # Ctrl-C on a terminal reaches this process alone, which stops the other
    )
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        match = re.search(r"https?://\S+", line)
        if match is None:
            raise ServiceError(f"the service did not start: {line.strip() or 'it printed nothing'}")
        yield process, match[0]
    finally:
        end_process(process, _STOP_PATIENCE)
        if process.stdout is not None:
            process.stdout.close()


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


COMMANDS = {
    "serve": Command.of(_run_serve, _configure_serve),
    "worker": Command.of(_run_worker, _configure_worker),
    "demo": Command.of(_run_demo, _configure_demo),
}
