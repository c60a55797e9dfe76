"""The workspace at one orientation: where the limits of all legs allow the platform to be, and where J is 0.

The document of :meth:`Workspace.to_json`::

    {"geometry": {…}, "geometry_hash": "sha256:…", "digits": 15, "solver_version": "…",
     "phi_deg": "30", "alpha_deg": "30.0000000000000", "frame": "article",
     "limits": {"l1": {"min": "2", "max": "8"}, …},
     "conic": {"kind": "hyperbola",
               "coefficients": {"xx": "…", "xy": "…", "yy": "…", "x": "…", "y": "…", "1": "…"}},
     "area": {"positive": "…", "negative": "…"},
     "vertices": [{"x": "…", "y": "…", "on": ["l1_max", "singular"]}, …],
     "regions": [{"sign": 1, "area": "…",
                  "boundary": [[{"on": "l1_max", "from": 1, "to": 2, "ccw": true}, …]]}],
     "isolated": [], "thin": []}

A place (x, y) is that of the origin of the platform's frame: of the points by which it was given, else of B1,
in the frame of the base's points, else in the article's. With points, vertices have ``b1_x`` and ``b1_y`` in
the article's frame, too. A boundary has the outer loop first, then holes; the region is to the left. An arc
of a circle runs counter-clockwise if ``ccw``; one of the conic has a point inside, for drawing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import arb, ctx

from rpr_solver.contract import MIN_DIGITS, Progress, check_digits, check_type, document_head, silent
from rpr_solver.exact.decimals import angle_text, round_ball, round_fraction
from rpr_solver.exact.rationals import Exact, exact_str, parse_exact
from rpr_solver.model.jets import direction
from rpr_solver.model.lengths import Bounds, ExactLimits, limits_json
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.notebook import Row, counted, csv_text, html_table, shortened, with_floats
from rpr_solver.notebook.figure import Figure, Pictured, draw
from rpr_solver.triangles import UserFrame
from rpr_solver.workspaces.arrangement import Arrangement, Edge, Face, Half, Loop, arrangement
from rpr_solver.workspaces.conic import ConicKind
from rpr_solver.workspaces.coordinates import coordinate_text, number_text, rounded
from rpr_solver.workspaces.curves import Circle, Conic, Point
from rpr_solver.workspaces.orientation import COEFFICIENTS, Orientation
from rpr_solver.workspaces.question import orientation, orientations, workspace_limits

_SIGNS = {"positive": 1, "negative": -1, "singular": 0}
_PLACE_BITS = 256
"""Bits of places for drawing, and by which regions of one area are put in order."""


@dataclass(frozen=True)
class WorkspaceVertex:
    """A common point of curves on the boundary of a region.

    Attributes:
        x, y: the place, correctly rounded.
        on: the curves through it: ``l1_min``, ``l1_max``, …, ``singular``.
        b1: x and y of B1 in the article's frame; None where that is the place.

    >>> WorkspaceVertex("3.1", "-3.9", ("l1_min", "l2_min")).on
    ('l1_min', 'l2_min')
    """

    x: str
    y: str
    on: tuple[str, ...]
    b1: tuple[str, str] | None = None

    def to_json(self) -> dict[str, Any]:
        """The document's vertex object."""
        given = {} if self.b1 is None else dict(zip(("b1_x", "b1_y"), self.b1, strict=True))
        return {"x": self.x, "y": self.y, **given, "on": list(self.on)}


@dataclass(frozen=True)
class WorkspaceArc:
    """A piece of the boundary of a region, the region at its left.

    Attributes:
        on: its curve: ``l1_min``, ``l1_max``, …, or ``singular``; several names where circles coincide.
        start, stop: the numbers of its ends among the vertices, from 1; None of a whole circle or ellipse.
        ccw: of a circle, whether it runs counter-clockwise; None of the conic.
        through: of the conic, a point inside, in 15 digits.

    >>> WorkspaceArc("l1_max", 1, 2, ccw=True).to_json()
    {'on': 'l1_max', 'from': 1, 'to': 2, 'ccw': True}
    """

    on: str
    start: int | None
    stop: int | None
    ccw: bool | None = None
    through: tuple[str, str] | None = None

    def to_json(self) -> dict[str, Any]:
        """The document's arc object."""
        ends = {"on": self.on, "from": self.start, "to": self.stop}
        if self.through is None:
            return {**ends, "ccw": self.ccw}
        return {**ends, "through": dict(zip("xy", self.through, strict=True))}


