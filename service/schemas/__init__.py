"""Questions and answers of the contract, as models."""

from service.schemas.registry import all_questions, by_kind, queries

__all__ = [
    "all_questions",
    "by_kind",
    "queries",
]
