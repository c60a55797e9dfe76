"""The parts of request bodies: exact, bounded, and with every fault named."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Collection, Mapping
from fractions import Fraction
from typing import TypeVar

from rpr_solver import Manipulator, parse_exact
from rpr_solver.errors import FieldProblem, InputError
from service.schemas.exact_json import JsonNumber
from service.schemas.limits import LimitError, Limits

T = TypeVar("T")

FIXED_LEGS = (1, 2, 3)
GEOMETRY_FIELDS = ("a2x", "a3x", "a3y", "d1", "d2", "d3", "orientation")
MISSING = object()
"""Stands for a field that was not sent."""

_DECIMAL = re.compile(r"[+-]?0*(\d*)(?:\.(\d*?)0*)?(?:[eE]([+-]?\d+))?", re.ASCII)
_LISTED = 20


class Collector:
    """Runs checks and keeps what they complain of, so that one answer names every fault."""

    def __init__(self) -> None:
        self.problems: list[FieldProblem] = []
        self.limit: LimitError | None = None

    def __call__(self, check: Callable[[], T]) -> T | None:
        try:
            return check()
        except LimitError as error:
            self.limit = self.limit or error
            self.problems.extend(error.problems)
        except InputError as error:
            self.problems.extend(error.problems)
        return None

    def finish(self) -> None:
        """Raise what was collected, if anything was."""
        if self.limit is not None and len(self.problems) == len(self.limit.problems):
            raise self.limit
        if self.problems:
            raise InputError(self.problems)


def geometry(value: object, limits: Limits) -> Manipulator:
    """Read the geometry object of the contract."""
    if value is MISSING:
        raise InputError.of("geometry", f"is missing; give an object with {', '.join(GEOMETRY_FIELDS[:-1])}")
    if not isinstance(value, dict):
        raise InputError.of(
            "geometry", f"is {kind_of(value)}; give an object with {', '.join(GEOMETRY_FIELDS[:-1])}"
        )
    collect = Collector()
    collect(lambda: check_keys(value, GEOMETRY_FIELDS, "geometry.", 1))
    for name in GEOMETRY_FIELDS[:-1]:
        if name not in value:
            collect.problems.append(FieldProblem(f"geometry.{name}", "is missing; give a number"))
        else:
            collect(lambda name=name: number(value[name], f"geometry.{name}", limits))  # type: ignore[misc]
    if not isinstance(value.get("orientation", "ccw"), str):
        collect.problems.append(
            FieldProblem("geometry.orientation", f'is {kind_of(value["orientation"])}; give "ccw" or "cw"')
        )
    collect.finish()
    return Manipulator.from_json(value, max_digits=limits.max_number_digits)


def number(value: object, field: str, limits: Limits) -> Fraction:
    """Read one exact number: a JSON number or a string."""
    if not isinstance(value, str):
        raise InputError.of(field, f'is {kind_of(value)}; give a number such as 17.04, "17.04" or "426/25"')
    try:
        return parse_exact(str(value), field, max_digits=limits.max_number_digits)
    except InputError:
        digits = digits_of(value)
        if digits > limits.max_number_digits:
            sent = (
                f"a number with {digits} digits"
                if digits < 10**20
                else "a number with more than 10^20 digits"
            )
            raise LimitError(field, "max_number_digits", limits.max_number_digits, sent) from None
        raise


def fixed_leg(value: object) -> int:
    """Read the number of the leg whose length is fixed in a slice."""
    found = whole(value, "fixed_leg", "1, 2 or 3")
    if found not in FIXED_LEGS:
        raise InputError.of("fixed_leg", f"is {str(value)[:40]}; it must be 1, 2 or 3")
    return found


def digits_in_range(digits: int, limits: Limits) -> int:
    """Check the number of significant digits against the limits."""
    if digits > limits.max_digits:
        raise LimitError("digits", "max_digits", limits.max_digits, f"asks for {_short(digits)} digits")
    if digits < limits.min_digits:
        raise LimitError("digits", "min_digits", limits.min_digits, f"asks for {_short(digits)} digits")
    return digits


def digits_of(text: str) -> int:
    """How many digits the numerator or the denominator of a written number has, at most; 0 if it is none."""
    if "/" in text:
        return max(len(part.strip().lstrip("+-0")) for part in text.split("/"))
    match = _DECIMAL.fullmatch(text.strip())
    if match is None:
        return 0
    whole, part, exponent = match[1] or "", match[2] or "", match[3] or "0"
    if len(exponent.lstrip("+-0")) > 20:
        return 10**20
    shift = int(exponent) - len(part)
    return len(whole + part) + shift if shift >= 0 else max(len((whole + part).lstrip("0")), 1 - shift)


def kind_of(value: object) -> str:
    """What kind of JSON value this is, as a message says it."""
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, JsonNumber):
        return "a number"
    kinds: dict[type, str] = {str: "a string", list: "a list", dict: "an object"}
    return kinds.get(type(value), type(value).__name__)


def check_keys(
    value: Mapping[str, object], known: Collection[str], prefix: str = "", leg: int | None = 1
) -> None:
    """Refuse unknown fields; `leg` is the fixed one, if it could be read."""
    problems: list[FieldProblem] = []
    for name in value:
        if name in known or (leg is None and name in ("l2", "l3")):
            continue
        if len(problems) == _LISTED:
            break
        if not prefix and f"l{leg}" in known and name in ("l1", "l2", "l3"):
            hint = f"with fixed_leg {leg} the slices are l{leg}"
        else:
            near = difflib.get_close_matches(name[:60], known, n=1, cutoff=0.5)
            hint = f"did you mean {near[0]}?" if near else f"known are {', '.join(known)}"
        problems.append(FieldProblem(f"{prefix}{name[:60]}", f"unknown field; {hint}"))
    if problems:
        raise InputError(problems)


def whole(value: object, field: str, wanted: str) -> int:
    """Read a whole number."""
    if not isinstance(value, JsonNumber):
        raise InputError.of(field, f"is {kind_of(value)}; give the number {wanted}")
    try:
        exact = parse_exact(str(value), field)
    except InputError:
        raise InputError.of(field, f"is {value[:40]}; give {wanted}") from None
    if exact.denominator != 1:
        raise InputError.of(field, f"is {value[:40]}; give the whole number {wanted}")
    return int(exact)


def read_digits(value: object, limits: Limits) -> int:
    """Read the number of significant digits that are wanted."""
    if value is MISSING:
        return limits.default_digits
    return digits_in_range(whole(value, "digits", f"{limits.min_digits} to {limits.max_digits}"), limits)


def read_samples(value: object, limits: Limits) -> int | None:
    """Read how many points each interval of a cusp curve shall have; None when that is not said."""
    if value is MISSING or value is None:
        return None
    found = whole(value, "samples", f"1 to {limits.max_samples}")
    if found > limits.max_samples:
        raise LimitError("samples", "max_samples", limits.max_samples, f"asks for {_short(found)} points")
    if found < 1:
        raise InputError.of("samples", f"is {found}; give 1 to {limits.max_samples}")
    return found


def _short(number: int) -> str:
    text = str(number)
    return text if len(text) <= 20 else f"{text[:20]}…"
