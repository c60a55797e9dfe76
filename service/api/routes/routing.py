"""Routes: `POST` of each question, as :mod:`service.schemas` lists them, and GET forms of some; and what the
routes of jobs and of batches share: the lists, the events, the end, and the log of webhooks."""

from __future__ import annotations

import re
from collections.abc import Awaitable, Callable, Coroutine, Mapping, Sequence
from typing import Annotated, Any, get_args
from urllib.parse import urlencode

from fastapi import APIRouter, Query, Request, Response
from pydantic import AfterValidator, ConfigDict, Field, WithJsonSchema

from rpr_solver.errors import InputError, clipped
from service.api.answer import Preferences, answer_asked, answer_question, asked_of
from service.api.batches import item_of
from service.api.caller import caller_of, client_of, oversees
from service.api.context import Context, ContextDep
from service.api.contract import PROBLEMS, Docs, json_response, question_responses, request_body
from service.api.contract.responses import CONDITIONAL, NEXT_PAGE, USUAL_WAIT, WAIT
from service.api.forms import json_answer
from service.api.http import LongAnswer
from service.api.http.transport import FOLLOWS, IS_HEAD
from service.api.job_events import EVENT_ID
from service.api.keys import KeyStore
from service.api.problems import ProblemError, ProblemType
from service.api.routes.parameters import CheckedRoute, check_known
from service.api.settings import here
from service.schemas import all_questions, queries
from service.schemas.columns import COLUMNS as GEOMETRY
from service.schemas.limits import Model
from service.schemas.questions import Question
from service.schemas.resources import ListedStatus
from service.webhooks.callbacks import Delivery
from worker.answers.kinds import kind_of_job
from worker.jobs.listing import Listed, Page, What
from worker.jobs.view import ACTIVE, JobView, Status


class PlainRoute(CheckedRoute):
    """A route whose endpoint takes the request and the context.

    FastAPI would look for parameters, a body and a form of the answer in each request, and find none.
    """

    def _handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        endpoint = self.endpoint

        async def handle(request: Request) -> Response:
            response: Response = await endpoint(request, request.app.state.context)
            return response

        return handle


class RowRoute(PlainRoute):
    """A route whose endpoint reads the query itself."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Returns the endpoint."""
        return self._handler()


router = APIRouter(route_class=PlainRoute)


def _post_endpoint(question: type[Question]) -> Callable[..., Awaitable[Response]]:
    async def endpoint(request: Request, context: ContextDep) -> Response:
        return await answer_question(request, context, question)

    return endpoint


for _question in all_questions():
    router.add_api_route(
        _question.path,
        _post_endpoint(_question),
        methods=["POST"],
        name=_question.name,
        tags=["questions"],
        summary=_question.summary,
        description=_question.description.strip(),
        status_code=200,
        responses=question_responses(_question, _question.example),
        openapi_extra=request_body(_question),
    )


_OWN = (WAIT, "format")


def _get_endpoint(question: type[Question]) -> Callable[..., Awaitable[Response]]:
    async def endpoint(request: Request, context: ContextDep) -> Response:
        if _is_of_another_site(request, context.settings.cors_origins):
            raise ProblemError(
                ProblemType.FORBIDDEN, "A page of another site may not start computations with GET."
            )
        row = _row(request, question)
        wait = _seconds(row.pop(WAIT, str(USUAL_WAIT)))
        own = {name: value for name, value in row.items() if name not in _OWN}
        document = item_of({**own, "kind": question.kinds[0].name})["request"]
        asked = await context.parsing(asked_of, question, document, context.settings.limits)
        return await answer_asked(request, context, asked, Preferences(wait=wait))

    return endpoint


def _is_of_another_site(request: Request, origins: Sequence[str]) -> bool:
    """Whether a web page sends this that may not call the service; a POST would be refused by its browser."""
    is_foreign = request.headers.get("sec-fetch-site") == "cross-site"
    return is_foreign and "*" not in origins and request.headers.get("origin") not in origins


def _row(request: Request, question: type[Question]) -> dict[str, str]:
    row: dict[str, str] = {}
    for name, value in request.query_params.multi_items():
        check_known(name, (*GEOMETRY, *question.columns, *_OWN))
        if name in row:
            raise InputError.of(name, "this parameter is given twice")
        if value.strip():
            row[name] = value.strip()
    return row


def _seconds(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) < 10):
        raise InputError.of(WAIT, f"is {clipped(text)!r}; give a whole number of seconds")
    return int(text)


for _question in queries():
    router.add_api_route(
        _question.path,
        _get_endpoint(_question),
        methods=["GET"],
        route_class_override=RowRoute,
        name=_question.name.replace("post_", "get_"),
        tags=["questions"],
        summary=f"{_question.summary}, as a URL",
        description="The question of POST as query parameters, for spreadsheets, `read_csv` and `webread`: "
        "the geometry, `l1` or `l1_from`, `l1_to` and `l1_step` (with `fixed_leg` 2 or 3 those of that leg), "
        "`digits`; `format=csv` for a table, `wait` for the time to wait. An answer may be cached.",
        responses={**question_responses(_question), **CONDITIONAL},
    )


def _of_form(pattern: str, advice: str) -> tuple[Any, Any]:
    """Returns the metadata of a text with a pattern; the message gives advice instead."""

    def check(text: str) -> str:
        if not re.search(pattern, text, re.ASCII):
            raise ValueError(advice)
        return text

    return Field(json_schema_extra={"pattern": pattern}), AfterValidator(check)


