"""Questions: `POST` of each, as :mod:`service.schemas.catalog` lists them, and GET forms of some."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Coroutine, Sequence
from typing import Any

from fastapi import APIRouter, Request, Response
from fastapi.routing import APIRoute

from rpr_solver.contract import MOST_POSES
from rpr_solver.errors import InputError
from rpr_solver.notebook.style import THEMES
from service.api.answers.answer import Preferences, answer_asked, answer_question, asked_of
from service.api.batches.items import GEOMETRY, item_of
from service.api.context import ContextDep
from service.api.contract.operations import (
    CONDITIONAL,
    RESULT_FORM,
    form_parameters,
    question_responses,
    request_body,
)
from service.api.problems import ProblemError, ProblemType
from service.schemas.catalog import queries, questions
from service.schemas.lengths import LEGS, SLICE_COLUMNS
from service.schemas.limits import MAX_DIGITS, MIN_DIGITS
from service.schemas.numbers import FIXED_LEGS, NUMBER_PATTERN, POSITIVE_PATTERN, list_pattern
from service.schemas.plots import LABELS, NARROWEST_MM, STYLES, UNIT_PATTERN, WIDEST_MM
from service.schemas.questions import Question
from service.schemas.tables import METHODS
from worker.answers.plots import PLOTS


class PlainRoute(APIRoute):
    """A route whose endpoint takes the request and the context.

    FastAPI would look for parameters, a body and a form of the answer in each request, and find none.
    """

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Returns the endpoint with the context of the application."""
        endpoint = self.endpoint

        async def handle(request: Request) -> Response:
            response: Response = await endpoint(request, request.app.state.context)
            return response

        return handle


router = APIRouter(route_class=PlainRoute)


def _post_endpoint(question: type[Question]) -> Callable[..., Awaitable[Response]]:
    async def endpoint(request: Request, context: ContextDep) -> Response:
        return await answer_question(request, context, question)

    return endpoint


for _question in questions():
    router.add_api_route(
        _question.path,
        _post_endpoint(_question),
        methods=["POST"],
        name=_question.name,
        tags=[_question.tag[0]],
        summary=_question.summary,
        description=_question.description.strip(),
        status_code=200,
        responses=question_responses(_question),
        openapi_extra=request_body(_question),
    )


_WAIT = 10
_OWN = ("wait", *RESULT_FORM)
_OF_GEOMETRY = "Of the geometry, as in the body of POST."
_NUMBER = {"type": "string", "pattern": NUMBER_PATTERN}
_POSITIVE = {"type": "string", "pattern": POSITIVE_PATTERN}
_PARAMETERS: dict[str, tuple[str, dict[str, Any]]] = {
    **dict.fromkeys(GEOMETRY[:3], (_OF_GEOMETRY, _NUMBER)),
    **dict.fromkeys(GEOMETRY[3:6], (_OF_GEOMETRY, _POSITIVE)),
    "orientation": (_OF_GEOMETRY, {"type": "string", "enum": ["ccw", "cw"]}),
    **dict.fromkeys(
        LEGS,
        (
            "Lengths of the fixed leg, with semicolons between them.",
            {"type": "string", "pattern": list_pattern(POSITIVE_PATTERN)},
        ),
    ),
    **dict.fromkeys(SLICE_COLUMNS, ("Of a range of lengths of the fixed leg.", _NUMBER)),
    "fixed_leg": (
        "The leg whose length is fixed in a slice; 1 if missing.",
        {"type": "integer", "enum": list(FIXED_LEGS)},
    ),
    "digits": (
        "Significant digits of every number in the answer.",
        {"type": "integer", "minimum": MIN_DIGITS, "maximum": MAX_DIGITS},
    ),
    "plot": ("The type of picture; a slice if missing.", {"type": "string", "enum": list(PLOTS)}),
    "theme": (
        "The colours; `auto`, the reader's setting, if missing.",
        {"type": "string", "enum": list(THEMES)},
    ),
    "width_mm": (
        f"For print: the width in millimetres, {NARROWEST_MM} to {WIDEST_MM}.",
        _POSITIVE,
    ),
    "style": (
        "`paper` sets quantities as symbols, in a serif font; `page` if missing.",
        {"type": "string", "enum": list(STYLES)},
    ),
    "unit": ("The unit of lengths, for the axes.", {"type": "string", "pattern": UNIT_PATTERN}),
    "labels": (
        "What stands above and below the picture, title and geometry; `both` if missing.",
        {"type": "string", "enum": list(LABELS)},
    ),
    "cusp": (
        "Of a loop, or of the mechanism: the number or the letter of a cusp.",
        {"type": "string", "pattern": "^([A-Xa-x]|[1-9]|1[0-9]|2[0-4])$"},
    ),
    "pose": (
        "Of the mechanism with three lengths: the number of the pose.",
        {"type": "integer", "minimum": 1, "maximum": MOST_POSES},
    ),
    "method": ("`article`: by the article's own algorithm.", {"type": "string", "enum": list(METHODS)}),
    "sensitivities": (
        "Whether each transition has its sensitivity to the lengths of the geometry.",
        {"type": "boolean"},
    ),
    "tolerance": (
        "A change of all lengths of the geometry: the answer is to hold for every geometry within it.",
        _POSITIVE,
    ),
    "wait": (
        f"Seconds to wait for an answer that is not known yet; {_WAIT} if missing.",
        {"type": "integer", "minimum": 0},
    ),
}
"""Name → description and schema."""


