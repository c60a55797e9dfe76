"""Forgeries of singular curves, for the random forger."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from copy import deepcopy
from fractions import Fraction
from itertools import pairwise
from math import dist

from rpr_solver.exact.rationals import exact_str
from rpr_solver.verify.core.members import POSE_KINDS
from tests.rpr_solver.verify.forging import Document, Forge, Forged, digit, leading_digit

_AT = "/components"


def _strands(document: Document) -> Iterator[Document]:
    return (strand for part in document["components"] for strand in part["strands"])


def _vertices(document: Document) -> list[Document]:
    return [vertex for strand in _strands(document) for vertex in strand["vertices"]]


def _numbers(vertex: Document) -> Document:
    return {name: x for name, x in vertex.items() if name not in ("index", "cusp")}


def _renumbered(document: Document) -> None:
    """The cusps with the numbers that follow from their angles."""
    cusps = [vertex for vertex in _vertices(document) if vertex["kind"] == "cusp"]
    theta = f"theta{document['fixed_leg']}_deg"
    for n, cusp in enumerate(sorted(cusps, key=lambda vertex: float(vertex[theta])), 1):
        cusp["cusp"] = n


def _are_different(vertices: Sequence[Document]) -> bool:
    return all(_numbers(x) != _numbers(y) for k, x in enumerate(vertices) for y in vertices[:k])


def point_dropped(draw: random.Random, document: Document) -> Forged:
    """A special point less, or twice, or one in the place of another, with the numbers of the cusps."""
    strands = [strand for strand in _strands(document) if strand["vertices"]]
    if not strands:
        return None
    strand = draw.choice(strands)
    vertices = strand["vertices"]
    n = draw.randrange(len(vertices))
    match draw.randrange(3):
        case 0:
            del vertices[n]
        case 1:
            index = vertices[n]["index"] + 1
            if any(vertex["index"] == index for vertex in vertices):
                return None
            vertices.insert(n + 1, deepcopy(vertices[n]) | {"index": index})
        case _:
            other = draw.choice(_vertices(document))
            if _numbers(other) == _numbers(vertices[n]):
                return None
            vertices[n] = deepcopy(other) | {"index": vertices[n]["index"]}
    _renumbered(document)
    return "a point dropped, doubled or replaced", _AT


def point_changed(draw: random.Random, document: Document) -> Forged:
    """Another digit of a special point, or another kind."""
    vertices = _vertices(document)
    if not vertices:
        return None
    vertex = draw.choice(vertices)
    if draw.random() < 0.5:
        row = {name: x for name, x in vertex.items() if isinstance(x, str) and name != "kind"}
        if digit(draw, row, "") is None:
            return None
        vertex.update(row)
        _renumbered(document)
        return "another digit of a point", _AT
    kinds = ["cusp", "turning", "closed-leg", *POSE_KINDS]
    vertex["kind"] = draw.choice([kind for kind in kinds if kind != vertex["kind"]])
    vertex.pop("cusp", None)
    if vertex["kind"] == "cusp":
        vertex["cusp"] = 1
    _renumbered(document)
    return f"a point as {vertex['kind']}", _AT


def points_exchanged(draw: random.Random, document: Document) -> Forged:
    """Two points in each other's place, on one component or on two; or a component run the other way."""
    strands = [strand for strand in _strands(document) if strand["vertices"]]
    if not strands:
        return None
    one, two = draw.choice(strands), draw.choice(strands)
    if draw.random() < 0.4:
        rows = one["vertices"]
        if len(rows) < 3 or not _are_different(rows):
            return None
        indices = [row["index"] for row in rows]
        one["vertices"] = [row | {"index": k} for row, k in zip(rows[::-1], indices, strict=True)]
        if draw.random() < 0.5:
            one["turns"] = {name: -n for name, n in one["turns"].items()}
        return "a component run the other way", _AT
    if not _are_different([*one["vertices"], *(two["vertices"] if two is not one else ())]):
        return None
    i, k = draw.randrange(len(one["vertices"])), draw.randrange(len(two["vertices"]))
    same = one is two
    if (same and (i == k or len(one["vertices"]) < 4)) or (
        not same and len(one["vertices"]) == len(two["vertices"]) == 1 and one["turns"] == two["turns"]
    ):
        return None  # a cyclic order of three points has two directions, and components have no order
    first, second = one["vertices"][i], two["vertices"][k]
    one["vertices"][i] = second | {"index": first["index"]}
    two["vertices"][k] = first | {"index": second["index"]}
    return "points exchanged", _AT


