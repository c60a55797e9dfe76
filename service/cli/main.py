"""The command line `rpr-cusps`.

Exit status: 0 success, 1 a question without an answer, a check that failed or output that cannot be written,
2 bad input, 3 the service failed or cannot be reached, 130 interrupted.
"""

from __future__ import annotations

import argparse
import gc
import importlib
import os
import sys
from collections.abc import Mapping, Sequence
from typing import Any, cast

from rpr_solver.errors import InputError, NotInstalledError, SolverError
from service import __version__
from service.cli import output
from service.cli.parsers import BAD_INPUT, Command, Parser, complete, typed
from service.errors import JobInterrupted, ServiceError, lacking
from service.schemas.registry import COMPUTE, DESIGN, DOCUMENTS, PATHS, QUESTIONS

NO_ANSWER, NO_SERVICE, INTERRUPTED, BROKEN_PIPE = 1, 3, 130, 141

GROUPS: Mapping[str, Mapping[str, str]] = {
    COMPUTE: {},
    PATHS: {},
    DESIGN: {"atlas": "make a table of the censuses of many random manipulators"},
    DOCUMENTS: {
        "export": "write a document as a script for another system",
        "cite": "print a reference to a document, in BibTeX",
    },
    "Ask a service": {
        "submit": "send a batch of questions to a service and print their answers",
        "status": "print the state of a job or a batch of a service",
        "jobs": "list the jobs and batches of a service",
        "fetch": "wait for a job or a batch of a service and print its result",
        "cancel": "withdraw a question or a batch from a service",
    },
    "Run a service": {
        "demo": "run the whole service on one example",
        "serve": "run the whole service",
        "worker": "run one worker",
        "keys": "create, list and revoke API keys",
        "store": "inspect and prune the store of a service",
    },
    "Shell": {"completion": "print the code for completion of commands and options by a shell"},
}
"""Group → command → summary, of the commands that ask no question; those of questions stand before them."""

_MODULES = {
    COMPUTE: "compute",
    PATHS: "plan",
    DESIGN: "design",
    DOCUMENTS: "documents",
    "Ask a service": "jobs",
    "Run a service": "serve",
    "Shell": "parsers",
    **{"check": "check", "keys": "store", "store": "store"},
}
"""Group → module in this package; and the commands that have another."""


def _by_group() -> Mapping[str, Mapping[str, str]]:
    asked: dict[str, dict[str, str]] = {group: {} for group in GROUPS}
    for entry in QUESTIONS:
        asked[entry.group][entry.command] = entry.summary
    return {group: {**asked[group], **others} for group, others in GROUPS.items()}


_BY_GROUP = _by_group()
COMMANDS = {name: summary for commands in _BY_GROUP.values() for name, summary in commands.items()}
"""Command → summary."""

_SERVERS = ("serve", "worker")
"""Commands that need no stdout."""

_DESCRIPTION = "Certified cusp points in the joint space of planar 3-RPR parallel manipulators."
_EXAMPLES = """\
examples:
  rpr-cusps demo                                   run the whole service on one example
  rpr-cusps solve innocenti --l1 14.98             solve locally, without a service
  rpr-cusps serve                                  run the service on http://127.0.0.1:8000
  rpr-cusps solve robot.json --l1 27 --url http://127.0.0.1:8000
  rpr-cusps help census                            the options of a command
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit status."""
    # pydantic would read the metadata of every installed package in search of plugins
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    output.prepare()
    argv = sys.argv[1:] if argv is None else argv
    name, parser = "rpr-cusps", None
    try:
        args, command, parser = _parsed(_as_option(argv))
        name = f"rpr-cusps {args.command}"
        if args.command not in _SERVERS:
            output.stdout()  # a closed one is noticed before the work, not after it
        status = command.run(args)
        output.flush()
        return status
    except (InputError, SolverError, ServiceError, output.OutputError, ValueError, ImportError) as error:
        message, status = _failure(error, parser)
        return _fail(name, message, status)
    except JobInterrupted as interrupt:
        return _fail(name, str(interrupt), INTERRUPTED) if str(interrupt) else INTERRUPTED
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        output.discard()
        return BROKEN_PIPE


