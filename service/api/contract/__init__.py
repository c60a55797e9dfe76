"""What openapi.yaml says beyond the models: bodies, parameters, responses, examples, links."""

from service.api.contract.responses import PROBLEMS, Docs, json_response, question_responses, request_body

__all__ = [
    "PROBLEMS",
    "Docs",
    "json_response",
    "question_responses",
    "request_body",
]