class WantedOfList(Model):
    """Which entries of a list are wanted.

    Attributes:
        status: Only those that are `queued`, `running`, `succeeded` (batches: `completed`), `failed` or
            `canceled`; `active`: the first two. Without it, all.
        before: Only those created before this time, in seconds since 1970; from `next` of a page.
        limit: The maximum number of entries.
    """

    model_config = ConfigDict(defer_build=False)  # FastAPI needs it at once

    status: Annotated[ListedStatus | None, WithJsonSchema({"type": "string"})] = None
    before: Annotated[str, *_of_form(r"^(\d{1,12}(\.\d{1,6})?)?$", "give that in `next` of a page")] = ""
    limit: int = Field(default=50, ge=1, le=100)


class Withdrawal(Model):
    """For whom a question or a batch is withdrawn.

    Attributes:
        force: Cancels it for all callers; needs a key with scope `admin`, or on a service without keys a call
            from its own computer.
    """

    model_config = ConfigDict(defer_build=False)

    force: bool = False


ListQuery = Annotated[WantedOfList, Query()]
EndQuery = Annotated[Withdrawal, Query()]

_STATES: Mapping[str | None, frozenset[Status]] = {
    **{status: frozenset({status}) for status in get_args(Status)},
    "active": ACTIVE,
    "completed": frozenset({"succeeded"}),
    None: frozenset(get_args(Status)),
}

LIST_RESPONSES: Docs = {
    200: json_response("A page of the list.", "JobList", headers=NEXT_PAGE),
    **PROBLEMS,
}


async def list_response(request: Request, context: Context, what: What, wanted: WantedOfList) -> Response:
    """Returns a page of what the caller may see."""
    caller = caller_of(request.scope)
    client = None if oversees(request.scope) else "unknown" if caller is None else caller.id
    queue = context.queue

    def read() -> tuple[Page, dict[str, str]]:
        page = queue.listing.page(what, client, _STATES[wanted.status], wanted.before, wanted.limit)
        ids = {item.maker for item in page.items if item.maker is not None and item.maker[:4] == "key:"}
        keys = KeyStore(queue.redis, queue.settings.key_prefix).all() if ids else {}
        return page, {f"key:{key_id}": key.name for key_id, key in keys.items()}

    page, names = await context.redis(read)
    query = {"status": wanted.status, "limit": str(wanted.limit), "before": page.before}
    following = urlencode({name: value for name, value in query.items() if value is not None})
    url = None if page.before is None else here(f"/v1/{what}?{following}")
    body = {"items": [_item(item, names) for item in page.items], "next": url}
    return json_answer(body, headers=None if url is None else {"Link": f'<{url}>; rel="next"'})


def _item(item: Listed, names: dict[str, str]) -> dict[str, object]:
    view = item.view
    kind = kind_of_job(view.id)
    return {
        "id": view.id,
        "kind": None if kind is None else kind.name,
        "status": view.state,
        "created_at": view.created_at,
        "started_at": view.started_at,
        "ended_at": view.ended_at,
        "estimate_seconds": view.estimate_seconds,
        "key": names.get(item.maker or ""),
    }


async def follow(request: Request, context: Context, view: JobView) -> Response:
    """Returns the stream of events, from after `Last-Event-ID` if it is sent; or 204 if none follows.

    Raises:
        ProblemError: 400, the id is malformed.
    """
    last = request.headers.get("last-event-id", "0").strip() or "0"
    if not re.fullmatch(EVENT_ID, last, re.ASCII):
        raise ProblemError(
            ProblemType.INVALID_HEADER,
            f"Last-Event-ID {clipped(last, 60)!r} is not an event id of this stream.",
            errors=[("Last-Event-ID", "send the id of the last event received, or omit it")],
        )
    if view.is_terminal and last != "0" and not await context.events.after(view, last):
        return Response(status_code=204)
    headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
    if request.scope.get(IS_HEAD):
        return Response(headers=headers, media_type="text/event-stream")
    request.scope[FOLLOWS] = True
    stream = context.events.follow(view, last)
    return LongAnswer(stream, headers, "text/event-stream", context.followers)


Find = Callable[[Context, str], JobView]
"""Returns the job or batch of an id, or raises 404."""


async def end(request: Request, context: Context, find: Find, job_id: str, wanted: Withdrawal) -> JobView:
    """Withdraw the caller from a job or batch, or with `force` cancel it for all; returns its state.

    Raises:
        ProblemError: 404, or 403 if the caller may not cancel it for all.
    """
    caller = caller_of(request.scope)
    if wanted.force and not oversees(request.scope):
        raise ProblemError(
            ProblemType.FORBIDDEN,
            "Only a key with scope admin, or on a service without keys a call from its own computer, can "
            "cancel jobs of other clients (force).",
        )

    def act() -> JobView:
        find(context, job_id)
        queue = context.queue
        if wanted.force:
            return queue.cancel(job_id) or find(context, job_id)
        return queue.withdraw(job_id, client_of(caller)) or find(context, job_id)

    return await context.redis(act)


async def deliveries(context: Context, view: JobView) -> list[Delivery]:
    """Returns the log of the deliveries to every `callback_url` of a job or batch that has ended."""
    return await context.redis(context.callbacks.of_job, view.id) if view.is_terminal else []
