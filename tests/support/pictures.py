"""What every picture must be: well-formed, named, inside its frame, with labels that cover no other."""

from __future__ import annotations

import re
from collections.abc import Iterator
from fractions import Fraction
from itertools import combinations
from random import Random
from xml.etree import ElementTree

from rpr_solver import Manipulator
from rpr_solver.figures.sheet import box_of
from rpr_solver.notebook.figure import Figure
from rpr_solver.notebook.scene import Box, Group, Shape, Text

SVG = "{http://www.w3.org/2000/svg}"
GEOMETRY = {
    **{"a2x": "15.91", "a3x": "0", "a3y": "10", "d1": "17.04", "d2": "16.54", "d3": "20.84"},
    "orientation": "ccw",
}


def random_robot(rng: Random) -> Manipulator:
    """A manipulator with proper triangles of random sizes."""
    sides = [Fraction(rng.randint(2, 40), rng.choice((1, 2, 5, 10))) for _ in range(5)]
    d3 = abs(sides[3] - sides[4]) + Fraction(rng.randint(1, 99), 100) * 2 * min(sides[3], sides[4])
    return Manipulator(sides[0], rng.randint(-15, 15), sides[2], sides[3], sides[4], d3)


def every(shapes: tuple[Shape, ...]) -> Iterator[Shape]:
    """All shapes, those in groups too."""
    for shape in shapes:
        yield shape
        if isinstance(shape, Group):
            yield from every(shape.shapes)


def words(figure: Figure) -> list[str]:
    """The texts of a picture, in its order."""
    return [shape.words for shape in every(figure.scene.shapes) if isinstance(shape, Text)]


def points(data: str) -> list[tuple[float, float]]:
    """The points of a path's data."""
    numbers = [float(x) for x in re.findall(r"-?[\d.]+", data)]
    return list(zip(numbers[::2], numbers[1::2], strict=True))


def meet(first: Box, second: Box) -> bool:
    """Whether boxes have inner points in common."""
    across = first.x0 < second.x1 and second.x0 < first.x1
    return across and first.y0 < second.y1 and second.y0 < first.y1


def check(figure: Figure, slack: float = 0.5) -> ElementTree.Element:
    """Check a picture, and return its root."""
    text = figure.svg()
    assert text == figure.svg(), "the same bytes each time"
    root = ElementTree.fromstring(text)
    assert root.tag == f"{SVG}svg"
    names = {element.attrib["id"]: element.text or "" for element in root if "id" in element.attrib}
    title, description = root.attrib["aria-labelledby"].split()
    assert root.attrib["role"] == "img"
    assert names[title] == figure.scene.title != ""
    assert names[description] == figure.scene.description != ""
    left, top, width, height = map(float, root.attrib["viewBox"].split())
    frame = Box(left, top, left + width, top + height).grown(slack)
    clipped = {
        id(path)
        for group in root.iter(f"{SVG}g")
        if {"clip-path", "transform"} & group.attrib.keys()
        for path in group.iter()
    }
    for path in root.iter(f"{SVG}path"):
        if id(path) not in clipped:
            assert all(point in frame for point in points(path.attrib["d"]))
    texts = [shape for shape in every(figure.scene.shapes) if isinstance(shape, Text)]
    boxes = [(text.words, box_of(text)) for text in texts if not text.turn]
    for name, box in boxes:
        assert 0 <= box.x0 <= box.x1 <= width, name
        assert top <= box.y0 <= box.y1 <= top + height, name
    for (a, first), (b, second) in combinations(boxes, 2):
        assert not meet(first.grown(-2), second.grown(-2)), f"{a!r} covers {b!r}"
    return root
