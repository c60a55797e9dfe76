"""Draws the pictures of the documentation, from the solver's answers.

    python docs/figures.py [NAME …]            write these, or all, to docs/figures/
    python docs/figures.py --check [NAME …]    write nothing; exit 1 if one of them shows another answer

The same answers give the same bytes with one version of matplotlib, and with all versions the same title and
description, which are compared. Figures 2 to 5 are those of the article.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path

from rpr_solver import (
    EXAMPLES,
    Figure,
    Manipulator,
    Requirement,
    census,
    cusp_curves,
    cusp_loop,
    cusp_table,
    design,
    leg_poses,
    margin,
    pose_connections,
    poses,
    singular_curves,
    with_sensitivities,
    workspace,
)
from rpr_solver.figures.margins import margin_figure, sensitivities_figure
from rpr_solver.figures.mechanism import point_figure
from rpr_solver.notebook import Style

FOLDER = Path(__file__).with_name("figures")
FIRST, SECOND, EIGHTEEN = EXAMPLES["innocenti"], EXAMPLES["zein-flat"], EXAMPLES["eighteen-cusps"]
SIMILAR = Manipulator(a2x=30, a3x=0, a3y=40, d1=15, d2=25, d3=20)


def _of(base: object, platform: object, **orientation: str) -> Manipulator:
    return Manipulator.from_json({"base": base, "platform": platform, **orientation})


SIDES = {"sides": [4, 5, 6]}
EQUILATERAL = _of({"equilateral": 10}, {"circumradius": 1})
CONGRUENT, MIRRORED = _of(SIDES, SIDES), _of(SIDES, SIDES, orientation="cw")
ISOSCELES = _of({"sides": [5, 6, 5]}, {"sides": [3, 2, 3]})
FLAT = _of({"points": [[0, 0], [10, 0], [25, 0]]}, {"sides": [6, 7, 13]})

PAPER = Style(width_mm=86, has_symbols=True, unit="mm", has_title=False)


def _loop() -> Figure:
    return cusp_loop(FIRST, 27, "B").figure(singular_curves(FIRST, 27))


def _cusp() -> Figure:
    [table] = cusp_table(FIRST, 27, digits=15)
    return point_figure(
        FIRST.to_json(), 1, "27", table.cusps[1].to_json(), "The mechanism at cusp B, L1 = 27"
    )


def _locus(view: str = "space") -> Figure:
    return cusp_curves(FIRST, digits=15).part(samples=14).figure(view)


def _margin() -> Figure:
    whole = with_sensitivities(census(FIRST, digits=15).to_json())
    found = [margin(FIRST, length).to_json() for length in ("26.9", "28.1", "28.5")]
    return margin_figure(whole, {"from": "26", "to": "29"}, found)


def _design() -> Figure:
    wish = Requirement(start=27, stop=31, max_cusps=6)
    return design(FIRST, "longest-range", wish, vary="5%", decimals=2, budget=30).figure()


FIGURES: Mapping[str, Callable[[], Figure]] = {
    "article-2": lambda: singular_curves(FIRST, "14.98").figure(),
    "article-3": lambda: singular_curves(FIRST, 34).figure(),
    "article-4": lambda: singular_curves(FIRST, 27).figure(),
    "article-5": lambda: singular_curves(SECOND, 3).figure(),
    "ten-cusps": lambda: singular_curves(FIRST, "28.1").figure(),
    "eighteen-cusps": lambda: singular_curves(EIGHTEEN, "15.6431").figure("torus"),
    "eighteen-cusps-census": lambda: census(EIGHTEEN, digits=15).figure(),
    "nodes": lambda: singular_curves(SIMILAR, 14).figure("torus"),
    "equilateral": lambda: singular_curves(EQUILATERAL, 5).figure(),
    "congruent": lambda: singular_curves(CONGRUENT, 3).figure("torus"),
    "mirrored": lambda: singular_curves(MIRRORED, 3).figure("torus"),
    "isosceles": lambda: singular_curves(ISOSCELES, 4).figure(),
    "flat": lambda: singular_curves(FLAT, 8).figure(),
    "lips": lambda: singular_curves(FIRST, "30.9").figure(),
    "aspects": lambda: singular_curves(FIRST, 27).figure("torus"),
    "loop": _loop,
    "cusp": _cusp,
    "poses": lambda: poses(FIRST, "14.98", 16, 20, digits=15).figure(2),
    "workspace": lambda: workspace(FIRST, 30, {"l1": (5, 30), "l2": (5, 25), "l3": (5, 25)}).figure(),
    "poses-along": lambda: leg_poses(FIRST, {"l1": 17, "l3": 15}, 0, 40, digits=15).figure(),
    "census": lambda: census(FIRST, digits=15).figure(),
    "locus": _locus,
    "projections": lambda: _locus("projections"),
    "sensitivities": lambda: sensitivities_figure(
        with_sensitivities(census(FIRST, start=26, stop=29, digits=15).to_json())
    ),
    "margin": _margin,
    "design": _design,
    "connections": lambda: pose_connections(
        FIRST, 27, 20, 20, to=(30, 21, 19), limits={"l2": (5, 22)}
    ).figure(),
    "paper": lambda: singular_curves(FIRST, 27).figure().styled(PAPER),
}
"""The files of the documentation, without their suffix."""


def said(svg: str) -> str:
    """Returns title and description of a picture."""
    return svg.partition("<title>")[2].partition("</desc>")[0]


def main(argv: list[str]) -> int:
    """Writes or compares pictures; returns the exit status."""
    is_check = "--check" in argv
    names = [name for name in argv if name != "--check"] or list(FIGURES)
    unknown = [name for name in names if name not in FIGURES]
    if unknown:
        print(f"no figure {', '.join(unknown)}; there are {', '.join(FIGURES)}", file=sys.stderr)
        return 2
    different = []
    for name in names:
        path, text = FOLDER / f"{name}.svg", FIGURES[name]().svg()
        if not is_check:
            FOLDER.mkdir(exist_ok=True)
            path.write_text(text, encoding="utf-8", newline="\n")
        elif not path.exists() or said(path.read_text(encoding="utf-8")) != said(text):
            different.append(path.name)
    if different:
        print(f"out of date: {', '.join(different)}; run `python docs/figures.py`", file=sys.stderr)
    return 1 if different else 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