@dataclass(frozen=True)
class WorkspaceRegion:
    """A connected region of allowed places in which no pose is singular: an aspect at this orientation.

    Attributes:
        sign: that of J, as in slices of leg 1; 0 where J is 0 everywhere.
        area: correctly rounded.
        boundary: the outer loop, then those of holes.

    >>> WorkspaceRegion(1, "12.5", ((WorkspaceArc("l1_max", None, None, ccw=True),),)).sign
    1
    """

    sign: int
    area: str
    boundary: tuple[tuple[WorkspaceArc, ...], ...]

    def to_json(self) -> dict[str, Any]:
        """The document's region object."""
        loops = [[arc.to_json() for arc in loop] for loop in self.boundary]
        return {"sign": self.sign, "area": self.area, "boundary": loops}


@dataclass(frozen=True)
class Workspace(Pictured):
    """The places that the limits of all legs allow at one orientation, and the singular conic in them.

    Proved: vertices, regions, signs, and each digit.

    Attributes:
        manipulator: the geometry.
        phi: the orientation in degrees, exact: the angle of the platform's frame in that of the base.
        alpha_deg: the same as α of the article, correctly rounded.
        limits: by legs' numbers, exact.
        digits: significant digits of every printed number.
        conic: what the places with J = 0 are.
        coefficients: those of x², x y, y², x, y and 1 in J, correctly rounded.
        areas: the sums of areas by the sign of J.
        vertices: the common points of curves on boundaries of regions, or isolated.
        regions: by the sign of J, + first, then by area, the largest first.
        isolated: numbers of vertices that are allowed, while no place near them is.
        thin: arcs that are allowed, while no place beside them is.

    >>> from rpr_solver import EXAMPLES, workspace
    >>> workspace(EXAMPLES["innocenti"], 30, {"l1": (5, 30), "l2": (5, 25), "l3": (5, 25)})
    <Workspace φ=30: hyperbola, 4 regions>
    """

    manipulator: Manipulator
    phi: Fraction
    alpha_deg: str
    limits: Mapping[int, Bounds]
    digits: int
    conic: ConicKind
    coefficients: tuple[str, ...]
    areas: Mapping[int, str]
    vertices: tuple[WorkspaceVertex, ...]
    regions: tuple[WorkspaceRegion, ...]
    isolated: tuple[int, ...]
    thin: tuple[WorkspaceArc, ...]

    def __repr__(self) -> str:
        found = counted(len(self.regions), "region")
        return f"<Workspace φ={shortened(exact_str(self.phi))}: {self.conic.value}, {found}>"

    def to_json(self) -> dict[str, Any]:
        """The document described at the top of this module."""
        frame = UserFrame.of(self.manipulator.geometry)
        points = {} if frame is None else {"points": dict(_points_of(self.manipulator))}
        return {
            **document_head(self.manipulator, self.digits),
            "phi_deg": exact_str(self.phi),
            "alpha_deg": self.alpha_deg,
            "frame": "article" if frame is None else "points",
            **points,
            "limits": limits_json(self.limits),
            "conic": {
                "kind": self.conic.value,
                "coefficients": dict(zip(COEFFICIENTS, self.coefficients, strict=True)),
            },
            "area": {name: self.areas[sign] for name, sign in _SIGNS.items() if sign in self.areas},
            "vertices": [vertex.to_json() for vertex in self.vertices],
            "regions": [region.to_json() for region in self.regions],
            "isolated": list(self.isolated),
            "thin": [arc.to_json() for arc in self.thin],
        }

    def rows(self) -> list[Row]:
        """A row for each region, for ``pandas.DataFrame(found.rows())``; areas are floats."""
        return [{"sign": region.sign, "area": float(region.area)} for region in self.regions]

    def figure(self) -> Figure:
        """A picture: the regions, tinted by the sign of J, the limits, the conic, and the machine at a pose.

        Raises:
            InputError: the lengths are too large to be drawn.
        """
        return draw(self.to_json())

    def _repr_html_(self) -> str:
        rows = [{"sign of J": _SIGN_WORDS[r.sign], "area": r.area} for r in self.regions]
        return html_table(repr(self)[1:-1], rows, [], first=self.manipulator.remark)