def _failure(error: Exception, parser: Parser | None) -> tuple[str, int]:
    """The message and the exit status for a command that ended with an error; any other error is raised."""
    match error:
        case InputError():
            problems = map(parser.said, error.problems) if parser else error.problems
            return str(InputError([*problems])), BAD_INPUT
        case NotInstalledError():
            return str(error), BAD_INPUT
        case SolverError():
            return f"no answer (solver-error): {error}", NO_ANSWER
        case ServiceError():
            return str(error), BAD_INPUT if error.is_input else NO_SERVICE
        case output.OutputError():
            output.discard()
            return str(error), NO_ANSWER
        case ImportError():
            if (message := lacking(error.name)) is None:
                raise error
            return message, BAD_INPUT
    from pydantic import ValidationError  # imported here to keep the start quick

    from worker.settings import settings_problem

    if not isinstance(error, ValidationError):
        raise error
    return settings_problem(error), BAD_INPUT


class _Version(argparse.Action):
    """Prints the version of what runs, and the commit that it was built from."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from service.commit import commit

        built = commit()
        output.stdout().write(f"rpr-cusps {__version__}{'' if built is None else f' ({built})'}\n")
        output.flush()
        parser.exit()


def _as_option(argv: Sequence[str]) -> Sequence[str]:
    """`help` and `help COMMAND` as `--help` and `COMMAND --help`."""
    return [*argv[1:], "--help"] if argv and argv[0] == "help" else argv


def _parsed(argv: Sequence[str]) -> tuple[argparse.Namespace, Command, Parser]:
    """Returns the arguments, the command and its parser; to start quickly, no other module is imported."""
    usage = "rpr-cusps [-h] [--version] COMMAND ..."
    parser = Parser("rpr-cusps", usage=usage, description=_DESCRIPTION, epilog=_EXAMPLES)
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and its commit")
    asked = typed()
    words = argv if asked is None else asked
    chosen = next((word for word in words if not word.startswith("-")), None)
    kind = cast(type[Parser], _parser_of_chosen) if asked is None else Parser
    commands = parser.add_subparsers(
        prog="rpr-cusps", dest="command", metavar="COMMAND", required=True, parser_class=kind
    )
    command: Any = None
    own = parser
    for group, summaries in _BY_GROUP.items():
        for name, summary in summaries.items():
            if name != chosen:
                commands.add_parser(name, help=summary)
                continue
            command = command_of(name)
            own = commands.add_parser(name, help=summary, **command.help)
            command.configure(own)
        parser.group_commands(group, commands, summaries)
    if asked is not None:
        complete(parser)
    if not argv:
        parser.print_help()
        parser.exit(BAD_INPUT)
    args, unknown = parser.parse_known_args(argv)
    if unknown:
        own.refuse_unknown(unknown)
    return args, command, own


def _parser_of_chosen(**options: Any) -> Parser | None:
    """The parser of the command that is chosen; of the others name and summary suffice, and all parsers
    together would take a third of the start."""
    return Parser(**options) if "description" in options else None


def command_of(name: str) -> Command:
    """Returns a command: as its module makes it of its question, or as it follows from the question alone.

    Garbage is never sought in what is loaded, which would take a twentieth of a start.
    """
    group = next(group for group, names in _BY_GROUP.items() if name in names)
    gc.disable()
    try:
        module = importlib.import_module(f"service.cli.{_MODULES.get(name, _MODULES[group])}")
        found: Command | None = module.COMMANDS.get(name)
        if isinstance(found, Command):
            return found
        from service.cli import asking

        entry = next(entry for entry in QUESTIONS if entry.command == name)
        return (found or asking.command)(entry.question)
    finally:
        gc.freeze()
        gc.enable()


def _fail(name: str, message: str, status: int) -> int:
    output.say(f"{name}: {' '.join(message.split())}")
    return status
