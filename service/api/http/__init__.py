"""HTTP below the framework: connections, heads, bodies, and answers in pieces."""

from service.api.http.transport import LongAnswer, Slots, in_pieces, made_in_threads

__all__ = [
    "LongAnswer",
    "Slots",
    "in_pieces",
    "made_in_threads",
]