def _names(question: type[Question]) -> tuple[str, ...]:
    return (*GEOMETRY, *question.columns)


def _parameters(question: type[Question]) -> list[dict[str, Any]]:
    return [
        *(
            {
                "name": name,
                "in": "query",
                "required": name in GEOMETRY[:-1],
                "description": _PARAMETERS[name][0],
                "schema": _PARAMETERS[name][1],
            }
            for name in (*_names(question), "wait")
        ),
        *form_parameters(question.forms),
    ]


def _get_endpoint(question: type[Question]) -> Callable[..., Awaitable[Response]]:
    async def endpoint(request: Request, context: ContextDep) -> Response:
        if _is_of_another_site(request, context.settings.origins):
            raise ProblemError(
                ProblemType.FORBIDDEN, "A page of another site may not start computations with GET."
            )
        row = _row(request, question)
        wait = _seconds(row.pop("wait", str(_WAIT)))
        own = {name: value for name, value in row.items() if name not in _OWN}
        document = item_of({**own, "kind": question.kinds[0].name})["request"]
        asked = await context.parsing(asked_of, question, document, context.settings.limits)
        return await answer_asked(request, context, question, asked, Preferences(wait=wait))

    return endpoint


def _is_of_another_site(request: Request, origins: Sequence[str]) -> bool:
    """Whether a web page sends this that may not call the service; a POST would be refused by its browser."""
    is_foreign = request.headers.get("sec-fetch-site") == "cross-site"
    return is_foreign and "*" not in origins and request.headers.get("origin") not in origins


def _row(request: Request, question: type[Question]) -> dict[str, str]:
    known = (*_names(question), *_OWN)
    row: dict[str, str] = {}
    for name, value in request.query_params.multi_items():
        if name not in known:
            raise InputError.of(name[:60] or "query", f"unknown parameter; known are {', '.join(known)}")
        if name in row:
            raise InputError.of(name, "this parameter is given twice")
        if value.strip():
            row[name] = value.strip()
    return row


def _seconds(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) < 10):
        raise InputError.of("wait", f"is {text[:40]!r}; give a whole number of seconds")
    return int(text)


for _question in queries():
    _responses = {**question_responses(_question), **CONDITIONAL}
    router.add_api_route(
        _question.path,
        _get_endpoint(_question),
        methods=["GET"],
        name=_question.name.replace("post_", "get_"),
        tags=[_question.tag[0]],
        summary=f"{_question.summary}, as a URL",
        description="The question of POST as query parameters, for spreadsheets, `read_csv` and `webread`: "
        "the geometry, `l1` or `l1_from`, `l1_to` and `l1_step` (with `fixed_leg` 2 or 3 those of that leg), "
        "`digits`; `format=csv` for a table, `wait` for the time to wait. An answer may be cached.",
        responses=_responses,
        openapi_extra={"parameters": _parameters(_question)},
    )
