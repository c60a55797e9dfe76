"""Questions on the command line: asked here or of a running service; and the commands that ask one, with an
option for each of its members and its answer as a page."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import closing, contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any, Literal, get_args, get_origin

from pydantic import TypeAdapter
from pydantic.fields import FieldInfo

from rpr_solver import DEFAULT_DIGITS, Progress
from rpr_solver.contract import LEGS, document_head
from rpr_solver.errors import InputError
from service.cli import arguments, output, parsers
from service.cli.output import progress_bar
from service.cli.pages import Page, Section, about, rows_of, write_document
from service.cli.parsers import Command
from service.errors import ServiceError
from service.schemas.answers import CSV, FORMATS, JSON
from service.schemas.document import named, part
from service.schemas.limits import DEFERRED
from service.schemas.numbers import DeadlineSeconds
from service.schemas.questions import Question
from service.schemas.tables import CuspTableRequest
from worker.answers.requests import Store, answer

if TYPE_CHECKING:  # httpx is slow to load
    from service.client import ServiceClient


_DEADLINE: TypeAdapter[float | None] = TypeAdapter(DeadlineSeconds, config=DEFERRED)


def deadline_of(args: argparse.Namespace) -> dict[str, object]:
    """Returns the deadline as a member of a question.

    Raises:
        InputError: there is no service that could keep it.
    """
    if args.deadline is not None and args.url is None:
        raise InputError.of("--deadline", "is for jobs of a service; give --url too, or leave it out")
    return {"deadline_s": args.deadline}


def seconds_of(args: argparse.Namespace) -> float | None:
    """Returns the deadline of a command that asks several questions.

    Raises:
        InputError: it is none, or there is no service that could keep it.
    """
    text = deadline_of(args)["deadline_s"]
    if text is None:
        return None
    with named("--deadline"):
        return part(_DEADLINE.validate_python, text, arguments.source())


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
    if url is None and steps is None:
        return answer(question.job_request(), Store())
    with progress_bar(1, "steps" if url is not None else steps or "steps") as progress:
        if url is None:
            return answer(question.job_request(), Store(), progress)
        return document_of(url, question, progress)


def slices_of(
    client: ServiceClient, question: CuspTableRequest, progress: Progress
) -> tuple[dict[str, Any], Generator[Mapping[str, Any], None, None]]:
    """Returns the head of a cusp table, and its slices as a service computes them."""
    from service.client import Asked

    head = document_head(question.geometry, question.digits, question.fixed_leg)
    head["solver_version"] = client.version()["solver_version"]
    count = len(question.content()["l1"])

    def counted() -> Generator[Mapping[str, Any], None, None]:
        with closing(client.slices(Asked.of(question))) as slices:
            for done, answered in enumerate(slices, 1):
                yield answered
                progress(done, count)

    return head, counted()


_APART = ("geometry", "deadline_s", "callback_url")
_METAVARS = {"fixed_leg": "LEG", "to": "LENGTHS"}
_IN_PARTS = ("tolerance", "weights", "to")
"""Members of which an option gives the parts: `d1=0.01,a3x=0`."""
_HEAD = ("geometry", "geometry_hash", "fixed_leg", "digits", "solver_version")


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
    question: type[Question],
    description: str | None = None,
    examples: str | None = None,
    *,
    page: Callable[[Mapping[str, Any]], Page] = page_of,
    words: Mapping[str, str] | None = None,
    steps: str | None = None,
    status: Callable[[Mapping[str, Any]], int] = lambda _document: 0,
) -> Command:
    """Returns the command that asks a question.

    Args:
        question: what is asked.
        description: what the command does; that of the question if missing.
        examples: below the options, or None.
        page: the answer as a person reads it.
        words: member → help of its option; by default what the contract says of it.
        steps: what the progress counts, if the answer may take long.
        status: the exit status of an answer.
    """
    head, *others = (description or question.description.strip()).partition("\n\nExit status:")
    text = f"{head}\n\n{parsers.GEOMETRY}{''.join(others)}"
    configure = partial(_configure, question, words or {})

    def run(args: argparse.Namespace) -> int:
        document = answer_of(args.url, _asked(question, args), steps)
        form = question.forms.get(FORMATS.get(args.format, ""))
        if form is not None and args.format == "svg":
            output.write(form.encode(document).decode())
        else:
            csv = None if CSV not in question.forms else partial(_csv, question)
            write_document(document, page(document), args.format, csv=csv)
        return status(document)

    return Command(text, examples, configure, run)


def _csv(question: type[Question], document: Mapping[str, Any]) -> str:
    return question.forms[CSV].encode(document).decode()


def _members(question: type[Question]) -> dict[str, FieldInfo]:
    fields = ((info.alias or name, info) for name, info in question.model_fields.items())
    return {name: info for name, info in fields if name not in _APART}


def _is_of_slice(members: Mapping[str, FieldInfo]) -> bool:
    """Whether a question may give the length of its fixed leg, and of no other."""
    return "fixed_leg" in members and LEGS[0] in members and not members[LEGS[0]].is_required()


_OWN: Mapping[str, Callable[[argparse.ArgumentParser, str], None]] = {
    "range": parsers.add_ranges,
    "limits": parsers.add_limits,
    "between": parsers.add_between,
    "requirement": parsers.add_requirement,
    "certificate": lambda parser, _: parsers.add_certificate(parser),
}
"""Members with options of their own."""


def _configure(question: type[Question], words: Mapping[str, str], parser: argparse.ArgumentParser) -> None:
    """Add the options of a question."""
    members = _members(question)
    has_range = not members.keys().isdisjoint({"range", "requirement"})
    kinds = dict(_OWN)
    if _is_of_slice(members):
        kinds |= dict.fromkeys(("fixed_leg", *LEGS), lambda *_: None)
        kinds[LEGS[0]] = _add_lengths if has_range else parsers.add_slice
    elif has_range:
        kinds["fixed_leg"] = lambda *_: None
    parsers.add_geometry(parser)
    for name, info in members.items():
        text = words.get(name, (info.description or "").replace("%", "%%"))
        if name == "digits":
            parsers.add_digits(parser, info.default if isinstance(info.default, int) else DEFAULT_DIGITS)
        else:
            kinds.get(name, partial(_add, name, info))(parser, text)
    forms = (name for name, media in FORMATS.items() if media != JSON and media in question.forms)
    parsers.add_format(parser, *forms)
    parsers.add_url(parser)


def _add_lengths(parser: argparse.ArgumentParser, text: str) -> None:
    parsers.add_options(parser, "--l{}", "lengths", "X", text)


def _add(name: str, info: FieldInfo, parser: argparse.ArgumentParser, text: str) -> None:
    options: dict[str, Any] = {"metavar": _METAVARS.get(name, "N" if info.annotation is int else "X")}
    if info.annotation is bool:
        options = {"action": "store_true", "default": None}
    elif get_origin(info.annotation) is Literal:
        options = {"choices": get_args(info.annotation)}
    parser.add_argument(_option(name), dest=name, help=text, required=info.is_required(), **options)


def _option(member: str) -> str:
    return f"--{member.replace('_', '-')}"


def _asked(question: type[Question], args: argparse.Namespace) -> Question:
    """Returns the question that the options ask."""
    fields = _members(question)
    members: dict[str, object] = {name: getattr(args, name, None) for name in fields}
    names = {name: _option(name) for name in fields if name not in ("limits", "requirement")}
    members |= {name: arguments.tolerance_of(getattr(args, name)) for name in _IN_PARTS if name in fields}
    if "requirement" in fields:
        members["requirement"], places = arguments.requirement_if_any(args)
        names |= places
    _take_leg(fields, args, members, names)
    if "limits" in fields:
        limits, places = arguments.joint_limits(args.limits)
        members["limits"], names = limits or None, names | places
    if "between" in fields:
        members["between"] = arguments.between_of(args)
    return arguments.ask(question, args, {**members, **deadline_of(args)}, arguments.source(names))


def _take_leg(
    fields: Mapping[str, FieldInfo],
    args: argparse.Namespace,
    members: dict[str, object],
    names: dict[str, str],
) -> None:
    """Add the fixed leg with its range, or with its length in a slice, as the options give them."""
    ranges, lengths = getattr(args, "ranges", ()), getattr(args, "lengths", ())
    is_of_slice = _is_of_slice(fields)
    if "range" in fields and (ranges or not is_of_slice):
        members["fixed_leg"], members["range"], names["range"] = arguments.leg_and_range(args)
    if is_of_slice and (lengths or not ranges):
        members["fixed_leg"] = arguments.leg_of(lengths, args.fixed_leg, "lengths")
    members |= {option[2:]: text for option, text in lengths}
