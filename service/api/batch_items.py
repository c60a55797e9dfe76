"""The reading of a batch's items; one that is not valid becomes a problem in its place."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rpr_solver.contract import FULL
from rpr_solver.errors import InputError
from service.api.body import json_of
from service.api.operations import OPERATIONS
from service.api.problems import ProblemError
from service.schemas.batches import KIND_NAMES, BatchItem
from service.schemas.document import Source, at, part
from service.schemas.limits import Limits
from service.schemas.price import check_price
from service.schemas.questions import Question
from worker.answers import article, certified
from worker.answers.items import Item
from worker.answers.requests import JobRequest

_QUESTIONS: Mapping[str, type[Question]] = {
    kind.name: operation.question for operation in OPERATIONS for kind in operation.question.kinds
}
_CERTIFIED = tuple(kind.name for kind in certified.KINDS)


def read_item(sent: bytes | Mapping[str, Any], index: int, limits: Limits) -> Item:
    """Read an item, the text of a JSON object or its members."""
    place, name, kind = f"items[{index}]", None, None
    try:
        value = json_of(sent, limits) if isinstance(sent, bytes) else sent
        if isinstance(value, Mapping) and type(value.get("id")) is str:
            name = value["id"][:200]
        if isinstance(value, Mapping) and value.get("kind") in KIND_NAMES:
            kind = str(value["kind"])
        item = part(BatchItem.model_validate, value, Source(limits))
        request = _job_request(item, limits)
    except ProblemError as error:  # it is not JSON
        faults = [(place if field == "body" else f"{place}.{field}", text) for field, text in error.errors]
        problem = ProblemError(error.kind, f"{place}: {error.detail}", errors=faults)
        return Item(name, problem=problem.document())
    except InputError as error:
        return Item(name, problem=ProblemError.of_input(at(error, place)).document(), kind=kind)
    return Item(item.id, request)


def _job_request(item: BatchItem, limits: Limits) -> JobRequest:
    sent = dict(item.request)
    if sent.pop("deadline_s", None) is not None:
        raise InputError.of("request.deadline_s", "is not for items; leave it out")
    if sent.pop("callback_url", None) is not None:
        raise InputError.of("request.callback_url", "is not for items; give it with the batch")
    if item.kind == article.KIND.name:
        sent.setdefault("method", "article")
    if item.kind in _CERTIFIED:
        sent.setdefault("certificate", FULL)
    try:
        question = _QUESTIONS[item.kind]
        request = part(question.model_validate, sent, Source(limits)).job_request()
        if item.kind not in (request.kind.name, question.kinds[0].name):
            field = "certificate" if item.kind in _CERTIFIED else "method"
            raise InputError.of(field, f"does not fit an item of the kind {item.kind}")
        check_price(request, limits)
    except InputError as error:
        raise at(error, "request") from None
    return request
