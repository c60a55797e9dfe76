"""Batches: many questions in one request."""

from service.api.batches.rows import item_of, read_item

__all__ = [
    "item_of",
    "read_item",
]
