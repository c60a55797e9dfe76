"""HTTP below the framework: connections, heads, bodies, and answers in pieces."""

from service.api.http.transport import LongAnswer, Slots, cut, in_pieces, made_in_threads, part_of

__all__ = [
    "LongAnswer",
    "Slots",
    "cut",
    "in_pieces",
    "made_in_threads",
    "part_of",
]
