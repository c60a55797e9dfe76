"""What schemathesis does not do by itself: newline-delimited JSON, and media types with parameters."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import jsonschema_rs
import schemathesis
from schemathesis.openapi.checks import JsonSchemaError

NDJSON = "application/x-ndjson"


@schemathesis.serializer(NDJSON)
def lines(_context: schemathesis.SerializationContext, value: object) -> bytes:
    """Returns generated text as a body."""
    return str(value).encode("utf-8", "surrogatepass")


@schemathesis.hook
def filter_failure(
    _context: schemathesis.HookContext,
    failure: Exception,
    _case: schemathesis.Case,
    response: schemathesis.Response,
) -> bool:
    """Drops objections to JSON that has a schema of its own by a parameter: they were about plain JSON."""
    is_plain = media_type_of(response) in ("application/json", "application/problem+json")
    return is_plain or not isinstance(failure, JsonSchemaError)


@schemathesis.check
def by_exact_media_type(
    _context: schemathesis.CheckContext, response: schemathesis.Response, case: schemathesis.Case
) -> None:
    """The answer is what the contract says of its media type with parameters; of NDJSON, each line."""
    media_type = media_type_of(response)
    contract = case.operation.schema.raw_schema
    answer = case.operation.definition.raw["responses"].get(str(response.status_code), {})
    schema: Mapping[str, Any] = answer.get("content", {}).get(media_type, {}).get("schema", {})
    if media_type == NDJSON and "$ref" in schema:
        values = response.text.splitlines()
    elif media_type.startswith("application/json;"):
        values = [response.text]
    else:
        return
    validator = jsonschema_rs.validator_for({**schema, "components": contract["components"]})
    for value in values:
        validator.validate(json.loads(value))


def media_type_of(response: schemathesis.Response) -> str:
    """Returns the media type of an answer, with its parameters."""
    return str(response.headers.get("content-type", [""])[0])
