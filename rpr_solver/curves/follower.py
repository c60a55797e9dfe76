"""A cusp followed by proof along its curve J = E = 0 in (α, θ, L), from tube to tube.

Tubes also lead through swallowtails, lips and beaks, where the curve turns back in L. All its other points
are cusps: a zero is a cusp unless ∇f = 0, v·∇E = 0 or ∇J = 0, and poses with ∇f = 0 form separate curves,
which would be a second curve in the tube. E can be taken along either leg; it is taken along the leg with
the larger gradient, since a cusp may pass a pose at which the other gradient vanishes
(mathematics.md#tubes-of-cusps).
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from flint import arb, ctx

from rpr_solver.curves.neighbourhood import ALONG_L, CuspForms, Neighbourhood, Place
from rpr_solver.curves.tubes import Tube, build
from rpr_solver.exact.precision import TUBE_BITS, decided_or_none
from rpr_solver.exact.real_roots import ball_of

_FIRST_BITS = 128
_FIRST_REACH = Fraction(1, 32)


class LostError(Exception):
    """Control flow between modules: no tube continues the curve at any precision up to the limit."""


class Follower:
    """A cusp of a slice, moving up or down in L along its curve.

    ``start`` gives a box that contains the cusp and no other zero, as small as a precision in bits allows.
    Lengths are scaled.
    """

    def __init__(
        self, forms: CuspForms, start: Callable[[int], Place], length: Fraction, *, upwards: bool
    ) -> None:
        self.forms = forms
        self._start, self._begin, self._upwards = start, length, upwards
        self._bits = _FIRST_BITS
        self._reach = ball_of(_FIRST_REACH)
        self._tube: Tube | None = None

    @property
    def tube(self) -> Tube | None:
        """The last tube, None before the first step."""
        return self._tube

    @property
    def bits(self) -> int:
        """The precision of the last tube."""
        return self._bits

    def walk(self, low: Fraction, high: Fraction, tubes: int) -> tuple[Fraction, Place] | None:
        """Continues between ``low`` and ``high`` to the first of these two slices that the curve meets.

        Returns:
            The length of that slice and the box there; None if ``tubes`` new tubes reach neither.

        Raises:
            LostError: no tube continues the curve.
        """
        for _ in range(tubes + 1):
            if self._tube:
                with ctx.workprec(self._bits):
                    met = self._tube.meets(low, high)
                    if met is not None:
                        return met, self._tube.place_at(ball_of(met))
            self._extend(low, high)
        return None

    def _extend(self, low: Fraction, high: Fraction) -> None:
        def tube(bits: int) -> Tube | None:
            self._bits = bits
            with ctx.workprec(bits):
                return self._next(ball_of(low), ball_of(high))

        following = decided_or_none(tube, self._bits, TUBE_BITS)
        if following is None:
            raise LostError
        self._tube, self._reach = following, 2 * following.reach

    def _next(self, low: arb, high: arb) -> Tube | None:
        if self._tube is None:
            around = Neighbourhood.at(self.forms, self._start(self._bits), ball_of(self._begin), self._bits)
            return build(around, ALONG_L, self._upwards, self._reach)
        tube = self._tube
        around = Neighbourhood.at(self.forms, *tube.end(), self._bits)
        heading = around.heading(tube.axis, tube.forwards)
        if heading is None:
            return None
        axis, forwards, upwards = heading
        if axis == ALONG_L:
            return build(around, axis, forwards, self._reach)
        across = build(around, axis, forwards, self._reach, between=(low, high))
        if (across and across.reach * 4 > self._reach) or upwards is None:
            return across
        worth = (axis, across.reach) if across else None
        return build(around, ALONG_L, upwards, self._reach, worth=worth) or across
