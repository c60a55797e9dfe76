"""Run the whole service: the HTTP API, worker processes and, unless a Redis URL is given, an embedded Valkey.
Ctrl-C stops everything; queued jobs are resumed at the next start."""

from __future__ import annotations

import argparse
import signal
from pathlib import Path

from service.api.prefix import read_prefix
from service.cli.environment import warn_of_unknown_settings
from service.cli.options import add_redis_url, whole
from service.stack.serve import ServeSettings, serve
from worker.logs import log_uncaught
from worker.process.os_limits import die_with_parent

DESCRIPTION = __doc__
EXAMPLES = """\
examples:
  rpr-cusps serve
  rpr-cusps serve --port 8080 --workers 8 --data-dir /var/lib/rpr-cusps
  rpr-cusps serve --host 0.0.0.0                 for other computers: first make a key, see keys
  rpr-cusps serve --workers 0 --redis-url redis://queue:6379/0    only the API; see worker

Settings come from the environment: RPR_CUSPS_MAX_SLICES and the other limits of /v1/limits,
RPR_CUSPS_DEADLINE (maximum run time of a chunk of a job, in seconds) and more.
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        help="address or name to listen on (default: 127.0.0.1); one that other computers reach needs a key",
    )
    parser.add_argument("--insecure", action="store_true", help="let everyone in who reaches the address")
    parser.add_argument(
        "--port",
        type=whole("a port", 65535),
        default=8000,
        metavar="N",
        help="port to listen on (default: 8000); 0 chooses a free one",
    )
    parser.add_argument(
        "--workers",
        type=whole("a number of workers", 1024),
        metavar="N",
        help="number of worker processes (default: one per core)",
    )
    parser.add_argument(
        "--root-path",
        type=_prefix,
        metavar="PATH",
        help="path under which a reverse proxy shows the service, such as /cusps",
    )
    add_redis_url(parser, "the Redis or Valkey server to use (default: an embedded one)")
    parser.add_argument(
        "--data-dir",
        type=Path,
        metavar="DIR",
        help="data directory of the embedded Valkey (default: the user's data directory)",
    )
    parser.add_argument("--parent-pid", type=int, help=argparse.SUPPRESS)


def _prefix(text: str) -> str:
    try:
        return read_prefix(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    log_uncaught("rpr-cusps serve")
    warn_of_unknown_settings("serve")
    if args.parent_pid is not None:
        die_with_parent(args.parent_pid, signal.SIGTERM)
    return serve(
        ServeSettings(
            host=args.host,
            port=args.port,
            workers=args.workers,
            redis_url=args.redis_url,
            data_dir=args.data_dir,
            insecure=args.insecure,
            root_path=args.root_path,
        )
    )