_SIGN_WORDS = {1: "+", -1: "−", 0: "0"}


@dataclass(frozen=True)
class SweptWorkspace:
    """The workspace at one of several orientations, in numbers.

    Attributes:
        phi: the orientation in degrees, exact.
        conic: what the places with J = 0 are.
        counts: the numbers of regions by the sign of J.
        areas: the sums of their areas, correctly rounded.

    >>> SweptWorkspace(Fraction(30), ConicKind.CIRCLE, {1: 1}, {1: "12.5"}).to_json()["positive"]
    '12.5'
    """

    phi: Fraction
    conic: ConicKind
    counts: Mapping[int, int]
    areas: Mapping[int, str]

    def to_json(self) -> dict[str, Any]:
        """The document's row."""
        row: dict[str, Any] = {"phi_deg": exact_str(self.phi), "conic": self.conic.value}
        for name, sign in _SIGNS.items():
            if sign in self.areas:
                row |= {f"{name}_regions": self.counts[sign], name: self.areas[sign]}
        return row


@dataclass(frozen=True)
class WorkspaceSweep(Pictured):
    """The workspaces at several orientations, in numbers.

    Attributes:
        manipulator: the geometry.
        turns: the first orientation, the last one and the step, in degrees, exact.
        limits: by legs' numbers, exact.
        digits: significant digits of the areas.
        orientations: one after the other.

    >>> from rpr_solver import EXAMPLES, workspace_sweep
    >>> workspace_sweep(EXAMPLES["innocenti"], 0, 90, 30, {"l1": (5, 30)})
    <WorkspaceSweep: 4 orientations>
    """

    manipulator: Manipulator
    turns: tuple[Fraction, Fraction, Fraction]
    limits: Mapping[int, Bounds]
    digits: int
    orientations: tuple[SweptWorkspace, ...]

    def __repr__(self) -> str:
        return f"<WorkspaceSweep: {counted(len(self.orientations), 'orientation')}>"

    def to_json(self) -> dict[str, Any]:
        """The document: the head, the range of ``phi_deg``, ``limits`` and ``orientations``."""
        return {
            **document_head(self.manipulator, self.digits),
            "phi_deg": dict(zip(("from", "to", "step"), map(exact_str, self.turns), strict=True)),
            "limits": limits_json(self.limits),
            "orientations": [row.to_json() for row in self.orientations],
        }

    def figure(self) -> Figure:
        """A picture: the areas of both signs of J against the orientation."""
        return draw(self.to_json())

    def rows(self) -> list[Row]:
        """A row for each orientation, for ``pandas.DataFrame(found.rows())``; numbers are floats."""
        named = ("phi_deg", "positive", "negative", "singular")
        return with_floats(
            {**row, **{name: float(Fraction(row[name])) for name in named if name in row}}
            for row in (one.to_json() for one in self.orientations)
        )


