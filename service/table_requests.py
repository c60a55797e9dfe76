"""From the JSON of `POST /v1/cusp-tables` to an exact, canonical request."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import cast

from rpr_solver import Manipulator
from rpr_solver.errors import FieldProblem, InputError
from service.json_body import JsonNumber
from service.reading import MISSING, Collector, check_keys, fixed_leg, geometry, kind_of, number, read_digits
from service.settings import Limits
from service.slices import Range, check_count
from worker.requests import TableRequest

RANGE_FIELDS = ("start", "stop", "step")


def table_request(body: object, limits: Limits) -> TableRequest:
    """Read a request for a cusp table, as :func:`service.json_body.parse_json` gives it.

    Raises:
        LimitError: the request is right but too large.
        InputError: naming every field at fault.
    """
    if not isinstance(body, dict):
        raise InputError.of("body", f"is {kind_of(body)}; send an object with geometry and l1")
    collect = Collector()
    leg = collect(lambda: fixed_leg(body.get("fixed_leg", JsonNumber("1"))))
    slice_key = f"l{leg or 1}"
    collect(lambda: check_keys(body, ("geometry", slice_key, "digits", "fixed_leg"), "", leg))
    manipulator = collect(lambda: geometry(body.get("geometry", MISSING), limits))
    values = collect(lambda: slice_values(body.get(slice_key, MISSING), slice_key, limits))
    digits = collect(lambda: read_digits(body.get("digits", MISSING), limits))
    collect.finish()
    # finish() has raised if any of them is None
    return TableRequest.of(
        cast(Manipulator, manipulator),
        values or (),
        fixed_leg=leg or 1,
        digits=digits or limits.default_digits,
    )


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
