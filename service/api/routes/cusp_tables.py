"""`POST /v1/cusp-tables`."""

from __future__ import annotations

from fastapi import APIRouter, Request, Response

from service.api import operation_docs as doc
from service.api.answering import answer
from service.api.context import ContextDep
from service.schemas.table_requests import table_request

router = APIRouter(tags=["cusp tables"])


@router.post(
    "/v1/cusp-tables",
    summary="The cusps of one manipulator in one or many slices",
    status_code=200,
    responses=doc.CUSP_TABLES_RESPONSES,
    openapi_extra=doc.CUSP_TABLES_EXTRA,
)
async def post_cusp_table(request: Request, context: ContextDep) -> Response:
    """Answers 200 with the table when every slice is known already. Otherwise answers 202 with a job that
    computes the missing slices; follow its `Location`. With `Prefer: wait=N` the answer waits up to N seconds
    for the job and is 200 when it ends in that time.

    The same request twice is one job, at the same time or later, and slices that other requests have in
    common with this one are computed once. Numbers are exact: `17.04` is 426/25, never a binary float.
    """
    return await answer(request, context, table_request)
