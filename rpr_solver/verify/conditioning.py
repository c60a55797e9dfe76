"""Condition numbers of poses: singular values of the matrix of the legs' rates, by FLINT's eigenvalues.

Row i is (cos θᵢ, sin θᵢ, (bᵢ × uᵢ)/λ), bᵢ being the vector from the centroid of the platform's corners to the
corner i, and uᵢ the direction of leg i. The squared singular values are the eigenvalues of the matrix times
its transpose.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from flint import acb, acb_mat, arb, arb_mat, ctx

from rpr_solver.boxes import Box, Undecided
from rpr_solver.verify.claims import Open, Refused
from rpr_solver.verify.geometry import Geometry
from rpr_solver.verify.numbers import POSITIVE, Printed, ball, square_of
from rpr_solver.verify.reader import Read, nothing_or, record, word
from rpr_solver.verify.work import Work

SCALE: dict[str, Read] = {"length_scale": square_of, "reference": word("centroid")}
"""What documents say of all their condition numbers."""
ALONG = record({**SCALE, "asked": nothing_or(POSITIVE), "min": POSITIVE, "max": POSITIVE})
"""What the document of a path says of those along it."""
_STEPS, _SPARE = 4, 64


@dataclass(frozen=True)
class Rates:
    """The matrices of the rates of the legs, for a geometry with one leg fixed.

    Attributes:
        geometry: the manipulator.
        fixed: the leg whose angle poses have.
        square: of the length scale.
    """

    geometry: Geometry
    fixed: int
    square: Fraction

    def at(self, pose: Box, length: arb) -> arb_mat:
        """That at a pose (α and θ), or at all poses of a box; ``length`` is that of the fixed leg."""
        own, turn = self.fixed - 1, acb(0, pose[0]).exp()
        base, platform = self.geometry.base, self.geometry.platform
        tip, centre = length * acb(0, pose[1]).exp(), sum(platform, acb(0)) / 3
        rows, scale = [], ball(self.square).sqrt()
        for a, b in zip(base, platform, strict=True):
            leg = tip + turn * (b - platform[own]) - (a - base[own])
            u, arm = leg / abs(leg), turn * (b - centre)
            rows.append([u.real, u.imag, (arm.conjugate() * u).imag / scale])
        return arb_mat(rows)

    def condition(self, pose: Box, length: arb) -> arb:
        """The condition number at a pose.

        Raises:
            Open: the singular values are not told apart, or the least may be 0.
        """
        least, most = extremes(self.at(pose, length))
        found: arb = most / least
        return found


def extremes(matrix: arb_mat) -> tuple[arb, arb]:
    """The least and the greatest singular value of a matrix.

    Raises:
        Open: the singular values are not told apart, or the least may be 0.
    """
    try:
        values = [x.real for x in acb_mat(matrix * matrix.transpose()).eig()]
    except ValueError:
        raise Open("two singular values are one, as far as balls tell") from None
    least, _, most = sorted(values, key=lambda x: float(x.mid()))
    if not least > 0:
        raise Open("the least singular value may be 0")
    return least.sqrt(), most.sqrt()


def is_between(middle: arb_mat, whole: arb_mat, low: arb, high: arb) -> bool | None:
    """Whether the condition numbers of matrices are between two numbers; None if that is open.

    ``whole`` are balls of all of them, ``middle`` is one. A singular value of another one differs from its
    own by at most the norm of the difference (Weyl).
    """
    try:
        least, most = extremes(middle)
    except Open:
        return None
    if most > high * least or most < low * least:
        return False
    squares = [(x - y) ** 2 for x, y in zip(whole.entries(), middle.entries(), strict=True)]
    off = sum(squares, arb(0)).abs_upper().sqrt()
    return True if most + off <= high * (least - off) and most - off >= low * (least + off) else None


def has_condition(number: Printed, at: Callable[[int], arb], work: Work) -> str:
    """Proves that a number is a condition number, of which there are balls at each precision.

    Raises:
        Open: it is not decided.
        Refused: it is another one.
    """
    bits = max(number.bits, _SPARE) + len(number.text) * 4
    for step in range(_STEPS):
        work.spend(1, bits << step)
        with ctx.workprec((bits << step) + _SPARE):
            try:
                right = number.rounds(at(bits << step))
            except Undecided:
                break
            except Open:
                right = None
        if right is not None:
            if right:
                return "by the eigenvalues of the matrix times its transpose"
            raise Refused("it has other digits")
    raise Open("the digits are not decided")
