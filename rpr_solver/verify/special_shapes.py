"""Special shapes near a geometry, as the head of a document lists them: their distances, found anew.

The distance is the least fraction by which sides have to change (mathematics.md#distance-to-a-special-shape).
With the quotients of squared sides to those of the shape, and R² the greatest of them over the least, it is

    (R − 1) / (R + 1) = (R² − 1) / (R + 1)²,

and for congruent and mirrored shapes the greatest |R − 1| = |R² − 1| / (R + 1). For flat ones it is
(a + b − c) / (a + b + c) with c the longest side, in which Heron's product keeps the digits of the numerator.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import partial, reduce

from flint import arb, ctx

from rpr_solver.verify.claims import Claim, claim_by, demand
from rpr_solver.verify.geometry import Geometry
from rpr_solver.verify.numbers import ball
from rpr_solver.verify.reader import Record, anything, no_claim, record, rows, text, word

_EFFECTS = {
    "similar": ("contradicts",),
    "congruent": ("contradicts", "weakens"),
    "mirrored": ("weakens",),
    "isosceles": ("harmless",),
    "right isosceles": ("harmless",),
    "equilateral": ("harmless",),
    "flat": ("contradicts", "harmless"),
}
"""Shape → what it may mean for the answer."""
_NEAR = Fraction(1, 1000)
_HALF = Fraction(500001, 1000000)
"""Units of the last digit by which a distance may be off: half of one, and what balls do not decide."""
_BITS = 256

NEAR = rows(
    record(
        {
            "shape": word(*_EFFECTS),
            "distance": text(r"0\.0*[1-9]\d|[1-9]\.\de-\d{1,4}"),
            "says": no_claim(text()),
            "spelling": no_claim(anything),
            "effect": word("contradicts", "weakens", "harmless"),
        }
    ),
    1,
    10,
)
"""The member ``near``."""


def near_claims(geometry: Geometry, listed: Sequence[Record]) -> Iterator[Claim]:
    """The claims of the member ``near``: each shape is near, at the distance that is printed."""
    for n, shape in enumerate(listed):
        claim = f"the geometry is within {shape['distance']} of a {shape['shape']} shape, and has not got it"
        yield claim_by(f"/near/{n}/distance", claim, partial(_found, geometry, shape))


def _found(geometry: Geometry, shape: Record) -> str:
    printed, unit = Fraction(shape["distance"]), Fraction(1)
    # invariant: the unit is a power of 10 above a tenth of the number, which is positive, so that this ends
    while printed < 10 * unit:
        unit /= 10
    with ctx.workprec(_BITS):
        own = [
            d
            for d in _distances(geometry, shape["shape"])
            if d > 0 and d < ball(_NEAR) and abs(d - ball(printed)) < ball(_HALF * unit)
        ]
    demand(shape["effect"] in _EFFECTS[shape["shape"]], "such a shape means something else for the answer")
    return demand(own, "no triangle is at this distance from such a shape", "by the sides, in balls")


def _distances(geometry: Geometry, shape: str) -> Iterator[arb]:
    """The distances to a shape: of both triangles together, or of the base and of the platform."""
    keys = (1, 2), (2, 3), (1, 3)
    base, platform = ([sides[key] for key in keys] for sides in geometry.squared_sides)
    is_flat = geometry.is_base_flat or geometry.is_platform_flat
    is_one_sense = is_flat or geometry.base_clockwise == geometry.clockwise
    if shape in ("similar", "congruent", "mirrored"):
        quotients = [x / y for x, y in zip(base, platform, strict=True)]
        if is_one_sense == (shape != "mirrored"):
            yield _spread(quotients) if shape == "similar" else _change(quotients)
        return
    for squares in (base, platform):
        yield _of_one(squares, shape)


def _of_one(squares: Sequence[Fraction], shape: str) -> arb:
    a, b, c = sorted(squares)
    if shape == "equilateral":
        return _spread([a, b, c])
    if shape == "isosceles":
        return _spread(min([a, b], [b, c], key=lambda pair: pair[1] / pair[0]))
    if shape == "right isosceles":
        # for the nearest one, the right angle is opposite to the longest side
        return _spread([a, b, c / 2])
    x, y, z = (ball(square / c).sqrt() for square in (a, b, c))
    area16 = 2 * (a * b + b * c + c * a) - a * a - b * b - c * c
    return ball(area16 / c**2) / ((x + y + z) ** 2 * (x + z - y) * (y + z - x))


def _spread(squares: Sequence[Fraction]) -> arb:
    square = max(squares) / min(squares)
    return ball(square - 1) / (ball(square).sqrt() + 1) ** 2


def _change(squares: Sequence[Fraction]) -> arb:
    changes = [ball(abs(square - 1)) / (ball(square).sqrt() + 1) for square in squares]
    return reduce(arb.max, changes)
