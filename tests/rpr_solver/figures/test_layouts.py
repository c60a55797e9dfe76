"""No label covers another and nothing leaves the canvas: all vectors and 200 random answers, at every width.

Mechanisms have the same in test_mechanism.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from fractions import Fraction
from itertools import pairwise
from math import cos, sin
from random import Random
from typing import Any

import pytest

from rpr_solver import EXAMPLES, Figure, SolverError, cusp_loop, singular_curves
from rpr_solver.figures.census import census_figure
from rpr_solver.figures.locus import locus_figure, projections_figure
from tests.support.pictures import GEOMETRY, STYLES, check_texts, random_robot, sheet_of
from tests.support.sampling import long, sample, seeds
from tests.support.shared import census_of, curves_of

KINDS = ["swallowtail", "beak-to-beak", "lips", "several"]
Drawn = Callable[[dict[str, Any]], Figure]


def at_every_width(figure: Figure) -> None:
    for style in STYLES:
        check_texts(sheet_of(figure.styled(style)))


VECTORS = [
    ("innocenti", "28.1"),
    long("sixteen-cusps", "14.46845"),
    long("eighteen-cusps", "15.6431"),
    long("fourteen-cusps", "5.96"),
    long("zein-flat", "3"),
]


@pytest.mark.parametrize("view", ["joints", long("torus")])
@pytest.mark.parametrize(("name", "length"), VECTORS)
def test_a_slice_of_a_vector(name: str, length: str, view: str) -> None:
    at_every_width(singular_curves(EXAMPLES[name], length).figure(view))


@pytest.mark.parametrize("some", seeds(1))
def test_random_slices(some: range) -> None:
    for rng in map(Random, some):
        leg = rng.choice((1, 2, 3))
        curves = singular_curves(random_robot(rng), Fraction(rng.randint(1, 400), 10), fixed_leg=leg)
        at_every_width(curves.figure())
        at_every_width(curves.figure("torus"))


@pytest.mark.parametrize("some", seeds(0, at_once=10))
def test_loops_of_random_slices(some: range) -> None:
    for rng in map(Random, some):
        draw_a_loop(rng)


def draw_a_loop(rng: Random) -> None:
    """A loop round some cusp of a random slice, if there is one."""
    robot, length = random_robot(rng), Fraction(rng.randint(1, 400), 10)
    curves = singular_curves(robot, length)
    if count := len(curves.table.cusps):
        with suppress(SolverError):
            at_every_width(cusp_loop(robot, length, rng.randint(1, count)).figure(curves))


@pytest.mark.parametrize("name", sample(EXAMPLES, 0))
def test_the_census_of_a_vector(name: str) -> None:
    at_every_width(census_of(EXAMPLES[name], digits=15).figure())


@pytest.mark.parametrize("some", seeds(1))
def test_random_censuses(some: range) -> None:
    for rng in map(Random, some):
        at_every_width(census_figure(random_census(rng)))


def random_census(rng: Random) -> dict[str, Any]:
    """Transitions in clusters of any size, as many as there may be."""
    lengths = clustered(rng, rng.randint(0, 40))
    start, stop = rng.choice([("0", None), ("0", "100"), ("50", None)])
    lengths = [x for x in lengths if x > int(start)]
    ends = [start, *map(str, lengths), stop]
    counts = [2 * rng.randint(0, 9) for _ in range(len(lengths) + 1)]
    document = {
        "geometry": GEOMETRY,
        "fixed_leg": rng.choice((1, 2, 3)),
        "range": {"from": start, "to": stop},
    }
    leg = f"l{document['fixed_leg']}"
    document["transitions"] = [{leg: str(x), "kind": rng.choice(KINDS), "events": []} for x in lengths]
    document["intervals"] = [{"from": ends[k], "to": ends[k + 1], "count": n} for k, n in enumerate(counts)]
    return document


def clustered(rng: Random, count: int) -> list[float]:
    """Ascending lengths up to 100, some as near to the one before as a millionth of a millionth."""
    lengths: list[float] = []
    while len(lengths) < count:
        near = lengths and rng.random() < 0.5
        lengths.append(rng.choice(lengths) + 10.0 ** -rng.randint(1, 12) if near else rng.uniform(0.1, 99))
    return sorted({round(x, 13) for x in lengths})


@pytest.mark.timeout(400)
@pytest.mark.parametrize("draw", [locus_figure, projections_figure], ids=["locus", "projections"])
@pytest.mark.parametrize("name", [long(name) for name in EXAMPLES])
def test_the_locus_of_a_vector(name: str, draw: Drawn) -> None:
    at_every_width(draw(curves_of(EXAMPLES[name], digits=15).part(samples=6).to_json()))


@pytest.mark.parametrize("draw", [locus_figure, projections_figure], ids=["locus", "projections"])
@pytest.mark.parametrize("some", seeds(1))
def test_random_loci(some: range, draw: Drawn) -> None:
    for rng in map(Random, some):
        at_every_width(draw(random_locus(rng)))


def random_locus(rng: Random) -> dict[str, Any]:
    """Curves of any length, joined at transitions, that wind in joint space."""
    leg, size = rng.choice((1, 2, 3)), 10.0 ** rng.randint(-2, 3)
    names = [f"l{k}" for k in (leg, *sorted({1, 2, 3} - {leg}))]
    ends = [size * x / 40 for x in clustered(rng, rng.randint(2, 26))]
    curves = [curve(rng, f"C{k}", names, pair, size) for k, pair in enumerate(pairwise(ends), 1)]
    stop = rng.choice([None, str(ends[-1])])
    return {"geometry": GEOMETRY, "fixed_leg": leg, "range": {"from": "0", "to": stop}, "curves": curves}


def curve(
    rng: Random, name: str, names: Sequence[str], ends: tuple[float, float], size: float
) -> dict[str, Any]:
    """A curve of a document from one length to another, some of them on to infinity."""
    start, stop = ends
    phase, turns = rng.uniform(0, 6), rng.uniform(0.1, 3)

    def at(x: float) -> dict[str, str]:
        far = size * (1.5 + sin(phase + turns * x / size)), size * (1.2 + cos(phase - turns * x / size))
        return dict(zip(names, map(str, (x, *far)), strict=True))

    def end(x: float) -> dict[str, Any]:
        kind = rng.choice(KINDS)
        return {names[0]: str(x), "kind": kind, "joins": None, "events": [{"kind": kind, **at(x)}]}

    endless = {names[0]: None, "kind": "open", "joins": None, "events": []}
    points = [at(start + (stop - start) * k / 20) for k in range(1, 20)]
    return {
        "name": name,
        "from": end(start),
        "to": endless if rng.random() < 0.2 else end(stop),
        "points": points,
    }
