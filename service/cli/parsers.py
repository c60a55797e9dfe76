"""Parsers of commands: options that several share, help that fits the terminal, errors in one line that say
where to read more, and completion by a shell."""

from __future__ import annotations

import argparse
import difflib
import os
import re
import sys
import textwrap
from collections.abc import Callable, Container, Iterator, Sequence
from dataclasses import dataclass
from inspect import cleandoc
from pathlib import Path
from typing import Any, NoReturn

from rpr_solver.contract import FIXED_LEGS
from rpr_solver.errors import FieldProblem, clipped
from service.cli import output
from service.cli.digits import PRINTED

BAD_INPUT = 2

_EXAMPLES = "examples:\n"
_OPTIONS = re.compile(r"^Options:\n(?: {4}.*\n?)+\n?", re.MULTILINE)
_OPTION = re.compile(r"^    (?=\S)", re.MULTILINE)
_NEGATIVE = re.compile(r"-\.?\d.*")
"""What begins with a minus sign and is a value, not an option."""


@dataclass(frozen=True)
class Command:
    """A command: its help, its options, and what it does.

    Attributes:
        text: what it does; and examples of it, below its options, from the line ``examples:`` on.
        configure: adds the options to its parser.
        run: runs it and returns the exit status.
    """

    text: str
    configure: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], int]

    @classmethod
    def of(
        cls, run: Callable[[argparse.Namespace], int], configure: Callable[[argparse.ArgumentParser], None]
    ) -> Command:
        """The command that `run` runs, with its docstring as the text; the help of its options is the section
        ``Options:`` in the docstring of `configure`."""

        def add_options(parser: argparse.ArgumentParser) -> None:
            configure(parser)
            actions = {name: x for x in parser._actions for name in x.option_strings or (x.metavar,)}
            for name, text in said_of(configure).items():
                actions[name].help = text

        return cls(text_of(run), add_options, run)

    @property
    def help(self) -> dict[str, str]:
        """Its texts as its parser takes them."""
        description, line, examples = self.text.partition(_EXAMPLES)
        return {"description": description, "epilog": line + examples}


def text_of(function: Callable[..., object]) -> str:
    """Returns the docstring of a function, without what it says of options."""
    return _OPTIONS.sub("", cleandoc(function.__doc__ or ""))


def said_of(function: Callable[..., object]) -> dict[str, str]:
    """Returns what the docstring of a function says of options under ``Options:``, by their names."""
    section = _OPTIONS.search(cleandoc(function.__doc__ or ""))
    items = () if section is None else _OPTION.split(section[0])[1:]
    pairs = (" ".join(item.split()).partition(": ") for item in items)
    return {name: text.replace("%", "%%") for name, _, text in pairs}


def whole(what: str, high: int, low: int = 0) -> Callable[[str], int]:
    """Returns the conversion of an option that is a whole number."""

    def parse(text: str) -> int:
        if not (text.isascii() and text.isdigit() and len(text) < 10 and low <= int(text) <= high):
            raise argparse.ArgumentTypeError(f"{clipped(text)!r} is not {what} from {low} to {high}")
        return int(text)

    return parse


