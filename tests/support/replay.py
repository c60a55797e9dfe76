"""A path driven once more from its document alone, by mpmath: shares nothing with the solver."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

from mpmath import findroot, matrix, mp, mpc, mpf

from rpr_solver.triangles import read_geometry
from tests.support.triangle_oracle import corners_of

DIGITS = 60
Place = tuple[mpf, mpf, mpf]
"""α and the fixed leg's angle in degrees, and the fixed leg's length."""


@dataclass(frozen=True)
class Replay:
    """The arcs of a document, and the mechanism that they move; numbers of 60 digits."""

    base: Sequence[mpc]
    platform: Sequence[mpc]
    leg: int
    arcs: Sequence[Sequence[Place]]

    @classmethod
    def of(cls, document: Mapping[str, Any]) -> Replay:
        """The motion that a document describes, its samples apart."""
        with mp.workdps(DIGITS):
            base, platform = corners_of(read_geometry(document["geometry"]))
            replay = cls(base, platform, document["fixed_leg"], ())
            certificate = document["certificate"]
            ends = {end: replay._end(document, end) for end in ("from", "to")}
            names = "alpha_deg", f"theta{replay.leg}_deg", f"l{replay.leg}"
            arcs = [
                [ends[p] if isinstance(p, str) else tuple(number(p[name]) for name in names) for p in arc]
                for arc in certificate["arcs"]
            ]
            return cls(base, platform, replay.leg, arcs)

    def at(self, place: Fraction) -> Place:
        """The point of a place: the number of the arc plus τ; the last place is the end of the last arc."""
        with mp.workdps(DIGITS):
            arc = min(int(place), len(self.arcs) - 1)
            tau = number(place - arc)
            points = self.arcs[arc]
            while len(points) > 1:
                points = [
                    tuple(x + tau * (y - x) for x, y in zip(p, q, strict=True)) for p, q in pairwise(points)
                ]
            return points[0]

    def legs(self, place: Place) -> tuple[mpf, mpf, mpf]:
        """L1, L2 and L3."""
        with mp.workdps(DIGITS):
            alpha, theta, length = place
            held = self.leg - 1
            joint = self.base[held] + length * mp.expj(mp.radians(theta))
            turn = mp.expj(mp.radians(alpha))
            first, second, third = (
                abs(joint + turn * (b - self.platform[held]) - a)
                for a, b in zip(self.base, self.platform, strict=True)
            )
            return first, second, third

    def determinant(self, place: Place) -> mpf:
        """The derivatives of the legs by x, y and the rotation, as a determinant, up to a constant sign."""
        with mp.workdps(DIGITS):
            alpha, theta, length = place
            turn = mp.expj(mp.radians(alpha))
            origin = self.base[self.leg - 1] + length * mp.expj(mp.radians(theta))
            rows = []
            for a, b in zip(self.base, self.platform, strict=True):
                arm = turn * (b - self.platform[self.leg - 1])
                along = (origin + arm - a) / abs(origin + arm - a)
                rows.append([along.real, along.imag, (arm.conjugate() * along).imag])
            return mp.det(matrix(rows))

    def _end(self, document: Mapping[str, Any], end: str) -> Place:
        """The exact pose near the printed angles, in its turn."""
        theta = f"theta{self.leg}"
        turns = document["certificate"]["turns"][end]
        near = [number(document[end][f"{name}_deg"]) + 360 * turns[name] for name in ("alpha", theta)]
        own = document[end] if "l1" in document[end] else document
        goal = [number(own[f"l{leg}"]) for leg in (1, 2, 3)]
        length = goal[self.leg - 1]
        if document[end]["pose"] is None:  # its angles are exact
            return near[0], near[1], length

        def missing(alpha: mpf, angle: mpf) -> list[mpf]:
            legs = self.legs((alpha, angle, length))
            return [x - y for k, (x, y) in enumerate(zip(legs, goal, strict=True), 1) if k != self.leg]

        found = findroot(missing, near, tol=mpf(10) ** (10 - 2 * DIGITS))
        assert max(abs(x - y) for x, y in zip(found, near, strict=True)) < mpf(10) ** -6
        return found[0], found[1], length


def number(exact: str | Fraction) -> mpf:
    """An exact number."""
    exact = Fraction(exact)
    return mpf(exact.numerator) / exact.denominator


def rounds_to(x: mpf, text: str) -> bool:
    """Whether a number is as printed, to half a unit of the last digit."""
    digits = text.lstrip("-").partition("e")[0]
    place = -len(digits.partition(".")[2]) + int(text.partition("e")[2] or 0)
    with mp.workdps(DIGITS):
        return bool(abs(x - number(text)) <= mpf(10) ** place / 2 + mpf(10) ** (10 - DIGITS))
