"""From a question to its document: kinds, costs, stores."""

from worker.answers.kind import Document, JobRequest, Kept, Kind, SliceJson, Store, answer, in_groups

__all__ = [
    "Document",
    "JobRequest",
    "Kept",
    "Kind",
    "SliceJson",
    "Store",
    "answer",
    "in_groups",
]
