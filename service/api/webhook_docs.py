"""OpenAPI descriptions of the requests that the service sends."""

from __future__ import annotations

from typing import Any

from service.api.contract.operations import ref
from service.api.negotiation import JSON

_HEADERS = {
    "webhook-id": "The same at every attempt: whoever has seen it has the event already.",
    "webhook-timestamp": "When the attempt was made, in seconds since 1970.",
    "webhook-signature": "`v1,` and the HMAC-SHA256 of `id.timestamp.body` in base64; one for each secret, "
    "separated by spaces.",
}
_PARAMETERS = [
    {"name": name, "in": "header", "required": True, "description": text, "schema": {"type": "string"}}
    for name, text in _HEADERS.items()
]


def _event(what: str, model: str) -> dict[str, Any]:
    return {
        "post": {
            "operationId": f"{what}_ended",
            "summary": f"The end of a {what}",
            "description": f"Sent to every `callback_url` of a {what} when it has succeeded, failed or was "
            "canceled, signed after the Standard Webhooks specification.",
            "tags": ["webhooks"],
            "security": [],
            "parameters": _PARAMETERS,
            "requestBody": {"required": True, "content": {JSON: {"schema": ref(model)}}},
            "responses": {
                "2XX": {"description": "Received."},
                "410": {"description": "No more attempts, please."},
                "default": {"description": "Sent again later; `Retry-After` is honoured."},
            },
        }
    }


WEBHOOKS: dict[str, Any] = {
    "job-ended": _event("job", "JobEvent"),
    "batch-ended": _event("batch", "BatchEvent"),
}
