"""What motions are asked by: a cusp, poses at the ends, lengths between which a leg may vary, a clearance."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Annotated, Any, ClassVar, Literal, TypeAlias

from pydantic import Field, PlainValidator, ValidationInfo

from rpr_solver import exact_str
from rpr_solver.contract import FIXED_LEGS, LEGS, MOST_CUSPS, MOST_POSES, letter, number_of
from rpr_solver.errors import FieldProblem, InputError
from service.schemas.document import Document, JsonNumber, Source, given, json_kind, part
from service.schemas.lengths import NEEDED
from service.schemas.numbers import Exact, Length, PoseNumber, exact_number, positive, whole_number

_LAST = letter(MOST_CUSPS)
BEST = "best"


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
        raise InputError.of("", f"is {number[:40]!r}; give {expected}") from None


CuspNumber = Annotated[int, PlainValidator(cusp_number, json_schema_input_type=_CUSP_SCHEMA)]
"""A cusp by its number in the table of the slice."""


def cusp_field() -> Any:
    """Returns the field of a cusp."""
    return Field(
        default=1, description="The cusp: its number, from 1, in the cusp table of the slice, or its letter."
    )


class Between(Document):
    """The lengths between which the fixed leg may vary."""

    expected: ClassVar[str] = 'give an object with "from" and "to"'

    start: Length = Field(alias="from", description="The lower end.")
    stop: Length = Field(alias="to", description="The upper end.")


Duration = Annotated[Fraction, positive("a duration must be > 0", Length)]
"""The time of a motion."""


def _clearance(value: object, info: ValidationInfo) -> str | None:
    if value is None or value == BEST:
        return None if value is None else BEST
    expected = f"give {BEST!r} or a number of degrees > 0"
    if isinstance(value, str) and value.strip().isalpha():
        raise InputError.of("", f"is {value[:40]!r}; {expected}")
    clearance = exact_number(value, info)
    if clearance <= 0:
        raise InputError.of("", f"is {exact_str(clearance)}; {expected}")
    return exact_str(clearance)


AskedClearance = Annotated[
    str | None, PlainValidator(_clearance, json_schema_input_type=Literal["best"] | Length)
]
"""How far a path is to keep from singular poses, in its canonical form."""


class AskedJoints(Document):
    """A joint vector."""

    expected: ClassVar[str] = "give an object with l1, l2 and l3"

    l1: Length = Field(description="The length of leg 1.")
    l2: Length = Field(description="The length of leg 2.")
    l3: Length = Field(description="The length of leg 3.")

    def lengths(self) -> dict[str, str]:
        """The canonical form."""
        return {leg: exact_str(getattr(self, leg)) for leg in LEGS}


class NumberedPose(AskedJoints):
    """A pose of a joint vector."""

    expected: ClassVar[str] = "give an object with l1, l2, l3 and pose"

    pose: PoseNumber = Field(description="Its number, from 1, in the answer of /v1/poses.")

    def content(self) -> dict[str, Any]:
        """The canonical form."""
        return {**self.lengths(), "pose": self.pose}


class AngledPose(Document):
    """A pose given by the orientation of the platform, the angle of the fixed leg and its length; exact."""

    expected: ClassVar[str] = "give an object with alpha_deg, theta1_deg and l1"

    alpha_deg: Exact = Field(description="The orientation of the platform, in degrees.")
    theta1_deg: Exact = given("The angle of leg 1, in degrees. With `fixed_leg` 2 or 3 use its own.")
    theta2_deg: Exact = given("The angle of leg 2, with `fixed_leg` 2.")
    theta3_deg: Exact = given("The angle of leg 3, with `fixed_leg` 3.")
    l1: Length = given("The length of leg 1.")
    l2: Length = given("The length of leg 2, with `fixed_leg` 2.")
    l3: Length = given("The length of leg 3, with `fixed_leg` 3.")

    def content(self) -> dict[str, Any]:
        """The canonical form."""
        names = type(self).model_fields
        return {name: exact_str(value) for name in names if (value := getattr(self, name)) is not None}

    def check(self, leg: int) -> None:
        """Checks that the angle and the length are those of the fixed leg, and not of others.

        Raises:
            InputError: naming the member at fault.
        """
        for number in FIXED_LEGS:
            for name in (f"theta{number}_deg", f"l{number}"):
                has = getattr(self, name) is not None
                if number == leg and not has:
                    raise InputError.of(name, f"is missing; {leg} is the fixed leg")
                if number != leg and has:
                    raise InputError.of(name, f"is given, but the fixed leg is {leg}")


AskedPose: TypeAlias = NumberedPose | AngledPose
_FORMS = "the number of a pose, an object with l1, l2, l3 and pose, or one with alpha_deg, theta1_deg and l1"


def _end(value: object, info: ValidationInfo) -> int | AskedPose:
    """Reads a pose: its number among those of the joint vector of the question, or an object."""
    if isinstance(value, NumberedPose | AngledPose):
        return value
    source = Source.of(info)
    if isinstance(value, Mapping):
        if set(value) == {"pose"}:
            value = value["pose"]
        else:
            angled = any(name.startswith(("alpha", "theta")) for name in value)
            if angled:
                return part(AngledPose.model_validate, value, source)
            return part(NumberedPose.model_validate, value, source)
    expected = f"the number of a pose, 1 to {MOST_POSES}"
    if not isinstance(value, int | str):
        raise InputError.of("", f"is {json_kind(value)}; give {_FORMS}")
    number = whole_number(value, expected, is_text=source.is_text)
    if not 1 <= number <= MOST_POSES:
        raise InputError.of("", f"is {str(number)[:40]}; give {expected}")
    return number


EndOfPath = Annotated[
    int | AskedPose,
    PlainValidator(
        _end, json_schema_input_type=Annotated[int, Field(ge=1, le=MOST_POSES)] | NumberedPose | AngledPose
    ),
]
"""A pose at an end of a path."""

POSES = ("from", "to")
"""The members that give the ends of a path."""

_BY_NUMBER: dict[str, Any] = {
    "if": {"anyOf": [{"type": "object", "properties": {name: {"type": "integer"}}} for name in POSES]},
    "then": {"required": [*LEGS]},
    "else": {"properties": dict.fromkeys(LEGS, False)},
}
LOOP_OR_POSES: dict[str, Any] = {
    "if": {"anyOf": [{"type": "object", "required": [name]} for name in POSES]},
    "then": {"required": [*POSES], "properties": {"cusp": False}, **_BY_NUMBER},
    "else": {**NEEDED, "properties": {"between": False}},
}
"""Of a schema: a loop, or a path from pose to pose."""


def is_of_poses(value: Mapping[str, Any]) -> bool:
    """Whether an object asks for a path from pose to pose."""
    return any(name in value for name in POSES)


def is_numbered(end: object) -> bool:
    """Whether a pose is given as one of the joint vector of the question."""
    return set(end) == {"pose"} if isinstance(end, Mapping) else not isinstance(end, AskedJoints | AngledPose)


def problems_of_poses(value: Mapping[str, Any]) -> Iterator[FieldProblem]:
    """What a path from pose to pose lacks: lengths, if a pose is given by its number, and none otherwise."""
    numbered = any(is_numbered(value[name]) for name in POSES if name in value)
    missing = [name for name in (*(LEGS if numbered else ()), *POSES) if name not in value]
    yield from (FieldProblem(name, "is missing; give a number") for name in missing)
    spare = [] if numbered else [name for name in LEGS if name in value]
    yield from (FieldProblem(name, "is for poses by number; leave it out") for name in spare)
