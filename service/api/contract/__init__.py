"""What openapi.yaml says beyond the models: bodies, parameters, responses, examples, links."""

from service.api.contract.responses import Docs, json_response, problems, question_responses, request_body

__all__ = [
    "Docs",
    "json_response",
    "problems",
    "question_responses",
    "request_body",
]
