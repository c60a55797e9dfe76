"""Branch and prune: all zeros of a system in some boxes, each proved to be alone in a box.

A box has no zero, or it is narrowed, or it is cut in two, until Krawczyk's test proves that it has exactly
one. Where two zeros are very near to each other, or nearly meet, the box is in a fold.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterable
from dataclasses import dataclass, field

from flint import arb, ctx

from rpr_solver.boxes.box import Empty, bits_of, common, contains, halves, widest
from rpr_solver.boxes.folds import fold_at
from rpr_solver.boxes.krawczyk import Expansion
from rpr_solver.boxes.systems import Box, Functions, System, Undecided
from rpr_solver.boxes.zeros import Turned, Zero, is_same, turned

_WORD = 64
"""Bits of a computation with a box as wide as 1, and what precisions are multiples of."""
_FOLDED, _FOLDS = 12, (2.0**-7, 2.0**-10, 2.0**-13)
"""Boxes with so many bits may be in a fold, which has at most such a radius."""
_FAILURES = 8
"""So many boxes of a size may be in no fold before it is tried for no more of them."""


@dataclass
class Search:
    """All zeros of a system in some boxes: those that are proved, and boxes in which others may be.

    A proved zero may be a little outside of the boxes that were searched.

    Attributes:
        zeros: those that are proved, each once.
        doubts: boxes where it is open whether there are others.
        looked: the number of boxes that were looked at.
        done: boxes in which there are no others than ``zeros``, or that are among ``doubts``.
        failures: how often a box with so many bits was in no fold.
    """

    zeros: list[Zero] = field(default_factory=list)
    doubts: list[Box] = field(default_factory=list)
    looked: int = 0
    done: list[Box] = field(default_factory=list)
    failures: Counter[int] = field(default_factory=Counter)


def search(
    system: System, start: Iterable[Box], least: float, most: int, moved: Turned | None = None
) -> Search:
    """Finds all zeros of a system in some boxes.

    Boxes are cut until each is known to have no zero or one, or has only radii below ``least``, or ``most``
    have been looked at, the widest first; what is undecided then is in doubt. Zeros that ``moved`` brings
    together are one.

    Invariant: each zero in ``start`` is one of ``zeros``, or is in a box of ``todo`` or ``doubts``. It ends
    as ``looked`` grows.
    """
    found, todo, moved = Search(), deque(start), moved or turned()
    while todo:
        if found.looked >= most:
            found.doubts += todo
            break
        box = todo.popleft()
        found.looked += 1
        with ctx.workprec(_WORD * (1 + 3 * max(bits_of(box), 0) // _WORD)):
            rest = _rest(system, box, found, moved)
            if rest is None:
                continue
            if widest(rest) < least:
                found.doubts.append(rest)
            elif 2 * widest(rest) < widest(box):
                todo.append(rest)
            else:
                todo += halves(rest)
    return found


def _rest(system: System, box: Box, found: Search, moved: Turned) -> Box | None:
    """The part of a box where zeros may be that are not found; None if there are none."""
    if any(contains(room, moved(box, room)) for room in found.done):
        return None
    try:
        functions = system.square(box)
    except Undecided:
        return None if Expansion.of(system.stages[-1], box).excluded else box
    expansion = Expansion.of(functions, box)
    if expansion.excluded:
        return None
    try:
        part = common(box, expansion.image())
        if 2 * widest(part) < widest(box):
            room = [arb(x.mid(), 2 * x.rad()) for x in part]
            _add(found, [Zero.alone(system.square(room), room)], room, moved)
            return None
    except Empty:
        return None
    except Undecided:
        part = box
    if len(box) == 2 and bits_of(box) >= _FOLDED and _is_folded(system, part, found, moved):
        return None
    return part


def _is_folded(system: System, box: Box, found: Search, moved: Turned) -> bool:
    """Whether a box is in a fold, with whose zeros it is done."""
    bits = bits_of(box)
    if found.failures[bits] >= _FAILURES:
        return False
    try:
        fold = fold_at(*_wide(system, box), box)
        if fold.zeros is None:
            found.doubts.append(fold.room)
            found.done.append(fold.room)
        else:
            _add(found, fold.zeros, fold.room, moved)
    except Undecided:
        found.failures[bits] += 1
        return False
    return True


def _wide(system: System, box: Box) -> tuple[Functions, Box]:
    """The square system of a box that is much wider than a given one, and that box.

    Raises:
        Undecided: there is none.
    """
    for radius in _FOLDS:
        wide = [arb(x.mid(), radius) for x in box]
        try:
            return system.square(wide), wide
        except Undecided:
            continue
    raise Undecided


def _add(found: Search, zeros: Iterable[Zero], room: Box, moved: Turned) -> None:
    """Adds all zeros of a box, but those that are known.

    Raises:
        Undecided: it is open whether one is known.
    """
    new = [zero for zero in zeros if not any(is_same(zero, other, moved) for other in found.zeros)]
    found.zeros += new
    found.done.append(room)
