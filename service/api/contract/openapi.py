"""The published contract: the OpenAPI 3.1 document of the application."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from fastapi.routing import APIRoute, iter_route_contexts
from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from service.api.access.docs import describe_access
from service.api.float_docs import in_floats
from service.api.header_docs import describe_headers
from service.api.operations import OPERATIONS
from service.api.webhook_docs import WEBHOOKS
from service.schemas.batches import Batch, BatchRequest, BatchResult
from service.schemas.job_list import JobList
from service.schemas.jobs import Job, StreamEvent
from service.schemas.numbers import EXACT_NUMBER, POSITIVE_NUMBER
from service.schemas.operations import Health, LimitsDocument, Readiness, Version
from service.schemas.problems import ProblemDocument
from service.schemas.webhooks import BatchEvent, Deliveries, JobEvent

DESCRIPTION = """\
Certified cusp points in the joint space of planar 3-RPR parallel manipulators.

Post a manipulator and its slices L1 to `/v1/cusp-tables`. `/v1/censuses` finds every length at which the
number of cusps changes, `/v1/cusp-curves` follows each cusp from one such length to another, `/v1/checks`
proves or refutes a requirement on the number of cusps, `/v1/poses` computes all poses for three leg lengths,
`/v1/singular-curves` draws the singular curves of a slice with the number of poses in each region,
`/v1/aspects` tells which poses are joined while a leg varies, and `/v1/paths` leads to another pose without a
singularity. `/v1/batches` takes thousands of such questions at once. Known answers are returned immediately;
all others are computed by a job. Every number in an answer is a decimal string with proved digits, and every
number in a request is taken exactly as written.

Errors are `application/problem+json` (RFC 9457); the `type` of a problem is an address that documents it.
"""
TAGS = [
    *(operation.tag for operation in OPERATIONS),
    ("batches", "Many questions in one, with their results as they come."),
    ("jobs", "Follow, fetch and cancel computations."),
    ("webhooks", "Events that the service sends; see `callback_url`."),
    ("operations", "Health, versions, limits and metrics."),
]
MODELS: tuple[type[BaseModel], ...] = (
    *(model for operation in OPERATIONS for model in (operation.question, operation.answer)),
    *(
        BatchRequest,
        Batch,
        BatchResult,
        Job,
        StreamEvent,
        JobEvent,
        BatchEvent,
        Deliveries,
        JobList,
        ProblemDocument,
        Health,
        Readiness,
        Version,
        LimitsDocument,
    ),
)
"""All documents of the contract."""
NUMBERS = {"ExactNumber": EXACT_NUMBER, "PositiveNumber": POSITIVE_NUMBER}
"""The schemas of numbers in requests, by name."""


def describe(app: FastAPI) -> None:
    """Give the application its OpenAPI document, which is made at first use."""

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is None:
            app.openapi_schema = document(app)
        return app.openapi_schema

    app.openapi = openapi  # type: ignore[method-assign]


def document(app: FastAPI) -> dict[str, Any]:
    """Returns the OpenAPI document of the application."""
    contract: dict[str, Any] = get_openapi(
        title=app.title,
        version=app.version,
        openapi_version="3.1.0",
        description=DESCRIPTION,
        tags=[{"name": name, "description": text} for name, text in TAGS],
        license_info={"name": "MIT", "identifier": "MIT"},
        routes=app.routes,
    )
    schemas = contract.setdefault("components", {}).setdefault("schemas", {})
    schemas.update(_schemas())
    for unused in ("HTTPValidationError", "ValidationError"):
        schemas.pop(unused, None)
    for operations in contract["paths"].values():
        for operation in operations.values():
            responses = operation["responses"]
            if responses.get("422", {}).get("description") == "Validation Error":
                del responses["422"]  # the framework's own, which never occurs
    _show_nulls(contract, app)
    describe_headers(contract)
    describe_access(contract)
    contract["webhooks"] = WEBHOOKS
    return contract


def _show_nulls(contract: dict[str, Any], app: FastAPI) -> None:
    """Put the examples of answers in again, from which the framework drops every null."""
    routes = (context.original_route for context in iter_route_contexts(app.routes))
    for route in routes:
        if not isinstance(route, APIRoute) or not route.include_in_schema:
            continue
        for method in route.methods or ():
            described = contract["paths"][route.path_format][method.lower()]["responses"]
            for status, response in route.responses.items():
                for media_type, content in response.get("content", {}).items():
                    shown = {key: content[key] for key in ("example", "examples") if key in content}
                    described[str(status)]["content"][media_type].update(shown)


def operation_id(route: APIRoute) -> str:
    """Returns the name of the route's function."""
    return route.name


def _schemas() -> dict[str, Any]:
    _, schema = models_json_schema(
        [(model, "validation") for model in MODELS], ref_template="#/components/schemas/{model}"
    )
    titles = {name: value["title"] for name, value in schema["$defs"].items()}
    tidy = {titles[name]: _tidy(value, titles) for name, value in schema["$defs"].items()}
    return {
        **{name: {"title": name, **number} for name, number in NUMBERS.items()},
        **{title: {"title": title, **value} for title, value in tidy.items()},
        **in_floats(tidy, [operation.answer.__name__ for operation in OPERATIONS]),
    }


def _tidy(value: Any, titles: Mapping[str, str]) -> Any:
    """Name every schema by its title, refer to shared ones, and drop derived titles."""
    if isinstance(value, list):
        return [_tidy(item, titles) for item in value]
    if not isinstance(value, dict):
        return value
    schema = {key: _tidy(item, titles) for key, item in value.items()}
    for name, number in NUMBERS.items():
        if schema.get("oneOf") == number["oneOf"]:
            text = schema["description"]
            described = {} if text == number["description"] else {"description": text}
            return {"$ref": f"#/components/schemas/{name}", **described}
    if isinstance(schema.get("title"), str) and "properties" not in schema:
        del schema["title"]  # derived from the name of the field
    if isinstance(ref := schema.get("$ref"), str):
        prefix, _, name = ref.rpartition("/")
        schema["$ref"] = f"{prefix}/{titles.get(name, name)}"
    if isinstance(text := schema.get("description"), str):
        schema["description"] = re.sub(r"\s*\n\s*", " ", text)
    return schema
