"""The tree of boxes that a search has cut, with the verdicts about its leaves, and which of them touch."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from rpr_solver.paths.boxes import FIRST_LEVEL, Box, Boxes, Judgement, PosePoint, Verdict, whole

_BATCH = 4096
"""So many boxes at once keep the arrays in the processor's cache."""


class BoxTree:
    """Boxes, and those into which they were cut.

    Attributes:
        boxes: which boxes there are, and what is proved about each.
        verdicts: about those that were not cut; None of the others.
        judgements: what balls show of those that are undecided, or were.
    """

    def __init__(self, boxes: Boxes) -> None:
        self.boxes = boxes
        self._near: dict[Box, list[Box]] = {}
        self.verdicts: dict[Box, Verdict | None] = {}
        self.judgements: dict[Box, Judgement] = {}
        self._judge(boxes.first())

    def leaves(self, verdict: Verdict) -> list[Box]:
        """The boxes, not cut any further, with a verdict."""
        return [box for box, own in self.verdicts.items() if own is verdict]

    def leaf(self, place: PosePoint, level: int = FIRST_LEVEL) -> Box | None:
        """The box, not cut any further, that holds a place; None if this is too near to an edge."""
        while (box := self.boxes.holding(place, level)) is not None and self.verdicts[box] is None:
            level += 1
        return box

    def narrowest(self) -> int:
        """The level of the narrowest boxes."""
        return max(box[0] for box, verdict in self.verdicts.items() if verdict is not None)

    def cut(self, boxes: Iterable[Box]) -> None:
        """Cuts boxes, and looks at their parts."""
        parts: list[Box] = []
        for box in boxes:
            for other in (box, *self.neighbours(box)):
                self.forget(other)
            self.verdicts[box] = None
            own = self.boxes.parts(box)
            self.verdicts.update(dict.fromkeys(own, Verdict.UNDECIDED))
            parts += own
        self._judge(parts)

    def forget(self, box: Box) -> None:
        """Forgets what depends on how the boxes beside one are cut."""
        self._near.pop(box, None)

    def _judge(self, boxes: Sequence[Box]) -> None:
        for first in range(0, len(boxes), _BATCH):
            batch = boxes[first : first + _BATCH]
            for box, judgement in zip(batch, self.boxes.judged(batch), strict=True):
                self.verdicts[box] = judgement.verdict
                if judgement.verdict is Verdict.UNDECIDED:
                    self.judgements[box] = judgement

    def neighbours(self, box: Box) -> list[Box]:
        """The boxes, not cut any further, that share a part of a face with one."""
        if box not in self._near:
            self._near[box] = [
                other
                for axis in self.boxes.axes
                for step in (-1, 1)
                if (same := self.boxes.neighbour(box, axis, step)) is not None
                for other in self.uncut(same, axis, step)
            ]
        return self._near[box]

    def uncut(self, box: Box, axis: int, step: int) -> Iterator[Box]:
        """The boxes into which one is cut, at the face by which it is entered, or the one that holds it."""
        while box not in self.verdicts:
            box = whole(self.boxes, box)
        if self.verdicts[box] is not None:
            yield box
            return
        parts = self.boxes.parts(box)
        places = [part[axis + 1] for part in parts]
        side = min(places) if step > 0 else max(places)
        for part in parts:
            if part[axis + 1] == side:
                yield from self.uncut(part, axis, step)
