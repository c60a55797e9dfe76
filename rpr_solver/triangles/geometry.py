"""The geometry of a manipulator as two triangles: its spellings, its canonical form and its hash.

The *article's frame* has A1 at the origin and its x-axis through A2. Its six numbers are, with the squared
sides a, b, c of the base and H from :func:`~rpr_solver.triangles.triangle.heron`,

    a2x = √a,    a3x = (a + c − b) / (2 √a),    a3y = ± √H / (2 √a)  (− for a clockwise base),

and the sides d1, d2, d3 of the platform. All of them are surds. Only where six rational numbers are given,
the axis may lead from A2 to A1: a2x < 0, and the base is turned by 180°. If A1 = A2, the x-axis leads through
A3: a2x = a3y = 0 and a3x = √c; if B1 = B2, the direction of B1B3 is that of the platform.
"""

from __future__ import annotations

import difflib
import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, TypeAlias

from rpr_solver.contract import LENGTHS
from rpr_solver.errors import FieldProblem, InputError, clipped, shown
from rpr_solver.exact.rationals import MAX_DIGITS, exact_str, parse_all
from rpr_solver.triangles.surds import SQUARE, Surd, parse_surd
from rpr_solver.triangles.triangle import (
    CCW,
    CW,
    SIDES,
    Named,
    Squares,
    Triangle,
    by_points,
    by_sides,
    one_point,
    read_triangle,
)

Canonical: TypeAlias = dict[str, str | list[str]]
Points: TypeAlias = Mapping[str, Sequence[Sequence[str]]]
"""Corners of the base, of the platform, or of both, by the name of the triangle."""

_ANY_DIGITS = 1 << 20
"""The digits that the numbers of a canonical form may have: far more than are ever read."""
_PAIR = ("base", "platform")
_SENSES = ("base_orientation", "platform_orientation")
_BESIDE = ("$schema", "name", "unit")
"""What a geometry may have beside what describes it: for editors and readers, and no part of its identity."""
_SHOW = (
    '{"base": {"points": [["0", "0"], ["10", "0"], ["5", "8"]]}, "platform": {"sides": ["3", "4", "5"]}}, '
    "with sides, points, equilateral or circumradius of each triangle"
)


