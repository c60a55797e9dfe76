"""The command line `rpr-cusps`.

Exit status: 0 done, 1 some question has no answer or a check is not passed, 2 bad input, 3 the service cannot
be reached or failed, 130 interrupted.
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
    "census": "every length at which the number of cusps changes",
    "curves": "each cusp followed from its birth to its death",
    "check": "prove or refute a requirement on the number of cusps",
    "poses": "all poses of given leg lengths",
    "serve": "run the whole service",
    "worker": "run one worker",
    "demo": "see the whole service at work, once",
}
"""Every command, which is a module of this package, with its summary."""

_FORMATTER = argparse.RawDescriptionHelpFormatter
_DESCRIPTION = "Certified cusp points in the joint space of planar 3-RPR parallel manipulators."
_EXAMPLES = """\
examples:
  rpr-cusps demo                                   see the whole service at work, once
  rpr-cusps solve innocenti --l1 14.98             solve here, without a service
  rpr-cusps serve                                  the service, on http://127.0.0.1:8000
  rpr-cusps solve robot.json --l1 27 --url http://127.0.0.1:8000
"""


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """One line instead of the whole usage."""
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
        from worker.settings import settings_problem  # only here: each command starts quickly

        return _fail(name, settings_problem(error), BAD_INPUT)
    except SolverError as error:
        return _fail(name, f"no answer (solver-error): {error}", NO_ANSWER)
    except ServiceError as error:
        return _fail(name, str(error), BAD_INPUT if error.is_input else NO_SERVICE)
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        # so that the interpreter's own flush at the end does not complain either
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE


def _parser(argv: Sequence[str]) -> tuple[_Parser, Any]:
    """The parser, and the module of the command; no other is imported, so that each starts quickly."""
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
