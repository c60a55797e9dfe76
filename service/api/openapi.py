"""The published contract: OpenAPI 3.1 as the application describes itself."""

from __future__ import annotations

import re
from typing import Any, cast

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from fastapi.routing import APIRoute
from pydantic.json_schema import models_json_schema

from service.schemas.document_models import DOCUMENT_MODELS
from service.schemas.models import EXACT_NUMBER, MODELS

DESCRIPTION = """\
Certified cusp points in the joint space of planar 3-RPR parallel manipulators.

Post a manipulator and the slices L1 that you want to `/v1/cusp-tables`. `/v1/censuses` tells every length at
which their number changes, `/v1/cusp-curves` follows each cusp from one such length to another,
`/v1/checks` proves or refutes a requirement on their number, and `/v1/poses` gives all poses of three leg
lengths. What is known already is answered at once; the rest is computed by a job. Every
number in an answer is a decimal string whose every digit is proved, and every number in a request is taken
exactly as it was written.

Errors are `application/problem+json` (RFC 9457); the `type` of a problem is an address that explains it.
"""
TAGS = [
    {"name": "cusp tables", "description": "Ask for the cusps of a manipulator."},
    {"name": "censuses", "description": "Where the number of cusps changes."},
    {"name": "cusp curves", "description": "How cusps move while the fixed leg changes its length."},
    {"name": "checks", "description": "Requirements on the number of cusps."},
    {"name": "poses", "description": "Direct kinematics."},
    {"name": "jobs", "description": "Follow, fetch and cancel what is being computed."},
    {"name": "operations", "description": "Run the service."},
]


def describe(app: FastAPI) -> None:
    """Give the application its OpenAPI document, made at first use."""

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is None:
            app.openapi_schema = document(app)
        return app.openapi_schema

    app.openapi = openapi  # type: ignore[method-assign]


def document(app: FastAPI) -> dict[str, Any]:
    """The OpenAPI document of the application."""
    found: dict[str, Any] = get_openapi(
        title=app.title,
        version=app.version,
        openapi_version="3.1.0",
        description=DESCRIPTION,
        tags=cast(Any, TAGS),
        license_info={"name": "MIT", "identifier": "MIT"},
        routes=app.routes,
    )
    schemas = found.setdefault("components", {}).setdefault("schemas", {})
    schemas.update(_schemas())
    for unused in ("HTTPValidationError", "ValidationError"):
        schemas.pop(unused, None)
    for path in found["paths"].values():
        for operation in path.values():
            _drop_undeclared(operation["responses"])
    return found


def operation_id(route: APIRoute) -> str:
    """The name of the route's function."""
    return route.name


def _schemas() -> dict[str, Any]:
    models = {**MODELS, **DOCUMENT_MODELS}
    _, schema = models_json_schema(
        [(model, "validation") for model in models.values()], ref_template="#/components/schemas/{model}"
    )
    names = {model.__name__: name for name, model in models.items()}
    renamed = {names.get(name, name): value for name, value in schema["$defs"].items()}
    tidy = {name: {"title": name, **_tidy(value, names)} for name, value in renamed.items()}
    return {"ExactNumber": {"title": "ExactNumber", **EXACT_NUMBER}, **tidy}


def _tidy(value: Any, names: dict[str, str]) -> Any:
    """Follow the new names, refer to what is used often, and leave out what says nothing."""
    if isinstance(value, dict):
        found = {key: _tidy(item, names) for key, item in value.items()}
        if found.get("oneOf") == EXACT_NUMBER["oneOf"]:
            own = {} if found["description"] == EXACT_NUMBER["description"] else found
            described = {key: own[key] for key in ("description",) if key in own}
            return {"$ref": "#/components/schemas/ExactNumber", **described}
        if isinstance(found.get("title"), str) and "properties" not in found:
            del found["title"]  # made from the name of the field
        if isinstance(ref := found.get("$ref"), str):
            prefix, _, name = ref.rpartition("/")
            found["$ref"] = f"{prefix}/{names.get(name, name)}"
        if isinstance(text := found.get("description"), str):
            found["description"] = re.sub(r"\s*\n\s*", " ", text)
        return found
    if isinstance(value, list):
        return [_tidy(item, names) for item in value]
    return value


def _drop_undeclared(responses: dict[str, Any]) -> None:
    """Remove what the framework adds: its own 422, and an empty schema beside a declared type."""
    for status, answer in list(responses.items()):
        content = answer.get("content", {})
        schema = content.get("application/json", {}).get("schema")
        if schema == {} and len(content) > 1:
            del content["application/json"]
        elif schema is not None and str(schema.get("$ref", "")).endswith("/HTTPValidationError"):
            del responses[status]
