"""`POST /v1/checks`."""

from __future__ import annotations

from fastapi import APIRouter, Request, Response

from service.api import operation_docs as doc
from service.api.answering import answer
from service.api.context import ContextDep
from service.schemas.document_requests import check_request

router = APIRouter(tags=["checks"])


@router.post(
    "/v1/checks",
    summary="Whether a manipulator satisfies a requirement on its cusps",
    status_code=200,
    responses=doc.CHECKS_RESPONSES,
    openapi_extra=doc.CHECKS_EXTRA,
)
async def post_check(request: Request, context: ContextDep) -> Response:
    """Proves or refutes a requirement: at most, or at least, so many cusps in every slice of a range, counted
    strictly within the joint limits of the other legs.

    The report lists the intervals of the range with their numbers of cusps, and for each that violates the
    requirement a slice with its cusps. A requirement that is not met is an answer too: 200, `passed` false.
    """
    return await answer(request, context, check_request)