@dataclass(frozen=True)
class Geometry:
    """A manipulator: base A1A2A3 and platform B1B2B3.

    Attributes:
        base, platform: the triangles.
        half_turn: whether a2x < 0 in the article's frame; only with six rational numbers.

    >>> read_geometry({"base": {"equilateral": 10}, "platform": {"circumradius": 1}}).to_json()["platform"]
    ['sqrt(3)', 'sqrt(3)', 'sqrt(3)']
    """

    base: Triangle
    platform: Triangle
    half_turn: bool = False

    @cached_property
    def lengths(self) -> tuple[Surd, Surd, Surd, Surd, Surd, Surd]:
        """The article's six numbers a2x, a3x, a3y, d1, d2 and d3."""
        axis = Surd.root(self.base.axis2)
        if self.half_turn:
            axis = -axis
        x, y = self.base.corner3
        return (axis if self.base.squares[0] else Surd.of(0)), axis * x, axis * y, *self.platform.sides

    @property
    def is_rational(self) -> bool:
        """Whether the article's six numbers are all rational."""
        return all(length.rational is not None for length in self.lengths)

    @property
    def is_similar(self) -> bool:
        """Whether base and platform are similar triangles of one sense, with corners in one order."""
        (a, b, c), (x, y, z) = self.base.squares, self.platform.squares
        return self.base.sense == self.platform.sense and a * y == b * x and a * z == c * x

    @property
    def shared_joints(self) -> str:
        """The joints that legs share, as ``"A1 = A2"`` or ``"A1 = A3 and B2 = B3"``; empty if there are none.

        No slice of such a machine has a cusp, and no aspect two poses of one joint vector
        (mathematics.md#shared-joints).

        >>> read_geometry({"base": {"sides": [0, 3, 3]}, "platform": {"sides": [3, 4, 5]}}).shared_joints
        'A1 = A2'
        """
        pairs = (("A", self.base.shared), ("B", self.platform.shared))
        return " and ".join(
            " = ".join(f"{letter}{corner + 1}" for corner in sorted(SIDES[side]))
            for letter, side in pairs
            if side is not None
        )

    def apart_from_shared(self) -> None:
        """Refuses a machine whose legs share joints, where a question is not answered for these.

        Raises:
            InputError: naming ``geometry``.
        """
        if joints := self.shared_joints:
            raise InputError.of("geometry", f"has {joints}, {_NOT_ANSWERED}")

    def with_drawn_curves(self, fixed_leg: int) -> None:
        """Refuses slices of a leg whose singular curves have whole lines θ = const, which are not drawn.

        Where legs share joints, the fixed leg must end in a shared joint of the base, but in none of the
        platform.

        Raises:
            InputError: naming ``fixed_leg``.
        """
        ends = [
            set() if x.shared is None else {k + 1 for k in SIDES[x.shared]}
            for x in (self.base, self.platform)
        ]
        drawn = [leg for leg in (1, 2, 3) if (not ends[0] or leg in ends[0]) and leg not in ends[1]]
        if fixed_leg not in drawn:
            message = (
                f"is {fixed_leg}, but with {self.shared_joints} the singular curves of its slices have whole "
                f"lines theta = const, which are not drawn; give {' or '.join(map(str, drawn))}"
            )
            raise InputError.of("fixed_leg", message)

    def to_json(self) -> Canonical:
        """The canonical form, which :func:`read_geometry` reads: all spellings of a machine have this one.

        It has the article's six numbers, if they are rational; otherwise the sides 12, 23, 31 of both
        triangles, each as ``q`` or ``sqrt(q)``, and their senses.
        """
        values = [length.rational for length in self.lengths]
        numbers = [exact_str(value) for value in values if value is not None]
        if len(numbers) == len(LENGTHS):
            return {**dict(zip(LENGTHS, numbers, strict=True)), "orientation": self.platform.sense}
        pair: Canonical = {}
        for name, sense, triangle in zip(_PAIR, _SENSES, (self.base, self.platform), strict=True):
            pair |= {name: list(map(str, triangle.sides)), sense: triangle.sense}
        return pair

    def as_given(self) -> Mapping[str, Any]:
        """The canonical form, but triangles that were given by points have these.

        >>> corners = [[1, 2], [4, 6], [1, 10]]
        >>> geometry = {"base": {"points": corners}, "platform": {"sides": [3, 4, 5]}, "orientation": "cw"}
        >>> read_geometry(geometry).as_given()["platform"], read_geometry(geometry).as_given()["orientation"]
        ({'sides': ['3', '4', '5']}, 'cw')
        """
        if self.base.points is None and (self.platform.points is None or self.base.sense == CW):
            return self.to_json()
        given: dict[str, Any] = {
            name: {"points": self.points_of(name)}
            if triangle.points
            else {"sides": list(map(str, triangle.sides))}
            for name, triangle in zip(_PAIR, (self.base, self.platform), strict=True)
        }
        return given if self.platform.points else {**given, "orientation": self.platform.sense}

    def points_of(self, name: str) -> list[list[str]]:
        """The points by which the ``"base"`` or the ``"platform"`` was given, in canonical text."""
        return [list(map(str, point)) for point in getattr(self, name).points or ()]

    def with_points(self, points: Points) -> Geometry:
        """The same geometry, given by points (:meth:`points_of`).

        Raises:
            InputError: the points are of another triangle.
        """
        own: dict[str, Triangle] = {}
        for name, corners in points.items():
            field = f"geometry.{name}"
            own[name] = by_points(corners, Named(field, "A" if name == "base" else "B"), 1 << 20)
            if own[name] != getattr(self, name):
                raise InputError.of(field, "has points that are not those of its sides")
        return replace(self, base=own.get("base", self.base), platform=own.get("platform", self.platform))

    @property
    def geometry_hash(self) -> str:
        """``sha256:`` and 64 hex digits over the canonical text."""
        return hash_of_canonical(self.to_json())


