"""The command line `rpr-cusps`.

Exit status: 0 success, 1 a question without an answer or a check that failed, 2 bad input, 3 the service
failed or cannot be reached, 130 interrupted.
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

from pydantic import ValidationError

from rpr_solver.errors import InputError, SolverError
from service import __version__
from service.errors import ServiceError

NO_ANSWER, BAD_INPUT, NO_SERVICE, INTERRUPTED, BROKEN_PIPE = 1, 2, 3, 130, 141

COMMANDS = {
    "solve": "compute cusp tables and print them",
    "census": "find every length at which the number of cusps changes",
    "curves": "follow each cusp from where it appears to where it vanishes",
    "check": "prove or refute a requirement on the number of cusps",
    "poses": "compute all poses for given leg lengths",
    "serve": "run the whole service",
    "worker": "run one worker",
    "keys": "make, list and revoke API keys",
    "store": "show and bound what a service keeps",
    "demo": "run the whole service on one example",
}
"""Command → summary; each command is a module of this package."""

_FORMATTER = argparse.RawDescriptionHelpFormatter
_DESCRIPTION = "Certified cusp points in the joint space of planar 3-RPR parallel manipulators."
_EXAMPLES = """\
examples:
  rpr-cusps demo                                   run the whole service on one example
  rpr-cusps solve innocenti --l1 14.98             solve locally, without a service
  rpr-cusps serve                                  run the service on http://127.0.0.1:8000
  rpr-cusps solve robot.json --l1 27 --url http://127.0.0.1:8000
"""


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """Print one line instead of the whole usage."""
        self.exit(BAD_INPUT, f"{self.prog}: {message}; see {self.prog} --help\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit status."""
    argv = sys.argv[1:] if argv is None else argv
    parser, command = _parser(argv)
    args = parser.parse_args(argv)
    name = f"rpr-cusps {args.command}"
    try:
        status: int = command.run(args)
        sys.stdout.flush()
        return status
    except InputError as error:
        return _fail(name, str(error), BAD_INPUT)
    except ValidationError as error:
        from worker.settings import settings_problem  # imported here to keep the start quick

        return _fail(name, settings_problem(error), BAD_INPUT)
    except SolverError as error:
        return _fail(name, f"no answer (solver-error): {error}", NO_ANSWER)
    except ServiceError as error:
        return _fail(name, str(error), BAD_INPUT if error.is_input else NO_SERVICE)
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        # keeps the interpreter's final flush from failing too
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE


def _parser(argv: Sequence[str]) -> tuple[_Parser, Any]:
    """Returns the parser and the module of the command; to start quickly, no other module is imported."""
    parser = _Parser("rpr-cusps", description=_DESCRIPTION, epilog=_EXAMPLES, formatter_class=_FORMATTER)
    parser.add_argument("--version", action="version", version=f"rpr-cusps {__version__}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    chosen = next((word for word in argv if not word.startswith("-")), None)
    module: Any = None
    for name, summary in COMMANDS.items():
        options: dict[str, Any] = {}
        if name == chosen:
            module = importlib.import_module(f"service.cli.{name}")
            options = {"description": module.DESCRIPTION, "epilog": module.EXAMPLES}
        command = commands.add_parser(name, help=summary, formatter_class=_FORMATTER, **options)
        if name == chosen:
            module.configure(command)
    return parser, module


def _fail(name: str, message: str, status: int) -> int:
    print(f"{name}: {' '.join(message.split())}", file=sys.stderr)
    return status
