"""The FastAPI application."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from anyio import to_thread
from fastapi import FastAPI, Response
from starlette.middleware.cors import CORSMiddleware

from service import __version__
from service.api.caller import Rules
from service.api.context import Context, Repeats
from service.api.contract.openapi import describe, operation_id
from service.api.guard import Guard
from service.api.http.middleware import AccessLog, Compression, RequestEnvelope, add_error_handlers
from service.api.routes import jobs, pages, questions
from service.api.routes.pages import WEB, Assets
from service.api.settings import Settings
from service.commit import commit

_GZIP_LEVEL = 1  # digits: level 5 takes five times as long for five per cent fewer bytes
_ALLOWED_HEADERS = (
    "Authorization",
    "Content-Type",
    "Idempotency-Key",
    "If-None-Match",
    "If-Range",
    "Last-Event-ID",
    "Prefer",
    "Range",
)
_EXPOSED_HEADERS = (
    "Accept-Ranges",
    "Content-Location",
    "Content-Range",
    "ETag",
    "Location",
    "Preference-Applied",
    "Retry-After",
    "X-Request-ID",
)


def create_app(settings: Settings | None = None) -> FastAPI:
    """Create the application. It starts and runs without Redis too."""
    settings = settings or Settings()
    context = Context.of(settings)

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        check = asyncio.create_task(context.check_redis())
        asking = asyncio.create_task(
            to_thread.run_sync(commit)
        )  # before files change under a service that runs
        try:
            yield
        finally:
            check.cancel()
            await asking
            await context.close()

    app = FastAPI(
        title="rpr-cusps",
        version=__version__,
        lifespan=lifespan,
        docs_url=None,
        redoc_url=None,
        openapi_url=None,
        redirect_slashes=False,
        default_response_class=Response,
        generate_unique_id_function=operation_id,
        telemetry={"tracing": False, "metrics": False, "logs": False},  # we have our own
    )
    app.state.context = context
    app.state.begin_shutdown = context.events.stop
    for router in (questions.router, jobs.batches, jobs.router, pages.status, pages.router):
        app.include_router(router)
    app.mount("/static", Assets(directory=WEB), name="static")
    add_error_handlers(app)
    describe(app)
    app.add_middleware(Repeats, kept=context.kept, count=context.metrics.count_answer)
    app.add_middleware(Guard, context=context, rules=Rules(app.routes))
    app.add_middleware(
        Compression, minimum_size=settings.gzip_bytes, compresslevel=_GZIP_LEVEL, thread_minimum_size=1 << 14
    )
    if settings.origins:
        app.add_middleware(
            CORSMiddleware,
            allow_origins=settings.origins,
            allow_methods=("GET", "POST", "DELETE"),
            allow_headers=_ALLOWED_HEADERS,
            expose_headers=_EXPOSED_HEADERS,
        )
    log = AccessLog(settings.access_log)
    app.add_middleware(RequestEnvelope, metrics=context.metrics, access_log=log, settings=settings)
    return app