def hash_of_canonical(canonical: Mapping[str, str | list[str]]) -> str:
    """The hash of a canonical form, without reading its numbers; in any order of its members."""
    values = {name: value if isinstance(value, str) else ",".join(value) for name, value in canonical.items()}
    # in the order of the alphabet, which is that of the canonical form
    text = ";".join(f"{name}={value}" for name, value in sorted(values.items()))
    return "sha256:" + hashlib.sha256(f"3-RPR;{text}".encode()).hexdigest()


def article_lengths(canonical: Mapping[str, Any]) -> Mapping[str, str]:
    """The six lengths of a canonical form, each as ``q`` or ``sqrt(q)``, and the sense of the platform.

    >>> pair = read_geometry({"base": {"equilateral": 10}, "platform": {"sides": ["3", "4", "5"]}}).to_json()
    >>> article_lengths(pair)["a3y"]
    'sqrt(75)'
    """
    if LENGTHS[0] in canonical:
        return canonical
    geometry = read_geometry(canonical, max_digits=_ANY_DIGITS)
    lengths = dict(zip(LENGTHS, map(str, geometry.lengths), strict=True))
    return {**lengths, "orientation": geometry.platform.sense}


def read_geometry(obj: object, *, max_digits: int = MAX_DIGITS) -> Geometry:
    """Reads a geometry in any of its spellings: the article's six numbers, two triangles, or a canonical
    form.

    ``{"base": T, "platform": T, "orientation": "cw"}`` has triangles as :func:`read_triangle` reads them.
    Triangles without points are counter-clockwise, but for a platform with the orientation ``"cw"``. Beside,
    a geometry may have a ``name`` and a ``unit``, which are texts.

    Args:
        obj: the JSON object.
        max_digits: limit on the digits of numbers.

    Raises:
        InputError: naming every member, number, side or corner at fault.

    >>> read_geometry({"a2x": 10, "a3x": 5, "a3y": "5*sqrt(3)", "d1": 3, "d2": 3, "d3": 3}).base
    Triangle(10, 10, 10, ccw)
    """
    if not isinstance(obj, Mapping):
        raise InputError.of("geometry", f"is {shown(obj)}; give an object, such as {_SHOW}")
    content = {name: value for name, value in obj.items() if name not in _BESIDE}
    problems = note_problems(obj)
    try:
        geometry = _read(content, max_digits)
    except InputError as error:
        raise InputError([*problems, *error.problems]) from None
    if problems:
        raise InputError(problems)
    return geometry


def note_problems(obj: Mapping[str, Any]) -> list[FieldProblem]:
    """What is wrong with the name and the unit of a geometry: they are no texts."""
    wrong = {name: obj[name] for name in _BESIDE[1:] if name in obj and type(obj[name]) is not str}
    return [
        FieldProblem(
            f"geometry.{name}", f"is {value if isinstance(value, str) else shown(value)}; give a text"
        )
        for name, value in wrong.items()
    ]


def _read(content: Mapping[str, Any], max_digits: int) -> Geometry:
    pair, six = ([name for name in names if name in content] for names in (_PAIR, LENGTHS))
    if pair and six:
        message = (
            f"stands beside {' and '.join(pair)}; give the six numbers {', '.join(LENGTHS)}, or two triangles"
        )
        raise InputError([FieldProblem(f"geometry.{name}", message) for name in six])
    if not pair:
        return _by_lengths(content, max_digits)
    is_canonical = any(name in content for name in _SENSES)
    return _by_canonical(content, max_digits) if is_canonical else _by_triangles(content, max_digits)


