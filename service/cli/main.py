"""The command line `rpr-cusps`.

Exit status: 0 done, 1 some question has no answer or a check is not passed, 2 bad input, 3 the service cannot
be reached or failed, 130 interrupted.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NoReturn

from pydantic import ValidationError

from rpr_solver.errors import InputError
from service import __version__
from service.cli.arguments import Options, add_analysis, add_command, add_format, add_geometry

WORKER_FAILED, BAD_INPUT, NO_SERVICE, INTERRUPTED, BROKEN_PIPE = 1, 2, 3, 130, 141

_FORMATTER = argparse.RawDescriptionHelpFormatter
_DESCRIPTION = "Certified cusp points in the joint space of planar 3-RPR parallel manipulators."
_EXAMPLES = """\
examples:
  rpr-cusps demo                                   see the whole service at work, once
  rpr-cusps solve innocenti --l1 14.98             solve here, without a service
  rpr-cusps serve                                  the service, on http://127.0.0.1:8000
  rpr-cusps solve robot.json --l1 27 --url http://127.0.0.1:8000
"""
_SOLVE = """\
Compute cusp tables and print them.

GEOMETRY is a JSON file, - for standard input, or a built-in manipulator: innocenti (the article's first),
zein-flat (its second), twelve-cusps or fourteen-cusps. Numbers are exact: 17.04, "17.04", "426/25".
"""
_SOLVE_EXAMPLES = """\
examples:
  rpr-cusps solve innocenti --l1 14.98
  rpr-cusps solve innocenti --l1 14.98 --method article
  rpr-cusps solve zein-flat --l1 2 --l1 5/2 --digits 200 --format json
  rpr-cusps solve robot.json --l1-range 0.1:50.1:0.1 --digits 30 --format csv > cusps.csv
  echo '{"a2x":15.91,"a3x":0,"a3y":10,"d1":17.04,"d2":16.54,"d3":20.84}' | rpr-cusps solve - --l1 14.98

On a terminal a table shows as many digits as fit; all of them are in every other output.
"""
_SERVE = """\
Run the whole service: the HTTP API, worker processes and, unless a Redis URL is given, an embedded Valkey.
Ctrl-C stops all of it; queued jobs are there again at the next start.
"""
_SERVE_EXAMPLES = """\
examples:
  rpr-cusps serve
  rpr-cusps serve --port 8080 --workers 8 --data-dir /var/lib/rpr-cusps
  rpr-cusps serve --host 0.0.0.0 --workers 0 --redis-url redis://queue:6379/0    only the API; see worker

Settings come from the environment: RPR_CUSPS_MAX_SLICES and the other limits that /v1/limits shows,
RPR_CUSPS_DEADLINE (seconds that a part of a job may take) and more.
"""
_WORKER = "Run one worker that takes jobs from a Redis or Valkey server, on this or another machine."
_DEMO = """\
Start the whole service on a free port, post the article's first manipulator at L1 = 14.98 over HTTP, print
the cusp table that a worker computed, and stop everything.
"""


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """One line instead of the whole usage."""
        self.exit(BAD_INPUT, f"{self.prog}: {message}; see {self.prog} --help\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit status."""
    args = _parser().parse_args(argv)
    run: Callable[[argparse.Namespace], int] = args.run
    name = f"rpr-cusps {args.command}"
    try:
        status = run(args)
        sys.stdout.flush()
        return status
    except InputError as error:
        return _fail(name, str(error), BAD_INPUT)
    except ValidationError as error:
        wrong = "; ".join(f"RPR_CUSPS_{e['loc'][-1]}".upper() + f": {e['msg']}" for e in error.errors())
        return _fail(name, wrong, BAD_INPUT)
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        # so that the interpreter's own flush at the end does not complain either
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE


def _parser() -> _Parser:
    parser = _Parser("rpr-cusps", description=_DESCRIPTION, epilog=_EXAMPLES, formatter_class=_FORMATTER)
    parser.add_argument("--version", action="version", version=f"rpr-cusps {__version__}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for add in (_add_solve, add_analysis, _add_serve, _add_worker, _add_demo):
        add(commands)
    return parser


def _add_solve(commands: argparse._SubParsersAction[_Parser]) -> None:
    solve = add_command(commands, "solve", "compute cusp tables and print them", _SOLVE, _SOLVE_EXAMPLES)
    add_geometry(solve)
    legs = ("--l1", "--l2", "--l3")
    solve.add_argument(
        *legs,
        dest="slices",
        action=Options,
        metavar="X",
        help="a slice; may be given often (--l2 with fixed leg 2, …)",
    )
    solve.add_argument(
        *(f"{leg}-range" for leg in legs),
        dest="slices",
        action=Options,
        metavar="START:STOP:STEP",
        help="slices from START up to STOP, which is included when it is hit",
    )
    solve.add_argument(
        "--digits", default=None, metavar="N", help="significant digits, 15 to 1000 (default: 90)"
    )
    solve.add_argument(
        "--fixed-leg", default="1", metavar="LEG", help="the leg with the fixed length (default: 1)"
    )
    add_format(solve, csv=True)
    solve.add_argument(
        "--method",
        choices=("fast", "article"),
        default="fast",
        help="article: the article's own algorithm, audited; slower, for leg 1 only (default: fast)",
    )
    solve.add_argument(
        "--url", help="have the service at this address compute, for example http://127.0.0.1:8000"
    )
    solve.set_defaults(run=_solve)


def _add_serve(commands: argparse._SubParsersAction[_Parser]) -> None:
    serve = add_command(commands, "serve", "run the whole service", _SERVE, _SERVE_EXAMPLES)
    serve.add_argument("--host", default="127.0.0.1", help="address to listen on (default: 127.0.0.1)")
    serve.add_argument(
        "--port",
        type=_whole("a port", 0, 65535),
        default=8000,
        metavar="N",
        help="default: 8000; 0 takes a free one",
    )
    serve.add_argument(
        "--workers",
        type=_whole("a number of workers", 0, 1024),
        metavar="N",
        help="worker processes (default: one for each core)",
    )
    _add_redis_url(serve, "a Redis or Valkey server to use (default: an embedded one)")
    serve.add_argument(
        "--data-dir",
        type=Path,
        metavar="DIR",
        help="where the embedded Valkey keeps its data (default: your own)",
    )
    serve.add_argument("--parent-pid", type=int, help=argparse.SUPPRESS)
    serve.set_defaults(run=_serve)


def _add_worker(commands: argparse._SubParsersAction[_Parser]) -> None:
    worker = commands.add_parser(
        "worker", help="run one worker", description=_WORKER, formatter_class=_FORMATTER
    )
    _add_redis_url(worker, "the Redis or Valkey server with the queue")
    worker.set_defaults(run=_worker)


def _add_demo(commands: argparse._SubParsersAction[_Parser]) -> None:
    demo = commands.add_parser(
        "demo", help="see the whole service at work, once", description=_DEMO, formatter_class=_FORMATTER
    )
    demo.add_argument("--keep", action="store_true", help="leave the service running until Ctrl-C")
    demo.set_defaults(run=_demo)


def _add_redis_url(parser: argparse.ArgumentParser, text: str) -> None:
    # argparse also checks a default that is a string, so the environment is held to the same
    default = os.environ.get("RPR_CUSPS_REDIS_URL") or None
    parser.add_argument(
        "--redis-url",
        type=_redis_url,
        default=default,
        metavar="URL",
        help=f"{text}; also RPR_CUSPS_REDIS_URL",
    )


# The commands import what they need when they run, so that each starts quickly.


def _solve(args: argparse.Namespace) -> int:
    from service.cli import solve as solving
    from service.client import ServiceError

    try:
        return solving.solve(
            args.geometry,
            args.slices or [],
            args.digits,
            args.fixed_leg,
            args.format,
            args.url,
            args.method,
        )
    except ServiceError as error:
        return _fail("rpr-cusps solve", str(error), BAD_INPUT if error.is_input else NO_SERVICE)


def _serve(args: argparse.Namespace) -> int:
    from service.api.settings import Settings
    from service.stack.serve import ServeSettings, serve

    Settings()  # complains of the environment now rather than behind the first request
    if args.parent_pid is not None:
        from worker.process.os_limits import die_with_parent

        die_with_parent(args.parent_pid, signal.SIGTERM)
    return serve(
        ServeSettings(
            host=args.host,
            port=args.port,
            workers=args.workers,
            redis_url=args.redis_url,
            data_dir=args.data_dir,
        )
    )


def _worker(args: argparse.Namespace) -> int:
    if args.redis_url is None:
        return _fail(
            "rpr-cusps worker",
            "--redis-url is missing; give the address of the queue, for example redis://127.0.0.1:6379/0",
            BAD_INPUT,
        )
    from worker.process.worker import WorkerError, run_worker

    try:
        return run_worker(args.redis_url)
    except WorkerError as error:
        return _fail("rpr-cusps worker", str(error), WORKER_FAILED)


def _demo(args: argparse.Namespace) -> int:
    from service.cli.demo import demo
    from service.client import ServiceError

    try:
        return demo(keep=args.keep)
    except ServiceError as error:
        return _fail("rpr-cusps demo", str(error), NO_SERVICE)


def _whole(what: str, low: int, high: int) -> Callable[[str], int]:
    def parse(text: str) -> int:
        if not (text.isascii() and text.isdigit() and len(text) < 10 and low <= int(text) <= high):
            raise argparse.ArgumentTypeError(f"{text[:40]!r} is not {what} from {low} to {high}")
        return int(text)

    return parse


def _redis_url(text: str) -> str:
    if not text.startswith(("redis://", "rediss://", "unix://")):
        raise argparse.ArgumentTypeError(
            "the address must begin with redis://, rediss:// or unix://, for example redis://127.0.0.1:6379/0"
        )
    return text


def _fail(name: str, message: str, status: int) -> int:
    print(f"{name}: {' '.join(message.split())}", file=sys.stderr)
    return status
