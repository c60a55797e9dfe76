"""`POST /v1/poses`."""

from __future__ import annotations

from fastapi import APIRouter, Request, Response

from service.api import operation_docs as doc
from service.api.answering import answer
from service.api.context import ContextDep
from service.schemas.document_requests import poses_request

router = APIRouter(tags=["poses"])

IMPLIED_WAIT = 10


@router.post(
    "/v1/poses",
    summary="All poses of one manipulator with given leg lengths",
    status_code=200,
    responses=doc.POSES_RESPONSES,
    openapi_extra=doc.POSES_EXTRA,
)
async def post_poses(request: Request, context: ContextDep) -> Response:
    """Direct kinematics: every real pose of the joint vector (L1, L2, L3), proved to be all of them, each
    with its multiplicity: 1 regular, 2 on a singular curve, 3 at a cusp.

    A worker computes this in some milliseconds, so the answer waits for it, up to 10 seconds unless `Prefer`
    says otherwise; then it is 202 with a job.
    """
    return await answer(request, context, poses_request, implied_wait=IMPLIED_WAIT)