def workspace(
    manipulator: Manipulator, phi: Exact, limits: ExactLimits, *, digits: int = MIN_DIGITS
) -> Workspace:
    """The places that the limits of the legs allow at one orientation, and the singular conic in them.

    Args:
        manipulator: the geometry.
        phi: the orientation in degrees, exact, −360 to 360: the angle of the platform's frame in that of the
            base, each of the points by which it was given; otherwise they are the article's, and φ is α.
        limits: the least and the greatest length of legs, by leg; an end that is None is open. At least one
            leg has a greatest length.
        digits: significant digits of every printed number, 15 to 10000; all are proved.

    Raises:
        InputError: naming ``phi``, ``limits`` or ``digits``.
        SolverError: regions or digits could not be decided.

    >>> from rpr_solver import EXAMPLES
    >>> found = workspace(EXAMPLES["innocenti"], 30, {"l1": (5, 30), "l2": (5, 25), "l3": (5, 25)})
    >>> found.conic.value, [(region.sign, region.area) for region in found.regions][:2]
    ('hyperbola', [(1, '375.882830619136'), (1, '364.456903299546')])
    """
    check_type(manipulator, Manipulator, "manipulator")
    digits, turn, bounds = check_digits(digits), orientation(phi), workspace_limits(limits)
    turned = Orientation.of(manipulator.geometry, turn)
    return _Answer(manipulator, turn, bounds, digits, turned, arrangement(turned, bounds)).workspace()


def workspace_sweep(
    manipulator: Manipulator,
    start: Exact,
    stop: Exact,
    step: Exact,
    limits: ExactLimits,
    *,
    digits: int = MIN_DIGITS,
    progress: Progress = silent,
) -> WorkspaceSweep:
    """The workspaces at several orientations: kinds of conics, numbers of regions, areas.

    Args:
        manipulator: the geometry.
        start: the first orientation in degrees, exact.
        stop: the end of the range; ``start``, ``start + step``, … up to it are computed.
        step: > 0.
        limits: as in :func:`workspace`.
        digits: significant digits of the areas.
        progress: callback ``progress(done, total)``.

    Raises:
        InputError: naming the argument at fault.
        SolverError: regions or digits could not be decided.

    >>> from rpr_solver import EXAMPLES
    >>> limits = {"l1": (5, 30), "l2": (5, 25), "l3": (5, 25)}
    >>> [row.conic.value for row in workspace_sweep(EXAMPLES["innocenti"], -90, 90, 90, limits).orientations]
    ['ellipse', 'two lines', 'ellipse']
    """
    check_type(manipulator, Manipulator, "manipulator")
    digits, bounds = check_digits(digits), workspace_limits(limits)
    turns = orientation(start, "start"), orientation(stop, "stop"), parse_exact(step, "step")
    angles = orientations(*turns)
    found: list[SweptWorkspace] = []
    for angle in angles:
        progress(len(found), len(angles))
        one = arrangement(Orientation.of(manipulator.geometry, angle), bounds)
        areas = _areas(one, digits)
        counts = {sign: sum(face.sign == sign for face in one.faces) for sign in areas}
        found.append(SweptWorkspace(angle, one.conic.kind, counts, areas))
    progress(len(found), len(angles))
    return WorkspaceSweep(manipulator, turns, bounds, digits, tuple(found))


def workspace_csv(document: Mapping[str, Any]) -> str:
    """The document as CSV: a line for each region; of a sweep, a line for each orientation.

    Args:
        document: as ``to_json()`` of a workspace or of a sweep gives it.

    >>> from rpr_solver import EXAMPLES
    >>> print(workspace_csv(workspace(EXAMPLES["zein-flat"], 0, {"l1": (None, 5)}).to_json()), end="")
    sign,area,arcs,holes
    1,39.2699081698724,2,0
    -1,39.2699081698724,2,0
    """
    if "orientations" in document:
        rows = document["orientations"]
        columns = dict.fromkeys(name for row in rows for name in row)
        return csv_text(tuple(columns), rows)
    regions = [
        {**region, "arcs": sum(map(len, region["boundary"])), "holes": len(region["boundary"]) - 1}
        for region in document["regions"]
    ]
    return csv_text(("sign", "area", "arcs", "holes"), regions)


def _points_of(manipulator: Manipulator) -> list[tuple[str, list[list[str]]]]:
    geometry = manipulator.geometry
    return [(name, points) for name in ("base", "platform") if (points := geometry.points_of(name))]


