"""Cusps that are printed alike, or nearly so, as right beside a transition.

There, Newton's method finds one of two cusps from both texts, or none. But each line θ = const with a cusp is
an isolated root of Q, known to any precision, and α is a root of J or of E on it: so good a start leads to
each cusp, which is proved by its box as any other. A text then has as many cusps as round to it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

from rpr_solver.verify.claims import ClaimStatus
from rpr_solver.verify.core.angles import angle_near, degrees, radians
from rpr_solver.verify.core.boxes import Box, Pair, around, direction
from rpr_solver.verify.core.printed import Printed
from rpr_solver.verify.core.roots import real_roots, refined
from rpr_solver.verify.core.surds import ZERO, Poly, Ring, Surd, derivative, primitive
from rpr_solver.verify.core.system import System, Trig, in_half_tangent
from rpr_solver.verify.eliminant import Eliminant
from rpr_solver.verify.lines import meet, opposite, separation
from rpr_solver.verify.points import Finding, Point, Points

_SPARE_BITS = 64
_CONTACTS = (2, 4)
"""The derivative of (J, E) at a cusp is of the order of this power, less 1, of its distance to the next."""
_OPEN: Finding = (ClaimStatus.NOT_CHECKED, "")


@dataclass(frozen=True)
class Located:
    """A printed cusp, its proved box if there is one, and what is found about its digits."""

    point: Point
    box: Box | None
    finding: Finding


def located(
    points: Points, printed: Sequence[Point], eliminant: Eliminant | None = None, bits: int = 0
) -> list[Located]:
    """A box for each printed cusp, different ones where cusps are printed alike.

    Args:
        points: the equations of the slice.
        printed: the cusps as they are printed.
        eliminant: the lines of the slice, if they are known.
        bits: the boxes are of some 2^−``bits`` at most.
    """
    apart = separation(eliminant) if eliminant else 0
    if eliminant and eliminant.form and any(apart > point.bits for point in printed):
        hopeless = [Located(point, None, _OPEN) for point in printed]  # for Newton's method from the texts
        found = _told_apart(points, eliminant, hopeless, set(range(len(printed))), apart, bits)
        return [x if x.box else Located(x.point, *points.cusp(x.point)) for x in found]
    found = [Located(point, *points.cusp(point, max(bits, 2 * apart))) for point in printed]
    doubtful = doubtful_of(found)
    if not doubtful or not (eliminant and eliminant.form):
        return found
    return _told_apart(points, eliminant, found, doubtful, apart, bits)


def doubtful_of(found: Sequence[Located]) -> set[int]:
    """The cusps that are not proved, or share a box with another."""
    doubtful = {n for n, x in enumerate(found) if x.finding[0] is not ClaimStatus.PROVED}
    for n, x in enumerate(found):
        for k, y in enumerate(found[:n]):
            if x.box and y.box and x.box.meets(y.box):
                doubtful |= {n, k}
    return doubtful


def _told_apart(
    points: Points, eliminant: Eliminant, found: Sequence[Located], doubtful: set[int], apart: int, least: int
) -> list[Located]:
    """Doubtful cusps are given the boxes above the lines they may lie on, each box once."""
    result = list(found)
    rest = sorted(doubtful)
    for order in _CONTACTS:
        bits = max(least, order * apart, *(found[n].point.bits for n in rest))
        boxes = [x.box for n, x in enumerate(result) if x.box and n not in rest]
        known = len(boxes)
        starts = _starts(points.system, eliminant, [found[n].point for n in rest], bits + _SPARE_BITS)
        near = [points.cusp_near(*start, bits, (order - 1) * apart) for start in starts]
        for box in near:
            if box and not any(box.meets(other) for other in boxes):
                boxes.append(box)
        for box in sorted(boxes[known:], key=lambda box: box.theta.middle):
            findings = ((n, points.printed_right(found[n].point, box)) for n in rest)
            for n, finding in findings:
                if finding[0] is ClaimStatus.PROVED:
                    result[n] = Located(found[n].point, box, finding)
                    rest.remove(n)
                    break
        if not rest or None not in near:
            break
    return result


def _starts(
    system: System, eliminant: Eliminant, wanted: Sequence[Point], bits: int
) -> Iterator[tuple[Fraction, Fraction]]:
    """Angles in degrees of all poses that may be cusps, and may be printed as wanted."""
    areas = [(x, around(x.alpha, x.theta, bits, system.ring.radicand).directions) for x in wanted]
    for ratio, theta in _lines(eliminant, bits):
        here = [(x, area) for x, area in areas if meet(area.theta, theta)]
        for alpha in _alphas(system, ratio, bits) if here else ():
            for point, area in here:
                if meet(area.alpha, alpha):
                    yield _degrees(alpha, point.alpha), _degrees(theta, point.theta)
                    break


def _lines(eliminant: Eliminant, bits: int) -> Iterator[tuple[tuple[int, int], Pair]]:
    """All real lines: tan(θ/2) as a ratio, and the direction, both with this number of bits."""
    ring = eliminant.ring
    for form, roots in (
        (eliminant.single, eliminant.single_roots),
        (eliminant.special, eliminant.special_roots),
    ):
        for root in roots:
            narrow = refined(ring, form, root, Fraction(1, 1 << bits))
            n, d = ((narrow.lower + narrow.upper) / 2).as_integer_ratio()
            yield (d, n) if root.inverted else (n, d), direction(ring, form, narrow, bits)
    if eliminant.special_at_infinity:
        yield (1, 0), opposite(bits)


def _alphas(system: System, ratio: tuple[int, int], bits: int) -> Iterator[Pair]:
    """Directions α of the roots of J, and of E along either leg, on a line; each once."""
    seen: list[Pair] = []
    for p, degree in ((system.singular, 2), *((leg.kernel, 3) for leg in system.legs)):
        form = _squarefree(system.ring, _on_line(p, degree, *ratio))
        for root in real_roots(system.ring, form) if form else ():
            alpha = direction(system.ring, form, root, bits)
            if not any(_nearly(alpha, other) for other in seen):
                seen.append(alpha)
                yield alpha


def _on_line(p: Trig, degree: int, n: int, d: int) -> tuple[Surd, ...]:
    """A polynomial of this degree in α and in θ, by tan(α/2), where tan(θ/2) = n/d."""
    cos, sin, one = d * d - n * n, 2 * n * d, d * d + n * n
    return in_half_tangent(p, degree, lambda k, m: cos**k * sin**m * one ** (degree - k - m))


def _squarefree(ring: Ring, form: Sequence[Surd]) -> Poly:
    """The form with each root once, infinity too; empty if it is 0."""
    finite = primitive(form)
    if not finite:
        return ()
    if len(finite) > 2:
        finite_once = ring.field_quotient(finite, ring.gcd(finite, derivative(finite)))
    else:
        finite_once = finite
    return finite_once if len(finite) == len(form) else (*finite_once, ZERO)


def _nearly(first: Pair, second: Pair) -> bool:
    """Whether two directions agree to half of their bits."""
    return all(abs(x.lower - y.lower) >> (x.bits // 2) == 0 for x, y in zip(first, second, strict=True))


def _degrees(direction: Pair, printed: Printed) -> Fraction:
    """An angle in degrees near a printed one, by its cosine and sine."""
    cos, sin = direction
    return degrees(angle_near(cos, sin, radians(printed.value, cos.bits))).middle
