"""What a document lists, against what is found: each listed pose is another one of these, with its digits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from flint import arb, ctx

from rpr_solver.boxes import Box, Undecided, Zero
from rpr_solver.verify_by_boxes.equations import Space
from rpr_solver.verify_by_boxes.finding import TURNED
from rpr_solver.verify_by_boxes.numbers import Printed, ball, bits_of
from rpr_solver.verify_by_boxes.work import Work

_SPARE = 32
_STEPS = 4
"""How many of the bits that tell digits apart are tried: once, twice, four and eight times as many."""


def degrees(x: arb) -> arb:
    """An angle in degrees."""
    return x * 180 / arb.pi()


def is_turn(name: str) -> bool:
    """Whether a member is an angle in degrees."""
    return name.endswith("_deg")


@dataclass(frozen=True)
class Row:
    """Printed numbers of a pose by the names of the members, α and θ first."""

    numbers: Mapping[str, Printed]

    @cached_property
    def bits(self) -> int:
        """So many bits after the point tell the numbers from their neighbours."""
        return bits_of(self.numbers.values())

    @cached_property
    def angles(self) -> Box:
        """A box of the angles α and θ that round to the printed ones, and a little more, in radians."""
        first, second, *_ = self.numbers.values()
        with ctx.workprec(self.bits + _SPARE):
            return [_radians(first), _radians(second)]


def _radians(x: Printed) -> arb:
    return arb(ball(x.value), ball(x.upper - x.lower)) * arb.pi() / 180


def pose_numbers(space: Space, box: Box) -> Mapping[str, arb]:
    """The numbers of a pose, by the names of the members: α and θ in degrees, and the lengths of the legs."""
    angles = {"alpha_deg": degrees(box[0]), f"theta{space.mechanism.fixed}_deg": degrees(box[1])}
    return {**angles, **{f"l{leg}": x for leg, x in space.on(box, 0).lengths.items()}}


Values = Callable[[Box], Mapping[str, arb]]
"""The numbers of a pose by the names of the members, for all poses of a box."""


def agrees(zero: Zero, row: Row, values: Values, work: Work) -> bool | None:
    """Whether a zero has the printed numbers; None if that is open.

    Raises:
        OpenError: there is no work left.
    """
    near = [*TURNED(row.angles, zero.at[:2]), *zero.at[2:]]
    if not all(x.overlaps(y) for x, y in zip(near, zero.at, strict=True)):
        return False
    for step in range(_STEPS):
        bits = (row.bits << step) + _SPARE
        work.spend(8, bits)
        with ctx.workprec(bits + _SPARE):
            try:
                found = values(zero.within(bits, near))
            except Undecided:
                return None
            sides = [x.rounds(found[name], 360 if is_turn(name) else 0) for name, x in row.numbers.items()]
        if None not in sides:
            return False not in sides
        if False in sides:
            return False
    return None


@dataclass(frozen=True)
class Matching:
    """For each listed pose the place of a zero that it is, each another; and what is left.

    Attributes:
        places: of the zeros; None for a listed pose that is none of them.
        unsure: the listed poses that may be a zero, which is open.
    """

    places: Sequence[int | None]
    unsure: frozenset[int]

    @classmethod
    def of(cls, rows: Sequence[Row], zeros: Sequence[Zero], values: Values, work: Work) -> Matching:
        """Each listed pose goes to the first zero with its numbers that is left."""
        places: list[int | None] = []
        unsure = set()
        for n, row in enumerate(rows):
            place = None
            for k, zero in enumerate(zeros):
                if k in places or (same := agrees(zero, row, values, work)) is False:
                    continue
                if same:
                    place = k
                    break
                unsure.add(n)
            places.append(place)
        return cls(places, frozenset(unsure - {n for n, k in enumerate(places) if k is not None}))