class Formatter(argparse.RawDescriptionHelpFormatter):
    """Breaks lines between words only, and the lines of examples so that they can still be pasted."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        parts = (
            "\n".join(_example(line, width) for line in part.splitlines())
            if "\n " in part
            else textwrap.fill(part, width, initial_indent=indent, break_long_words=False)
            for part in text.strip("\n").split("\n\n")
        )
        return "\n\n".join(parts)

    def _format_action_invocation(self, action: argparse.Action) -> str:
        if not action.option_strings or action.nargs == 0:
            return super()._format_action_invocation(action)
        value = self._format_args(action, self._get_default_metavar_for_optional(action))
        return f"{', '.join(action.option_strings)} {value}"


def _example(line: str, width: int) -> str:
    """Returns a command and the remark beside it; what does not fit continues in the next line."""
    if len(line) <= width:
        return line
    command, _, remark = line.strip().partition("   ")
    lines = textwrap.wrap(
        command,
        width - 2,
        initial_indent="  ",
        subsequent_indent="      ",
        break_long_words=False,
        break_on_hyphens=False,
    )
    remarks = textwrap.wrap(remark.strip(), width, initial_indent=" " * 6, subsequent_indent=" " * 6)
    return "\n".join([" \\\n".join(lines), *remarks])


_IN_OPTIONS = {
    "from and to": "--from and --to",
    "follows from motion": "follows from --speed and --acceleration",
    "follows from sampling": "follows from --step or --chord",
    "number, step, chord": "--samples, --step, --chord",
    "beside step": "beside --step",
    "beside chord": "beside --chord",
}
"""How messages name members of a question → how a command that has these options names them."""

_MEMBER = re.compile(r"(?<![\w.-])(?:[a-z]+_[a-z_]+|l[123](?= = )|(?<=are )l[123])(?![\w.])")
"""The name of a member in a message."""


class _Store(argparse._StoreAction):
    """Takes the value of an option, which may be repeated, but not changed."""

    def __call__(self, parser: Any, namespace: argparse.Namespace, values: Any, *_: Any) -> None:
        parser.note(self, values)
        setattr(namespace, self.dest, values)


class _StoreConst(argparse._StoreConstAction):
    """The same for an option without a value."""

    def __call__(self, parser: Any, namespace: argparse.Namespace, *_: Any) -> None:
        parser.note(self, self.const)
        setattr(namespace, self.dest, self.const)


class Parser(argparse.ArgumentParser):
    """A parser of a command whose errors are one line; an option that contradicts another is one."""

    def __init__(self, prog: str | None = None, **options: Any) -> None:
        super().__init__(prog, **{"formatter_class": Formatter, **options})
        self._taken: dict[str, object] = {}
        for name, action in ((None, _Store), ("store", _Store), ("store_const", _StoreConst)):
            self.register("action", name, action)
        self._negative_number_matcher = _NEGATIVE  # argparse takes -1:5 and -1/2 for options

    def note(self, action: argparse.Action, value: object) -> None:
        """Note the value of an option.

        Raises:
            argparse.ArgumentError: the option, or another one for the same, has another value already.
        """
        if action.option_strings and self._taken.setdefault(action.dest, value) != value:
            told = f"is {value!s}, but {self._taken[action.dest]!s} is given already; give one"
            raise argparse.ArgumentError(action, told)

    def group_commands(self, title: str, commands: Any, names: Container[str]) -> None:
        """List these of the commands in a group of their own."""
        listed = [action for action in commands._choices_actions if action.dest in names]
        self.add_argument_group(title)._group_actions += listed
        commands.help = argparse.SUPPRESS  # which leaves the list of all of them out

    def error(self, message: str) -> NoReturn:
        """Print one line instead of the whole usage."""
        self.exit(BAD_INPUT, f"{self.prog}: {message}; see {self.prog} --help\n")

    def _print_message(self, message: str, file: Any = None) -> None:
        if file is not None and file is sys.stdout:
            output.write(message)  # argparse would drop what cannot be written
            output.flush()
        else:
            output.say(message.rstrip("\n"))

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Refuse an unknown choice, and name the one that was probably meant, or all."""
        choices = list(map(str, action.choices or ()))
        if choices and value not in choices:
            near = difflib.get_close_matches(str(value), choices, n=1)
            hint = f"did you mean {near[0]}?" if near else f"choose from {', '.join(choices)}"
            raise argparse.ArgumentError(action, f"invalid choice: {value!r}; {hint}")

    def option_of(self, field: str) -> str:
        """Returns the option behind the member of a question that the solver refuses, or the member."""
        if field.startswith("--"):
            return field
        place, dot, end = field.partition(".")
        name = f"--{place.partition('[')[0].replace('_', '-')}"
        if place == "limits" and end:
            leg, dot, end = end.partition(".")
            name = f"--{leg}-limits"
        if name in self._known:
            return f"{name}{dot}{end}"
        inner = self.option_of(end) if end else ""
        return inner if inner.startswith("--") else field

    @property
    def _known(self) -> set[str]:
        return {option for action in self._actions for option in action.option_strings}

    def said(self, problem: FieldProblem) -> FieldProblem:
        """Returns a problem with a question as one with the options that ask it."""
        field, message = self.option_of(problem.field), problem.message
        if field in self._known:
            message = re.sub("^unknown field", "does not go with the others", message)
        for words, options in _IN_OPTIONS.items():
            if set(re.findall(r"--[\w-]+", options)) <= self._known:
                message = re.sub(rf"(?<![\w-]){words}(?![\w-])", options, message)

        def option(match: re.Match[str]) -> str:
            name = f"--{match[0].replace('_', '-')}"
            return name if name in self._known else match[0]

        return FieldProblem(field, _MEMBER.sub(option, message))

    def refuse_unknown(self, words: Sequence[str]) -> NoReturn:
        """Name the words that the command does not know, and the option that was meant."""
        known = [name.lstrip("-") for action in self._actions for name in action.option_strings]
        options = [word.partition("=")[0] for word in words if word.startswith("-") and len(word) > 1]
        if not options:
            self.error(f"there is no place for {' '.join(words)!r}")
        near = difflib.get_close_matches(options[0].lstrip("-"), known, n=1)
        self.error(f"unknown option {options[0]}" + (f"; did you mean --{near[0]}?" if near else ""))


