"""From the JSON of `POST /v1/cusp-tables` to an exact, canonical request."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import cast

from rpr_solver import Manipulator
from rpr_solver.errors import FieldProblem, InputError
from service.schemas.exact_json import JsonNumber
from service.schemas.lengths import Range, check_count
from service.schemas.limits import LimitError, Limits
from service.schemas.numbers import (
    MISSING,
    Collector,
    check_keys,
    fixed_leg,
    geometry,
    kind_of,
    number,
    read_digits,
)
from worker.answers.article import article_request
from worker.jobs.requests import DocumentRequest, TableRequest

RANGE_FIELDS = ("start", "stop", "step")
ARTICLE = "article"
METHODS = ("fast", ARTICLE)


def table_request(body: object, limits: Limits) -> TableRequest | DocumentRequest:
    """Read a request for a cusp table, as :func:`service.schemas.exact_json.parse_json` gives it.

    By the article's algorithm it is a document of its own kind.

    Raises:
        LimitError: the request is right but too large.
        InputError: naming every field at fault.
    """
    if not isinstance(body, dict):
        raise InputError.of("body", f"is {kind_of(body)}; send an object with geometry and l1")
    collect = Collector()
    leg = collect(lambda: fixed_leg(body.get("fixed_leg", JsonNumber("1"))))
    slice_key = f"l{leg or 1}"
    collect(lambda: check_keys(body, ("geometry", slice_key, "digits", "fixed_leg", "method"), "", leg))
    method = collect(lambda: read_method(body.get("method", MISSING), leg))
    manipulator = collect(lambda: geometry(body.get("geometry", MISSING), limits))
    values = collect(lambda: slice_values(body.get(slice_key, MISSING), slice_key, limits))
    digits = collect(lambda: read_digits(body.get("digits", MISSING), limits))
    if method == ARTICLE:
        collect(lambda: check_article_slices(values or (), limits))
    collect.finish()
    # finish() has raised if any of them is None
    if method == ARTICLE:
        return article_request(cast(Manipulator, manipulator), values or (), cast(int, digits))
    return TableRequest.of(
        cast(Manipulator, manipulator),
        values or (),
        fixed_leg=leg or 1,
        digits=digits or limits.default_digits,
    )


def read_method(value: object, leg: int | None) -> str:
    """Read by which algorithm a table is wanted; the article's is for leg 1."""
    if value is MISSING:
        return METHODS[0]
    if value not in METHODS or not isinstance(value, str):
        said = f"{value[:40]!r}" if isinstance(value, str) else kind_of(value)
        raise InputError.of("method", f"is {said}; it must be one of {', '.join(METHODS)}")
    if value == ARTICLE and leg not in (None, 1):
        raise InputError.of("method", f"is article, which fixes leg 1, but fixed_leg is {leg}")
    return str(value)


def check_article_slices(values: Sequence[Fraction], limits: Limits) -> None:
    """Refuse more slices than the article's algorithm is given at once; each takes it a second or more."""
    if len(values) > limits.max_article_slices:
        sent = f"asks for {len(values)} slices by the article's method"
        raise LimitError("l1", "max_article_slices", limits.max_article_slices, sent)


def slice_values(value: object, field: str, limits: Limits) -> list[Fraction]:
    """Read the slices: one number, a list of them, or an object with start, stop and step."""
    if value is MISSING:
        raise InputError.of(
            field, 'is missing; give a number, a list of numbers, or {"start": …, "stop": …, "step": …}'
        )
    if isinstance(value, dict):
        return _range(value, field, limits)
    if not isinstance(value, list):
        return [number(value, field, limits)]
    if not value:
        raise InputError.of(field, "is an empty list; give at least one number")
    check_count(len(value), limits.max_slices, field)
    collect = Collector()
    found = [
        collect(lambda i=i, item=item: number(item, f"{field}[{i}]", limits))  # type: ignore[misc]
        for i, item in enumerate(value)
    ]
    collect.finish()
    return [x for x in found if x is not None]


def _range(value: Mapping[str, object], field: str, limits: Limits) -> list[Fraction]:
    collect = Collector()
    collect(lambda: check_keys(value, RANGE_FIELDS, f"{field}.", 1))
    found: dict[str, Fraction | None] = {}
    for name in RANGE_FIELDS:
        if name not in value:
            collect.problems.append(FieldProblem(f"{field}.{name}", "is missing; give a number"))
        else:
            found[name] = collect(lambda name=name: number(value[name], f"{field}.{name}", limits))  # type: ignore[misc]
    collect.finish()
    start, stop, step = (cast(Fraction, found[name]) for name in RANGE_FIELDS)
    return Range(start, stop, step, field).values(limits.max_slices)
