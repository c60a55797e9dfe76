"""The schemas of documents with JSON numbers in place of text, from those of the documents."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from service.api.answers.forms import IN_FLOATS, NO_NUMBERS

_PREFIX = "#/components/schemas/"
_NO_NUMBER = ("enum", "const", "pattern", "format")
"""What says of a text that it is none."""


def in_floats(schemas: Mapping[str, Any], documents: Sequence[str]) -> dict[str, Any]:
    """Returns the schemas of these documents with numbers, and of their parts that have any."""
    found: dict[str, Any] = {}

    def named(name: str) -> str:
        """Returns the name of the schema with numbers, or the same one if there are none in it."""
        if name not in schemas:
            return name  # one of those that take numbers anyway
        other = name + IN_FLOATS
        if other not in found:
            found[other] = {}  # a schema that leads to itself has, for all we know, numbers
            changed = of(schemas[name])
            if changed == schemas[name] and name not in documents:
                del found[other]
                return name
            found[other] = {**changed, "title": other}
        return other

    def of(schema: Any) -> Any:
        if not isinstance(schema, dict):
            return schema
        changed = dict(schema)
        if isinstance(reference := schema.get("$ref"), str):
            changed["$ref"] = _PREFIX + named(reference.removeprefix(_PREFIX))
        if schema.get("type") == "string" and not any(key in schema for key in _NO_NUMBER):
            changed["type"] = ["number", "string"]
        for key in ("items", "additionalProperties"):
            if key in schema:
                changed[key] = of(schema[key])
        for key in ("anyOf", "oneOf", "allOf", "prefixItems"):
            if key in schema:
                changed[key] = [of(part) for part in schema[key]]
        if "properties" in schema:
            changed["properties"] = {
                name: part if name in NO_NUMBERS else of(part) for name, part in schema["properties"].items()
            }
        return changed

    for name in documents:
        named(name)
    return found
