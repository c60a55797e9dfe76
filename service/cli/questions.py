"""Commands that ask one question: an option for each of its members, and its answer as a page."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Literal, get_args, get_origin

from pydantic.fields import FieldInfo

from rpr_solver import DEFAULT_DIGITS
from service.cli import arguments, remote
from service.cli.help import Command
from service.cli.pages import Page, Section, about, rows_of, write_document
from service.schemas.answers import CSV
from service.schemas.lengths import LEGS
from service.schemas.questions import Question

_APART = ("geometry", "deadline_s", "callback_url")
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
) -> Command:
    """Returns the command that asks a question.

    Args:
        question: what is asked.
        description: what the command does; that of the question if missing.
        examples: below the options, or None.
        page: the answer as a person reads it.
        words: member → help of its option; by default what the contract says of it.
        steps: what the progress counts, if the answer may take long.
    """
    text = f"{description or question.description.strip()}\n\n{arguments.GEOMETRY}"
    configure = partial(_configure, question, words or {})
    return Command(text, examples, configure, partial(_run, question, page, steps))


def _members(question: type[Question]) -> dict[str, FieldInfo]:
    fields = ((info.alias or name, info) for name, info in question.model_fields.items())
    return {name: info for name, info in fields if name not in _APART}


def _configure(question: type[Question], words: Mapping[str, str], parser: argparse.ArgumentParser) -> None:
    """Add the options of a question."""
    members = _members(question)
    arguments.add_geometry(parser)
    for name, info in members.items():
        text = words.get(name, (info.description or "").replace("%", "%%"))
        if name == "range":
            arguments.add_ranges(parser, text)
        elif name == "digits":
            arguments.add_digits(parser, info.default if isinstance(info.default, int) else DEFAULT_DIGITS)
        elif name == "certificate":
            arguments.add_certificate(parser)
        elif name == LEGS[0] and "fixed_leg" in members:
            arguments.add_slice(parser, text)
        elif name != "fixed_leg" and not (name in LEGS and "fixed_leg" in members):
            _add(parser, name, info, text)
    arguments.add_format(parser, *(["csv"] if CSV in question.forms else []))
    remote.add_url(parser)


def _add(parser: argparse.ArgumentParser, name: str, info: FieldInfo, text: str) -> None:
    options: dict[str, Any] = {"metavar": "N" if info.annotation is int else "X"}
    if info.annotation is bool:
        options = {"action": "store_true", "default": None}
    elif get_origin(info.annotation) is Literal:
        options = {"choices": get_args(info.annotation)}
    parser.add_argument(_option(name), dest=name, help=text, required=info.is_required(), **options)


def _option(member: str) -> str:
    return f"--{member.replace('_', '-')}"


def _run(
    question: type[Question],
    page: Callable[[Mapping[str, Any]], Page],
    steps: str | None,
    args: argparse.Namespace,
) -> int:
    """Ask a question, and print its answer; returns the exit status."""
    fields = _members(question)
    members: dict[str, object] = {name: getattr(args, name, None) for name in fields}
    names = {name: _option(name) for name in fields}
    if "tolerance" in members:
        members["tolerance"] = arguments.tolerance_of(args.tolerance)
    if "range" in fields:
        members["fixed_leg"], members["range"], names["range"] = arguments.leg_and_range(args)
    elif "fixed_leg" in fields:
        members["fixed_leg"] = arguments.leg_of(args.lengths, args.fixed_leg, "lengths")
        members |= {option[2:]: text for option, text in args.lengths}
    asked = arguments.ask(question, args, {**members, **remote.deadline_of(args)}, arguments.source(names))
    document = remote.answer_of(args.url, asked, steps)
    form = question.forms.get(CSV)
    csv = None if form is None else (lambda answer: form.encode(answer).decode())
    write_document(document, page(document), args.format, csv=csv)
    return 0