def _areas(found: Arrangement, digits: int) -> dict[int, str]:
    """The sums of areas by the sign of J."""
    signs = (0,) if found.conic.kind is ConicKind.PLANE else (1, -1)
    return {sign: _area(found, [x for x in found.faces if x.sign == sign], digits) for sign in signs}


def _area(found: Arrangement, faces: Sequence[Face], digits: int) -> str:
    """The sum of areas, correctly rounded; no region has area 0."""

    def total(bits: int) -> arb:
        with ctx.workprec(bits):
            return sum((found.area(face, bits) for face in faces), arb(0))

    return rounded(total, lambda _: False, digits) if faces else "0"


@dataclass(frozen=True)
class _Answer:
    """What the document is made from."""

    manipulator: Manipulator
    phi: Fraction
    limits: Mapping[int, Bounds]
    digits: int
    orientation: Orientation
    found: Arrangement

    @property
    def _is_given(self) -> bool:
        """Whether base or platform were given by points."""
        return UserFrame.of(self.manipulator.geometry) is not None

    def workspace(self) -> Workspace:
        """The document."""
        found, digits = self.found, self.digits
        regions = self._regions()
        thin = [self._bare(edge) for edge in found.thin]
        shown = sorted(_ends([*_arcs(regions), *thin]) | set(found.isolated))
        names = {k: number for number, k in enumerate(shown, 1)}
        return Workspace(
            self.manipulator,
            self.phi,
            alpha_text(self.orientation, None if self._is_given else self.phi, digits),
            self.limits,
            digits,
            found.conic.kind,
            tuple(number_text(x, digits) for x in found.conic.coefficients),
            _areas(found, digits),
            tuple(self._vertex(k) for k in shown),
            tuple(_renamed_region(region, names) for region in regions),
            tuple(names[k] for k in found.isolated),
            tuple(_renamed(arc, names) for arc in thin),
        )

    def _regions(self) -> list[WorkspaceRegion]:
        """The regions in their order; ends of arcs are numbers of the arrangement."""
        areas = {face: _area(self.found, [face], self.digits) for face in self.found.faces}

        def key(face: Face) -> tuple[int, float, tuple[float, float]]:
            return -face.sign, -float(f"{float(areas[face]):.12g}"), _corner(self.found, face)

        return [
            WorkspaceRegion(face.sign, areas[face], tuple(tuple(self._loop(loop)) for loop in face.loops))
            for face in sorted(self.found.faces, key=key)
        ]

    def _loop(self, loop: Loop) -> list[WorkspaceArc]:
        """The arcs of a loop, from vertex to vertex: points that only divide a curve are left out."""
        arcs: list[WorkspaceArc] = []
        vertices = self.found.vertices
        first = next((k for k, half in enumerate(loop) if len(vertices[self._ends(half)[0]].on) > 1), None)
        for half in loop if first is None else (*loop[first:], *loop[:first]):
            start, stop = self._ends(half)
            arc = self._arc(half, start, stop)
            if arcs and len(vertices[start].on) == 1:
                last = arcs[-1]
                arcs[-1] = WorkspaceArc(last.on, last.start, stop, last.ccw, last.through)
            else:
                arcs.append(arc)
        if first is None:
            arcs = [WorkspaceArc(arcs[0].on, None, None, arcs[0].ccw, arcs[0].through)]
        return arcs

    def _ends(self, half: Half) -> tuple[int, int]:
        edge = self.found.edges[half.edge]
        return (edge.start, edge.stop) if half.is_forward else (edge.stop, edge.start)

    def _arc(self, half: Half, start: int, stop: int) -> WorkspaceArc:
        edge = self.found.edges[half.edge]
        curve = self.found.curves[edge.curve]
        if isinstance(curve, Circle):
            return WorkspaceArc(curve.name, start, stop, half.is_forward)
        with ctx.workprec(_PLACE_BITS):
            x, y = (_near(z) for z in self.found.middle(edge, _PLACE_BITS))
        return WorkspaceArc(curve.name, start, stop, None, (x, y))

    def _bare(self, edge: Edge) -> WorkspaceArc:
        """An edge of a circle that bounds no region."""
        whole = len(self.found.vertices[edge.start].on) == 1
        start, stop = (None, None) if whole else (edge.start, edge.stop)
        return WorkspaceArc(self.found.curves[edge.curve].name, start, stop, ccw=True)

    def _vertex(self, k: int) -> WorkspaceVertex:
        vertex = self.found.vertices[k]
        conic = next((curve for curve in self.found.curves if isinstance(curve, Conic)), None)
        one, zero = self.orientation.tower.number(1), self.orientation.tower.number(0)
        x = coordinate_text(vertex.point, (one, zero), zero, self.digits, conic)
        y = coordinate_text(vertex.point, (zero, one), zero, self.digits, conic)
        names = [name for n in sorted(vertex.on) for name in self.found.curves[n].name.split()]
        return WorkspaceVertex(x, y, tuple(dict.fromkeys(names)), self._b1(vertex.point, conic))

    def _b1(self, point: Point, conic: Conic | None) -> tuple[str, str] | None:
        """B1 in the article's frame: p̄ (place + R b₁ − A₁), p being the direction of its x-axis."""
        own = self.orientation
        if not self._is_given:
            return None
        (p, q), (r, s), (u, v) = own.axis, own.arms[0], own.base[0]
        x, y = r - u, s - v
        return (
            coordinate_text(point, (p, q), p * x + q * y, self.digits, conic),
            coordinate_text(point, (-q, p), p * y - q * x, self.digits, conic),
        )


