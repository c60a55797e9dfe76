"""The proofs about a path: J keeps its sign along it, the free legs keep their limits, and its image goes
round a point of the (L2, L3) plane.

A path is cut into pieces until balls decide all questions on each. On a piece of half-width r about τ the
values lie in F(τ) + F′(τ)[−r, r] + F″(piece)[0, r²]/2, which shrinks with the square of the width
(mathematics.md#paths-without-a-singularity).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from flint import acb, arb

from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.arcs import Arc, Expansion, bounded, expanded
from rpr_solver.paths.isolated import Image
from rpr_solver.paths.path_limits import NO_LIMITS, PathLimits
from rpr_solver.paths.route import Route

_FIRST_CUT = 4
_SMALLEST = 2.0**-24


@dataclass(frozen=True)
class PathProof:
    """What is proved about a path.

    Attributes:
        sign: of J, the same all along.
        pieces: the number of pieces on which balls decided it.
        least: a lower bound of |J| / (L1 L2 L3) along the path (scaled).
        windings: for each point that was given, how often the image turns round it, counter-clockwise.
    """

    sign: int
    pieces: int
    least: arb
    windings: tuple[int, ...]


ProvedRoute: TypeAlias = tuple[Route, PathProof]


def prove(
    slice_map: SliceMap,
    arcs: Sequence[Arc],
    sign: int,
    centres: Sequence[Image] = (),
    most_pieces: int = 4000,
    limits: PathLimits = NO_LIMITS,
    at_ends: tuple[bool, bool] = (True, True),
) -> PathProof | None:
    """Proves that J has this sign along the arcs, and how often their closed image winds round each centre.

    The arcs must follow one another; with a centre, the image of the first point must be that of the last.
    ``at_ends`` tells whether the first point is the start of the path, and the last one its end. Returns None
    if J changes its sign, the image meets a centre, a leg exceeds its limits, or the balls do not decide it.
    """
    pieces, turns, least = 0, [arb(0)] * len(centres), arb("+inf")
    last = len(arcs) - 1
    for number, arc in enumerate(arcs):
        stack = [(arb(2 * k + 1) / (2 * _FIRST_CUT), 0.5 / _FIRST_CUT) for k in reversed(range(_FIRST_CUT))]
        start = expanded(slice_map, arc, arb(0), 0)
        while stack:
            tau, half = stack.pop()
            pieces += 1
            near = expanded(slice_map, arc, tau, 1)
            if pieces > most_pieces or near.singularity[0] * sign < 0:
                return None
            if limits.exclude((near.first[0], near.second[0])):
                return None
            wide = expanded(slice_map, arc, arb(tau, half), 2)
            radius = arb(half)
            value = bounded(near.singularity, wide.singularity, radius) * sign
            image = bounded(near.first, wide.first, radius), bounded(near.second, wide.second, radius)
            bends = None
            kept = limits.hold(
                image,
                (wide.first[1], wide.second[1]),
                at_start=at_ends[0] and number == 0 and tau == half,
                at_stop=at_ends[1] and number == last and tau + half == 1,
            )
            if value > 0 and image[0] > 0 and image[1] > 0 and kept:
                end = expanded(slice_map, arc, tau + radius, 0)
                bends = _bends(image, (start, end), centres)
            if bends is not None:
                turns = [turn + bend for turn, bend in zip(turns, bends, strict=True)]
                legs = 2 * (image[0].abs_upper() * image[1].abs_upper()).sqrt()
                start, least = end, least.min((value.abs_lower() / legs).lower())
            elif half < _SMALLEST:
                return None
            else:
                quarter = half / 2
                stack += [(tau + quarter, quarter), (tau - quarter, quarter)]
    windings = [n for turn in turns if (n := (turn / (2 * arb.pi())).unique_fmpz()) is not None]
    if len(windings) != len(centres):
        return None
    return PathProof(sign, pieces, least, tuple(map(int, windings)))


def _bends(image: Image, ends: tuple[Expansion, Expansion], centres: Sequence[Image]) -> list[arb] | None:
    """The angles through which a piece of the image turns about the centres; None if its box meets one.

    A box without the centre is seen from it under less than 180°.
    """
    bends = []
    for x, y in centres:
        if acb(image[0] - x, image[1] - y).contains(0):
            return None
        start, end = (acb(e.first[0] - x, e.second[0] - y) for e in ends)
        angle = (end / start).arg()
        if not (angle.is_finite() and abs(angle) < arb.pi()):
            return None
        bends.append(angle)
    return bends
