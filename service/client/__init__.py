"""Clients of the service, for programs: every kind of question, its answer typed and exact.

    from rpr_solver import EXAMPLES
    from service.client import ServiceClient, census

    with ServiceClient("http://127.0.0.1:8000") as client:
        answer = client.ask(census(EXAMPLES["innocenti"], digits=30))
    print(answer.typed.transitions[0].kind, len(answer.content))

The functions `cusp_table`, `census`, `cusp_curves`, `check`, `poses`, `leg_poses`, `sensed_poses`,
`cusp_loop`, `joint_path`, `pose_path`, `pose_connections`, `singular_curves`, `aspects`, `workspace`,
`workspace_sweep`, `assembly_modes`, `margin`, `design` and `verify_document` take what those of `rpr_solver`
take; `plot` asks for a picture.
`answer.content` is the document as the service sent it, byte for byte the compact JSON of the library's
answer; `answer.document` is it as a dictionary, and `answer.typed` as a model. `client.slices` yields the
slices of a table as they are computed; `client.ask_all` asks many questions in one batch and yields an
:class:`ItemResult` for each. :class:`AsyncServiceClient` is the same with `await`.
"""

from service.client.bodies import Answer, Asked
from service.client.clients import AsyncServiceClient, ServiceClient
from service.client.connection import ClientSettings
from service.client.questions import (
    aspects,
    assembly_modes,
    census,
    check,
    cusp_curves,
    cusp_loop,
    cusp_table,
    design,
    joint_path,
    leg_poses,
    margin,
    plot,
    pose_connections,
    pose_path,
    poses,
    sensed_poses,
    singular_curves,
    verify_document,
    workspace,
    workspace_sweep,
)
from service.client.results import ItemResult
from service.schemas.resources import Batch, Job

__all__ = [
    "Answer",
    "Asked",
    "AsyncServiceClient",
    "Batch",
    "ClientSettings",
    "ItemResult",
    "Job",
    "ServiceClient",
    "aspects",
    "assembly_modes",
    "census",
    "check",
    "cusp_curves",
    "cusp_loop",
    "cusp_table",
    "design",
    "joint_path",
    "leg_poses",
    "margin",
    "plot",
    "pose_connections",
    "pose_path",
    "poses",
    "sensed_poses",
    "singular_curves",
    "verify_document",
    "workspace",
    "workspace_sweep",
]
