"""What openapi.yaml promises, as lines; the contract only grows, so no line of an earlier one may go.

`python -m tests.support.contract` adds the lines of new calls and members to the file, with a release.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from service.api.app import create_app
from tests.support.processes import ROOT

FILE = ROOT / "tests" / "data" / "contract-v1.txt"


def promises(contract: dict[str, Any]) -> set[str]:
    """Calls, their parameters and answers, members of documents, values that requests may have."""
    return {*_of_calls(contract), *_of_documents(contract)}


def demands(contract: dict[str, Any]) -> set[str]:
    """What a request must have."""
    schemas = contract["components"]["schemas"]
    return {
        *(f"{name} must have {member}" for name in _asked(schemas) for member in _required(schemas[name])),
        *(
            f"{call} must have {parameter['name']}"
            for call, operation in _calls(contract)
            for parameter in _parameters(contract, operation)
            if parameter.get("required")
        ),
    }


def _calls(contract: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    for path, methods in contract["paths"].items():
        yield from ((f"{method.upper()} {path}", operation) for method, operation in methods.items())


def parts(schema: Any) -> Iterator[dict[str, Any]]:
    """A schema and all schemas in it."""
    if isinstance(schema, dict):
        yield schema
    for item in schema.values() if isinstance(schema, dict) else schema:
        if isinstance(item, dict | list):
            yield from parts(item)


def _of_calls(contract: dict[str, Any]) -> Iterator[str]:
    for call, operation in _calls(contract):
        yield call
        yield f"{call} is called {operation['operationId']}"
        for parameter in _parameters(contract, operation):
            yield f"{call} takes {parameter['in']} {parameter['name']}"
        for media_type in operation.get("requestBody", {}).get("content", {}):
            yield f"{call} takes {media_type}"
        for status, named in operation["responses"].items():
            name = named.get("$ref", "").rpartition("/")[2]
            answer = contract["components"]["responses"][name] if name else named
            yield from (f"{call} answers {status} {kind}" for kind in answer.get("content", {"": {}}))


def _of_documents(contract: dict[str, Any]) -> Iterator[str]:
    schemas = contract["components"]["schemas"]
    for name, schema in schemas.items():
        for member, part in schema.get("properties", {}).items():
            yield f"{name} has {member}"
            if name in _asked(schemas):
                yield from (f"{name} takes {member} {value}" for value in part.get("enum", ()))


def _asked(schemas: dict[str, Any]) -> list[str]:
    """The documents that are sent: those that allow no other members."""
    return [name for name, schema in schemas.items() if schema.get("additionalProperties") is False]


def _required(schema: dict[str, Any]) -> list[str]:
    return list(schema.get("required", ()))


def _parameters(contract: dict[str, Any], operation: dict[str, Any]) -> Iterator[dict[str, Any]]:
    for parameter in operation.get("parameters", ()):
        name = parameter.get("$ref", "").rpartition("/")[2]
        yield contract["components"]["parameters"][name] if name else parameter


def known() -> set[str]:
    """The lines of the file."""
    return set(FILE.read_text(encoding="utf-8").splitlines())


def main() -> None:
    contract = create_app().openapi()
    lines = known() if FILE.exists() else set()
    FILE.write_text(
        "\n".join(sorted(lines | promises(contract) | demands(contract))) + "\n", encoding="utf-8"
    )


if __name__ == "__main__":
    main()
