"""Systems of functions on boxes, which are to be 0."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from flint import arb

from rpr_solver.boxes.balls import Balls
from rpr_solver.boxes.jets import Jet
from rpr_solver.errors import ControlFlow

Box = Sequence[arb]
"""A ball for each variable: all points with a number of each ball."""


class Undecided(ControlFlow):
    """Nothing can be said of a box, as it is too wide."""


class Functions(Protocol):
    """Some smooth functions of some variables, over balls of FLINT and over arrays of :class:`Balls`."""

    def __call__(self, box: Sequence[arb] | Sequence[Balls], order: int, /) -> Sequence[Jet[Any]]:
        """The functions on a box, or on many at once, as jets of this order, which is 3 at most, or more.

        The terms hold the Taylor coefficients at each point of a box.
        """


class System(Protocol):
    """Functions of n variables, at least n, all of which are 0 at the points that are sought."""

    @property
    def stages(self) -> Sequence[Functions]:
        """Functions that are 0 at the points sought: a few cheap ones, it may be, and last all of them."""

    def square(self, box: Box, /) -> Functions:
        """n functions, 0 at the points sought in a box; their regular zeros there are such points.

        Raises:
            Undecided: they are not known to be so on the whole box.
        """
