"""The special points of J = 0 in a slice, found anew: cusps, turning points, and poses with a closed leg.

The cusps are those of the eliminant, the turning points those of the lines of the topology; a free leg is
closed at no pose or at two, as the lengths tell. Each is proved by Krawczyk's test, and placed on an arc.
Where J = 0 is not smooth, arcs meet in the topology; the pose is known exactly, with its kind.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from rpr_solver.verify.chart import ends, value_at
from rpr_solver.verify.claims import ClaimStatus, Finding, OpenError, finding
from rpr_solver.verify.core.intervals import Interval, degrees
from rpr_solver.verify.core.krawczyk import (
    Box,
    Equations,
    Pair,
    angle_of,
    common_on_axis,
    direction,
    zero_near,
)
from rpr_solver.verify.core.numbers import HALF_WAY, Printed
from rpr_solver.verify.core.reader import Record, spend
from rpr_solver.verify.core.roots import real_roots
from rpr_solver.verify.core.system import Surface, System, Trig, derivative
from rpr_solver.verify.cusps import Cusps, Located, Point, Slice
from rpr_solver.verify.landmarks import Event
from rpr_solver.verify.tables import exact_poses, slice_at
from rpr_solver.verify.topology import Cell, Chain, Topology, angles, is_nonzero, is_one, sides_of, span_of

BITS, _TRIES = 96, 5
_NODE = "it is not proved that J and its gradient are exactly 0 there, with this kind and these digits"
Name = tuple[str, int]
"""The kind of a special point, and its number among those that are found anew."""


@dataclass(frozen=True)
class Special:
    """A special point of J = 0: its proved box, the equations whose zero it is, the leg that is closed."""

    name: Name
    box: Box
    equations: Equations
    closed: int = 0

    def narrow(self, bits: int) -> Box:
        """Its box at more bits.

        Raises:
            OpenError: none is proved.
        """
        box = zero_near(self.equations, self.box.alpha, self.box.theta, bits)
        if box is None or not box.meets(self.box):
            raise OpenError("a special point is not isolated at the precision that is needed")
        return box

    def wrong(self, part: Slice, point: Point, *, doubted: bool = False) -> str | None:
        """The first printed number that is wrong; None if all are right."""
        box = self.box if point.bits <= BITS else self.narrow(point.bits + BITS)
        legs = (part.length(leg, box) for leg in part.system.legs)

        def vanishes(name: str) -> bool:
            if not name.endswith("_deg"):
                return name == f"l{self.closed}"
            return common_on_axis(self.equations, box, theta=name != "alpha_deg")

        values = [degrees(box.alpha), degrees(box.theta), *legs]
        return point.wrong(values, vanishes, doubted=doubted)


class SpecialPoints:
    """The special points of a slice; ``listed`` are those of a document, by their places."""

    def __init__(self, surface: Surface, length: Fraction, listed: Mapping[str, Record]) -> None:
        self.surface, self.length, self.listed = surface, length, listed

    @cached_property
    def slice(self) -> Slice:
        """Its equations."""
        return slice_at(self.surface, self.length)

    @cached_property
    def _topology(self) -> Topology | OpenError:
        try:
            return Topology.of(self.slice.system)
        except OpenError as error:
            return error

    @property
    def topology(self) -> Topology:
        """How J = 0 runs.

        Raises:
            OpenError: that is not found.
        """
        if isinstance(self._topology, OpenError):
            raise self._topology
        return self._topology

    @cached_property
    def cusps(self) -> tuple[dict[str, Located], Cusps]:
        """The listed cusps by their place, and all."""
        listed = dict(_of(self.listed, "cusp"))
        points = [Point.of(x, self.slice.system) for x in listed.values()]
        found, cusps = self.slice.located(points, BITS)
        return dict(zip(listed, found, strict=True)), cusps

    @cached_property
    def _turnings(self) -> dict[int, Special]:
        """The turning points by their meetings."""
        system, topology = self.slice.system, self.topology
        slope = derivative(system.singular, theta=False)
        equations = Equations.of(system.singular, slope, system.ring.radicand)
        closed = {_turning_at(topology, system, x): x.closed for x in self._closed}
        result = {}
        for n, (line, meeting) in enumerate(topology.meetings):
            if meeting.is_turning:
                alpha, theta = map(angle_of, angles(topology, line, meeting.t))
                box = isolated(equations, alpha, theta)
                # a zero of both lies on a line, and on each is one that is no other meeting
                if box is None or topology.line_of(_in_chart(topology, box)[1]) != line:
                    raise OpenError("a turning point is not isolated")
                result[n] = Special(("turning", n), box, equations, closed.get(n, 0))
        return result

    @cached_property
    def _nodes(self) -> dict[str, list[int]]:
        """The listed poses where J = 0 is not smooth, by their place: the meetings of all printed like one.

        The list is empty if they are not proved, or not told from others.
        """
        result: dict[str, list[int]] = {}
        known: dict[tuple[str, ...], list[int]] = {}
        for at, vertex in self.listed.items():
            if vertex["kind"] not in ("cusp", "turning", "closed-leg"):
                key = _printed(vertex)
                if key not in known:
                    poses = exact_poses(self.slice.system, vertex)
                    meetings = [_meeting(self.topology, pose) for pose in poses]
                    known[key] = [] if None in meetings else [x for x in meetings if x is not None]
                result[at] = known[key]
        return result

    @cached_property
    def found(self) -> dict[str, Special]:
        """The listed turning points and closed legs, each another one of those found here, by their place."""
        result: dict[str, Special] = {}
        for kind, all_of in (("turning", self._turnings.values), ("closed-leg", self._closed.copy)):
            listed = dict(_of(self.listed, kind))
            left = list(all_of()) if listed else []
            for at, vertex in listed.items():
                spend(8 * len(left))
                point = Point.of(vertex, self.slice.system)
                k = next((k for k, special in enumerate(left) if not special.wrong(self.slice, point)), None)
                if k is not None:
                    result[at] = left.pop(k)
        return result

    @cached_property
    def _closed(self) -> list[Special]:
        """The poses with a closed leg that are regular zeros of its components."""
        system, ring = self.slice.system, self.slice.system.ring
        result: list[Special] = []
        for leg in self.surface.free:
            equations = Equations.of(*closing(system, leg), ring.radicand)
            form = system.closed_lines(leg)
            (a, _), (b, _), (c, _) = form
            for root in real_roots(ring, form) if b * b > 4 * a * c else ():
                theta = direction(ring, form, root, 2 * BITS)
                box = isolated(equations, _closed_alpha(system, leg, theta), angle_of(theta))
                if box is None:
                    raise OpenError("a pose with a closed leg is not isolated")
                result.append(Special(("closed", len(result)), box, equations, leg))
        return result

    def judged(self, at: str) -> Finding:
        """Whether a listed point is another one of those found here, with its digits."""
        vertex = self.listed[at]
        if vertex["kind"] == "cusp":
            return self.cusps[0][at].finding
        if at in self._nodes:
            if not self._nodes[at]:
                if self.slice.excludes(Point.of(vertex, self.slice.system), self.cusps[1]):
                    return ClaimStatus.REFUSED, "a cusp is there, or J = E = 0 is excluded"
                raise OpenError(_NODE)
            return ClaimStatus.PROVED, "J and its gradient are exactly 0 there; its kind and digits are right"
        special, point = self.found.get(at), Point.of(vertex, self.slice.system)
        if special and special.wrong(self.slice, point, doubted=True):
            return ClaimStatus.CHECKED, HALF_WAY
        reason = f"it is none of the {vertex['kind']} points that are found anew, or listed twice"
        return finding(special is not None, "a proved box holds it, and each digit is right", reason)

    def name(self, at: str) -> Name | None:
        """Which point a listed one is, the first of all that are printed alike; None if it is none.

        Raises:
            OpenError: it is not proved to be one where J = 0 is not smooth.
        """
        if at in self._nodes and not self._nodes[at]:
            raise OpenError(_NODE)
        names = self._names_at(at)
        return self._first[names[0]] if names else None

    def _names_at(self, at: str) -> list[Name]:
        """The point that a listed one is, or all where J = 0 is not smooth that are printed like it."""
        if self.listed[at]["kind"] == "cusp":
            box = self.cusps[0][at].box
            return [] if box is None else [("cusp", self.cusps[1].boxes.index(box))]
        if at not in self._nodes:
            return [self.found[at].name] if at in self.found else []
        return [("node", number) for number in self._nodes[at]]

    @cached_property
    def _first(self) -> dict[Name, Name]:
        """Of each point that is listed the first of all that are printed alike: they are not told apart."""
        first: dict[tuple[str, ...], Name] = {}
        return {
            name: first.setdefault(_printed(vertex), name)
            for at, vertex in self.listed.items()
            for name in self._names_at(at)
        }

    @cached_property
    def _marks(self) -> dict[Cell, list[Name]]:
        """The cusps and the poses with a closed leg on each arc, in their order."""
        system = self.slice.system
        kernels = [Equations.of(system.singular, leg.kernel, system.ring.radicand) for leg in system.legs]
        points = [x for x in self._closed if _turning_at(self.topology, system, x) is None]
        for n, box in enumerate(self.cusps[1].boxes):
            zeros = (x for x in kernels if (y := isolated(x, box.alpha, box.theta)) and y.meets(box))
            points.append(Special(("cusp", n), box, next(zeros, kernels[0])))
        marks: dict[Cell, list[tuple[Interval, Name | None]]] = {}
        for special in points:
            cells, u = _placed(self.topology, special)
            for cell, name in zip(cells, (special.name, None), strict=False):
                others = marks.setdefault(cell, [])
                if any(u.meets(other) for other, _ in others):
                    raise OpenError("two special points of an arc are not told apart")
                others.append((u, name))
        for cell, found in marks.items():
            found.sort(key=lambda mark, cell=cell: self.topology.order(cell, mark[0]))  # type: ignore[misc]
        return {cell: [name for _, name in found if name] for cell, found in marks.items()}

    def of_chain(self, chain: Chain) -> list[Name]:
        """The special points of a strand in their order, with those at its ends; as ``name`` has them."""
        first, last = ([("node", n)] for n in chain.ends or (0, 0))
        names: list[Name] = [*first] if chain.ends else []
        for step in chain.steps:
            marks = self._marks.get(step.arc, [])
            names += marks if step.upwards else reversed(marks)
            if step.turning is not None:
                names.append(("turning", step.turning))
        names += last if chain.ends and chain.steps else []
        return [self._first.get(name, name) for name in names]


def _meeting(topology: Topology, pose: Event) -> int | None:
    """The meeting of arcs at a pose where J = 0 is not smooth; None if it is not told from others."""
    t, u = topology.chart.half_tangents(pose.directions.alpha, pose.directions.theta)
    line, meetings = topology.line_of(u), enumerate(topology.meetings)
    near = [n for n, (other, own) in meetings if other == line and own.t.at(t.bits).meets(t)]
    return near[0] if len(near) == 1 else None


def _turning_at(topology: Topology, system: System, special: Special) -> int | None:
    """The meeting of the turning point that a pose with a closed leg is; None if it is none."""
    try:
        t, u = _in_chart(topology, special.box)
    except ZeroDivisionError:  # arcs meet on no line at ∞
        return None
    line, form = topology.line_of(u), topology.chart.form_of(system.closed_lines(special.closed))
    for n, (number, own) in enumerate(topology.meetings):
        if number == line and own.is_turning and is_one(topology, number, own.t.at(t.bits), t, form):
            return n
    return None


def _printed(vertex: Record) -> tuple[str, ...]:
    """What is printed of a listed point: its kind, and its numbers."""
    return vertex["kind"], *(x.text for x in vertex.values() if isinstance(x, Printed))


def _of(listed: Mapping[str, Record], kind: str) -> Iterator[tuple[str, Record]]:
    return ((at, x) for at, x in listed.items() if x["kind"] == kind)


def _in_chart(topology: Topology, box: Box) -> tuple[Interval, Interval]:
    here = box.directions
    return topology.chart.half_tangents(here.alpha, here.theta)


def _placed(topology: Topology, special: Special) -> tuple[tuple[Cell, ...], Interval]:
    """The arc of a special point, and its u; the arcs before and after a line that cannot be told from it."""
    box, bits = special.box, 2 * BITS
    for k in range(_TRIES + 1):
        try:
            t, u = _in_chart(topology, box)
            if (cell := topology.place(t, u)) is not None:
                return (cell,), u
            if k == _TRIES and (cells := _crossing(topology, t, u)) is not None:
                return cells, u
        except ZeroDivisionError:
            pass
        if k < _TRIES:
            box, bits = special.narrow(bits), 2 * bits
    raise OpenError("a special point is not placed on an arc")


def _crossing(topology: Topology, t: Interval, u: Interval) -> tuple[Cell, Cell] | None:
    """The arcs after and before the line, one of several, that the arc of a point in a box crosses.

    On the box the slope of J along the line is not 0, so that one arc passes it from side to side.
    """
    number = topology.line_of(u)
    if number is None or len(topology.lines) == 1:
        return None
    low, high = ends(topology.lines[number].root)
    low, high = min(low, span_of(u)[0]), max(high, span_of(u)[1])
    wide = Interval.of((low + high) / 2, u.bits, high - low)
    root = Fraction(1, 1 << (wide.radius.denominator // wide.radius.numerator).bit_length() // 2)
    sides, values = sides_of(t, root), topology.chart.values(wide, inverted=False)
    if sides is None or topology.line_of(wide) is None or not is_nonzero(values, sides, t.bits):
        return None
    slope = [value.scaled(k) for k, value in enumerate(values)][1:]
    if not value_at(slope, Interval.of((sides[0] + sides[1]) / 2, t.bits, sides[1] - sides[0])).sign:
        return None
    below, above = (topology.chart.count_below(sides[0], x) for x in span_of(wide))
    return (number, above), ((number - 1) % len(topology.arcs), below)


def isolated(equations: Equations, alpha: Interval, theta: Interval) -> Box | None:
    """The zero near two angles, where others may be very near."""
    for times in (1, 2, 4):
        if (box := zero_near(equations, alpha, theta, times * BITS, (times - 1) * BITS)) is not None:
            return box
    return None


def _closed_alpha(system: System, leg: int, theta: Pair) -> Interval:
    """About the α of a pose with a closed leg, from θ: R(α) m = a − L e(θ)."""
    bits, (ax, ay) = theta[0].bits, system.base_side(leg)
    across, up = _side(system, leg)
    length = int(system.length * system.unit)
    x, y = (Interval.of(a, bits) - part.scaled(length) for a, part in zip((ax, ay), theta, strict=True))
    mx = Interval.of(across, bits)
    my = Interval.of(system.ring.radicand, bits).root().scaled(up)
    norm = mx * mx + my * my
    return angle_of(((x * mx + y * my).over(norm), (y * mx - x * my).over(norm)))


def _side(system: System, leg: int) -> tuple[int, int]:
    """From the platform's corner of the fixed leg to another for α = 0; y is a multiple of ω, or of 1."""
    geometry = system.surface.geometry
    zero = Fraction(0)
    corners = ((zero, zero), (geometry.d1, zero), (geometry.foot, geometry.height[0]))
    here, there = (corners[k - 1] for k in (system.fixed, leg))
    x, y = (int((b - a) * system.unit) for a, b in zip(here, there, strict=True))
    return x, y


def closing(system: System, leg: int) -> tuple[Trig, Trig]:
    """The components of a free leg, as trigonometric polynomials; its length is 0 where both are 0."""
    (ax, ay), (mx, my) = system.base_side(leg), _side(system, leg)
    rational = system.ring.radicand == 1
    across, up, down = (mx, 0), (my, 0) if rational else (0, my), (-my, 0) if rational else (0, -my)
    length = int(system.length * system.unit), 0
    one, cos_a, sin_a, cos_t, sin_t = (0, 0, 0, 0), (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)
    return (
        {one: (-ax, 0), cos_a: across, sin_a: down, cos_t: length},
        {one: (-ay, 0), cos_a: up, sin_a: across, sin_t: length},
    )
