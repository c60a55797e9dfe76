"""Questions: `POST` of each, as :mod:`service.schemas.catalog` lists them, and GET forms of some."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Coroutine, Sequence
from typing import Any

from fastapi import APIRouter, Request, Response
from fastapi.routing import APIRoute

from rpr_solver.errors import InputError
from service.api.answer import Preferences, answer_asked, answer_question, asked_of
from service.api.batches import GEOMETRY, item_of
from service.api.context import ContextDep
from service.api.contract import (
    CONDITIONAL,
    RESULT_FORM,
    USUAL_WAIT,
    WAIT,
    question_responses,
    request_body,
)
from service.api.problems import ProblemError, ProblemType
from service.schemas.catalog import queries, questions
from service.schemas.questions import Question


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


_OWN = (WAIT, *RESULT_FORM)


def _get_endpoint(question: type[Question]) -> Callable[..., Awaitable[Response]]:
    async def endpoint(request: Request, context: ContextDep) -> Response:
        if _is_of_another_site(request, context.settings.origins):
            raise ProblemError(
                ProblemType.FORBIDDEN, "A page of another site may not start computations with GET."
            )
        row = _row(request, question)
        wait = _seconds(row.pop(WAIT, str(USUAL_WAIT)))
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
    known = (*GEOMETRY, *question.columns, *_OWN)
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
        raise InputError.of(WAIT, f"is {text[:40]!r}; give a whole number of seconds")
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
    )
