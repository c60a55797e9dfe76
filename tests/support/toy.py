"""A toy kind of document, declared as any other: a function of the solver, a kind, a question, two lines."""

from __future__ import annotations

from typing import Any, ClassVar

from rpr_solver import Manipulator, exact_str
from rpr_solver.contract import Progress
from rpr_solver.errors import InputError
from service.schemas import registry
from service.schemas.answers import CSV, JSON, JSON_FORM, Form, Forms, GeometryText
from service.schemas.limits import Model
from service.schemas.numbers import Count, Digits, digits_field
from service.schemas.questions import Examples, Question
from worker.answers import kinds
from worker.answers.kind import Document, JobRequest, Kind, Store

# -- a function of the solver


def perimeter(manipulator: Manipulator, copies: int) -> str:
    """The sum of the platform's sides, so many times.

    Raises:
        InputError: there are no copies.
    """
    if copies == 0:
        raise InputError.of("copies", "is 0; a platform has one perimeter at least")
    return exact_str(copies * (manipulator.d1 + manipulator.d2 + manipulator.d3))


# -- a kind


def compute(request: JobRequest, _store: Store, _progress: Progress) -> Document:
    """Compute the perimeter."""
    copies = request.content["copies"]
    return {
        **request.identity_json(),
        "copies": copies,
        "perimeter": perimeter(request.manipulator, copies),
        "sides": [{"side": name, "length": request.geometry[name]} for name in ("d1", "d2", "d3")],
    }


PERIMETER = Kind("perimeter", "pe-", compute, lambda size: 0.001 * size.geometry)

# -- a question


class Side(Model):
    """A side of the platform."""

    side: str
    length: str


class Perimeter(Model):
    """The perimeter of the platform."""

    geometry: GeometryText
    geometry_hash: str
    copies: int
    perimeter: str
    sides: list[Side]


def _csv(document: Document) -> bytes:
    return f"copies,perimeter\n{document['copies']},{document['perimeter']}\n".encode()


class PerimeterRequest(Question):
    """A manipulator, and how many times its platform is there.

    The sum of the lengths of the platform's sides.

    Attributes:
        copies: How many platforms there are.
    """

    expected = "send an object with geometry"
    kinds = (PERIMETER,)
    answer = Perimeter
    path = "/v1/perimeters"
    tag = "perimeters"
    summary = "The perimeter of the platform"
    forms: ClassVar[Forms] = {JSON: JSON_FORM, CSV: Form(_csv, "A line.")}
    examples: ClassVar[Examples] = {"two": ("Of two platforms", {"copies": 2})}

    copies: Count = 1
    digits: Digits = digits_field(15)

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        return self.model_dump()


# -- two lines


def register() -> None:
    """Add the kind and the question to the registries; before anything else is imported that reads them."""
    kinds.KINDS = (*kinds.KINDS, PERIMETER)
    entry = registry.Entry(f"{__name__}:PerimeterRequest", "perimeter", "measure the platform", "Compute")
    registry.QUESTIONS = (*registry.QUESTIONS, entry)