def alpha_text(orientation: Orientation, phi: Fraction | None, digits: int) -> str:
    """α in degrees, correctly rounded, in (−180, 180]; ``phi`` is the same angle, if that is known."""
    if phi is not None:
        turn = -((180 - phi) % 360 - 180)
        return round_fraction(turn, digits)
    c, s = orientation.alpha
    if s.is_zero:
        return round_fraction(Fraction(0 if c.sign > 0 else 180), digits)
    text = rounded(lambda bits: direction(c.ball(bits), s.ball(bits)), lambda _: False, digits)
    return angle_text(text)


def _near(x: arb) -> str:
    """A coordinate of a point for drawing, to 15 digits; 0 if that is no further than balls can tell."""
    return round_ball(x, MIN_DIGITS) or (
        "0" if x.contains(0) else round_ball(arb(x.mid()), MIN_DIGITS) or "0"
    )


def _renamed(arc: WorkspaceArc, names: Mapping[int, int]) -> WorkspaceArc:
    """An arc whose ends have the numbers of the document."""
    ends = (None if end is None else names[end] for end in (arc.start, arc.stop))
    start, stop = ends
    return WorkspaceArc(arc.on, start, stop, arc.ccw, arc.through)


def _arcs(regions: Sequence[WorkspaceRegion]) -> list[WorkspaceArc]:
    return [arc for region in regions for loop in region.boundary for arc in loop]


def _ends(arcs: Sequence[WorkspaceArc]) -> set[int]:
    return {end for arc in arcs for end in (arc.start, arc.stop) if end is not None}


def _renamed_region(region: WorkspaceRegion, names: Mapping[int, int]) -> WorkspaceRegion:
    boundary = tuple(tuple(_renamed(arc, names) for arc in loop) for loop in region.boundary)
    return WorkspaceRegion(region.sign, region.area, boundary)


def _corner(found: Arrangement, face: Face) -> tuple[float, float]:
    """A place that tells apart regions of one area: of the vertices of its outer loop the left-most one."""
    edges = [found.edges[half.edge] for half in face.loops[0]]
    places = [found.vertices[edge.start].point.ball(_PLACE_BITS) for edge in edges]
    return min((float(f"{float(x):.9g}"), float(f"{float(y):.9g}")) for x, y in places)
