"""Draw the cusp curves of a manipulator, the fixed leg's angle against its length, to an SVG file.

    python docs/curves_figure.py innocenti 25 32 docs/curves.svg

Every curve ends at the pose of its transition, as the solver proved it.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

from rpr_solver import EXAMPLES, CurveEnd, CuspCurve, CuspCurves, cusp_curves

POINTS = 14
WIDTH, HEIGHT, MARGIN = 880, 620, 56
COLOURS = ("#1f5fa8", "#c2571a", "#2f8a4c", "#8a3fa0", "#a8871f", "#3aa0a8", "#b03060", "#5a6b7b")
MARKS = {"swallowtail": "#d0342c", "beak-to-beak": "#222222", "lips": "#1a9850"}
Point = tuple[float, float]


def end_point(end: CurveEnd) -> Iterator[Point]:
    """Yields the end point of a curve, if a single pose is known there."""
    if end.length is not None and len(end.events) == 1:
        yield float(end.length), float(end.events[0].point.theta1_deg)


def runs(curve: CuspCurve) -> Iterator[list[Point]]:
    """Yields the pieces of a curve, which is cut where the angle passes 180 degrees."""
    inside = [(float(p.length), float(p.point.theta1_deg)) for p in curve.points]
    points = [*end_point(curve.start), *inside, *end_point(curve.stop)]
    run = points[:1]
    for before, after in pairwise(points):
        turn = 360 if before[1] - after[1] > 180 else -360 if after[1] - before[1] > 180 else 0
        if turn:
            yield [*run, (after[0], after[1] + turn)]
            run = [(before[0], before[1] - turn)]
        run.append(after)
    yield run


def svg(curves: CuspCurves, low: float, high: float) -> str:
    """Returns the figure."""

    def place(point: Point) -> Point:
        x = MARGIN + (point[0] - low) / (high - low) * (WIDTH - 2 * MARGIN)
        return x, HEIGHT / 2 - point[1] / 180 * (HEIGHT / 2 - MARGIN)

    def path(run: list[Point]) -> str:
        return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in map(place, run))

    def text(point: Point, words: str, anchor: str = "middle", **style: str) -> str:
        more = "".join(f' {key.replace("_", "-")}="{value}"' for key, value in style.items())
        return f'<text x="{point[0]:.1f}" y="{point[1]:.1f}" text-anchor="{anchor}"{more}>{words}</text>'

    drawn, names, marks = [], [], {}
    for number, curve in enumerate(curves.curves):
        colour = COLOURS[number % len(COLOURS)]
        drawn += [f'<path d="{path(run)}" stroke="{colour}"/>' for run in runs(curve)]
        visible = [p for p in curve.points if low <= p.length <= high]
        if visible and visible[-1].length - visible[0].length > (high - low) / 12:
            between = (visible[0].length + visible[-1].length) / 2
            middle = min(visible, key=lambda p: abs(p.length - between))
            x, y = place((float(middle.length), float(middle.point.theta1_deg)))
            names.append(text((x, y - 7), curve.name, fill=colour))
        for end in (curve.start, curve.stop):
            for x, y in map(place, end_point(end)):
                marks[x, y] = (
                    f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4.5" fill="{MARKS.get(end.kind, "#888888")}"/>'
                )
    step = next(s for s in (1, 2, 5, 10, 20, 50) if (high - low) / s < 12)
    ticks = [
        text((place((n, 0))[0], HEIGHT - MARGIN + 22), str(n)) for n in range(int(low), int(high) + 1, step)
    ]
    ticks += [text((MARGIN - 8, place((0, n))[1] + 5), str(n), "end") for n in range(-180, 181, 60)]
    legend = []
    for number, (kind, colour) in enumerate(MARKS.items()):
        x = WIDTH - MARGIN - 330 + number * 125
        legend.append(f'<circle cx="{x}" cy="45" r="4.5" fill="{colour}"/>')
        legend.append(text((x + 10, 50), kind, "start", fill="#222222", font_size="14"))
    right = WIDTH - MARGIN
    frame = f'x="{MARGIN}" y="{MARGIN}" width="{right - MARGIN}" height="{HEIGHT - 2 * MARGIN}"'
    inside = 'clip-path="url(#inside)" fill="none" stroke-width="2" stroke-linejoin="round"'
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}"',
        ' font-family="sans-serif" font-size="14">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>',
        f'<clipPath id="inside"><rect {frame}/></clipPath>',
        f'<rect {frame} fill="none" stroke="#888888"/>',
        f'<g fill="#555555">{"".join(ticks)}</g>',
        text((WIDTH / 2, 26), "Cusp curves, named from birth to death", fill="#222222", font_size="18"),
        text((right, HEIGHT - 10), "L1", "end", fill="#222222"),
        text((MARGIN - 8, MARGIN - 8), "θ1 [deg]", fill="#222222"),
        *legend,
        f"<g {inside}>{''.join(drawn)}</g>",
        f'<g clip-path="url(#inside)">{"".join(marks.values())}{"".join(names)}</g>',
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


if __name__ == "__main__":
    name, start, stop, target = sys.argv[1:]
    whole = cusp_curves(EXAMPLES[name], digits=15)
    ends = Fraction(start), Fraction(stop)
    sampled = whole.sampled(whole.spread(POINTS, *ends)).within(*ends)
    Path(target).write_text(svg(sampled, float(start), float(stop)), encoding="utf-8")
