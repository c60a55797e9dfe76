"""`POST /v1/cusp-curves`."""

from __future__ import annotations

from fastapi import APIRouter, Request, Response

from service.api import operation_docs as doc
from service.api.answering import answer
from service.api.context import ContextDep
from service.schemas.document_requests import curves_request

router = APIRouter(tags=["cusp curves"])


@router.post(
    "/v1/cusp-curves",
    summary="Each cusp from the transition where it is born to the one where it dies",
    status_code=200,
    responses=doc.CURVES_RESPONSES,
    openapi_extra=doc.CURVES_EXTRA,
)
async def post_cusp_curves(request: Request, context: ContextDep) -> Response:
    """The curves that cusps run along while the fixed leg changes its length, each followed by proof and
    named: α, the fixed leg's angle and the other two legs as functions of the fixed length.

    A name belongs to the manipulator and its fixed leg, whatever range or points are asked for. Points are
    given at the lengths `l1`, and with `samples` at so many lengths in every interval between transitions,
    however narrow it is; without either, in one slice of each interval. The whole curves are computed once,
    by a job of some seconds, and kept.
    """
    return await answer(request, context, curves_request)
