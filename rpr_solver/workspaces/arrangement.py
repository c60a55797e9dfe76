"""The arrangement of circles and the singular conic in the plane, and the regions of allowed places in it.

Every common point of two curves is a *vertex*, with all curves that pass through it. Between neighbouring
vertices of a curve lies an *edge*, on which no other curve is met: what holds in its middle holds all along.
An edge of a circle bounds the allowed places if all other limits hold there; an edge of the conic divides
them. At a vertex the edges have an order, by their directions; where curves are tangent, by the side of one
on which the other one is. Who walks along edges, a region at the left, and turns left as sharply as possible
at each vertex, comes back: each region has one loop outside, and one for each hole.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import combinations, pairwise
from math import atan2

from flint import arb, ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.precision import precisions
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.lengths import Bounds
from rpr_solver.workspaces.conic import ConicKind, SingularConic
from rpr_solver.workspaces.curves import (
    Circle,
    Conic,
    Curve,
    Line,
    Pair,
    Place,
    Point,
    Quartic,
    Root,
    evaluated,
    gradient,
    intersections,
    quadratic,
    unit_vectors,
)
from rpr_solver.workspaces.orientation import Orientation
from rpr_solver.workspaces.tower import Number, Open

_FIRST_BITS = 128
_GREATEST_BITS = 1 << 14
"""What is equal is found exactly; what differs and is open here would differ by 10 to the power of −4,900."""


@dataclass(frozen=True, eq=False)
class Vertex:
    """A point of the arrangement.

    Attributes:
        point: the point.
        on: the numbers of the curves that pass through it; of one alone, if it only divides this.
    """

    point: Point
    on: frozenset[int]


@dataclass(frozen=True, eq=False)
class Edge:
    """A piece of a curve between two vertices, traversed counter-clockwise on a circle.

    Attributes:
        curve: the number of the curve.
        start, stop: the numbers of its ends.
    """

    curve: int
    start: int
    stop: int

    @property
    def is_closed(self) -> bool:
        """Whether it is a whole curve."""
        return self.start == self.stop


@dataclass(frozen=True)
class Half:
    """An edge with a direction.

    Attributes:
        edge: the number of the edge.
        is_forward: whether it is traversed as the edge says.
    """

    edge: int
    is_forward: bool

    @property
    def twin(self) -> Half:
        """The same edge, the other way."""
        return Half(self.edge, not self.is_forward)


Loop = tuple[Half, ...]


@dataclass(frozen=True)
class Face:
    """A connected region of allowed places without a singular one.

    Attributes:
        sign: that of J; 0 where J vanishes everywhere.
        loops: the boundary, the region at its left: the outer loop first, then holes.
    """

    sign: int
    loops: tuple[Loop, ...]


@dataclass(frozen=True, eq=False)
class Arrangement:
    """The curves of an orientation within limits, their vertices, and the regions of allowed places.

    Attributes:
        conic: the singular conic.
        curves: the circles, then the conic or its lines.
        vertices: the common points, and others that only divide a closed curve.
        edges: those that bound regions or divide them.
        faces: the regions.
        isolated: the numbers of allowed vertices that no region touches.
        thin: edges of circles that are allowed, with no allowed place on either side.
    """

    conic: SingularConic
    curves: tuple[Curve, ...]
    vertices: tuple[Vertex, ...]
    edges: tuple[Edge, ...]
    faces: tuple[Face, ...]
    isolated: tuple[int, ...]
    thin: tuple[Edge, ...]

    def area(self, face: Face, bits: int) -> arb:
        """The area of a region."""
        view = _View(self.conic, self.curves, self.vertices, bits)
        with ctx.workprec(bits):
            return sum((view.loop_area(self.edges, loop) for loop in face.loops), arb(0))

    def middle(self, edge: Edge, bits: int) -> Pair:
        """A point inside an edge."""
        view = _View(self.conic, self.curves, self.vertices, bits)
        with ctx.workprec(bits):
            return view.middle(edge)


def arrangement(orientation: Orientation, limits: Mapping[int, Bounds]) -> Arrangement:
    """The arrangement of an orientation, within limits of which at least one has a greatest length.

    Raises:
        Unproved: it could not be decided.
    """
    conic = SingularConic.of(orientation.conic)
    curves = _curves(orientation, limits, conic)
    vertices = _vertices(curves)
    vertices += [more for k in range(len(curves)) for more in _dividing(k, curves, vertices)]
    for bits in precisions(_FIRST_BITS, _GREATEST_BITS):
        try:
            with ctx.workprec(bits):
                return _Plane(conic, tuple(curves), tuple(vertices), bits).arrangement()
        except Open:
            continue
    raise Unproved("the regions of places at an orientation could not be decided")


# ---- curves and vertices, exact


def _curves(orientation: Orientation, limits: Mapping[int, Bounds], conic: SingularConic) -> list[Curve]:
    tower = conic.tower
    circles: list[Circle] = []
    for leg, bounds in sorted(limits.items()):
        x, y = (replace(z, tower=tower) for z in orientation.centres[leg - 1])
        for radius, is_max in zip(bounds, (False, True), strict=True):
            if not radius:
                continue
            k = _same_circle(circles, (x, y), radius)
            if k is None:
                circles.append(Circle((x, y), radius, ((leg, is_max),)))
            else:
                circles[k] = replace(circles[k], limits=(*circles[k].limits, (leg, is_max)))
    own: Sequence[Curve] = conic.lines
    if conic.kind in (ConicKind.ELLIPSE, ConicKind.CIRCLE, ConicKind.HYPERBOLA, ConicKind.PARABOLA):
        first = orientation.centres[0]
        on_it = Place(first[0], first[1], tower.number(1))
        free = (
            place
            for place in _more_points(conic.coefficients, on_it)
            if all(circle.value(place).sign for circle in circles)
        )
        own = [Conic(conic.coefficients, next(free))]
    return [*circles, *own]


def _same_circle(circles: Sequence[Circle], centre: tuple[Number, Number], radius: Fraction) -> int | None:
    for k, circle in enumerate(circles):
        if circle.radius == radius and all(
            (x - y).is_zero for x, y in zip(circle.centre, centre, strict=True)
        ):
            return k
    return None


def _more_points(conic: Sequence[Number], place: Place) -> Iterator[Place]:
    """Points of a conic, from one of them, in rational directions: without end."""
    a, b, c, *_ = conic
    g, h = Conic(tuple(conic), place).slopes(place)
    for t in _half_tangents():
        u, v = (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)
        square, slope = a * (u * u) + b * (u * v) + c * (v * v), g * u + h * v
        if square.sign and slope.sign:
            yield Place(place.x * square - slope * u, place.y * square - slope * v, place.w * square)


def _half_tangents() -> Iterator[Fraction]:
    """Half-tangents of directions, all over the half plane: without end."""
    k = 0
    while True:
        k += 1
        for n in range(1, 2 * k, 2):
            t = Fraction(n, 2 * k)
            if t.denominator == 2 * k:  # not had before
                yield t
                yield 1 / t


def _vertices(curves: Sequence[Curve]) -> list[Vertex]:
    vertices: list[Vertex] = []
    for a, b in combinations(range(len(curves)), 2):
        points = _common(curves[a], curves[b])
        known = [vertex.point for vertex in vertices if {a, b} <= vertex.on]
        taken = _matched(known, points) if known else set()
        for k, point in enumerate(points):
            if k in taken:
                continue
            on = {a, b}
            if isinstance(point, Place):
                on |= {n for n, curve in enumerate(curves) if n not in on and not curve.value(point).sign}
            vertices.append(Vertex(point, frozenset(on)))
    return vertices


def _common(one: Curve, other: Curve) -> Sequence[Point]:
    """The common points of two curves, the conic being the second."""
    if not isinstance(other, Conic):
        assert not isinstance(one, Conic)
        return intersections(one, other)
    assert isinstance(one, Circle)
    return Quartic.of(one, other.coefficients).points


def _matched(known: Sequence[Point], points: Sequence[Point]) -> set[int]:
    """The numbers of those points that are known, as all the known ones are among them."""
    for bits in precisions(_FIRST_BITS, _GREATEST_BITS):
        try:
            own = [point.ball(bits) for point in points]
            near = [[k for k, p in enumerate(own) if _overlap(p, point.ball(bits))] for point in known]
        except Open:
            continue
        if all(len(places) == 1 for places in near):
            return {places[0] for places in near}
    raise Unproved("common points of curves could not be told apart")


def _overlap(p: Pair, q: Pair) -> bool:
    return bool(p[0].overlaps(q[0]) and p[1].overlaps(q[1]))


def _dividing(k: int, curves: Sequence[Curve], vertices: Sequence[Vertex]) -> list[Vertex]:
    """Further points on a closed curve: a circle has at least one vertex, another conic two."""
    curve = curves[k]
    if isinstance(curve, Line):
        return []
    if isinstance(curve, Circle):
        x, y = curve.centre
        one, r = x.tower.number(1), curve.radius
        least = 1
        places: Iterator[Place] = (
            Place(x + r * ((1 - t * t) / (1 + t * t)), y + r * (2 * t / (1 + t * t)), one)
            for t in _half_tangents()
        )
    else:
        least = 2
        places = _more_points(curve.coefficients, curve.through)
    found: list[Vertex] = []
    while len(found) < least - sum(k in vertex.on for vertex in vertices):
        place = next(places)
        if all(n == k or other.value(place).sign for n, other in enumerate(curves)):
            found.append(Vertex(place, frozenset({k})))
    return found


# ---- what balls of one precision say


@dataclass(frozen=True, eq=False)
class _View:
    """The curves and vertices in balls of one precision."""

    conic: SingularConic
    curves: tuple[Curve, ...]
    vertices: tuple[Vertex, ...]
    bits: int

    @cached_property
    def places(self) -> list[Pair]:
        """The vertices."""
        return [vertex.point.ball(self.bits) for vertex in self.vertices]

    def mark(self, curve: Curve, p: Pair) -> Pair:
        """A vector that goes once round, counter-clockwise, as a point does on a circle or a conic."""
        if isinstance(curve, Conic):
            return _square(_less(p, curve.through.ball(self.bits)))
        return curve.gradient(p, self.bits)

    def gap(self, edge: Edge) -> arb:
        """The angle by which this vector turns along an edge."""
        curve = self.curves[edge.curve]
        if edge.is_closed:
            return 2 * arb.pi()
        return _turn(*(self.mark(curve, self.places[k]) for k in (edge.start, edge.stop)))

    def middle(self, edge: Edge) -> Pair:
        """A point inside an edge."""
        curve, start = self.curves[edge.curve], self.places[edge.start]
        if isinstance(curve, Line):
            x, y = (a + b for a, b in zip(start, self.places[edge.stop], strict=True))
            return x / 2, y / 2
        if isinstance(curve, Circle):
            u, v = _turned(curve.gradient(start, self.bits), self.gap(edge) / 2)
            x, y = (z.ball(self.bits) for z in curve.centre)
            return x + u, y + v
        direction = _turned(_less(start, curve.through.ball(self.bits)), self.gap(edge) / 4)
        return curve.in_direction(direction, self.bits)

    def along(self, edge: Edge) -> int:
        """1 if an edge is traversed with the greater values of its polynomial at the right, else −1."""
        curve = self.curves[edge.curve]
        if not isinstance(curve, Conic):
            return 1
        g, h = curve.gradient(self.places[edge.start], self.bits)
        # along (−h, g) the conic bends to the left exactly if its quadratic terms are positive there
        return self.bend(edge) * _sign(curve.quadratic((-h, g), self.bits))

    def bend(self, edge: Edge) -> int:
        """1 if an edge of the conic bends to the left, else −1."""
        start, stop = self.places[edge.start], self.places[edge.stop]
        return _sign(_cross(_less(self.middle(edge), start), _less(stop, start)))

    def heading(self, edge: Edge, half: Half) -> Pair:
        """The direction in which half an edge leaves its first vertex."""
        at = self.places[edge.start if half.is_forward else edge.stop]
        g, h = self.curves[edge.curve].gradient(at, self.bits)
        return (-h, g) if self.along(edge) * (1 if half.is_forward else -1) > 0 else (h, -g)

    def loop_area(self, edges: Sequence[Edge], loop: Loop) -> arb:
        """The area to the left of a loop, negative if it is a hole."""
        parts = (self.swept(edges[half.edge]) * (1 if half.is_forward else -1) for half in loop)
        return sum(parts, arb(0))

    def swept(self, edge: Edge) -> arb:
        """½ ∫ p × dp along an edge."""
        curve, start, stop = self.curves[edge.curve], self.places[edge.start], self.places[edge.stop]
        if isinstance(curve, Line):
            return _cross(start, stop) / 2
        if isinstance(curve, Circle):
            centre = tuple(z.ball(self.bits) for z in curve.centre)
            sector = ball_of(curve.radius) ** 2 * self.gap(edge)
            return (_cross(centre, _less(stop, start)) + sector) / 2
        if self.conic.kind is ConicKind.PARABOLA:
            return _cross(start, stop) / 2 + self._segment(curve, start, stop)
        a, b, c, d, e, _ = curve.balls(self.bits)
        over = 4 * a * c - b * b
        centre = (b * e - 2 * c * d) / over, (b * d - 2 * a * e) / over
        own = _cross(centre, _less(stop, start)) / 2
        level = -curve.at(centre, self.bits)
        u, v = _less(start, centre), _less(stop, centre)
        if self.conic.kind is ConicKind.HYPERBOLA:
            return own + _hyperbolic((a, b, c), level, u, v)
        return own + self._elliptic(edge, (a, b, c), level, (u, v))

    def _segment(self, curve: Conic, start: Pair, stop: Pair) -> arb:
        """The area between a parabola and its chord: two thirds of the triangle of the tangents."""
        (a, b), (c, d) = (curve.gradient(p, self.bits) for p in (start, stop))
        e, f = a * start[0] + b * start[1], c * stop[0] + d * stop[1]
        over = a * d - b * c
        tip = (e * d - b * f) / over, (a * f - e * c) / over
        return _cross(_less(tip, start), _less(stop, start)) / 3

    def _elliptic(self, edge: Edge, form: Sequence[arb], level: arb, ends: tuple[Pair, Pair]) -> arb:
        """½ ∫ u × du on the ellipse q(u) = level: that of the unit circle, to which √|q| maps it."""
        a, b, c = (x * _sign(form[0]) for x in form)
        root = a.sqrt()
        area = (a * c - b * b / 4).sqrt()

        def mapped(p: Pair) -> Pair:
            return root * p[0] + b / (2 * root) * p[1], area / root * p[1]

        u, v = map(mapped, ends)
        turn = _turn(u, v) if self.bend(edge) > 0 else -_turn(v, u)
        return abs(level) / area * turn / 2


def _hyperbolic(form: Sequence[arb], level: arb, u: Pair, v: Pair) -> arb:
    """½ ∫ u × du on the hyperbola q(u) = level, by ξ and η with q = a ξ η, 0 on its asymptotes."""
    for x, y in unit_vectors():
        c, s = arb(x.numerator) / x.denominator, arb(y.numerator) / y.denominator
        a, b = quadratic(form, (c, s)), _mixed(form, (c, s))
        if not a.contains(0):
            break
    else:
        raise Open
    root = (b * b - 4 * a * quadratic(form, (-s, c))).sqrt()

    def coordinate(p: Pair) -> arb:
        along, across = c * p[0] + s * p[1], c * p[1] - s * p[0]
        return along - (-b + root) / (2 * a) * across

    ratio = coordinate(v) / coordinate(u)
    # ξ η = level / a, and the area of coordinates is 1 / (difference of the slopes) of that of ξ and η
    return -(level / a) * ratio.log() / (root / a)


def _mixed(form: Sequence[arb], d: Pair) -> arb:
    """The coefficient of along · across in turned coordinates."""
    a, b, c = form
    x, y = d
    return 2 * (c - a) * x * y + b * (x * x - y * y)


# ---- the regions


@dataclass(frozen=True, eq=False)
class _Plane(_View):
    """The same, and what follows from it; an open question raises :class:`Open`."""

    def arrangement(self) -> Arrangement:
        """The edges that count, and the regions."""
        edges: list[Edge] = []
        thin: list[Edge] = []
        for k, curve in enumerate(self.curves):
            for edge in self._edges_of(k):
                allowed = self._is_allowed(self.middle(edge), {k})
                clash = isinstance(curve, Circle) and len({is_max for _, is_max in curve.limits}) > 1
                if allowed:
                    (thin if clash else edges).append(edge)
        order = self._order(edges)
        faces = self._faces(edges, self._loops(edges, order))
        used = {k for edge in (*edges, *thin) for k in (edge.start, edge.stop)}
        alone = [
            k
            for k, vertex in enumerate(self.vertices)
            if k not in used and len(vertex.on) > 1 and self._is_allowed(self.places[k], vertex.on)
        ]
        return Arrangement(
            self.conic, self.curves, self.vertices, tuple(edges), faces, tuple(alone), tuple(thin)
        )

    def _is_allowed(self, p: Pair, apart_from: set[int] | frozenset[int]) -> bool:
        """Whether a point keeps all limits, but for those of the circles on which it lies."""
        for k, curve in enumerate(self.curves):
            if isinstance(curve, Circle) and k not in apart_from:
                sign = _sign(curve.at(p, self.bits))
                if any((sign > 0) == is_max for _, is_max in curve.limits):
                    return False
        return True

    def _edges_of(self, k: int) -> list[Edge]:
        """All edges of a curve that are not infinite."""
        curve, own = self.curves[k], [n for n, vertex in enumerate(self.vertices) if k in vertex.on]
        if isinstance(curve, Line):
            return [Edge(k, a, b) for a, b in pairwise(self._along_line(curve, own))]
        marks: list[tuple[int | None, Pair]] = [(n, self.mark(curve, self.places[n])) for n in own]
        if isinstance(curve, Conic) and self.conic.kind in (ConicKind.HYPERBOLA, ConicKind.PARABOLA):
            marks += [(None, _square(d)) for d in self._asymptotes(curve)]
        order = [marks[n][0] for n in _cyclic([mark for _, mark in marks])]
        pairs = zip(order, [*order[1:], order[0]], strict=True)
        return [Edge(k, a, b) for a, b in pairs if a is not None and b is not None]

    def _along_line(self, line: Line, own: Sequence[int]) -> list[int]:
        """Vertices of a line in their order."""
        if not own:
            return []
        u, v = line.gradient(self.places[0], self.bits)
        at = {n: u * self.places[n][1] - v * self.places[n][0] for n in own}
        order = sorted(own, key=lambda n: float(at[n]))
        if not all(at[a] < at[b] for a, b in pairwise(order)):
            raise Open
        return order

    def _asymptotes(self, curve: Conic) -> list[Pair]:
        """The directions in which a hyperbola or a parabola is infinite."""
        exact_a, exact_b, exact_c, *_ = curve.coefficients
        a, b, c = (x.ball(self.bits) for x in (exact_a, exact_b, exact_c))
        if exact_a.is_zero:
            level = (arb(1), arb(0))
            return [level] if self.conic.kind is ConicKind.PARABOLA else [level, (-c, b)]
        if self.conic.kind is ConicKind.PARABOLA:
            return [(-b, 2 * a)]
        root = (b * b - 4 * a * c).sqrt()
        return [(root - b, 2 * a), (-root - b, 2 * a)]

    def _order(self, edges: Sequence[Edge]) -> dict[int, list[Half]]:
        """The halves of edges that leave each vertex, counter-clockwise."""
        leaving: dict[int, list[Half]] = {}
        for k, edge in enumerate(edges):
            leaving.setdefault(edge.start, []).append(Half(k, True))
            leaving.setdefault(edge.stop, []).append(Half(k, False))
        return {n: self._round(n, halves, edges) for n, halves in leaving.items()}

    def _round(self, n: int, halves: Sequence[Half], edges: Sequence[Edge]) -> list[Half]:
        bundles: list[list[Half]] = []
        headings: list[Pair] = []
        for half in halves:
            own = self.heading(edges[half.edge], half)
            for bundle, heading in zip(bundles, headings, strict=True):
                if _cross(heading, own).contains(0) and _dot(heading, own) > 0:
                    curves = edges[bundle[0].edge].curve, edges[half.edge].curve
                    if not self._are_tangent(self.vertices[n], *curves):
                        raise Open
                    bundle.append(half)
                    break
            else:
                bundles.append([half])
                headings.append(own)
        ordered = (bundles[k] for k in _cyclic(headings))
        return [half for bundle in ordered for half in self._fanned(bundle, edges)]

    def _are_tangent(self, vertex: Vertex, a: int, b: int) -> bool:
        if a == b:
            return False
        if isinstance(vertex.point, Root):
            return vertex.point.quartic.is_tangent(vertex.point.number)
        (p, q), (r, s) = (self.curves[k].slopes(vertex.point) for k in (a, b))
        return (p * s - q * r).is_zero

    def _fanned(self, bundle: Sequence[Half], edges: Sequence[Edge]) -> list[Half]:
        """Halves that leave in one direction, from right to left: by how many lie to the left of each."""

        def is_left(half: Half, other: Half) -> bool:
            """Whether the other half lies to the left of this one."""
            edge = edges[half.edge]
            left = -self.along(edge) * (1 if half.is_forward else -1)
            middle = self.middle(edges[other.edge])
            return _sign(self.curves[edge.curve].at(middle, self.bits)) == left

        return sorted(bundle, key=lambda half: -sum(is_left(half, x) for x in bundle if x is not half))

    def _loops(self, edges: Sequence[Edge], order: Mapping[int, Sequence[Half]]) -> list[Loop]:
        """The loops round regions, each with the region at its left."""
        todo: dict[Half, None] = {}
        for k, edge in enumerate(edges):
            curve = self.curves[edge.curve]
            for is_forward in (True, False):
                if not isinstance(curve, Circle) or curve.limits[0][1] == is_forward:
                    todo[Half(k, is_forward)] = None
        loops = []
        # each half belongs to one loop, which ends where it began, as each half has one that it follows
        while todo:
            loop, half = [], next(iter(todo))
            while half in todo:
                del todo[half]
                loop.append(half)
                edge = edges[half.edge]
                around = order[edge.stop if half.is_forward else edge.start]
                half = around[around.index(half.twin) - 1]
            if half != loop[0]:
                raise Unproved("the regions of places at an orientation do not close")
            loops.append(tuple(loop))
        return loops

    def _faces(self, edges: Sequence[Edge], loops: Sequence[Loop]) -> tuple[Face, ...]:
        outer: list[list[Loop]] = []
        holes: list[Loop] = []
        for loop in loops:
            if _sign(self.loop_area(edges, loop)) > 0:
                outer.append([loop])
            else:
                holes.append(loop)
        signs = [self._sign_left(edges[face[0][0].edge], face[0][0]) for face in outer]
        for hole in holes:
            edge = edges[hole[0].edge]
            sign = self._sign_left(edge, hole[0])
            round_it = [k for k, own in enumerate(signs) if own == sign]
            if len(round_it) > 1:
                # of several loops round the hole, the innermost is that of its region
                round_it = [k for k in round_it if self._is_inside(edge, edges, outer[k][0])]
                round_it.sort(key=lambda k: float(self.loop_area(edges, outer[k][0])))
            outer[round_it[0]].append(hole)
        return tuple(Face(sign, tuple(face)) for sign, face in zip(signs, outer, strict=True))

    def _sign_left(self, edge: Edge, half: Half) -> int:
        """The sign of J to the left of half an edge."""
        if self.conic.kind is ConicKind.PLANE:
            return 0
        curve, p = self.curves[edge.curve], self.middle(edge)
        balls = [x.ball(self.bits) for x in self.conic.coefficients]
        if isinstance(curve, Circle):
            return _sign(evaluated(balls, *p, arb(1)))
        if self.conic.kind is ConicKind.DOUBLE:
            a, _, c, *_ = self.conic.coefficients
            return a.sign or c.sign
        g, h = curve.gradient(p, self.bits)
        side = -self.along(edge) * (1 if half.is_forward else -1)
        return side * _sign(_dot(gradient(balls, p), (g, h)))

    def _is_inside(self, edge: Edge, edges: Sequence[Edge], loop: Loop) -> bool:
        """Whether the middle of an edge lies within a loop that it does not belong to."""
        p = self.middle(edge)
        for x, y in unit_vectors():
            d = arb(x.numerator) / x.denominator, arb(y.numerator) / y.denominator
            try:
                crossed = (self._crossings(edges[half.edge], p, d, edge.curve) for half in loop)
                return sum(crossed) % 2 == 1
            except Open:
                continue
        raise Open

    def _crossings(self, edge: Edge, p: Pair, d: Pair, own: int) -> int:
        """How often a ray from a point of a curve crosses an edge."""
        curve = self.curves[edge.curve]
        level = arb(0) if edge.curve == own else curve.at(p, self.bits)
        slope = _dot(curve.gradient(p, self.bits), d) * (2 if isinstance(curve, Circle) else 1)
        if isinstance(curve, Line):
            times = [-level / slope] if edge.curve != own else []
        else:
            square = curve.quadratic(d, self.bits) if isinstance(curve, Conic) else arb(1)
            if square.contains(0):
                raise Open
            if edge.curve == own:
                times = [-slope / square]
            else:
                discriminant = slope * slope - 4 * square * level
                if _sign(discriminant) < 0:
                    return 0
                root = discriminant.sqrt()
                times = [(-slope + root) / (2 * square), (-slope - root) / (2 * square)]
        ahead = [t for t in times if _sign(t) > 0]
        return sum(self._is_between(edge, (p[0] + t * d[0], p[1] + t * d[1])) for t in ahead)

    def _is_between(self, edge: Edge, p: Pair) -> bool:
        """Whether a point of a curve lies on an edge of it."""
        if edge.is_closed:
            return True
        curve, start, stop = self.curves[edge.curve], self.places[edge.start], self.places[edge.stop]
        if isinstance(curve, Line):
            chord = _less(stop, start)
            share = _dot(_less(p, start), chord)
            return _sign(share) > 0 and _sign(_dot(chord, chord) - share) > 0
        return _sign(self.gap(edge) - _turn(self.mark(curve, start), self.mark(curve, p))) > 0


def _sign(x: arb) -> int:
    if x > 0:
        return 1
    if x < 0:
        return -1
    raise Open


def _less(p: Pair, q: Pair) -> Pair:
    return p[0] - q[0], p[1] - q[1]


def _cross(p: Sequence[arb], q: Sequence[arb]) -> arb:
    return p[0] * q[1] - p[1] * q[0]


def _dot(p: Pair, q: Pair) -> arb:
    return p[0] * q[0] + p[1] * q[1]


def _square(p: Pair) -> Pair:
    return p[0] * p[0] - p[1] * p[1], 2 * p[0] * p[1]


def _turned(p: Pair, angle: arb) -> Pair:
    s, c = angle.sin_cos()
    return p[0] * c - p[1] * s, p[0] * s + p[1] * c


def _turn(p: Pair, q: Pair) -> arb:
    """The angle from one vector to another, counter-clockwise, between 0 and 2 π."""
    cross, dot = _cross(p, q), _dot(p, q)
    if cross > 0:
        return arb.atan2(cross, dot)
    if cross < 0:
        return 2 * arb.pi() + arb.atan2(cross, dot)
    if dot < 0:
        return arb.pi() + arb.atan2(-cross, -dot)
    raise Open


def _cyclic(vectors: Sequence[Pair]) -> list[int]:
    """The numbers of vectors in their counter-clockwise order."""
    order = sorted(range(len(vectors)), key=lambda k: atan2(float(vectors[k][1]), float(vectors[k][0])))
    if len(order) > 1:
        pairs = zip(order, [*order[1:], order[0]], strict=True)
        total = sum((_turn(vectors[a], vectors[b]) for a, b in pairs), arb(0))
        # the order is right exactly if it goes round once
        if not (total < 3 * arb.pi()):
            raise Open
    return order
