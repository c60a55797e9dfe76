"""What is to be 0: systems of functions on boxes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from flint import arb

from rpr_solver.boxes.balls import Balls
from rpr_solver.boxes.jets import Jet

Box = Sequence[arb]
"""A ball for each variable."""


class Undecided(Exception):  # noqa: N818 - no error: a box is cut
    """Nothing can be said of a box, as it is too wide."""


class Functions(Protocol):
    """Some functions of some variables."""

    def __call__(self, box: Sequence[arb] | Sequence[Balls], order: int) -> Sequence[Jet]:  # type: ignore[type-arg]
        """Jets of at least this order, 0 or 1, whose terms hold the Taylor coefficients at each point of a box.

        A box is a ball for each variable, or an array of balls for each.
        """


class System(Protocol):
    """Functions of n variables, at least n, all of which are 0 at the points that are sought."""

    @property
    def stages(self) -> Sequence[Functions]:
        """The functions, from cheap ones to all: those of a stage are 0 at the points that are sought."""

    def square(self, box: Box) -> Functions:
        """n functions that are 0 at the sought points in a box, and whose regular zeros there are such points.

        Raises:
            Undecided: there are none for the whole box.
        """