def _by_triangles(content: Mapping[str, Any], max_digits: int) -> Geometry:
    problems = _unknown(content, (*_PAIR, "orientation"))
    triangles: dict[str, Triangle] = {}
    for name in _PAIR:
        try:
            if name not in content:
                raise InputError.of(f"geometry.{name}", f"is missing; give a triangle, as in {_SHOW}")
            triangles[name] = read_triangle(content[name], f"geometry.{name}", max_digits=max_digits)
        except InputError as error:
            problems += error.problems
    platform, wanted = triangles.get("platform"), content.get("orientation")
    if "orientation" in content:
        problems += _wrong_sense("geometry.orientation", wanted)
        if (
            platform
            and platform.points
            and platform.area16
            and wanted in (CCW, CW)
            and wanted != platform.sense
        ):
            message = (
                f'is "{wanted}", but the points of the platform are {_SENSE[platform.sense]}; leave it out, '
                "or give two of its corners in the other order"
            )
            problems.append(FieldProblem("geometry.orientation", message))
    if problems:
        raise InputError(problems)
    base, platform = (triangles[name] for name in _PAIR)
    return _of(base, platform.mirrored() if wanted == CW and not platform.points else platform)


_NOT_ANSWERED = (
    "a joint that two legs share, for which this is not answered: no slice of such a machine has a cusp, and "
    "its assembly mode never changes without a singularity; ask for poses, tables, curves, or modes"
)


def _of(base: Triangle, platform: Triangle, *, half_turn: bool = False) -> Geometry:
    """The geometry of two triangles.

    Raises:
        InputError: two legs have both ends in common.
    """
    if base.shared is not None and base.shared == platform.shared:
        first, second = sorted(corner + 1 for corner in SIDES[base.shared])
        message = (
            f"has B{first} = B{second} beside A{first} = A{second}: legs {first} and {second} are one, so "
            "that their lengths are equal in all poses"
        )
        raise InputError.of("geometry.platform", message)
    return Geometry(base, platform, half_turn)


_SENSE = {CCW: "counter-clockwise", CW: "clockwise"}


def _by_canonical(content: Mapping[str, Any], max_digits: int) -> Geometry:
    problems = _unknown(content, (*_PAIR, *_SENSES))
    triangles: list[Triangle] = []
    # the sides of a canonical form may be those of points, and longer than a number that people write
    digits = SQUARE * max_digits
    for name, sense in zip(_PAIR, _SENSES, strict=True):
        field, sides = f"geometry.{name}", content.get(name)
        problems += _wrong_sense(f"geometry.{sense}", content.get(sense))
        try:
            if not isinstance(sides, list) or len(sides) != 3:
                raise InputError.of(
                    field, f"is {shown(sides)}; beside {sense} give its three sides as a list"
                )
            fields = f"{field}[0]", f"{field}[1]", f"{field}[2]"
            triangles.append(by_sides(sides, Named(field, "AB"[len(triangles)], fields), digits))
        except InputError as error:
            problems += error.problems
    if problems:
        raise InputError(problems)
    turned = [
        t.mirrored() if content[sense] == CW else t for t, sense in zip(triangles, _SENSES, strict=True)
    ]
    return _of(turned[0], turned[1])


