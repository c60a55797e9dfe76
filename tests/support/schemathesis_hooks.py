"""What schemathesis does not know by itself: newline-delimited JSON, in bodies and in answers."""

from __future__ import annotations

import json

import jsonschema_rs
import schemathesis

NDJSON = "application/x-ndjson"


@schemathesis.serializer(NDJSON)
def lines(_context: schemathesis.SerializationContext, value: object) -> bytes:
    """Returns generated text as a body."""
    return str(value).encode("utf-8", "surrogatepass")


@schemathesis.check
def lines_conform(
    _context: schemathesis.CheckContext, response: schemathesis.Response, case: schemathesis.Case
) -> None:
    """Each line is what the schema of the answer describes, if it describes lines."""
    contract = case.operation.schema.raw_schema
    answer = case.operation.definition.raw["responses"].get(str(response.status_code), {})
    schema = answer.get("content", {}).get(NDJSON, {}).get("schema", {})
    if "$ref" in schema and NDJSON in response.headers.get("content-type", [""])[0]:
        line = jsonschema_rs.validator_for({**schema, "components": contract["components"]})
        for text in response.text.splitlines():
            line.validate(json.loads(text))
