"""`POST` of every question, as :mod:`service.api.operations` lists them."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from fastapi import APIRouter, Request, Response

from service.api.answers.answer import answer_question
from service.api.context import ContextDep
from service.api.contract.operations import question_responses, request_body
from service.api.operations import OPERATIONS, Operation
from service.api.routes.plain import PlainRoute

router = APIRouter(route_class=PlainRoute)


def _endpoint(operation: Operation) -> Callable[..., Awaitable[Response]]:
    async def endpoint(request: Request, context: ContextDep) -> Response:
        return await answer_question(request, context, operation)

    return endpoint


for _operation in OPERATIONS:
    router.add_api_route(
        _operation.path,
        _endpoint(_operation),
        methods=["POST"],
        name=_operation.name,
        tags=[_operation.tag[0]],
        summary=_operation.summary,
        description=_operation.description.strip(),
        status_code=200,
        responses=question_responses(_operation),
        openapi_extra=request_body(_operation),
    )
