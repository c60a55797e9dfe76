"""The image of J = 0 of similar and mirrored congruent triangles, whose poses come in pairs with one image.

A slice is folded along curves, the *folds*; then the plane of v, or of (β, X), is mapped, by a map that is
singular along one curve more, the *bend* (mathematics.md#folded-slices). So each part of the image is run
once by one parameter, of which the squared legs are waves. The image of the bend does not meet itself; it
ends where the bend comes to a fold, and touches the image of the fold there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import isqrt

from rpr_solver.verify.arrangement import Arrangement
from rpr_solver.verify.claims import OpenError
from rpr_solver.verify.core.intervals import Interval, cos_sin
from rpr_solver.verify.core.krawczyk import angle_of
from rpr_solver.verify.core.surds import Poly
from rpr_solver.verify.courses import (
    Course,
    Stretch,
    Touching,
    Waves,
    both_legs,
    combined,
    slope_of,
    tangents_of,
    times,
    wave_of,
)
from rpr_solver.verify.fronts import BITS, ONE, TURN, Point
from rpr_solver.verify.images import UNDECIDED
from rpr_solver.verify.landmarks import Shape, Unclear
from rpr_solver.verify.mirrored import Mirrored, entering, lines_of, value_of


@dataclass(frozen=True)
class Picture:
    """The image of J = 0: its chains of pieces; the squared legs are divided by 2^shift."""

    chains: Sequence[Sequence[Stretch]]
    shifts: tuple[int, int]

    def arrangement(self) -> Arrangement:
        """With all of its crossings."""
        touching = Touching()
        return Arrangement(self.chains, touching, touching.contacts)


def picture_of(shape: Shape, length: Fraction) -> Picture:
    """The image of J = 0 of a slice of similar triangles that are not flat, or of mirrored ones.

    Raises:
        OpenError: the bend touches a fold.
    """
    scaled = length * shape.surface.unit
    try:
        return _of_mirrored(shape, scaled) if isinstance(shape, Mirrored) else _of_similar(shape, scaled)
    except (Unclear, ZeroDivisionError):
        raise OpenError(UNDECIDED) from None


def _of_mirrored(shape: Mirrored, length: Fraction) -> Picture:
    """X = L by β, over a full turn, and X = S by β, over half a turn, where |S| < L."""
    heights, singular = [_waves(form) for form in shape.heights[:2]], _waves(shape.singular)
    fold, bend = list[Waves](), list[Waves]()
    for h in heights:
        square = combined((length**2, {(0, 0): Fraction(1)}), (Fraction(4), times(h, h)))
        fold.append(combined((Fraction(1), square), (-4 * length, h)))
        # S is what is singular, divided by the area with the other sign
        bend.append(combined((Fraction(1), square), (Fraction(4, shape.area), times(h, singular))))
    (first, second), shifts = both_legs(fold, bend)
    own = Course(first, (slope_of(first[0]), slope_of(first[1])), is_bend=False)
    turning = wave_of(_waves(shape.coalescing))
    other = Course(second, tangents_of(heights, shifts), is_bend=True, turning=turning)
    form = entering(shape.singular, shape.area, length)
    lines, multiplicity = lines_of(form)
    if multiplicity > 1:
        raise OpenError("the bend of a slice touches a fold")
    nodes = []
    for line in lines:
        here, x = shape.place(line, 2 * BITS)
        turns, place = divmod(_place(angle_of(here), TURN), TURN // 2)
        # S changes its sign in half a turn
        at = place if (_sign(x) > 0) != turns % 2 else place + TURN // 2
        nodes.append((place, at, own.point(at)))
    nodes.sort(key=lambda node: node[0])
    chains = [own.chain(_round([(at, point) for _, at, point in nodes], own))]
    if not nodes:
        start = other.point(0)
        runs = [[(0, start), (TURN // 2, start)]]
    else:
        runs = [
            [(x[0], x[2]), (y[0] + (TURN // 2 if n + 1 == len(nodes) else 0), y[2])]
            for n, (x, y) in enumerate(zip(nodes, [*nodes[1:], nodes[0]], strict=True))
        ]
    for run in runs:
        middle = (run[0][0] + run[1][0]) // 2
        if _sign(value_of(form, cos_sin(Interval(middle, middle, BITS)))) < 0:
            chains.append(other.chain(run))
    return Picture(chains, shifts)


def _of_similar(shape: Shape, length: Fraction) -> Picture:
    """|v| = |κ ± 1| by the angle of v, and the bend, a line, by v = (i y + s sin ψ) m̄ / |m|²."""
    a, b = shape.a, shape.b
    first, second = a[0] ** 2 + a[1] ** 2, b[0] ** 2 + b[1] ** 2
    m = a[0] * second - b[0] * first, a[1] * second - b[1] * first
    size, y = m[0] ** 2 + m[1] ** 2, -length * (a[1] * b[0] - a[0] * b[1])
    radii = [abs(shape.ratio + sign) for sign in (1, -1)]
    squares = {rho: rho**2 * size - y**2 for rho in radii if rho}
    if 0 in squares.values():
        raise OpenError("the bend of a slice touches a fold")
    farthest = Fraction(2 * isqrt(int(max(Fraction(0), *squares.values())) + 1) + 2)
    rows: list[list[Waves]] = []
    for rho in squares:
        rows.append(
            [
                {
                    (0, 0): length**2 + own * rho**2,
                    (1, 0): 2 * length * rho * x[0],
                    (0, 1): -2 * length * rho * x[1],
                }
                for own, x in ((first, a), (second, b))
            ]
        )
    bend, tangents = list[Waves](), list[Waves]()
    for own, x in ((first, a), (second, b)):
        p, q = x[0] * m[0] + x[1] * m[1], x[1] * m[0] - x[0] * m[1]
        slope, square = 2 * length * p / size, Fraction(own, size)
        bend.append(
            {
                (0, 0): length**2 - 2 * length * q * y / size + square * y**2,
                (0, 1): slope * farthest,
                (0, 2): square * farthest**2,
            }
        )
        tangents.append({(0, 0): slope, (0, 1): 2 * square * farthest})
    courses, shifts = both_legs(*rows, bend)
    folds = [Course(legs, (slope_of(legs[0]), slope_of(legs[1])), is_bend=False) for legs in courses[:-1]]
    other = Course(courses[-1], tangents_of(tangents, shifts), is_bend=True)
    marks: list[tuple[int, Point]] = []
    chains = []
    for rho, fold in zip(squares, folds, strict=True):
        own_marks = []
        for sign in (1, -1) if squares[rho] > 0 else ():
            s = Interval.of(squares[rho], 2 * BITS).root().scaled(sign)
            up, norm = Interval.of(y, 2 * BITS), Interval.of(rho * size, 2 * BITS)
            direction = s.scaled(m[0]) + up.scaled(m[1]), up.scaled(m[0]) - s.scaled(m[1])
            at = _place(angle_of((direction[0].over(norm), direction[1].over(norm))), TURN)
            sine = s.over(Interval.of(farthest, 2 * BITS))
            cosine = (Interval.of(1, 2 * BITS) - sine * sine).root()
            own_marks.append((at, fold.point(at)))
            place = angle_of((cosine, sine))
            marks.append((int(place.middle * ONE), own_marks[-1][1]))
        chains.append(fold.chain(_round(own_marks, fold)))
    marks.sort(key=lambda mark: mark[0])
    chains += [other.chain(marks[n : n + 2]) for n in range(0, len(marks), 2)]
    return Picture(chains, shifts)


def _round(marks: Sequence[tuple[int, Point]], course: Course) -> list[tuple[int, Point]]:
    """Points of a closed course in their order, the first again after a full turn."""
    found = sorted(marks, key=lambda mark: mark[0]) or [(0, course.point(0))]
    return [*found, (found[0][0] + TURN, found[0][1])]


def _sign(x: Interval) -> int:
    if not x.sign:
        raise OpenError(UNDECIDED)
    return x.sign


def _place(angle: Interval, period: int) -> int:
    """About an angle, within ROOM of courses, between 0 and a period."""
    if angle.radius > Fraction(1, 1 << (BITS - 20)):
        raise OpenError(UNDECIDED)
    return int(angle.middle * ONE) % period


def _waves(form: Poly) -> Waves:
    """A form in tan β, by the cosine and the sine of β."""
    return {(len(form) - 1 - k, k): Fraction(x) for k, (x, _) in enumerate(form)}
