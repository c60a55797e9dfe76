"""How much may be done for a document: so many boxes as its length allows, and no more."""

from __future__ import annotations

from rpr_solver.verify_by_boxes.claims import OpenError

LEAST_CHARACTERS = 100_000
"""A shorter document has the work of one of this length."""
BOXES_OF_A_CHARACTER = 1
_SHORT_BITS = 128


class Work:
    """The boxes that may still be looked at.

    A unit is a box at up to 128 bits, about 50 to 100 microseconds of one core; at more bits it counts as
    the products of its numbers do.
    """

    def __init__(self, characters: int) -> None:
        self.left = BOXES_OF_A_CHARACTER * max(LEAST_CHARACTERS, characters)

    def spend(self, boxes: int = 1, bits: int = _SHORT_BITS) -> None:
        """Counts boxes that are looked at with so many bits.

        Raises:
            OpenError: there is no work left.
        """
        self.left -= boxes * (1 + (bits // _SHORT_BITS) ** 2 // 16)
        if self.left < 0:
            raise OpenError("it needs more work than the length of the document allows; verify parts of it")
