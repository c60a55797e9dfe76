"""Start the whole service on a free port, post the article's first manipulator at L1 = 14.98, print the cusp
table that a worker computes, and stop everything."""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rpr_solver import EXAMPLES as MANIPULATORS
from service.cli.pages import write_table
from service.cli.progress import progress_bar
from service.cli.solve import report
from service.client import ServiceClient, cusp_table
from service.errors import ServiceError
from worker.process.child import python_program
from worker.process.os_limits import end_process

DESCRIPTION, EXAMPLES = __doc__, None

EXAMPLE, L1 = "innocenti", "14.98"

_STOP_PATIENCE = 15.0


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("--keep", action="store_true", help="keep the service running until Ctrl-C")


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status.

    Raises:
        ServiceError: the service did not start or answer.
    """
    with (
        tempfile.TemporaryDirectory(prefix="rpr-cusps-") as directory,
        _service(Path(directory)) as (process, url),
    ):
        _say(f"The service runs at {url}; posting the manipulator {EXAMPLE!r} at L1 = {L1}.")
        with ServiceClient(url, with_key=False) as client, progress_bar(1) as progress:
            asked = cusp_table(MANIPULATORS[EXAMPLE], L1)
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