def _by_lengths(content: Mapping[str, Any], max_digits: int) -> Geometry:
    is_begun = any(name in content for name in LENGTHS)
    problems = _unknown(content, (*LENGTHS, *(() if is_begun else _PAIR), "orientation"))
    if not is_begun:
        none = FieldProblem("geometry", f"describes no manipulator; give {_SHOW}")
        raise InputError(problems or [none])
    fields = {f"geometry.{name}": content.get(name, _MISSING) for name in LENGTHS}

    def number(value: Any, field: str) -> Surd:
        if value is _MISSING:
            raise InputError.of(field, "is missing; give a number")
        return parse_surd(value, field, max_digits=max_digits)

    orientation = content.get("orientation", CCW)
    problems += _wrong_sense("geometry.orientation", orientation)
    try:
        a2x, a3x, a3y, *sides = parse_all(fields, number).values()
    except InputError as error:
        raise InputError([*problems, *error.problems]) from None
    triangles: list[Triangle] = []
    readers = partial(_article_base, a2x, a3x, a3y), partial(by_sides, sides, _PLATFORM, max_digits)
    for read in readers:
        try:
            triangles.append(read())
        except InputError as error:
            problems += error.problems
    if problems:
        raise InputError(problems)
    base, platform = triangles
    if orientation == CW:
        platform = platform.mirrored()
    geometry = _of(base, platform, half_turn=a2x.sign < 0)
    # the cached property, which would be found from the squares
    geometry.__dict__["lengths"] = (a2x, a3x, a3y, *sides)
    if geometry.half_turn and not geometry.is_rational:
        turned = ", ".join(f"{name} = {-x}" for name, x in zip(LENGTHS, (a2x, a3x, a3y), strict=False))
        message = f"is {a2x}; with roots a2x must be > 0. Turned by 180 degrees the base has {turned}"
        raise InputError.of("geometry.a2x", message)
    return geometry


_MISSING = object()
_PLATFORM = Named("geometry", "B", ("geometry.d1", "geometry.d2", "geometry.d3"))


def _article_base(a2x: Surd, a3x: Surd, a3y: Surd) -> Triangle:
    """The triangle (0, 0), (a2x, 0), (a3x, a3y)."""
    dot = (a2x * a3x).rational
    if not a2x and not a3x and not a3y:
        raise one_point(Named("geometry", "A"))
    if not a2x and (a3y or a3x.sign < 0):
        message = (
            "is 0, so A1 = A2, and the x-axis leads through A3: give a3x > 0 and a3y = 0, or the base by its "
            'points, as in {"base": {"points": [["0", "0"], ["0", "0"], ["6", "8"]]}, …}'
        )
        raise InputError.of("geometry.a2x", message)
    if dot is None:
        message = (
            f"{a3x} is at odds with geometry.a2x = {a2x}: the square of A2A3 would be irrational, and must "
            "be rational; give a2x and a3x as multiples of one root"
        )
        raise InputError.of("geometry.a3x", message)
    across = a3x.square + a3y.square
    squares: Squares = a2x.square, a2x.square + across - 2 * dot, across
    return Triangle(squares, CW if a2x.sign * a3y.sign < 0 else CCW)


def _wrong_sense(field: str, sense: object) -> list[FieldProblem]:
    return [] if sense in (CCW, CW) else [FieldProblem(field, f'{shown(sense)} is neither "ccw" nor "cw"')]


_OTHER_NAMES = {
    "points": (
        "points",
        "vertices",
        "corners",
        "anchors",
        "joints",
        "a",
        "b",
        "a1",
        "a2",
        "a3",
        "b1",
        "b2",
        "b3",
    ),
    "sides": ("sides", "lengths", "edges"),
    "equilateral": ("equilateral", "side"),
    "circumradius": ("circumradius", "radius", "circle", "r"),
}
"""What people call parts of a geometry outside of a triangle."""


_LISTED = 20


def _unknown(content: Mapping[str, Any], known: tuple[str, ...]) -> list[FieldProblem]:
    problems = []
    unknown = [str(name) for name in content if name not in known]
    for name in unknown[:_LISTED]:
        ours = next((k for k, others in _OTHER_NAMES.items() if name.lower() in others), None)
        near = difflib.get_close_matches(name[:60].lower(), known, n=1, cutoff=0.5)
        if ours:
            hint = f"a triangle has {ours}: {_SHOW}"
        elif near:
            hint = f"did you mean {near[0]}?"
        else:
            hint = f"known are {', '.join(known)}"
        problems.append(FieldProblem(f"geometry.{clipped(name, 60)}", f"unknown member; {hint}"))
    if len(unknown) > _LISTED:
        message = f"{problems[-1].message} … and {len(unknown) - _LISTED} more unknown members"
        problems[-1] = FieldProblem(problems[-1].field, message)
    return problems
