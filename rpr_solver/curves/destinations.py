"""To which cusp of another slice a cusp comes: tubes, matched with whole tables.

A table lists every cusp of its slice. So a tube's box that is apart from all cusps of a table but one has
come to that one; nothing is decided by nearness.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from fractions import Fraction

from flint import arb, ctx

from rpr_solver.curves.follower import Follower, LostError
from rpr_solver.curves.neighbourhood import CuspForms, Place
from rpr_solver.exact.precision import MATCH_BITS, decided
from rpr_solver.exact.rationals import exact_str
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.half_tangent import HalfTangent
from rpr_solver.slices.cusp_table import solve_slice
from rpr_solver.slices.eliminant import Eliminant
from rpr_solver.slices.slice_table import SliceTable

_TUBES_A_TURN = 16
_PATIENCE, _GREAT_PATIENCE = 512, 1 << 13
"""Tubes spent on one cusp: between slices chosen well, and wherever slices may lie."""
_FIRST_BITS = 128

Cusp = tuple[Fraction, int]
"""A cusp by the length of its slice and its place in the table, from 0."""


class Tracker:
    """The slices of one eliminant, with so many digits at least, and the ways of their cusps.

    ``known`` are slices with just so many digits, which need not be solved again.
    """

    def __init__(self, eliminant: Eliminant, digits: int, known: Iterable[SliceTable] = ()) -> None:
        self.eliminant, self.digits = eliminant, digits
        self._forms = CuspForms(eliminant.slice_map)
        self._tables = {(table.length, digits): table for table in known}

    def table(self, length: Fraction, digits: int = 0) -> SliceTable:
        """A slice, kept."""
        key = length, max(digits, self.digits)
        if key not in self._tables:
            self._tables[key] = solve_slice(self.eliminant, *key)
        return self._tables[key]

    def follower(self, cusp: Cusp, *, upwards: bool) -> Follower:
        """Sets out from a cusp to larger or to smaller lengths."""
        length, index = cusp

        def start(bits: int) -> Place:
            return self._places(length, bits)[index]

        return Follower(self._forms, start, self._scaled(length), upwards=upwards)

    def destinations(
        self,
        followers: Mapping[int, Follower],
        low: Fraction,
        high: Fraction,
        *,
        until_full: Fraction | None = None,
    ) -> dict[int, Cusp]:
        """To which cusp of two slices each follower comes first, without leaving the lengths between.

        Who does not come to either is missing. With ``until_full`` no more is done once all cusps of that
        slice are met, and much until then.
        """
        patience = _PATIENCE if until_full is None else _GREAT_PATIENCE
        met: dict[int, Cusp] = {}
        still_free = None if until_full is None else self.table(until_full).count
        waiting = deque((name, follower, 0) for name, follower in followers.items())
        ends = {self._scaled(length): length for length in (low, high)}
        scaled_low, scaled_high = ends
        while waiting and still_free != 0:
            name, follower, spent = waiting.popleft()
            try:
                found = follower.walk(scaled_low, scaled_high, _TUBES_A_TURN)
            except LostError:
                continue
            if found is not None:
                length = ends[found[0]]
                met[name] = length, self._index(found[1], length)
                if still_free is not None and length == until_full:
                    still_free -= 1
            elif spent < patience:
                waiting.append((name, follower, spent + _TUBES_A_TURN))
        return met

    def _index(self, place: Place, length: Fraction) -> int:
        def index(bits: int) -> int | None:
            with ctx.workprec(bits):
                near = [i for i, cusp in enumerate(self._places(length, bits)) if not place.apart(cusp)]
            return near[0] if len(near) == 1 else None

        message = f"cusps of the slice {exact_str(length)} are too close to tell which is followed"
        return decided(index, _FIRST_BITS, MATCH_BITS, message)

    def _places(self, length: Fraction, bits: int) -> list[Place]:
        table = self.table(length, bits // 6)
        with ctx.workprec(bits):
            return [
                Place(*(_half_tangent(angle, table.digits) for angle in cusp.coordinates[:2]))
                for cusp in table.cusps
            ]

    def _scaled(self, length: Fraction) -> Fraction:
        return length * self.eliminant.slice_map.scale


def _half_tangent(degrees: str, digits: int) -> HalfTangent:
    """An angle that was rounded to so many digits."""
    angle = ball_of(Fraction(degrees))
    angle = arb(angle.mid(), angle.rad() + abs(angle) * arb(10) ** (1 - digits)) * arb.pi() / 360
    return HalfTangent(angle.sin(), angle.cos())
