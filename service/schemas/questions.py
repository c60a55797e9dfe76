"""The base of all questions: a manipulator, the request for a job, and its price."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

from pydantic import (
    BaseModel,
    Field,
    PlainValidator,
    model_validator,
)

from rpr_solver import triangles
from rpr_solver.errors import FieldProblem, InputError
from service.schemas.answers import JSON, JSON_FORM, Forms
from service.schemas.document import Document, JsonNumber, Source, json_kind
from service.schemas.geometry import GeometryField
from service.schemas.limits import LimitError, Limits
from service.schemas.numbers import DeadlineSeconds
from worker.answers import JobRequest, Kind
from worker.answers.cost import SHORT_BITS, Sizes, digits_of_bits

EXAMPLE_GEOMETRY = {"a2x": 15.91, "a3x": 0, "a3y": 10, "d1": 17.04, "d2": 16.54, "d3": 20.84}


Examples = Mapping[str, tuple[str, Mapping[str, Any]]]
"""Name → summary and body; the geometry defaults to the article's first manipulator."""


class _InFile:
    """The examples of a question in `examples.json`, by the name of its class; read when they are wanted."""

    def __get__(self, _question: object, kind: type[Question]) -> Examples:
        return _examples_by_question().get(kind.__name__, {})


@cache
def _examples_by_question() -> Mapping[str, Examples]:
    text = Path(__file__).with_name("examples.json").read_text(encoding="utf-8")
    found: Mapping[str, Examples] = json.loads(text)
    return found


def _url(value: object) -> str:
    if not isinstance(value, str) or isinstance(value, JsonNumber):
        raise InputError.of("", f"is {json_kind(value)}; give a URL such as https://example.com/hooks/cusps")
    return value


CallbackUrl = Annotated[str, PlainValidator(_url, json_schema_input_type=str)]
"""The callback URL of the question; the service checks whether it is allowed."""


class Question(Document):
    """A kind of question: the model that reads a body or a command's options, and all that is said of it.

    Routes, the contract, clients, items of batches and commands follow from these attributes; its line is in
    `service.schemas.QUESTIONS`.
    The docstring says first what a body has, then, in further paragraphs, what is answered: the description
    of the operation.

    Attributes:
        expected: what to send, for messages.
        kinds: the kinds of documents that answer the question, the usual one first; the others are asked for
            by a member of the question (`Kind.implied`).
        examples: bodies for the documentation: those in `examples.json`, unless a class has its own.
        names_geometry: whether a body has the member `geometry`.
        path, name, summary: of the operation in OpenAPI, which is a POST; its name follows from that of the
            class.
        tag: what its answers are called, in the plural.
        answer: the model of the document.
        example: an answer, for the documentation.
        forms: media type → form of the document.
        columns: what a query may have beside the geometry; if nothing, there is no form with GET.
        deadline_seconds: Seconds after which a job that is not done fails; of several clients'
            the latest counts.
        callback_url: The URL to which an event is posted when the job ends; the service must allow its host.
    """

    expected: ClassVar[str] = "send an object with geometry"
    kinds: ClassVar[Sequence[Kind]]
    examples: ClassVar[Examples | _InFile] = _InFile()
    names_geometry: ClassVar[bool] = True
    path: ClassVar[str]
    name: ClassVar[str]
    summary: ClassVar[str]
    description: ClassVar[str]
    tag: ClassVar[str]
    answer: ClassVar[type[BaseModel]]
    example: ClassVar[object] = None
    forms: ClassVar[Forms] = {JSON: JSON_FORM}
    columns: ClassVar[Sequence[str]] = ()

    geometry: GeometryField
    deadline_seconds: DeadlineSeconds | None = Field(default=None, exclude=True)
    callback_url: CallbackUrl | None = Field(default=None, exclude=True)

    @property
    def takes_shared_joints(self) -> bool:
        """Whether it is answered for a machine whose legs share joints."""
        return False

    @model_validator(mode="after")
    def _joints_are_apart(self) -> Self:
        if not self.takes_shared_joints:
            self.geometry.geometry.apart_from_shared()
        return self

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if "path" in cls.__dict__ and "name" not in cls.__dict__:
            cls.name = "post" + re.sub("[A-Z]", lambda x: f"_{x[0].lower()}", cls.__name__).removesuffix(
                "_request"
            )
        if description := super().about().partition("\n\n")[2]:
            cls.description = description

    @classmethod
    def about(cls) -> str:
        """Returns what the docstring says of the body: its first paragraph."""
        return super().about().partition("\n\n")[0]

    @classmethod
    def by_query(cls) -> type[Question] | None:
        """Returns the question that is asked by GET, if there is one."""
        return cls if cls.columns else None

    @property
    def kind(self) -> Kind:
        """The kind of the document that answers the question: the one whose member it has, or the usual."""
        meant = (k for k in self.kinds if k.implied and getattr(self, k.implied[0]) == k.implied[1])
        return next(meant, self.kinds[0])

    def content(self) -> dict[str, Any]:
        """Returns the canonical form: plain JSON, the same for every spelling of the question."""
        return self.model_dump(exclude={kind.implied[0] for kind in self.kinds if kind.implied})

    def body(self) -> dict[str, Any]:
        """Returns the question as the body of a request: what was given, its numbers as text."""
        given = {"digits": getattr(self, "digits", None), "deadline_seconds": self.deadline_seconds}
        # a union's parts are read by one function, of which the serializer does not know
        body = self.model_dump(mode="json", exclude_unset=True, warnings=False)
        if "geometry" in body:
            body["geometry"] = self.geometry.geometry.as_given()
        return body | {name: value for name, value in given.items() if value is not None}

    def job_request(self) -> JobRequest:
        """Returns the request for the job that answers the question."""
        geometry = self.geometry.geometry
        points = {} if geometry.is_rational else triangles.points_needed(geometry)
        return JobRequest(self.kind, self.content(), points=points)


