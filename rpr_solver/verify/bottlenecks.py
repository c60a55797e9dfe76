"""That no path between two poses of a slice has a greater clearance than a bound.

If a pose q has the other sign of J, a path through a pose within X of q has a clearance of X at most. So has
each path between two poses that are separated by boxes all of whose poses are within X of such a q, or have
the other sign (mathematics.md#paths-without-a-singularity). Floats propose q, and which boxes need not be
looked at; the sign of J at q, and all distances, are proved.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from itertools import product
from math import cos, dist, radians, sin

from rpr_solver.verify.arcs import Forms, Place, directions
from rpr_solver.verify.claims import ClaimStatus, Finding, OpenError
from rpr_solver.verify.clearance import Square, singular_on, waves_of
from rpr_solver.verify.core.intervals import Interval, ends_of
from rpr_solver.verify.core.krawczyk import value
from rpr_solver.verify.core.reader import spend

BITS = 96
_TURN = 360
_NODES = 180
_STEP = _TURN / _NODES
_ORIGIN = Fraction(47, 1021) * _TURN, Fraction(-31, 877) * _TURN
"""Of the boxes: generic, so that no pose lies on an edge."""
_FIRST, _LAST = 4, 13
_FINEST = 96
_STEPS = 6
_BEYOND = (1e-3, 1e-2)
_SPARE = 1e-6
_SIDES = ((-1, 0), (1, 0), (0, -1), (0, 1))
Box = tuple[int, int, int]
"""The level, at which 2^level boxes make a turn, and the numbers of the box along α and θ."""
Spot = tuple[float, float]


class Field:
    """sign · J of a slice in floats, and the poses nearest to others where it is less than 0."""

    def __init__(self, waves: Mapping[tuple[int, int], Sequence[Interval]], sign: int, most: float) -> None:
        largest = max(x.greatest for pair in waves.values() for x in pair) or Fraction(1)
        # those of opposite directions are conjugate
        self.waves = [
            (p, q, *(sign * 2 * float(x.middle / largest) for x in pair))
            for (p, q), pair in waves.items()
            if (p, q) > (0, 0)
        ]
        self.size = max(2 * most, 3 * _STEP)

    def at(self, spot: Spot) -> tuple[float, float, float]:
        """The value and its derivatives by degrees; a constant, which J has not, would be missing."""
        alpha, theta = radians(spot[0]), radians(spot[1])
        value = first = second = 0.0
        for p, q, even, odd in self.waves:
            turn = p * alpha + q * theta
            c, s = cos(turn), sin(turn)
            value += even * c - odd * s
            slope = even * s + odd * c
            first -= p * slope
            second -= q * slope
        return value, radians(first), radians(second)

    @cached_property
    def _zeros(self) -> dict[tuple[int, int], list[Spot]]:
        """Zeros between neighbours of a grid, in squares of a size, and in those beside them."""
        spend(_NODES**2 * 12)
        nodes = range(_NODES)
        rows = [[self.at((i * _STEP, k * _STEP))[0] for k in nodes] for i in nodes]
        found: dict[tuple[int, int], list[Spot]] = {}
        for i, k in product(nodes, repeat=2):
            for x, y in ((1, 0), (0, 1)):
                here, there = rows[i][k], rows[(i + x) % _NODES][(k + y) % _NODES]
                if (here < 0) != (there < 0):  # a node may be a zero
                    share = here / (here - there)
                    self._keep(found, ((i + share * x) * _STEP, (k + share * y) * _STEP))
        return found

    def _keep(self, found: dict[tuple[int, int], list[Spot]], spot: Spot) -> None:
        for turns in product((-_TURN, 0, _TURN), repeat=2):
            zero = spot[0] + turns[0], spot[1] + turns[1]
            if all(-self.size <= x <= _TURN + self.size for x in zero):
                found.setdefault(self._square(zero), []).append(zero)

    def _square(self, spot: Spot) -> tuple[int, int]:
        return int(spot[0] // self.size), int(spot[1] // self.size)

    def beyond(self, spot: Spot) -> Spot | None:
        """A pose near the nearest zero, with a value below 0; None if none is near."""
        spend(400)
        if self.at(spot)[0] < 0:
            return spot
        own = spot[0] % _TURN, spot[1] % _TURN
        i, k = self._square(own)
        near = [x for m, n in product((-1, 0, 1), repeat=2) for x in self._zeros.get((i + m, k + n), ())]
        if not near:
            return None
        foot = self._polished(own, min(near, key=lambda x: dist(x, own)))
        for share in _BEYOND:
            x, y = (b + (b - a) * share for a, b in zip(own, foot, strict=True))
            if self.at((x, y))[0] < 0:
                return x + spot[0] - own[0], y + spot[1] - own[1]
        return None

    def _polished(self, spot: Spot, foot: Spot) -> Spot:
        """The zero nearest to a spot, from one near it: along the curve, by less where that leads away."""
        best, share = self._zero(foot), 1.0
        for _ in range(_STEPS):
            _, x, y = self.at(best)
            square = x * x + y * y or 1e-300
            along = share * ((spot[0] - best[0]) * -y + (spot[1] - best[1]) * x) / square
            found = self._zero((best[0] - y * along, best[1] + x * along))
            if dist(found, spot) < dist(best, spot):
                best = found
            else:
                share /= 3
        return best

    def _zero(self, spot: Spot) -> Spot:
        """A zero near a spot, by Newton's method along the slope."""
        for _ in range(2):
            value, x, y = self.at(spot)
            square = x * x + y * y or 1e-300
            spot = spot[0] - x * value / square, spot[1] - y * value / square
        return spot


