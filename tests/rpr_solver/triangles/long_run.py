"""Random machines by points, sides and roots: cusps over one field, against a witness that knows no field.

    python -m tests.rpr_solver.triangles.long_run --machines 500 --seed 1

Each line is a machine that differs; the last line has the numbers. A machine in which J and E share curves,
as similar triangles do, is counted as special, and one that needs two roots at once as refused.
"""

import argparse
import random
from fractions import Fraction
from typing import Any

import mpmath as mp

from rpr_solver import InputError
from rpr_solver.triangles import CommonFrame, Geometry, own_shapes, read_geometry
from tests.support.triangle_oracle import corners_of, cusps, wrapped
from tests.support.twisted import Slices, article_angle

_BITS = 256


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--machines", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    draw, counts = random.Random(args.seed), {"agree": 0, "differ": 0, "special": 0, "refused": 0}
    while sum(counts.values()) < args.machines:
        spelling = spelled(draw)
        length = Fraction(draw.randint(200, 2500), 100)
        try:
            geometry = read_geometry(spelling)
        except InputError:
            continue
        verdict = compared(geometry, length)
        counts[verdict] += 1
        if verdict == "differ":
            print(spelling, length)
    print(counts)


def spelled(draw: random.Random) -> dict[str, Any]:
    """A geometry as people write it; not all are manipulators."""
    spelling = {name: triangle(draw) for name in ("base", "platform")}
    return (
        spelling
        if "points" in spelling["platform"]
        else spelling | {"orientation": draw.choice(["ccw", "cw"])}
    )


def triangle(draw: random.Random) -> Any:
    def decimal(low: int, high: int) -> str:
        return f"{draw.uniform(low, high):.2f}"

    def whole() -> str:
        return str(draw.randint(3, 12))

    def root() -> str:
        return f"{draw.randint(1, 6)}*sqrt({draw.randint(2, 7)})"

    corners = [
        ["0", "0"],
        [decimal(3, 15), "0"],
        [decimal(0, 15), f"{decimal(1, 4)}*sqrt({draw.randint(2, 1000)})"],
    ]
    spellings = (
        {"equilateral": decimal(3, 15)},
        {"equilateral": root()},
        {"circumradius": decimal(3, 6)},
        {"sides": [decimal(3, 14) for _ in range(3)]},
        {"sides": [whole(), root(), whole()]},
        {"points": [[decimal(-5, 15), decimal(-5, 15)] for _ in range(3)]},
        {"points": draw.sample(corners, 3)},
    )
    return draw.choice(spellings)


def compared(geometry: Geometry, length: Fraction) -> str:
    if any(shape == "similar" for shape, _ in own_shapes(geometry)):
        return "special"
    try:
        frame = CommonFrame.of(geometry)
    except InputError:
        return "refused"
    try:
        roots = Slices.of(frame).roots(length)
    except AssertionError:
        return "special"
    balls = [article_angle(root.refined(_BITS), frame.axes[0], _BITS) for root in roots]
    with mp.workdps(40):
        angles = sorted(wrapped(mp.radians(mp.mpf(ball.str(25, radius=False)))) for ball in balls)
        base, platform = corners_of(geometry)
        for starts in (60, 160):
            found = cusps(base, platform, mp.mpf(length.numerator) / length.denominator, starts)
            others = sorted(theta for _, theta in found)
            if len(others) == len(angles):
                break
        near = all(abs(wrapped(x - y)) < 1e-8 for x, y in zip(angles, others, strict=False))
        return "agree" if len(others) == len(angles) and near else "differ"


if __name__ == "__main__":
    main()
