"""`POST /v1/censuses`."""

from __future__ import annotations

from fastapi import APIRouter, Request, Response

from service.api import operation_docs as doc
from service.api.answering import answer
from service.api.context import ContextDep
from service.schemas.document_requests import census_request

router = APIRouter(tags=["censuses"])


@router.post(
    "/v1/censuses",
    summary="Every length at which the number of cusps changes",
    status_code=200,
    responses=doc.CENSUSES_RESPONSES,
    openapi_extra=doc.CENSUSES_EXTRA,
)
async def post_census(request: Request, context: ContextDep) -> Response:
    """The census of a manipulator: all transitions of its slices, by proof and not by scan, each with its
    kind and its degenerate poses, and the number of cusps in every interval between.

    The whole census is computed once, by a job of some seconds, and kept; a range of it, or fewer digits, are
    answered at once from then on. `Prefer: wait=N` waits for the job.
    """
    return await answer(request, context, census_request)