STANDARD_INPUT = "-"


def about_geometry() -> str:
    """Returns what is said of the manipulator in the help of a command."""
    from rpr_solver import EXAMPLES  # the start of a service, and the list of commands, do without

    *first, last = EXAMPLES
    return (
        "GEOMETRY is a JSON file, - for standard input, or a built-in manipulator: "
        f'{", ".join(first)} or {last}. Numbers are exact: 17.04, "17.04", "426/25", "5*sqrt(3)/2". A file '
        "may have a name and a unit, or be an answer of rpr-cusps in JSON, whose geometry is used. Or give "
        "the machine itself: base=points 0,0 10,0 5,8; platform=sides 3 4 5 (or equilateral 10, circumradius "
        "sqrt(3)), optionally with orientation=cw; or six numbers: a2x=15.91; a3x=0; …"
    )


class Options(argparse.Action):
    """Collects the values of several options, each with the name of its option."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: object,
        option_string: str | None = None,
    ) -> None:
        """Append one option."""
        del parser
        setattr(namespace, self.dest, [*getattr(namespace, self.dest), (option_string, str(values))])


def add_options(parser: argparse.ArgumentParser, form: str, dest: str, metavar: str, text: str) -> None:
    """Add an option for each leg, such as `--l{}-range`; their values are collected in order."""
    names = (form.format(leg) for leg in FIXED_LEGS)
    parser.add_argument(*names, dest=dest, action=Options, default=[], metavar=metavar, help=text)


def add_geometry(parser: argparse.ArgumentParser, what: str = "a JSON file", **options: Any) -> None:
    """Add the manipulator, or several, and say in the description what may be given as one."""
    head, *status = (parser.description or "").rstrip().partition("\n\nExit status:")
    parser.description = "".join((f"{head}\n\n{about_geometry()}", *status))
    text = f"{what}, -, or a built-in name"
    action = parser.add_argument("geometry", metavar="GEOMETRY", help=text, **options)
    action.completer = _geometries  # type: ignore[attr-defined]  # for argcomplete


def _geometries(prefix: str, **_: object) -> Iterator[str]:
    """Yields the names and paths with this prefix that may be given as a manipulator."""
    from rpr_solver import EXAMPLES

    yield from (name for name in EXAMPLES if name.startswith(prefix))
    place, slash, begin = prefix.rpartition("/")
    folder = Path(f"{place}{slash}")
    for path in sorted(folder.iterdir()) if folder.is_dir() else ():
        if path.name.startswith(begin) and (path.is_dir() or path.suffix == ".json"):
            yield f"{place}{slash}{path.name}{'/' if path.is_dir() else ''}"


def add_lengths(parser: argparse.ArgumentParser, text: str) -> None:
    """Add a length for each leg."""
    add_options(parser, "--l{}", "lengths", "X", text)


def add_slice(parser: argparse.ArgumentParser, text: str) -> None:
    """Add a length for each leg, and `--fixed-leg`."""
    add_lengths(parser, text)
    add_fixed_leg(parser, "length")


def add_fixed_leg(parser: argparse.ArgumentParser, of: str) -> None:
    """Add `--fixed-leg`, which the leg of another option implies."""
    text = f"the fixed leg (default: the leg of the {of}, or 1)"
    parser.add_argument("--fixed-leg", metavar="LEG", help=text)


def add_digits(parser: argparse.ArgumentParser, default: int) -> None:
    """Add `--digits`."""
    of_tables = f"; tables show {PRINTED}" if default > PRINTED else ""
    shown = f"significant digits, at most 1000 (default: {default}{of_tables})"
    parser.add_argument("--digits", metavar="N", help=shown)


def add_format(parser: argparse.ArgumentParser, *more: str) -> None:
    """Add `--format`."""
    forms = ("table", "json", *more)
    parser.add_argument("--format", choices=forms, default="table", help="default: table")
    text = "the same as --format json"
    parser.add_argument("--json", dest="format", action="store_const", const="json", help=text)


def add_ranges(parser: argparse.ArgumentParser, text: str) -> None:
    """Add the range of lengths, and `--fixed-leg`."""
    add_options(parser, "--l{}-range", "ranges", "FROM:TO", text)
    add_fixed_leg(parser, "range")


def add_limits(parser: argparse.ArgumentParser, of: str = "another leg") -> None:
    """Add the joint limits of the legs."""
    add_options(parser, "--l{}-limits", "limits", "MIN:MAX", f"joint limits of {of}")


def add_between(parser: argparse.ArgumentParser, ends: str) -> None:
    """Add the lengths between which the fixed leg may vary on the way between two ends."""
    text = f"it stays fixed, or varies between its lengths at both {ends}"
    parser.add_argument(
        "--between", metavar="FROM:TO", help=f"lengths between which the fixed leg may vary (default: {text})"
    )


def add_requirement(parser: argparse.ArgumentParser, text: str) -> None:
    """Add the options of a requirement; `text` is the help of its range."""
    add_ranges(parser, text)
    parser.add_argument("--max-cusps", metavar="N", help="maximum number of cusps in any slice of the range")
    parser.add_argument("--min-cusps", metavar="N", help="minimum number of cusps in any slice of the range")
    add_limits(parser)
    add_ignored(parser)


def add_ignored(parser: argparse.ArgumentParser) -> None:
    """Add `--ignore-windows`."""
    text = "ignore (but list) windows with other numbers of cusps that are narrower than this"
    parser.add_argument("--ignore-windows", metavar="X", help=text)


def actions_of(parser: argparse.ArgumentParser) -> Callable[[Callable[..., None], str], Any]:
    """Returns what adds an action to a command: name and text are those of the function, kept as ``act``."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)

    def add(act: Callable[..., None], summary: str) -> Any:
        name, text = act.__name__.removeprefix("_"), cleandoc(act.__doc__ or "")
        action = actions.add_parser(name, help=summary, description=text)
        action.set_defaults(act=act)
        return action

    return add


