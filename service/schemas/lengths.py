"""Lengths of the fixed leg: slices as a number, a list or a range; ranges with open ends; joint limits; and
changes of the lengths of a geometry."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainValidator,
    TypeAdapter,
    ValidationInfo,
    model_serializer,
    model_validator,
)

from rpr_solver import LengthRange, exact_str, parse_exact
from rpr_solver.contract import FIXED_LEGS, LEGS, LENGTHS
from rpr_solver.errors import FieldProblem, InputError, clipped
from rpr_solver.margins import changes
from rpr_solver.model.lengths import Bounds, limits_json, read_limits
from service.schemas.document import Document, Source, part, unnamed
from service.schemas.limits import DEFERRED, Detail, LimitError, Limits, Model
from service.schemas.numbers import Exact, Positive, exact_number
from service.schemas.questions import Question

ENDS = ("from", "to", "step")
"""Of a range of lengths."""


_NUMBERS: TypeAdapter[tuple[Fraction, ...]] = TypeAdapter(tuple[Exact, ...], config=DEFERRED)


class SliceRange(Document):
    """The values `from`, `from` + `step`, …, up to `to`, which is included if it is one of them."""

    expected: ClassVar[str] = 'give an object with "from", "to" and "step"'

    start: Exact = Field(alias="from", description="The first value.")
    stop: Exact = Field(alias="to", description="The end of the range; >= `from`.")
    step: Positive = Field(description="> 0")

    @model_validator(mode="after")
    def _is_not_empty(self) -> Self:
        if self.step <= 0:
            raise InputError.of("step", f"is {exact_str(self.step)}; a step must be > 0")
        if self.stop < self.start:
            start, stop = self._names()[:2]
            raise InputError.of(
                stop,
                f"is {exact_str(self.stop)}, less than {start} = {exact_str(self.start)}; the range is empty",
            )
        return self

    def values(self, limits: Limits) -> tuple[Fraction, ...]:
        """Returns all values of the range.

        Raises:
            LimitError: there are too many.
        """
        count = int((self.stop - self.start) // self.step) + 1
        check_count(count, limits)
        return tuple(self.start + i * self.step for i in range(count))


class OpenRange(Document):
    """A range of lengths; an end that is missing or null is open."""

    expected: ClassVar[str] = 'give an object with "from" and "to"'

    start: Exact | None = Field(default=None, alias="from", description="Lower end; 0 if missing.")
    stop: Exact | None = Field(default=None, alias="to", description="Upper end; unbounded if missing.")

    @model_validator(mode="after")
    def _is_not_empty(self) -> Self:
        with unnamed("range"):
            LengthRange.of(*self.ends, ("range.from", "range.to"))
        return self

    @model_serializer
    def _canonical(self) -> dict[str, str | None]:
        start, stop = self.ends
        return {"from": exact_str(start), "to": None if stop is None else exact_str(stop)}

    @property
    def ends(self) -> tuple[Fraction, Fraction | None]:
        """Both ends; None is no upper end."""
        return self.start or Fraction(0), self.stop

    def check_inside(self, lengths: Iterable[Fraction]) -> None:
        """Refuse lengths that are not positive or lie outside the range.

        Raises:
            InputError: naming the first such length.
        """
        start, stop = self.ends
        for x in lengths:
            if x <= 0:
                raise InputError.of("", f"is {exact_str(x)}; a leg length must be > 0")
            if x < start or (stop is not None and x > stop):
                end = "" if stop is None else f" to {exact_str(stop)}"
                raise InputError.of("", f"is {exact_str(x)}, outside the range from {exact_str(start)}{end}")


Range = Annotated[
    OpenRange,
    BeforeValidator(lambda value: {} if value is None else value, json_schema_input_type=OpenRange | None),
]
"""A range of lengths; null stands for all."""


def range_field() -> Any:
    """Returns the field of a range, which may be missing or null."""
    return Field(
        default_factory=OpenRange, description="All lengths if missing.", json_schema_extra={"default": None}
    )


def check_count(count: int, limits: Limits) -> None:
    """Refuse too many slices.

    Raises:
        LimitError: naming the limit.
    """
    if count > limits.max_slices:
        shown = str(count) if count < 10**20 else "more than 10^20"
        raise LimitError.exceeded(limits, "max_slices", f"asks for {shown} slices")


def split_range(text: str) -> dict[str, str]:
    """Returns the parts of `FROM:TO:STEP`.

    >>> split_range("14:15:0.5")
    {'from': '14', 'to': '15', 'step': '0.5'}
    """
    return _split(text, ("from", "to", "step"), "FROM:TO:STEP, for example 0.1:50.1:0.1")


def split_ends(text: str, names: tuple[str, str] = ("from", "to")) -> dict[str, str | None]:
    """Returns the parts of `FROM:TO`, either of which may be missing.

    >>> split_ends("10:61/2"), split_ends(":")
    ({'from': '10', 'to': '61/2'}, {'from': None, 'to': None})
    """
    parts = _split(text, names, "FROM:TO, for example 10:20, 10: or :20")
    return {name: part if part.strip() else None for name, part in parts.items()}


def _split(text: str, names: Sequence[str], form: str) -> dict[str, str]:
    parts = text.split(":")
    if len(parts) != len(names):
        raise InputError.of("", f"{clipped(text, 60)!r} is not {form}")
    return dict(zip(names, parts, strict=True))


def _slices(value: object, info: ValidationInfo) -> tuple[Fraction, ...]:
    source = Source.of(info)
    if isinstance(value, Mapping):
        return part(SliceRange.model_validate, value, source).values(source.limits)
    if not isinstance(value, list | tuple):
        return (exact_number(value, info),)
    if not value:
        raise InputError.of("", "is an empty list; give at least one number")
    check_count(len(value), source.limits)
    return part(_NUMBERS.validate_python, value, source)


Slices = Annotated[
    tuple[Exact, ...],
    PlainValidator(
        _slices,
        json_schema_input_type=Exact | Annotated[list[Exact], Field(min_length=1)] | SliceRange,
    ),
]
"""One length, a list of them, or a range."""


def slices_field(description: str, **more: Any) -> Any:
    """Returns the field of the lengths of one leg."""
    # of a built-in factory the signature would be parsed, for 15 ms
    return Field(default_factory=lambda: (), description=description, **more)


def _of_leg(leg: int) -> dict[str, Any]:
    return {"properties": {"fixed_leg": {"const": leg}}, **({} if leg == 1 else {"required": ["fixed_leg"]})}


def _needed(leg: int) -> dict[str, Any]:
    needed = {"required": [f"l{leg}"]}
    return needed if leg == 3 else {"if": _of_leg(leg), "then": needed, "else": _needed(leg + 1)}


OF_THE_FIXED_LEG: dict[str, Any] = {"dependentSchemas": {f"l{leg}": _of_leg(leg) for leg in FIXED_LEGS}}
"""Of a schema: lengths of the fixed leg alone; leg 1 is fixed if none is given."""


NEEDED: dict[str, Any] = {**OF_THE_FIXED_LEG, **_needed(1)}
"""The same, if there must be some."""


class SlicesOfOneLeg(Document):
    """Base of questions that give lengths of their fixed leg alone, as l1, l2 or l3."""

    model_config = ConfigDict(json_schema_extra=OF_THE_FIXED_LEG)

    needs_slices: ClassVar[bool]
    hint_of_slices: ClassVar[str] = 'give a number, a list of numbers, or {"from": …, "to": …, "step": …}'

    if TYPE_CHECKING:  # each question has these among its own fields
        fixed_leg: int

    @property
    def slices(self) -> tuple[Fraction, ...]:
        """The lengths of the fixed leg."""
        lengths: tuple[Fraction, ...] = getattr(self, f"l{self.fixed_leg}")
        return lengths

    @classmethod
    def _members(cls, value: Mapping[str, Any]) -> Sequence[str]:
        leg = leg_of(value)
        return [name for name in cls._names() if leg is None or name not in LEGS or name == f"l{leg}"]

    @classmethod
    def _problems_of_members(cls, value: Mapping[str, Any], known: Sequence[str]) -> Iterator[FieldProblem]:
        yield from super()._problems_of_members(value, known)
        own = [name for name in LEGS if name in known]
        if cls.needs_slices and not any(name in value for name in own):
            yield FieldProblem(own[0], f"is missing; {cls.hint_of_slices}")

    @classmethod
    def _hint(cls, name: str, known: Sequence[str]) -> str:
        if name not in LEGS:
            return super()._hint(name, known)
        [own] = [leg for leg in LEGS if leg in known]
        return f"with fixed_leg {own[1]} the slices are {own}"


RANGE_COLUMNS = tuple(f"{leg}_{end}" for leg in LEGS for end in ENDS[:2])
"""The columns of a row, or parameters of a query, that give a range of lengths."""

SLICE_COLUMNS = tuple(f"{leg}_{end}" for leg in LEGS for end in ENDS)
"""The same, in steps."""


PHI_COLUMNS = ("phi", *(f"phi_{end}" for end in ENDS))
"""Those that give an orientation, or several in steps."""

LIMIT_COLUMNS = tuple(f"{leg}_{end}" for leg in LEGS for end in ("min", "max"))
"""Those that give joint limits."""


class OneSlice(Question):
    """Base of questions about the slice of one length of the fixed leg, which is l1, l2 or l3.

    Its canonical form has the length under the name "length".
    """

    if TYPE_CHECKING:  # each question has it among its own fields
        fixed_leg: int

    @property
    def length(self) -> Fraction | None:
        """The length of the fixed leg, or None if it is not given."""
        length: Fraction | None = getattr(self, f"l{self.fixed_leg}")
        return length

    def _of_slice(self) -> dict[str, Any]:
        """The canonical form of the manipulator, the fixed leg and its length, if that is given."""
        length = {} if self.length is None else {"length": exact_str(self.length)}
        return {"geometry": self.geometry.to_json(), "fixed_leg": self.fixed_leg, **length}


def leg_of(value: Mapping[str, Any]) -> int | None:
    """Returns the fixed leg of a question, 1 if it names none, or None if it cannot be read."""
    try:
        leg = parse_exact(value.get("fixed_leg", 1), "fixed_leg")
    except InputError:
        return None
    return int(leg) if leg in FIXED_LEGS else None


class JointLimit(Document):
    """The joint limits of one leg; an end that is missing or null is open."""

    expected: ClassVar[str] = 'give an object with "min" and "max"'

    min: Exact | None = None
    max: Exact | None = None


class JointLimits(Document):
    """Joint limits of legs."""

    expected: ClassVar[str] = "give an object with the free legs, such as l2 and l3"

    l1: JointLimit | None = None
    l2: JointLimit | None = None
    l3: JointLimit | None = None

    def bounds(self) -> dict[int, Bounds]:
        """The limits as the solver takes them."""
        return {int(leg[1]): (limit.min, limit.max) for leg, limit in self.given().items()}


def limits_member(limits: JointLimits | None, **leg: int) -> dict[str, Any]:
    """Returns joint limits in their canonical form, as a member of a question; nothing if there are none.

    `leg`: the `fixed_leg`, which may have none, or one that is `held` and may keep one length.

    Raises:
        InputError: naming `limits` or a part of it.
    """
    bounds = {} if limits is None else read_limits(limits.bounds(), "limits", **leg)
    return {"limits": limits_json(bounds)} if bounds else {}


class LegLimits(Model):
    """The joint limits of one leg, exact; null is an open end."""

    min: str | None
    max: str | None


class KeptLimits(Detail):
    """The requested joint limits, by leg."""

    l1: LegLimits | None = None
    l2: LegLimits | None = None
    l3: LegLimits | None = None


class Changes(Document):
    """Numbers for the lengths of the geometry."""

    expected: ClassVar[str] = f"give an object with some of {', '.join(LENGTHS)}"

    a2x: Exact | None = None
    a3x: Exact | None = None
    a3y: Exact | None = None
    d1: Exact | None = None
    d2: Exact | None = None
    d3: Exact | None = None


def number_or(model: type[Document]) -> PlainValidator:
    """Returns the validator of one number for all, or of an object with a number for some."""

    def validate(value: object, info: ValidationInfo) -> Fraction | Document:
        if isinstance(value, Mapping):
            return part(model.model_validate, value, Source.of(info))
        return exact_number(value, info)

    return PlainValidator(validate, json_schema_input_type=Exact | model)


def numbers_of(value: Fraction | Document) -> Fraction | dict[str, Fraction]:
    """Returns the number for all, or the numbers that are given."""
    return value if isinstance(value, Fraction) else value.given()


def _is_tolerance(value: Fraction | Changes) -> Fraction | Changes:
    with unnamed("tolerance"):
        changes_json(value)
    return value


Tolerance = Annotated[Fraction | Changes, number_or(Changes), AfterValidator(_is_tolerance)]
"""A change of all lengths of a geometry, or those of single ones, the others being exact."""


def changes_json(tolerance: Fraction | Changes | None, weights: Changes | None = None) -> dict[str, str]:
    """What radii of a margin multiply, for each length, in canonical text.

    Raises:
        InputError: naming `tolerance` or `weights`.
    """
    given = None if tolerance is None else numbers_of(tolerance)
    numbers = changes(None if weights is None else weights.given(), given)
    return {name: exact_str(x) for name, x in zip(LENGTHS, numbers, strict=True)}
