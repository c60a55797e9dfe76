"""From the JSON of a question for one document to an exact, canonical request."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import cast

from rpr_solver import Manipulator, exact_str
from rpr_solver.errors import InputError
from service.reading import MISSING, Collector, check_keys, geometry, kind_of, number, read_digits
from service.settings import Limits
from worker.requests import DocumentRequest

LEGS = ("l1", "l2", "l3")


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
