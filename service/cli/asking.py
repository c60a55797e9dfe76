"""Questions on the command line: asked here or of a running service; and the commands that ask one, with an
option for each of its members and its answer as a page."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, Generic, Literal, TypeVar, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from rpr_solver import DEFAULT_DIGITS, Progress, exact_str
from rpr_solver.contract import LEGS
from rpr_solver.errors import InputError
from service.cli import arguments, output, parsers
from service.cli.digits import printed
from service.cli.output import progress_bar
from service.cli.pages import Page, Section, about, rows_of, write_document
from service.cli.parsers import Command
from service.errors import ServiceError
from service.schemas.answers import CSV, FORMATS, JSON
from service.schemas.numbers import DeadlineSeconds
from service.schemas.questions import Question
from worker.answers import Store, answer

if TYPE_CHECKING:  # httpx is slow to load
    from service.client import ServiceClient

Q = TypeVar("Q", bound=Question)


def deadline_of(args: argparse.Namespace) -> dict[str, object]:
    """Returns the deadline as a member of a question.

    Raises:
        InputError: there is no service that could keep it.
    """
    if args.deadline is not None and args.url is None:
        raise InputError.of("--deadline", "is for jobs of a service; give --url too, or leave it out")
    return {"deadline_seconds": args.deadline}


def seconds_of(args: argparse.Namespace) -> float | None:
    """Returns the deadline of a command that asks several questions.

    Raises:
        InputError: it is invalid, or there is no service that could keep it.
    """
    given = deadline_of(args)["deadline_seconds"]
    return None if given is None else arguments.read_option(DeadlineSeconds, given, "--deadline")


@contextmanager
def client_of(url: str) -> Iterator[ServiceClient]:
    """A client of the service at `--url`."""
    from service.client import ServiceClient

    try:
        client = ServiceClient(url)
    except ServiceError as error:
        raise InputError.of("--url", str(error)) from None
    with client:
        yield client


def document_of(url: str, question: Question, progress: Progress) -> dict[str, Any]:
    """Returns the answer of a service.

    Raises:
        ServiceError: the service refused, failed, or cannot be reached.
    """
    from service.client import Asked

    with client_of(url) as client:
        return client.ask(Asked.of(question), progress).document


def answer_of(url: str | None, question: Question, steps: str | None = None) -> dict[str, Any]:
    """Returns the answer, which is computed here, or by the service at `--url`.

    `steps`: what the progress counts of an answer that is computed here, if that may take long.

    Raises:
        InputError: the question has no answer.
        SolverError: it could not be decided.
        ServiceError: the service refused, failed, or cannot be reached.
    """
    if url is not None:
        with progress_bar(1, "steps") as progress:
            return document_of(url, question, progress)
    if steps is None:
        return answer(question.job_request(), Store())
    with progress_bar(1, steps) as progress:
        return answer(question.job_request(), Store(), progress)


_APART = ("geometry", "deadline_seconds", "callback_url")
_METAVARS = {
    **{"fixed_leg": "LEG", "from": "POSE", "to": "POSE", "cusp": "CUSP", "clearance": "DEGREES"},
    "budget.censuses": "N",
}
_IN_PARTS = (
    *("tolerance", "weights", "from", "to", "vary"),
    *("motion.speed", "motion.acceleration", "motion.jerk"),
)
"""Members of which an option may give the parts: `d1=0.01,a3x=0`."""
_LONG = 40
_HEAD = ("geometry", "geometry_hash", "near", "fixed_leg", "digits", "solver_version")


def page_of(document: Mapping[str, Any]) -> Page:
    """Returns any document as a page: its single values, then a table of each list of objects."""
    shown = {name: value for name, value in document.items() if name not in _HEAD}
    values = [[name, str(value)] for name, value in shown.items() if not isinstance(value, list | dict)]
    sections = [Section("Answer", [["member", "value"], *values] if values else ())]
    for name, value in shown.items():
        if isinstance(value, list) and value and all(isinstance(item, dict) for item in value):
            keys = [key for key in value[0] if all(isinstance(item.get(key), str | int) for item in value)]
            sections.append(Section(name, rows_of(value, keys)))
    return Page(about(document), sections, document.get("digits"))


def command(
    question: type[Q],
    *,
    page: Callable[[Mapping[str, Any]], Page] = page_of,
    steps: str | None = None,
    status: Callable[[Mapping[str, Any]], int] = lambda _document: 0,
    compute: Callable[[Q], dict[str, Any]] | None = None,
    **own: Any,
) -> Command:
    """Returns the command that asks a question.

    Args:
        question: what it asks.
        page: the answer as a person reads it; its docstring is the text of the command, with the help of its
            options, unless it is that of any document, with which the question describes itself.
        steps: what the progress counts, if the answer may take long.
        status: the exit status of an answer.
        compute: computes the answer here, if that needs more than others.
        own: what more :class:`Options` takes.
    """
    options = Options(question, parsers.said_of(page), **own)
    text = question.description if page is page_of else parsers.text_of(page)

    def run(args: argparse.Namespace) -> int:
        asked = options.asked(args)
        document = compute(asked) if compute and args.url is None else answer_of(args.url, asked, steps)
        write(question, document, page(shown(args, asked, document, steps)), args.format)
        return status(document)

    return Command(text, options.configure, run)


def shown(
    args: argparse.Namespace, asked: Question, document: dict[str, Any], steps: str | None
) -> dict[str, Any]:
    """Returns a document as a page has it: with the digits that are to be printed."""

    def finer(digits: int) -> dict[str, Any]:
        return answer_of(args.url, asked.model_copy(update={"digits": digits}), steps)

    return printed(document, arguments.printed_digits(args), finer) if args.format == "table" else document


def write(question: type[Question], document: dict[str, Any], page: Page, name: str) -> None:
    """Print an answer in a form of its question, or as a page."""
    forms, media = question.forms, FORMATS.get(name, "")
    if media in forms and media not in (JSON, CSV):
        output.write(forms[media].encode(document).decode())
        return
    csv = (lambda document: forms[CSV].encode(document).decode()) if CSV in forms else None
    write_document(document, page, name, csv=csv)


_OWN: Mapping[str, Callable[[argparse.ArgumentParser, str], None]] = {
    "range": parsers.add_ranges,
    "limits": parsers.add_limits,
    "between": parsers.add_between,
    "requirement": parsers.add_requirement,
}
"""Members with options of their own."""


@dataclass(frozen=True)
class Options(Generic[Q]):
    """An option for each member of a question.

    Attributes:
        question: what is asked.
        words: member → help of its option; by default what the contract says of it. The members of a member
            have options, too: `motion.speed`.
        names: member → its option, if that has another name; empty if it has none.
        readers: member → what its text means.
        others: member → more names of its option.
        deadline: what `--deadline` does, if it needs no service.
    """

    question: type[Q]
    words: Mapping[str, str] = field(default_factory=dict)
    names: Mapping[str, str] = field(default_factory=dict)
    readers: Mapping[str, Callable[[str], object]] = field(default_factory=dict)
    others: Mapping[str, str] = field(default_factory=dict)
    deadline: str | None = None

    @cached_property
    def members(self) -> dict[str, FieldInfo]:
        """The members that have options."""
        found: dict[str, FieldInfo] = {}
        for name, info in self.question.model_fields.items():
            member = info.alias or name
            inner = None if member in (*_APART, *_OWN, *_IN_PARTS) else _model_in(info.annotation)
            parts = {} if inner is None else inner.model_fields
            found |= {f"{member}.{part}": _optional(parts[part]) for part in parts} or {member: info}
        return {name: info for name, info in found.items() if name not in _APART and self._option(name)}

    def _option(self, member: str) -> str:
        return self.names.get(member, f"--{member.rpartition('.')[2].replace('_', '-')}")

    @property
    def _is_of_slice(self) -> bool:
        """Whether a question may give the length of its fixed leg, and of no other."""
        leg = self.members.get(LEGS[0])
        return "fixed_leg" in self.members and leg is not None and not leg.is_required()

    @property
    def _has_points(self) -> bool:
        """Whether it may give many lengths, within a range."""
        leg = self.members.get(LEGS[0])
        return "range" in self.members and leg is not None and get_origin(leg.annotation) is tuple

    def configure(self, parser: argparse.ArgumentParser, *formats: str) -> None:
        """Add the options, and those of all questions; with more formats than the answer has over HTTP."""
        self.add_members(parser)
        forms = self.question.forms.keys() - {JSON}
        parsers.add_format(parser, *(name for name, media in FORMATS.items() if media in forms), *formats)
        parsers.add_url(parser, self.deadline or parsers.DEADLINE)

    def add_members(self, parser: argparse.ArgumentParser) -> None:
        """Add the options of the members."""
        has_range = not self.members.keys().isdisjoint({"range", "requirement"})
        kinds = dict(_OWN)
        if self._is_of_slice:
            kinds |= dict.fromkeys(("fixed_leg", *LEGS), lambda *_: None)
            kinds[LEGS[0]] = parsers.add_lengths if has_range else parsers.add_slice
        elif has_range:
            kinds["fixed_leg"] = lambda *_: None
        parsers.add_geometry(parser)
        for name, info in self.members.items():
            text = self.words.get(name) or _help(info)
            if name == "digits":
                parsers.add_digits(parser, info.default if isinstance(info.default, int) else DEFAULT_DIGITS)
            elif name in kinds:
                kinds[name](parser, text)
            else:
                self._add(name, info, parser, text)

    def _add(self, name: str, info: FieldInfo, parser: argparse.ArgumentParser, text: str) -> None:
        kinds = (info.annotation, *get_args(info.annotation))
        choices = next((get_args(kind) for kind in kinds if get_origin(kind) is Literal), None)
        options: dict[str, Any] = {"metavar": _METAVARS.get(name, "N" if int in kinds else "X")}
        if info.annotation is bool:
            options = {"action": "store_true", "default": None}
        elif choices is not None:
            options = {"choices": choices, "metavar": "WORD" if len("".join(choices)) > _LONG else None}
        names = (self._option(name), *([self.others[name]] if name in self.others else []))
        parser.add_argument(*names, dest=name, help=text, required=info.is_required(), **options)

    def asked(self, args: argparse.Namespace, **others: object) -> Q:
        """Returns the question that the options ask, with other members.

        Raises:
            InputError: naming the faulty options and members of the geometry.
        """
        members = {name: self._read(name, getattr(args, name, None)) for name in self.members}
        members.pop("digits", None)  # which all questions read alike
        names = {name: self._option(name) for name in self.members if name not in ("limits", "requirement")}
        if "range" in members:
            names["range"] = f"--l{args.fixed_leg or 1}-range"
        if "requirement" in members:
            members["requirement"], places = arguments.requirement_if_any(args, self._is_of_slice)
            names |= places | {
                "requirement": places.get("requirement.range", f"--l{args.fixed_leg or 1}-range")
            }
        self._take_leg(args, members, names)
        if "limits" in members:
            limits, places = arguments.joint_limits(args.limits)
            members["limits"], names = limits or None, names | places
        if "between" in members:
            members["between"] = arguments.between_of(args)
        deadline = {"deadline_seconds": args.deadline} if self.deadline else deadline_of(args)
        return arguments.ask(
            self.question, args, _nested({**members, **others}) | deadline, arguments.source(names)
        )

    def _read(self, name: str, text: str | None) -> object:
        if name in _IN_PARTS:
            return arguments.parts_of(text)
        return self.readers[name](text) if text is not None and name in self.readers else text

    def _take_leg(self, args: argparse.Namespace, members: dict[str, object], names: dict[str, str]) -> None:
        """Add the fixed leg with its range, or with its length in a slice, as the options give them."""
        ranges, lengths = getattr(args, "ranges", []), getattr(args, "lengths", [])
        if self._has_points:
            self._take_points(args, members, names)
            return
        if "range" in members and (ranges or not self._is_of_slice):
            members["fixed_leg"], members["range"], names["range"] = arguments.leg_and_range(args)
        if self._is_of_slice and (lengths or not ranges):
            own = lengths if len({option for option, _ in lengths}) == 1 else []  # several fix no leg
            members["fixed_leg"] = arguments.leg_of(own, args.fixed_leg, "lengths")
        members |= arguments.lengths_once(lengths)

    def _take_points(
        self, args: argparse.Namespace, members: dict[str, object], names: dict[str, str]
    ) -> None:
        """Add the fixed leg with its range, and with many lengths: those of its options and of steps."""
        points: list[object] = [text for _, text in args.lengths]
        if len(args.ranges) == 1 and args.ranges[0][1].count(":") == 2:
            [(option, text)] = args.ranges
            points = [*arguments.range_values(text, option, arguments.source()), *points]
            args.ranges = [(option, text.rpartition(":")[0])]
        leg = arguments.leg_of([*args.ranges, *args.lengths], args.fixed_leg, "lengths")
        _, members["range"], names["range"] = arguments.leg_and_range(args)
        members |= {"fixed_leg": leg, f"l{leg}": points or None}
        names[f"l{leg}"] = f"--l{leg}" if args.lengths else names["range"]


def _model_in(annotation: Any) -> type[BaseModel] | None:
    """The model of a member that is an object, and nothing else."""
    kinds = [kind for kind in get_args(annotation) or (annotation,) if kind is not type(None)]
    is_model = len(kinds) == 1 and isinstance(kinds[0], type) and issubclass(kinds[0], BaseModel)
    return kinds[0] if is_model else None


def _optional(info: FieldInfo) -> FieldInfo:
    """A member of an object that may be missing."""
    default = None if info.is_required() else info.get_default()
    return FieldInfo(annotation=info.annotation, default=default, description=info.description)


def _help(info: FieldInfo) -> str:
    """What the contract says of a member, with its default."""
    text = (info.description or "").replace("%", "%%").replace("`", "").rstrip(".")
    text = text[:1].lower() + text[1:]
    if isinstance(info.default, bool) or not isinstance(info.default, int | str | Fraction):
        return text
    default = exact_str(info.default) if isinstance(info.default, Fraction) else info.default
    return f"{text} (default: {default})" if default != "" else text


def _nested(members: Mapping[str, object]) -> dict[str, object]:
    """Returns members, with those of `motion.speed` in an object."""
    found: dict[str, Any] = {}
    for name, value in members.items():
        place, _, part = name.partition(".")
        if part and value is not None:
            found.setdefault(place, {})[part] = value
        elif not part:
            found[place] = value
    return found
