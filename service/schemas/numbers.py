"""Numbers in the input: exact, bounded, and read once."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Annotated, Any, Literal

from pydantic import Field, PlainSerializer, PlainValidator, ValidationInfo, WithJsonSchema

from rpr_solver import DEFAULT_DIGITS, exact_str, parse_exact
from rpr_solver.contract import FIXED_LEGS, MOST_CUSPS, MOST_POSES, letter, number_of
from rpr_solver.errors import InputError, clipped
from rpr_solver.exact.numerals import digit_count
from rpr_solver.triangles import parse_surd
from service.schemas.document import Expected, JsonNumber, Source, json_kind
from service.schemas.limits import MIN_DIGITS, LimitError

NUMBER_PATTERN = r"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,9})?\s*$|^\s*[+-]?\d+/\d+\s*$"

EXACT_NUMBER: dict[str, Any] = {
    "oneOf": [{"type": "number"}, {"type": "string", "pattern": NUMBER_PATTERN}],
    "description": "An exact number: a JSON number, or a string with a decimal or a fraction. Every "
    "digit counts; nothing is rounded to a binary float.",
    "examples": [17.04, "17.04", "426/25", "1.704e1"],
}
"""The schema of a number in a request."""

POSITIVE_PATTERN = NUMBER_PATTERN.replace("[+-]?(", r"\+?(").replace(r"[+-]?\d+/", r"\+?\d+/")
POSITIVE_NUMBER: dict[str, Any] = {
    "oneOf": [{"type": "number", "exclusiveMinimum": 0}, {"type": "string", "pattern": POSITIVE_PATTERN}],
    "description": "An exact number > 0, as a JSON number or a string.",
    "examples": EXACT_NUMBER["examples"],
}
"""The schema of a number that must be positive."""

_PART = r"(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,9})?|\d+/\d+"
_ROOT_PATTERN = rf"^\s*%s(({_PART})\*)?sqrt\(({_PART})\)(/({_PART}))?\s*$"
ROOT_PATTERN = f"{NUMBER_PATTERN}|{_ROOT_PATTERN % '[+-]?'}"
POSITIVE_ROOT_PATTERN = f"{POSITIVE_PATTERN}|{_ROOT_PATTERN % '[+]?'}"
ROOT_NUMBER: dict[str, Any] = {
    "oneOf": [{"type": "number"}, {"type": "string", "pattern": ROOT_PATTERN}],
    "description": "An exact number, which may be a root: a JSON number, or a string with a decimal or a "
    "fraction, perhaps times a root. Every digit counts; nothing is rounded to a binary float.",
    "examples": [17.04, "17.04", "426/25", "sqrt(3)", "5*sqrt(3)/2"],
}
"""The schema of a number of a geometry."""
POSITIVE_ROOT: dict[str, Any] = {
    "oneOf": [
        {"type": "number", "exclusiveMinimum": 0},
        {"type": "string", "pattern": POSITIVE_ROOT_PATTERN},
    ],
    "description": "An exact number > 0, which may be a root, as a JSON number or a string.",
    "examples": ROOT_NUMBER["examples"],
}
"""The schema of a number of a geometry that must be positive."""
SIDE: dict[str, Any] = {
    "oneOf": [{"type": "number", "minimum": 0}, {"type": "string", "pattern": POSITIVE_ROOT_PATTERN}],
    "description": "An exact number >= 0, which may be a root, as a JSON number or a string.",
    "examples": ROOT_NUMBER["examples"],
}
"""The schema of a side of a triangle, of which one may be 0."""

_DEFAULT: Any = object()


def exact_number(value: object, info: ValidationInfo) -> Fraction:
    """Read one exact number: a JSON number or text."""
    if isinstance(value, Fraction | int) and not isinstance(value, bool):
        return Fraction(value)
    if not isinstance(value, str):
        raise InputError.of("", f'is {json_kind(value)}; give a number such as 17.04, "17.04" or "426/25"')
    limits = Source.of(info).limits
    try:
        return parse_exact(str(value), "", max_digits=limits.max_number_digits)
    except InputError:
        if (digits := digit_count(value)) > limits.max_number_digits:
            raise LimitError.of_digits(limits, digits) from None
        if nearest := _nearest_to_root(value):
            message = f"is {clipped(value)}, but only a geometry has roots; the nearest decimal is {nearest}"
            raise InputError.of("", message) from None
        raise


def _nearest_to_root(text: str) -> str | None:
    """The decimal nearest to a root, for a message; None if the text is none."""
    if "sqrt" not in text:
        return None
    try:
        return parse_surd(text, "").decimal(MIN_DIGITS)
    except InputError:
        return None


def list_pattern(number: str) -> str:
    """Returns the pattern of one or more numbers, with semicolons between them, from that of one.

    >>> list_pattern("^a$|^b$")
    '^(a|b)(;(a|b))*$'
    """
    one = f"({number.replace('^', '').replace('$', '')})"
    return f"^{one}(;{one})*$"


def whole_number(value: object, expected: str, *, is_text: bool) -> int:
    """Read an integer: a JSON number, or text on a command line.

    >>> whole_number("3.00e1", "15 to 1000", is_text=True)
    30
    """
    if isinstance(value, int) and not isinstance(value, bool):
        return value
    if not isinstance(value, str if is_text else JsonNumber):
        raise InputError.of("", f"is {json_kind(value)}; give a whole number: {expected}")
    text = str(value)
    # a lone surrogate in a message would be an error of its own
    shown = clipped(text) if text.isprintable() else repr(clipped(text))
    try:
        exact = parse_exact(text, "")
    except InputError:
        raise InputError.of("", f"is {shown}; give a whole number: {expected}") from None
    if exact.denominator != 1:
        raise InputError.of("", f"is {shown}; give a whole number: {expected}")
    return int(exact)


def _whole(value: object, info: ValidationInfo, expected: str) -> int:
    return whole_number(value, expected, is_text=Source.of(info).is_text)


def _flag(value: object) -> bool:
    if not isinstance(value, bool):
        raise InputError.of("", f"is {json_kind(value)}; give true or false")
    return value


def whole_from(least: int, most: int | None = None, what: str = "") -> PlainValidator:
    """Returns the validator of a whole number in a range, with its schema; messages may say what it is."""
    expected = f"{what}{least} {'or more' if most is None else f'to {most}'}"

    def validate(value: object, info: ValidationInfo) -> int:
        number = _whole(value, info, expected)
        if number < least or (most is not None and number > most):
            raise InputError.of("", f"is {clipped(str(number))}; give {expected}")
        return number

    return PlainValidator(validate, json_schema_input_type=Annotated[int, Field(ge=least, le=most)])


def number_where(expected: str, is_right: Callable[[Fraction], bool], schema: Any = Any) -> PlainValidator:
    """Returns the validator of an exact number with a condition, which messages state, and its schema."""

    def validate(value: object, info: ValidationInfo) -> Fraction:
        number = exact_number(value, info)
        if not is_right(number):
            raise InputError.of("", f"is {exact_str(number)}; {expected}")
        return number

    return PlainValidator(validate, json_schema_input_type=schema)


def positive(expected: str, schema: Any = Any) -> PlainValidator:
    """Returns the validator of an exact number > 0."""
    return number_where(expected, lambda number: number > 0, schema)


def _fixed_leg(value: object, info: ValidationInfo) -> int:
    leg = _whole(value, info, "1, 2 or 3")
    if leg not in FIXED_LEGS:
        raise InputError.of("", f"is {clipped(str(value))}; it must be 1, 2 or 3")
    return leg


def _digits(value: object, info: ValidationInfo) -> int:
    limits = Source.of(info).limits
    if value is _DEFAULT:
        value = limits.default_digits
    digits = _whole(value, info, f"{limits.min_digits} to {limits.max_digits}")
    if limits.min_digits <= digits <= limits.max_digits:
        return digits
    limit = "max_digits" if digits > limits.max_digits else "min_digits"
    raise LimitError.exceeded(limits, limit, f"asks for {clipped(str(digits), 20)} digits")


def _samples(value: object, info: ValidationInfo) -> int:
    limits = Source.of(info).limits
    expected = f"1 to {limits.max_samples}"
    samples = _whole(value, info, expected)
    if samples > limits.max_samples:
        raise LimitError.exceeded(limits, "max_samples", f"asks for {clipped(str(samples), 20)} points")
    if samples < 1:
        raise InputError.of("", f"is {samples}; give {expected}")
    return samples


def _deadline(value: object, info: ValidationInfo) -> float:
    limits, seconds = Source.of(info).limits, exact_number(value, info)
    if seconds <= 0:
        raise InputError.of("", f"is {exact_str(seconds)}; give a number of seconds > 0")
    if seconds > limits.deadline_seconds:
        asked = Decimal(seconds.numerator) / seconds.denominator  # of any size
        raise LimitError.exceeded(limits, "deadline_seconds", f"is {asked:.6g} s")
    return float(seconds)


def _count(value: object) -> int:
    # text is accepted here even in JSON, as it was in the first version
    return whole_number(value, "0 or more", is_text=isinstance(value, str))


_AS_TEXT = PlainSerializer(exact_str, return_type=str)

Exact = Annotated[
    Fraction, PlainValidator(exact_number), _AS_TEXT, WithJsonSchema(EXACT_NUMBER), Expected("give a number")
]
"""An exact number."""

Positive = Annotated[
    Fraction,
    PlainValidator(exact_number),
    _AS_TEXT,
    WithJsonSchema(POSITIVE_NUMBER),
    Expected("give a number"),
]
"""An exact number whose document checks that it is positive, in its own words."""

Root = Annotated[str, WithJsonSchema(ROOT_NUMBER)]
"""A number of a geometry, which the library reads."""

PositiveRoot = Annotated[str, WithJsonSchema(POSITIVE_ROOT)]
"""A number of a geometry that must be > 0."""

Side = Annotated[str, WithJsonSchema(SIDE)]
"""A side of a triangle, of which one may be 0."""

Length = Annotated[
    Fraction,
    positive("a leg length must be > 0"),
    _AS_TEXT,
    WithJsonSchema(POSITIVE_NUMBER),
    Expected("give a number > 0"),
]
"""The length of a leg."""

FixedLeg = Annotated[int, PlainValidator(_fixed_leg, json_schema_input_type=Literal[FIXED_LEGS])]
"""The leg whose length is fixed in a slice."""

Flag = Annotated[bool, PlainValidator(_flag, json_schema_input_type=bool)]
"""Whether something is wanted."""

PoseNumber = Annotated[
    int,
    whole_from(1, MOST_POSES, "the number of a pose, "),
    Expected(f"give the number of a pose, 1 to {MOST_POSES}"),
]
"""The number of a pose in the table of all poses of a joint vector."""

Digits = Annotated[int, PlainValidator(_digits, json_schema_input_type=Annotated[int, Field(ge=15, le=1000)])]
"""The requested number of significant digits."""

Samples = Annotated[int, PlainValidator(_samples, json_schema_input_type=Annotated[int, Field(ge=1)])]
"""The requested number of points per cusp curve in each interval."""

DeadlineSeconds = Annotated[
    float, PlainValidator(_deadline, json_schema_input_type=Annotated[float, Field(gt=0)])
]
"""A deadline in seconds."""

Count = Annotated[int, PlainValidator(_count, json_schema_input_type=Annotated[int, Field(ge=0)])]
"""A number of cusps."""


_LAST = letter(MOST_CUSPS)
_CUSP_SCHEMA = (
    Annotated[int, Field(ge=1, le=MOST_CUSPS)]
    | Annotated[str, Field(pattern=f"^[A-{_LAST}a-{_LAST.lower()}]$")]
)


def cusp_number(value: object, info: ValidationInfo) -> int:
    """Read a cusp by its number or its letter."""
    expected = "its number in the table of the slice, 1, 2, …, or its letter, A, B, …"
    if isinstance(value, str) and (Source.of(info).is_text or not isinstance(value, JsonNumber)):
        number = value
    elif isinstance(value, str | int):
        number = str(whole_number(value, expected, is_text=False))
    else:
        raise InputError.of("", f"is {json_kind(value)}; give {expected}")
    try:
        return number_of(number)
    except InputError:
        raise InputError.of("", f"is {clipped(number)!r}; give {expected}") from None


CuspNumber = Annotated[int, PlainValidator(cusp_number, json_schema_input_type=_CUSP_SCHEMA)]
"""A cusp by its number in the table of the slice."""


def cusp_field() -> Any:
    """Returns the field of a cusp."""
    return Field(
        default=1, description="The cusp: its number, from 1, in the cusp table of the slice, or its letter."
    )


def fixed_leg_field() -> Any:
    """Returns the field of the fixed leg."""
    return Field(default=1, description="The leg whose length is fixed in a slice.")


def digits_field(default: int | None = None) -> Any:
    """Returns the field of the digits; without a default, the limits give it."""
    defaults: dict[str, Any] = {"default": default}
    if default is None:
        defaults = {"default_factory": lambda: _DEFAULT, "json_schema_extra": {"default": DEFAULT_DIGITS}}
    return Field(
        validate_default=True, description="Significant digits of every number in the answer.", **defaults
    )
