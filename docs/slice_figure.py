"""Draw the singular curves of a slice with its cusps, as in the article's figures, to an SVG file.

    python docs/slice_figure.py innocenti 27 docs/slice.svg

The curves are approximate: J = 0 is traced in floating point on a grid of (alpha, theta1) by marching squares
and mapped to (L2, L3). The cusps come from the solver.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from math import cos, pi, sin
from pathlib import Path

from rpr_solver import EXAMPLES, Manipulator, cusp_table

GRID = 700
WIDTH, HEIGHT, MARGIN = 880, 620, 56
Point = tuple[float, float]
Edge = tuple[int, int, int]


def slice_map(
    m: Manipulator, l1: float
) -> tuple[Callable[[float, float], Point], Callable[[float, float], float]]:
    """Returns the functions (alpha, theta1) → (L2, L3) and (alpha, theta1) → J."""
    a2x, a3x, a3y, d1, d2, d3 = (float(getattr(m, k)) for k in ("a2x", "a3x", "a3y", "d1", "d2", "d3"))
    p = (d1 * d1 + d3 * d3 - d2 * d2) / (2 * d1)
    h = max(d3 * d3 - p * p, 0.0) ** 0.5 * (1 if m.orientation == "ccw" else -1)

    def legs(alpha: float, theta: float) -> tuple[float, float, float, float]:
        x, y, c, s = l1 * cos(theta), l1 * sin(theta), cos(alpha), sin(alpha)
        return x + d1 * c - a2x, y + d1 * s, x + p * c - h * s - a3x, y + p * s + h * c - a3y

    def joints(alpha: float, theta: float) -> Point:
        x2, y2, x3, y3 = legs(alpha, theta)
        return (x2 * x2 + y2 * y2) ** 0.5, (x3 * x3 + y3 * y3) ** 0.5

    def jacobian(alpha: float, theta: float) -> float:
        x2, y2, x3, y3 = legs(alpha, theta)
        c, s, ct, st = cos(alpha), sin(alpha), cos(theta), sin(theta)
        f_alpha, f_theta = (y2 * c - x2 * s) * d1, y2 * ct - x2 * st
        g_alpha, g_theta = x3 * (-p * s - h * c) + y3 * (p * c - h * s), y3 * ct - x3 * st
        return f_alpha * g_theta - f_theta * g_alpha

    return joints, jacobian


def zero_curves(function: Callable[[float, float], float]) -> Iterator[list[Point]]:
    """Yields polylines on which the function vanishes, by marching squares on the torus."""
    step = 2 * pi / GRID
    value = [[function(i * step, k * step) for k in range(GRID)] for i in range(GRID)]
    where: dict[Edge, Point] = {}
    links: dict[Edge, list[Edge]] = {}
    for i in range(GRID):
        for k in range(GRID):
            i1, k1 = (i + 1) % GRID, (k + 1) % GRID
            corners = [(i, k), (i1, k), (i1, k1), (i, k1)]
            places = [(i, k), (i + 1, k), (i + 1, k + 1), (i, k + 1)]
            names = [(i, k, 0), (i1, k, 1), (i, k1, 0), (i, k, 1)]
            crossed = []
            for n in range(4):
                (a, b), (c, d) = corners[n], corners[(n + 1) % 4]
                u, v = value[a][b], value[c][d]
                if (u < 0) != (v < 0):
                    (x, y), (z, w) = places[n], places[(n + 1) % 4]
                    t = u / (u - v)
                    where[names[n]] = ((x + t * (z - x)) * step, (y + t * (w - y)) * step)
                    crossed.append(names[n])
            for a_edge, b_edge in zip(crossed[::2], crossed[1::2], strict=True):
                links.setdefault(a_edge, []).append(b_edge)
                links.setdefault(b_edge, []).append(a_edge)
    while links:
        start = next(iter(links))
        line, at = [where[start]], start
        while links.get(at):
            following = links[at].pop()
            links[following].remove(at)
            if not links[at]:
                del links[at]
            line.append(where[following])
            at = following
        links.pop(at, None)
        yield line


def svg(m: Manipulator, l1: str) -> str:
    """Returns the figure."""
    joints, jacobian = slice_map(m, float(l1))
    curves = [[joints(*point) for point in line] for line in zero_curves(jacobian)]
    [table] = cusp_table(m, [l1], digits=15)
    cusps = [(float(c.l2), float(c.l3)) for c in table.cusps]
    right = max(x for line in curves for x, _ in line) * 1.04
    top = max(y for line in curves for _, y in line) * 1.04

    def place(point: Point) -> Point:
        return (
            MARGIN + point[0] / right * (WIDTH - 2 * MARGIN),
            HEIGHT - MARGIN - point[1] / top * (HEIGHT - 2 * MARGIN),
        )

    def path(line: list[Point]) -> str:
        return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in map(place, line))

    ticks = []
    for axis, end in ((0, right), (1, top)):
        step = next(s for s in (1, 2, 5, 10, 20, 50, 100, 1000) if end / s < 9)
        for n in range(0, int(end), step):
            x, y = place((n, 0) if axis == 0 else (0, n))
            ticks.append(
                f'<text x="{x:.0f}" y="{y + 20:.0f}" text-anchor="middle">{n}</text>' if axis == 0
                else f'<text x="{x - 10:.0f}" y="{y + 5:.0f}" text-anchor="end">{n}</text>'
            )  # fmt: skip
    marks = "".join(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="9"/>' for x, y in map(place, cusps))

    def label(x: float, y: float, anchor: str, text: str, size: int = 15) -> str:
        style = f'text-anchor="{anchor}" fill="#222222" font-size="{size}"'
        return f'<text x="{x}" y="{y}" {style}>{text}</text>'

    line = 'fill="none" stroke="#1f5fa8" stroke-width="1.6" stroke-linejoin="round"'
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}"',
        ' font-family="sans-serif" font-size="15">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>',
        f'<path d="M{MARGIN} {MARGIN}V{HEIGHT - MARGIN}H{WIDTH - MARGIN}" fill="none" stroke="#888888"/>',
        f'<g fill="#555555">{"".join(ticks)}</g>',
        label(WIDTH - MARGIN, HEIGHT - 12, "end", "L2"),
        label(MARGIN, MARGIN - 12, "middle", "L3"),
        label(WIDTH / 2, 32, "middle", f"Slice L1 = {l1}: singular curves and {len(cusps)} cusps", 18),
        f'<path d="{"".join(map(path, curves))}" {line}/>',
        f'<g fill="none" stroke="#d0342c" stroke-width="2.2">{marks}</g>',
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


if __name__ == "__main__":
    name, length, target = sys.argv[1:]
    Path(target).write_text(svg(EXAMPLES[name], length))