@dataclass(frozen=True)
class Bottlenecks:
    """The poses of a slice within a distance of those with the other sign of J.

    Attributes:
        length: the scaled length of the fixed leg.
        sign: that of J on the paths.
        most: the distance, in degrees.
    """

    forms: Forms
    length: Interval
    sign: int
    most: Fraction
    known: dict[Box, bool | None] = field(default_factory=dict, repr=False)

    def bar(self, ends: Sequence[Place]) -> Finding:
        """Whether each path between two poses passes such a pose.

        Raises:
            OpenError: it is not decided.
        """
        spots = [(float(at[0].middle), float(at[1].middle)) for at in ends]
        for spot, at in zip(spots, ends, strict=True):
            if self._is_near(at[:2], spot, 0.0):
                return ClaimStatus.PROVED, "an end is as near to a pose where J has the other sign"
        for level in range(_FIRST, _LAST):
            width = _TURN / (1 << level)
            if width * _FINEST < float(self.most):
                break
            if width < float(self.most) and not self._is_open(ends, level):
                return ClaimStatus.PROVED, "boxes near poses where J has the other sign lie between"
        raise OpenError("boxes that separate both poses are not found")

    def _is_near(self, centre: Sequence[Interval], spot: Spot, reach: float) -> bool:
        """Whether a pose with the other sign is so near to all within ``reach`` of a place."""
        found = self._field.beyond(spot)
        if found is None or dist(found, spot) + reach > float(self.most) * (1 - _SPARE):
            return False
        q = [Interval.of(Fraction(x), BITS) for x in found]
        gaps = [x - y.at(BITS) for x, y in zip(q, centre, strict=True)]
        away = (gaps[0] * gaps[0] + gaps[1] * gaps[1]).root()
        if (away + Interval.of(Fraction(reach), BITS)).greatest > self.most:
            return False
        here = directions((q[0], q[1], self.length), self.forms.surface.ring.radicand)
        return value(here, self.forms.functions[0], self.length).sign == -self.sign

    def _is_open(self, ends: Sequence[Place], finest: int) -> bool:
        """Whether boxes down to a level that may hold wider paths lead from one pose to the other."""
        start, goal = (self._leaf(at, finest) for at in ends)
        seen, queue = {start}, deque([start])
        while queue:
            box = queue.popleft()
            if box == goal:
                return True
            if self._judged(box) is False:
                continue
            beside = {leaf for side in _SIDES for leaf in self._beyond(box, side, finest)}
            queue += beside - seen
            seen |= beside
        return False

    def _leaf(self, at: Place, finest: int) -> Box:
        """The leaf that holds a pose."""
        box = 0, 0, 0
        while not self._is_leaf(box, finest):
            width = Fraction(_TURN, 2 << box[0])
            columns = [
                {(end - low) // width for end in ends_of(x)} for x, low in zip(at, _ORIGIN, strict=False)
            ]
            if any(len(column) > 1 for column in columns):
                raise OpenError("it is not decided in which box a pose lies")
            i, k = (int(n) % (2 << box[0]) for column in columns for n in column)
            box = box[0] + 1, i, k
        return box

    def _is_leaf(self, box: Box, finest: int) -> bool:
        return box[0] >= _FIRST and (box[0] >= finest or self._judged(box) is not None)

    def _beyond(self, box: Box, side: tuple[int, int], finest: int) -> Iterator[Box]:
        """The leaves that share a part of a side with a box."""
        level, turn = box[0], 1 << box[0]
        place = (box[1] + side[0]) % turn, (box[2] + side[1]) % turn
        for above in range(_FIRST, level):
            wide = above, place[0] >> (level - above), place[1] >> (level - above)
            if self._is_leaf(wide, finest):
                yield wide
                return
        waiting = [(level, *place)]
        while waiting:
            own = waiting.pop()
            if self._is_leaf(own, finest):
                yield own
                continue
            # of its quarters those on the side towards the box
            parts = [
                (own[0] + 1, 2 * own[1] + x, 2 * own[2] + y)
                for x, y in product((0, 1), repeat=2)
                if (not side[0] or x == (side[0] < 0)) and (not side[1] or y == (side[1] < 0))
            ]
            waiting += parts

    def _judged(self, box: Box) -> bool | None:
        """False if all poses of a box are proved to bar a path, True if none seems to; None if neither."""
        if box not in self.known:
            self.known[box] = self._found(box)
        return self.known[box]

    def _found(self, box: Box) -> bool | None:
        width = Fraction(_TURN, 1 << box[0])
        middles = [x + (n + Fraction(1, 2)) * width for x, n in zip(_ORIGIN, box[1:], strict=True)]
        spot = float(middles[0]), float(middles[1])
        reach = float(width) * 0.7072
        centre = [Interval.of(x, BITS) for x in middles]
        if self._is_near(centre, spot, reach):
            return False
        found = self._field.beyond(spot)
        if found is None:
            return True
        if found == spot:
            half = Interval.of(width / 2, BITS).upper
            square = Square(centre[0].lower, centre[1].lower, half + 1)
            return False if singular_on(self.forms, square, self.length).sign == -self.sign else None
        return True if dist(found, spot) - reach > float(self.most) * (1 + _SPARE) else None

    @cached_property
    def _field(self) -> Field:
        waves = waves_of(self.forms.functions[0], self.forms.surface.ring.radicand, self.length)
        return Field(waves, self.sign, float(self.most))
