"""From the JSON of a question for one document to an exact, canonical request."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import cast

from rpr_solver import Manipulator, Requirement, exact_str
from rpr_solver.errors import InputError
from service.schemas.exact_json import JsonNumber
from service.schemas.limits import Limits
from service.schemas.numbers import (
    MISSING,
    Collector,
    check_keys,
    fixed_leg,
    geometry,
    kind_of,
    number,
    read_digits,
    read_samples,
)
from service.schemas.ranges import LengthRange, read_range
from service.schemas.table_requests import slice_values
from worker.answers import censuses, curves
from worker.jobs.requests import DocumentRequest

LEGS = ("l1", "l2", "l3")
CHECK_DIGITS = 30
"""Digits of a check's report when a request does not say."""


def poses_request(body: object, limits: Limits) -> DocumentRequest:
    """Read a request for the poses of a joint vector.

    Raises:
        LimitError: the request is right but too large.
        InputError: naming every field at fault.
    """
    given = _object(body, "geometry, l1, l2 and l3")
    collect = Collector()
    collect(lambda: check_keys(given, ("geometry", *LEGS, "digits")))
    manipulator = collect(lambda: geometry(given.get("geometry", MISSING), limits))
    lengths = [collect(lambda leg=leg: length(given.get(leg, MISSING), leg, limits)) for leg in LEGS]  # type: ignore[misc]
    digits = collect(lambda: read_digits(given.get("digits", MISSING), limits))
    collect.finish()
    # finish() has raised if any of them is None
    return of_poses(cast(Manipulator, manipulator), cast("list[Fraction]", lengths), cast(int, digits))


def census_request(body: object, limits: Limits) -> DocumentRequest:
    """Read a request for a census.

    Raises:
        LimitError: the request is right but too large.
        InputError: naming every field at fault.
    """
    given = _object(body, "geometry")
    collect = Collector()
    collect(lambda: check_keys(given, ("geometry", "fixed_leg", "digits", "range")))
    manipulator = collect(lambda: geometry(given.get("geometry", MISSING), limits))
    leg = collect(lambda: fixed_leg(given.get("fixed_leg", JsonNumber("1"))))
    digits = collect(lambda: read_digits(given.get("digits", MISSING), limits))
    wanted = collect(lambda: read_range(given.get("range", MISSING), limits))
    collect.finish()
    return censuses.census_request(
        cast(Manipulator, manipulator),
        fixed_leg=cast(int, leg),
        digits=cast(int, digits),
        start=cast(LengthRange, wanted).start,
        stop=cast(LengthRange, wanted).stop,
    )


def check_request(body: object, limits: Limits) -> DocumentRequest:
    """Read a request for a check.

    Raises:
        LimitError: the request is right but too large.
        InputError: naming every field at fault.
    """
    given = _object(body, "geometry and requirement")
    collect = Collector()
    collect(lambda: check_keys(given, ("geometry", "requirement", "digits")))
    manipulator = collect(lambda: geometry(given.get("geometry", MISSING), limits))
    digits = collect(lambda: read_digits(given.get("digits", JsonNumber(str(CHECK_DIGITS))), limits))
    wanted = collect(lambda: _requirement(given.get("requirement", MISSING), limits))
    collect.finish()
    # finish() has raised if any of them is None
    content = {
        "geometry": cast(Manipulator, manipulator).to_json(),
        "requirement": cast(Requirement, wanted).to_json(),
        "digits": digits,
    }
    return DocumentRequest("check", content)


def curves_request(body: object, limits: Limits) -> DocumentRequest:
    """Read a request for cusp curves.

    Raises:
        LimitError: the request is right but too large.
        InputError: naming every field at fault.
    """
    given = _object(body, "geometry")
    collect = Collector()
    leg = collect(lambda: fixed_leg(given.get("fixed_leg", JsonNumber("1"))))
    key = f"l{leg or 1}"
    collect(lambda: check_keys(given, ("geometry", key, "samples", "range", "digits", "fixed_leg"), "", leg))
    manipulator = collect(lambda: geometry(given.get("geometry", MISSING), limits))
    digits = collect(lambda: read_digits(given.get("digits", MISSING), limits))
    wanted = collect(lambda: read_range(given.get("range", MISSING), limits))
    lengths = collect(lambda: slice_values(given[key], key, limits)) if key in given else []
    samples = collect(lambda: read_samples(given.get("samples", MISSING), limits))
    if wanted is not None and lengths:
        collect(lambda: wanted.check_inside(lengths, key))
    collect.finish()
    return curves.curves_request(
        cast(Manipulator, manipulator),
        fixed_leg=cast(int, leg),
        digits=cast(int, digits),
        start=cast(LengthRange, wanted).start,
        stop=cast(LengthRange, wanted).stop,
        lengths=cast("list[Fraction]", lengths),
        samples=samples,
    )


def _requirement(value: object, limits: Limits) -> Requirement:
    if value is MISSING:
        raise InputError.of("requirement", "is missing; give an object with range and max_cusps or min_cusps")
    if not isinstance(value, dict):
        raise InputError.of("requirement", f"is {kind_of(value)}; give an object")
    leg = {"fixed_leg": fixed_leg(value["fixed_leg"])} if "fixed_leg" in value else {}
    return Requirement.from_json({**value, **leg}, max_digits=limits.max_number_digits)


def of_poses(manipulator: Manipulator, lengths: list[Fraction], digits: int) -> DocumentRequest:
    """The request for the poses of a joint vector."""
    legs = {leg: exact_str(value) for leg, value in zip(LEGS, lengths, strict=True)}
    return DocumentRequest("poses", {"geometry": manipulator.to_json(), **legs, "digits": digits})


def length(value: object, field: str, limits: Limits) -> Fraction:
    """Read the length of a leg."""
    if value is MISSING:
        raise InputError.of(field, "is missing; give a number > 0")
    found = number(value, field, limits)
    if found <= 0:
        raise InputError.of(field, f"is {exact_str(found)}; a leg length must be > 0")
    return found


def _object(body: object, wanted: str) -> Mapping[str, object]:
    if not isinstance(body, dict):
        raise InputError.of("body", f"is {kind_of(body)}; send an object with {wanted}")
    return body
