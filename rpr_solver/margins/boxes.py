"""Boxes of poses and geometries in doubles, and the functions of systems.py there.

There are two kinds of arithmetic: slopes.py bounds derivatives, too, expansions.py values more tightly.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from rpr_solver.exact.turns import TURN, cos_sin
from rpr_solver.margins.expansions import Expansion, layout_of
from rpr_solver.margins.problems import ANGLES
from rpr_solver.margins.slopes import UNIT, UP, Errors, Slopes, refined

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rpr_solver.margins.problems import Problem
    from rpr_solver.margins.slopes import Doubles
    from rpr_solver.model.jets import Jet

    Integers = NDArray[np.int64]

_TRIG_ERROR = 16 * UNIT


class _Ring:
    """What rings of functions on boxes have in common.

    Attributes:
        middle, half: middles and half widths of the boxes; half widths of angles are in radians.
    """

    def __init__(self, problem: Problem, low: Doubles, high: Doubles) -> None:
        self._problem = problem
        self.middle = (low + high) / 2
        self.half = np.maximum(high - self.middle, self.middle - low) * UP
        self.half[:ANGLES] *= 2 * np.pi / TURN

    @property
    def _angles(self) -> tuple[tuple[Integers, tuple[int, int]], ...]:
        """α, θ and α − θ at the middles, and how α and θ enter."""
        alpha, theta = self.middle[:ANGLES].astype(np.int64)
        return (alpha, (1, 0)), (theta, (0, 1)), (alpha - theta, (1, -1))


class BoxRing(_Ring):
    """The ring of functions with slopes on boxes."""

    def __init__(self, problem: Problem, low: Doubles, high: Doubles) -> None:
        super().__init__(problem, low, high)
        self.refine = partial(refined, half=self.half)

    def constant(self, value: float) -> Slopes:
        """A number on all boxes, right to two units of its last place."""
        function = self._blank(Errors(4 * UNIT * abs(value), 0.0))
        function.middle[0] = value
        return function

    def number(self, place: int) -> Slopes:
        """One of the problem's spans as a function."""
        row = self._problem.rows.get(place)
        if row is None:
            return self.constant(self._problem.spans[place].low)
        function = self._blank(Errors(0.0, 0.0))
        function.middle[0], function.radius[0] = self.middle[row], self.half[row]
        function.middle[1 + row] = 1
        return function

    def turns(self) -> tuple[tuple[Slopes, Slopes], ...]:
        """Cosines and sines of α, θ and α − θ."""
        return tuple(self._turn(*angle) for angle in self._angles)

    def refine_one(self, function: Slopes) -> Slopes:
        """The function with a smaller radius of its values."""
        return function.tightened(self.half)

    @staticmethod
    def named(point: tuple[Slopes, Slopes]) -> tuple[Slopes, Slopes]:
        """The point as it is."""
        return point

    def _turn(self, angle: Integers, signs: tuple[int, int]) -> tuple[Slopes, Slopes]:
        cos, sin = cos_sin(angle)
        half = sum(self.half[k] for k, sign in enumerate(signs) if sign)
        functions = []
        for value, slope in ((cos, -sin), (sin, cos)):
            function = self._blank(Errors(_TRIG_ERROR, _TRIG_ERROR))
            changes = half * np.minimum(1, abs(slope) + half), half * np.minimum(1, abs(value) + half)
            function.middle[0], function.radius[0] = value, changes[0] * UP
            for k, sign in enumerate(signs):
                if sign:
                    function.middle[1 + k], function.radius[1 + k] = sign * slope, changes[1] * UP
            functions.append(function)
        return functions[0], functions[1]

    def _blank(self, error: Errors) -> Slopes:
        shape = (1 + self._problem.size, self.middle.shape[1])
        return Slopes(np.zeros(shape), np.zeros(shape), error)


class ExpansionRing(_Ring):
    """The ring of functions with expansions on boxes."""

    def __init__(self, problem: Problem, low: Doubles, high: Doubles) -> None:
        super().__init__(problem, low, high)
        self._layout = layout_of(problem.size)

    def constant(self, value: float) -> Expansion:
        """A number on all boxes, right to two units of its last place."""
        function = self._blank()
        function.terms[0] = value
        function.rest[:] = 4 * UNIT * abs(value)
        return function

    def number(self, place: int) -> Expansion:
        """One of the problem's spans as a function."""
        row = self._problem.rows.get(place)
        if row is None:
            return self.constant(self._problem.spans[place].low)
        function = self._blank()
        function.terms[0], function.terms[1 + row] = self.middle[row], self.half[row]
        return function

    def turns(self) -> tuple[tuple[Expansion, Expansion], ...]:
        """Cosines and sines of α, θ and α − θ."""
        return tuple(self._turn(*angle) for angle in self._angles)

    @staticmethod
    def named(point: tuple[Expansion, Expansion]) -> tuple[Expansion, Expansion]:
        """A point with symbols for what the expansions of its coordinates leave out."""
        x, y = point
        return x.named(0), y.named(1)

    @staticmethod
    def refine(jet: Jet[Expansion]) -> Jet[Expansion]:
        """The jet as it is."""
        return jet

    @staticmethod
    def refine_one(function: Expansion) -> Expansion:
        """The function as it is."""
        return function

    def _turn(self, angle: Integers, signs: tuple[int, int]) -> tuple[Expansion, Expansion]:
        cos, sin = cos_sin(angle)
        a, b = (sign * half for sign, half in zip(signs, self.half, strict=False))
        whole = abs(a) + abs(b)
        functions = []
        for value, slope in ((cos, -sin), (sin, cos)):
            function = self._blank()
            terms, blocks = function.terms, self._layout.blocks
            terms[0], terms[1], terms[2] = value, slope * a, slope * b
            terms[blocks[0].start], terms[blocks[1].start] = -value * a * a / 2, -value * b * b / 2
            terms[blocks[0].start + 1] = -value * a * b
            function.rest[:] = (whole**3 / 6 + 2 * _TRIG_ERROR * (1 + whole) ** 2) * UP
            functions.append(function)
        return functions[0], functions[1]

    def _blank(self) -> Expansion:
        boxes = self.middle.shape[1]
        return Expansion(np.zeros((self._layout.rows, boxes)), np.zeros(boxes), self._layout)