LOCAL = "http://127.0.0.1:8000"


COMPUTED_BY = f"compute with the service at this URL, for example {LOCAL}"
DEADLINE = "with --url: fail if the answer is not ready after this time"


def add_url(parser: argparse.ArgumentParser, deadline: str = DEADLINE) -> None:
    """Add `--url`, and `--deadline` with its help."""
    parser.add_argument("--url", help=COMPUTED_BY)
    parser.add_argument("--deadline", metavar="SECONDS", help=deadline)


def add_job(parser: argparse.ArgumentParser) -> None:
    """Add the id of a job or a batch, and the address of its service."""
    parser.add_argument("job", metavar="JOB", help="the id of a job or a batch")
    add_service(parser)


def add_service(parser: argparse.ArgumentParser) -> None:
    """Add the address of a service, without which there is nothing to do."""
    parser.add_argument("--url", default=LOCAL, help=f"URL of the service (default: {LOCAL})")


SHELLS = ("bash", "zsh", "fish")
_ASKED = "_ARGCOMPLETE"


def _configure_completion(parser: argparse.ArgumentParser) -> None:
    """Add the options of `completion`.

    Options:
        SHELL: bash, zsh or fish
    """
    parser.add_argument("shell", metavar="SHELL", choices=SHELLS)


def _run_completion(args: argparse.Namespace) -> int:
    """Print the code for completion of commands, options and files by the Tab key of a shell.

    examples:
      eval "$(rpr-cusps completion bash)"              in ~/.bashrc
      eval "$(rpr-cusps completion zsh)"               in ~/.zshrc, after compinit
      rpr-cusps completion fish > ~/.config/fish/completions/rpr-cusps.fish
    """
    from argcomplete.shell_integration import shellcode  # few need it, and the start must be quick

    output.write(shellcode(["rpr-cusps"], shell=args.shell))
    return 0


def typed() -> Sequence[str] | None:
    """The words to complete, if a shell asks for that."""
    return os.environ.get("COMP_LINE", "").split()[1:] if _ASKED in os.environ else None


def complete(parser: argparse.ArgumentParser) -> None:
    """Answer a shell, and exit."""
    import argcomplete

    argcomplete.autocomplete(parser)


COMMANDS = {"completion": Command.of(_run_completion, _configure_completion)}