def check_one(asked: Mapping[str, object], source: Source) -> None:
    """Check that exactly one of some members is given.

    Raises:
        InputError: naming the first if none is, or the second of those that are.
    """
    given = [name for name, value in asked.items() if value is not None]
    if len(given) == 1:
        return
    *names, last = map(source.called, asked)
    field, fault = (
        (given[1], f"is given beside {source.called(given[0])}")
        if given
        else (next(iter(asked)), "is missing")
    )
    raise InputError.of(field, f"{fault}; give exactly one of {', '.join(names)} and {last}")


def check_price(request: JobRequest, limits: Limits) -> None:
    """Refuse a question whose answer takes too long, even if parts of it are known.

    Raises:
        LimitError: naming what to reduce: whatever suffices alone, or else what saves most.
    """
    price = request.cost.whole
    limit = limits.max_cost_seconds
    if price <= limit:
        return
    ways = _ways(request, request.sizes)
    prices = {field: request.kind.cost_of(smaller).whole for field, (smaller, _) in ways.items()}
    enough = [field for field in ways if prices[field] <= limit] or [min(prices, key=prices.__getitem__)]
    cost = f"would take about {_rounded(price)} s of one core; the limit max_cost_seconds is {limit}"
    problems = [FieldProblem(field, f"{cost}; {ways[field][1]}") for field in enough]
    raise LimitError(problems, "max_cost_seconds", limit)


def _ways(request: JobRequest, size: Sizes) -> Mapping[str, tuple[Sizes, str]]:
    """Returns the fields that can be reduced, each with the sizes at best and what to do."""
    long = f"in their smallest common unit its sides have up to {digits_of_bits(size.geometry)} digits"
    shape = (
        ", and its triangles are nearly, but not quite, of a special shape"
        if size.nearness > SHORT_BITS
        else ""
    )
    plain = replace(size, geometry=min(size.geometry, SHORT_BITS), nearness=0)
    return {
        "geometry": (plain, f"shorten its numbers: {long}{shape}"),
        "digits": (replace(size, digits=15), f"ask for fewer than {size.digits} digits"),
        **request.kind.fewer(request.content, size),
    }


def _rounded(price: float) -> str:
    return f"{float(f'{price:.2g}'):.0f}"