def component_changed(draw: random.Random, document: Document) -> Forged:
    """A component less, or twice, open, with other turns, two as one, or one as two."""
    parts = document["components"]
    if not parts:
        return None
    part = draw.choice(parts)
    strand = part["strands"][0]
    match draw.randrange(6):
        case 0:
            parts.remove(part)
        case 1:
            parts.append(deepcopy(part))
        case 2:
            strand["closed"] = not strand["closed"]
        case 3:
            name = draw.choice(list(strand["turns"]))
            strand["turns"][name] += draw.choice([-1, 1])
        case 4:
            others = [other for other in parts if other is not part]
            if not others:
                return None
            other = draw.choice(others)
            parts.remove(other)
            if draw.random() < 0.3:
                part["strands"] += other["strands"]
            else:
                more = other["strands"][0]
                shift = 1 + max((row["index"] for row in strand["vertices"]), default=0)
                strand["vertices"] += [row | {"index": row["index"] + shift} for row in more["vertices"]]
                for name in strand["turns"]:
                    strand["turns"][name] += more["turns"][name]
        case _:
            new = deepcopy(part)
            cut = draw.randint(0, len(strand["vertices"]))
            new["strands"][0]["vertices"] = strand["vertices"][cut:]
            del strand["vertices"][cut:]
            moved = draw.choice([0, 1])
            for name, turns in strand["turns"].items():
                new["strands"][0]["turns"][name] = turns * moved
                strand["turns"][name] = turns * (1 - moved)
            parts.append(new)
    _renumbered(document)
    return "other components", _AT


def aspects_changed(draw: random.Random, document: Document) -> Forged:
    """An aspect less, one more, or of the other sign."""
    rows = document["aspects"]
    if not rows:
        return None
    row = draw.choice(rows)
    match draw.randrange(3):
        case 0:
            rows.remove(row)
        case 1:
            rows.append(deepcopy(row))
        case _:
            if draw.random() < 0.5 and len({x["sign"] for x in rows}) == 2:
                signs = [x["sign"] for x in rows]
                if signs.count(1) == signs.count(-1):
                    return None
                for x in rows:
                    x["sign"] = -x["sign"]
            else:
                row["sign"] = -row["sign"]
    return "other aspects", "/aspects"


def regions_changed(draw: random.Random, document: Document) -> Forged:
    """Another number of poses, a bounded region as unbounded, a region less, twice, or at another point."""
    rows = document["regions"]
    if not rows:
        return None
    row, other = draw.choice(rows), draw.choice(rows)
    match draw.randrange(6):
        case 0:
            change = draw.choice([-2, 2])
            if not 0 <= row["poses"] + change <= 6:
                return None
            row["poses"] += change
        case 1:
            row["bounded"] = not row["bounded"]
            if draw.random() < 0.5:  # and another is unbounded
                if other is row:
                    return None
                other["bounded"] = not other["bounded"]
        case 2:
            rows.remove(row)
            if any(other["rings"] == row["rings"] for other in rows):  # an earlier change has listed it twice
                rows.append(row)
                return None
            if document["thin_regions"]:  # another one may be the region now
                return None
            if draw.random() < 0.5 and _is_wide(row, document):
                document["thin_regions"] = 1
                return "a region less, as too thin", "/thin_regions"
        case 3:
            rows.insert(0, {**row, "point": _nudged(draw, row["point"])})
        case 4:
            if other is row or other["poses"] != row["poses"] or not other["bounded"]:
                return None
            row["point"] = _nudged(draw, other["point"])
        case _:
            if other["poses"] == row["poses"]:
                return None
            row["point"], other["point"] = other["point"], row["point"]
    return "other regions", "/regions"


def _is_wide(region: Document, document: Document) -> bool:
    """Whether it surely has room for a circle with a radius of four tolerances.

    Without holes, a region has room for one with its area divided by its perimeter.
    """
    if len(region["rings"]) != 1 or not region["bounded"]:
        return False
    names = sorted(region["point"])
    edges = list(pairwise(zip(*(region["rings"][0][name] for name in names), strict=True)))
    area = abs(sum(a * d - b * c for (a, b), (c, d) in edges)) / 2
    everywhere = [
        x for row in document["regions"] for ring in row["rings"] for name in names for x in ring[name]
    ]
    allowed = 6 * float(Fraction(document["tolerance"])) * max(everywhere)
    return area > allowed * sum(map(dist, *zip(*edges, strict=True)))


def _nudged(draw: random.Random, point: Document) -> Document:
    """A joint vector less than 10^-12 of its lengths away."""
    off = 1 + Fraction(draw.randint(1, 9), 10**13)
    return {name: exact_str(Fraction(text) * off) for name, text in point.items()}


def slice_changed(draw: random.Random, document: Document) -> Forged:
    """Another length of the fixed leg."""
    name = f"l{document['fixed_leg']}"
    if (changed := leading_digit(draw, document[name])) is None or not _vertices(document):
        return None
    document[name] = changed
    return "another slice", _AT


FORGES: Sequence[Forge] = (
    point_dropped,
    point_changed,
    points_exchanged,
    component_changed,
    component_changed,
    aspects_changed,
    regions_changed,
    slice_changed,
)
