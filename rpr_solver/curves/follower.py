"""A cusp followed by proof along its curve J = E = 0 in (α, θ, L), from tube to tube.

Tubes also lead through swallowtails, lips and beaks, where the curve turns back in L (mathematics.md#turns).
All its other points are cusps: a zero is a cusp unless ∇f = 0, v·∇E = 0 or ∇J = 0, and poses with ∇f = 0 form
separate curves, which would be a second curve in the tube. E can be taken along either leg; it is taken along
the leg with the larger gradient, since a cusp may pass a pose at which the other gradient vanishes
(mathematics.md#tubes-of-cusps).

A table lists every cusp of its slice. So if the box of a tube is disjoint from all cusps of a table but one,
it contains that one (mathematics.md#tubes-of-cusps); nothing is decided by proximity.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from itertools import pairwise
from math import log

from flint import arb, ctx

from rpr_solver.curves.neighbourhood import ALONG_L, CuspForms, Neighbourhood, PoseBox
from rpr_solver.curves.tubes import Tube, build
from rpr_solver.errors import ControlFlow, Unproved
from rpr_solver.exact import decided, decided_or_none
from rpr_solver.exact.precision import MATCH_BITS, TUBE_BITS
from rpr_solver.exact.rationals import exact_str
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.bridge import Bridge
from rpr_solver.model.jets import HalfTangent
from rpr_solver.slices import Eliminant
from rpr_solver.slices.cusp_table import solve_slice
from rpr_solver.slices.slice_table import SliceTable

_FIRST_BITS = 128
_UNIT_TERMS = 16
"""The terms of a tube that takes one unit of work more than a trial that fails."""


class Lost(ControlFlow):
    """Control flow between modules: no tube continues the curve at any precision up to the limit."""


class Follower:
    """A cusp of a slice, moving up or down in L along its curve.

    ``start`` gives a box that contains the cusp and no other zero, as small as a precision in bits allows.
    Lengths are scaled.

    Attributes:
        tube: the last tube; None before the first step.
        work: the tubes that were tried, by their terms and their precision: a unit takes one to three
            milliseconds.
    """

    def __init__(
        self, forms: CuspForms, start: Callable[[int], PoseBox], length: Fraction, *, upwards: bool
    ) -> None:
        self._forms = forms
        self._start, self._begin, self._upwards = start, length, upwards
        self._bits = _FIRST_BITS
        self.tube: Tube | None = None
        self.work = 0

    def walk(self, low: Fraction, high: Fraction, tubes: int) -> tuple[Fraction, PoseBox] | None:
        """Continues between ``low`` and ``high`` to the first of these two slices that the curve meets.

        Returns:
            The length of that slice and the box there; None if ``tubes`` new tubes reach neither.

        Raises:
            Lost: no tube continues the curve.
        """
        for _ in range(tubes + 1):
            if self.tube:
                with ctx.workprec(self._bits):
                    met = self.tube.meets(low, high)
                    if met is not None:
                        return met, self.tube.box_at(ball_of(met))
            self._extend(low, high)
        return None

    def _extend(self, low: Fraction, high: Fraction) -> None:
        def tube(bits: int) -> Tube | None:
            self._bits = bits
            self.work += max(1, bits // 256)
            with ctx.workprec(bits):
                return self._next(ball_of(low), ball_of(high))

        # a narrow place behind may have needed more bits
        following = decided_or_none(tube, max(_FIRST_BITS, self._bits // 2), TUBE_BITS)
        if following is None:
            raise Lost
        self.tube = following
        self.work += following.terms // _UNIT_TERMS * max(1, self._bits // 256)

    def _next(self, low: arb, high: arb) -> Tube | None:
        if self.tube is None:
            around = Neighbourhood.at(self._forms, self._start(self._bits), ball_of(self._begin), self._bits)
            return build(around, ALONG_L, self._upwards)
        tube = self.tube
        around = Neighbourhood.at(self._forms, *tube.end(), self._bits)
        heading = around.heading(tube.axis, tube.forwards)
        if heading is None:
            return None
        axis, forwards, upwards = heading
        terms = tube.terms // 2
        if axis == ALONG_L:
            return build(around, axis, forwards, terms=terms)
        across = build(around, axis, forwards, between=(low, high), terms=terms)
        if (across and across.reach * 4 > across.most) or upwards is None:
            return across
        along = build(around, ALONG_L, upwards)
        return along if along and (across is None or along.advance(axis) > across.reach) else across


_TUBES_A_TURN = 16
_PATIENCE, _NEAR_PATIENCE, _GREAT_PATIENCE = 64, 192, 1 << 13
"""The budget of tubes for one cusp: between slices of a survey, also if some are close, as beside special
shapes, and between arbitrary slices."""
_CLOSE = Fraction(1, 10**5)
"""How close, as a share of their length, slices of a survey are beside special shapes."""
_TOO_MUCH = (
    "the cusps could not be followed within a bound of work: slices with different numbers of cusps are too "
    "close to each other, as those of a manipulator that nearly has a special shape"
)
_MOST_WORK = 2400
"""The greatest work between all slices of a survey, or between two others: five to eight seconds. All curves
of a manipulator with 18 cusps take 400; beside a special shape most take 400 to 1,800."""
_MOST_EXPECTED = 1600
"""The greatest work that is begun. It takes 0.8 to 1.7 times as much as is expected, seldom three times."""
_WORK, _WORK_OF_GROWTH, _WORK_OF_CLOSENESS = 150, 4.5, 7.0
"""What is expected in any case; for each cusp while L grows by a factor of e; and for each birth or death of
two cusps in a gap, for each factor of e by which the gap is less than its length."""

Cusp = tuple[Fraction, int]
"""A cusp by the length of its slice and its index in the table, from 0."""


def expected_work(counts: Sequence[tuple[Fraction, int]]) -> float:
    """About the work of all cusps between slices, from their lengths, ascending, and numbers of cusps.

    A tube reaches so far in proportion to L, and where two transitions are close to each other, in proportion
    to what is left to them. So cusps pass from size to size by many tubes, beside special shapes over as many
    decades as they are near.
    """
    work = float(_WORK)
    for (low, below), (high, above) in pairwise(counts):
        growth, closeness = _log(high / low), -_log((high - low) / high)
        work += _WORK_OF_GROWTH * growth * min(below, above)
        work += _WORK_OF_CLOSENESS * closeness * abs(above - below) / 2
    return work


def _log(x: Fraction) -> float:
    return log(x.numerator) - log(x.denominator)


class Tracker:
    """The slices of one eliminant, with at least ``digits`` digits, and the followers of their cusps.

    ``known`` are slices solved to exactly this number of digits, which need not be solved again.
    """

    def __init__(self, eliminant: Eliminant, digits: int, known: Iterable[SliceTable] = ()) -> None:
        self.eliminant, self.digits = eliminant, digits
        self.forms = CuspForms(eliminant.slice_map)
        self._tables = {(table.length, digits): table for table in known}
        self._left = _MOST_WORK
        lengths = sorted(length for length, _ in self._tables)
        is_near = any(
            above - below < _CLOSE * above or below < _CLOSE * above for below, above in pairwise(lengths)
        )
        self._patience = _NEAR_PATIENCE if is_near else _PATIENCE

    def refuse_too_much(self, counts: Sequence[tuple[Fraction, int]]) -> None:
        """Refuse to follow cusps between slices, with their numbers of cusps, if it would take too long.

        Raises:
            Unproved: it would.
        """
        if expected_work(counts) > _MOST_EXPECTED:
            raise Unproved(_TOO_MUCH)

    def table(self, length: Fraction, digits: int = 0) -> SliceTable:
        """The table of a slice, cached."""
        key = length, max(digits, self.digits)
        if key not in self._tables:
            self._tables[key] = solve_slice(self.eliminant, *key)
        return self._tables[key]

    def follower(self, cusp: Cusp, *, upwards: bool) -> Follower:
        """The follower of a cusp towards greater or smaller lengths."""
        length, index = cusp

        def start(bits: int) -> PoseBox:
            return self._places(length, bits)[index]

        return Follower(self.forms, start, self._scaled(length), upwards=upwards)

    def destinations(
        self,
        followers: Mapping[int, Follower],
        low: Fraction,
        high: Fraction,
        *,
        until_full: Fraction | None = None,
        starts: Mapping[Cusp, int] | None = None,
    ) -> dict[int, Cusp]:
        """The first cusp of two slices that each follower reaches, without leaving the lengths between.

        Followers that reach neither slice are omitted. With ``until_full``, stop as soon as every cusp of
        that slice has been matched, and spend a larger budget until then. ``starts`` names followers by the
        cusps at which they stand: if one comes to the cusp of another, the other comes to that of the one.

        Raises:
            Unproved: the curves take too many tubes.
        """
        if until_full is not None:
            self._left = _MOST_WORK
        patience = self._patience if until_full is None else _GREAT_PATIENCE
        met: dict[int, Cusp] = {}
        still_free = None if until_full is None else self.table(until_full).count
        waiting = deque((name, follower, 0) for name, follower in followers.items())
        ends = {self._scaled(length): length for length in (low, high)}
        scaled_low, scaled_high = ends
        while waiting and still_free != 0:
            name, follower, spent = waiting.popleft()
            if name in met:
                continue
            if self._left <= 0:
                raise Unproved(_TOO_MUCH)
            self._left += follower.work
            try:
                arrival = follower.walk(scaled_low, scaled_high, _TUBES_A_TURN)
            except Lost:
                continue
            finally:
                self._left -= follower.work
            if arrival is not None:
                scaled, place = arrival
                length = ends[scaled]
                met[name] = length, self._index(place, length)
                other = (starts or {}).get(met[name])
                if other is not None:
                    met[other] = next(cusp for cusp, its in (starts or {}).items() if its == name)
                if still_free is not None and length == until_full:
                    still_free -= 1
            elif spent < patience:
                waiting.append((name, follower, spent + _TUBES_A_TURN))
        return met

    def _index(self, place: PoseBox, length: Fraction) -> int:
        def index(bits: int) -> int | None:
            with ctx.workprec(bits):
                near = [i for i, cusp in enumerate(self._places(length, bits)) if not place.apart(cusp)]
            return near[0] if len(near) == 1 else None

        message = f"cusps of the slice {exact_str(length)} are too close to tell which is followed"
        return decided(index, _FIRST_BITS, MATCH_BITS, message)

    def _places(self, length: Fraction, bits: int) -> list[PoseBox]:
        table = self.table(length, bits // 6)
        with ctx.workprec(bits):
            bridge = Bridge.of(self.eliminant.slice_map)
            angles = ([_half_tangent(x, table.digits) for x in cusp.coordinates[:2]] for cusp in table.cusps)
            return [PoseBox(*bridge.turns_of(alpha, theta)) for alpha, theta in angles]

    def _scaled(self, length: Fraction) -> Fraction:
        return length * self.eliminant.slice_map.scale


def _half_tangent(degrees: str, digits: int) -> HalfTangent:
    """The ball of an angle that was rounded to ``digits`` digits."""
    angle = ball_of(Fraction(degrees))
    angle = arb(angle.mid(), angle.rad() + abs(angle) * arb(10) ** (1 - digits)) * arb.pi() / 360
    return HalfTangent(angle.sin(), angle.cos())
