"""The ends of a path, poses of joint vectors or at given angles, and why two poses have no path."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cached_property, partial

from rpr_solver.verify.arcs import Forms, Place, directions
from rpr_solver.verify.bottlenecks import BITS, Bottlenecks
from rpr_solver.verify.chart import value_at
from rpr_solver.verify.claims import Claim, ClaimStatus, Finding, OpenError, finding, judged, worked
from rpr_solver.verify.core.intervals import Interval, degrees, radians
from rpr_solver.verify.core.krawczyk import Box, Equations, Pair, common_on_axis, enclosed, value, zero_near
from rpr_solver.verify.core.numbers import Printed, bits_of, first_wrong
from rpr_solver.verify.core.reader import Record, Unread
from rpr_solver.verify.core.schema import Document
from rpr_solver.verify.core.system import Surface, at_length, less
from rpr_solver.verify.poses import Closure, Found
from rpr_solver.verify.topology import Cell, Classes, Topology, joined_aspects

_SPARE_BITS = 96
ENDS = ("from", "to")


class PathEnds:
    """The ends of a path, and what follows from a pose."""

    def __init__(self, document: Document) -> None:
        self.members = document.members
        self.surface = Surface(document.geometry, document.fixed)
        self.forms = Forms(self.surface)
        self.names = "alpha_deg", f"theta{document.fixed}_deg"

    @cached_property
    def bits(self) -> int:
        """Bits well below the last printed digit."""
        rows = [*self.members["samples"], *(self.members[end] for end in ENDS)]
        numbers = (x for row in rows for x in row.values() if isinstance(x, Printed))
        return bits_of(numbers, _SPARE_BITS) + self.forms.bits

    def lengths(self, end: str) -> Record:
        """What has the leg lengths of an end."""
        own: Record = self.members[end]
        return own if "l1" in own else self.members

    def is_given(self, end: str) -> bool:
        """Whether a pose is given by its angles."""
        return self.members[end]["pose"] is None

    def scaled(self, end: str) -> Fraction:
        """The scaled length of the fixed leg at an end."""
        length: Fraction = self.lengths(end)[f"l{self.surface.fixed}"]
        return length * self.surface.unit

    def what(self, end: str) -> str:
        """The claim about an end."""
        pose = self.members[end]["pose"]
        return (
            "the pose at these angles has these lengths"
            if pose is None
            else f"it is pose {pose}, with these digits"
        )

    @cached_property
    def boxes(self) -> dict[str, Box | None]:
        """The proved boxes of the ends that are poses of joint vectors."""
        return {end: self._isolated(end) for end in ENDS if not self.is_given(end)}

    def equations(self, end: str) -> Equations:
        """The free legs have the lengths of an end."""
        lengths, unit = self.lengths(end), self.surface.unit
        first, second = (
            at_length(less(leg.squared, (lengths[f"l{leg.number}"] * unit) ** 2), self.scaled(end))
            for leg in self.surface.legs
        )
        return Equations.of(first, second, self.surface.ring.radicand)

    def _isolated(self, end: str) -> Box | None:
        alpha, theta = (radians(self.members[end][name].value, self.bits) for name in self.names)
        return zero_near(self.equations(end), alpha, theta, self.bits)

    def place(self, end: str) -> Place:
        """An end as its angles are printed, without turns.

        Raises:
            OpenError: it is not known.
        """
        length = Interval.of(self.scaled(end), self.bits)
        if self.is_given(end):
            alpha, theta = (Interval.of(self.members[end][name].value, self.bits) for name in self.names)
            return alpha, theta, length
        box = self.boxes[end]
        if box is None:
            raise OpenError(f"the pose {end} is not proved")
        alpha, theta = (degrees(x).at(self.bits) for x in (box.alpha, box.theta))
        return alpha, theta, length

    def end(self, end: str) -> Finding:
        """Whether an end is the pose that it is said to be."""
        own: Record = self.members[end]
        if self.is_given(end):
            values = self.lengths_at(self.place(end))
            rounded = [own[f"l{leg}"].rounds(values[f"l{leg}"]) for leg in self.surface.free]
            if False in rounded:
                # the angles may be rounded ones
                wide = self.lengths_at(self.wide(end))
                if any(own[f"l{leg}"].rounds(wide[f"l{leg}"]) is False for leg in self.surface.free):
                    return ClaimStatus.REFUSED, "a leg has another length there"
            if not all(rounded):
                raise OpenError("the lengths are not those at exactly these angles")
            return ClaimStatus.PROVED, "the legs at exactly these angles"
        box = self.boxes[end]
        if box is None:
            return ClaimStatus.REFUSED, "no pose of the lengths is proved near these angles"
        values = dict(zip(self.names, map(degrees, (box.alpha, box.theta)), strict=True))

        def vanishes(name: str) -> bool:
            return common_on_axis(self.equations(end), box, theta=name != self.names[0])

        if wrong := first_wrong(own, values, vanishes):
            return ClaimStatus.REFUSED, f"the pose near these angles has another {wrong}"
        number = self._number(end, box)
        return finding(
            number == own["pose"], "a proved zero of the closure equations", f"it is pose {number}"
        )

    def wide(self, end: str) -> Place:
        """All angles that round to those of an end."""
        own, length = self.members[end], Interval.of(self.scaled(end), self.bits)
        alpha, theta = (Interval.of(own[name].value, self.bits, own[name].half) for name in self.names)
        return alpha, theta, length

    def _number(self, end: str, box: Box) -> int:
        """The number of a pose among all of its joint vector, by α, then θ1."""
        fixed, lengths = self.surface.fixed, [self.lengths(end)[f"l{leg}"] for leg in (1, 2, 3)]
        closure = Closure.of(self.surface.geometry, (lengths[0] ** 2, lengths[1] ** 2, lengths[2] ** 2))
        found, doubt = closure.found(self.bits)
        if doubt:
            raise OpenError(doubt)
        here = box.directions
        length = Interval.of(lengths[fixed - 1] * closure.unit, here.bits)
        point = [x * length for x in here.theta]
        if fixed > 1:  # the leg is B1 and v
            point = [x - here.value(p) for x, p in zip(point, closure.vectors[fixed - 2], strict=True)]
        near = *here.alpha, *point
        own = [k for k, x in enumerate(found) if all(map(Interval.meets, near, (*x.alpha, *x.point)))]
        if len(own) != 1:
            raise OpenError("it is not decided which of the poses it is")
        return 1 + len([x for k, x in enumerate(found) if k != own[0] and _is_before(x, found[own[0]])])

    def lengths_at(self, at: Place) -> dict[str, Interval]:
        """L1, L2 and L3 in a box."""
        here, unit = directions(at, self.surface.ring.radicand), Interval.of(self.surface.unit, at[0].bits)
        found = {f"l{self.surface.fixed}": at[2].over(unit)}
        for leg in self.surface.legs:
            square = value(here, leg.squared, at[2])
            if square.sign <= 0:
                raise OpenError("a leg may be closed")
            found[f"l{leg.number}"] = square.root().over(unit)
        return found

    def singular(self, at: Place) -> Interval:
        """J / L in a box."""
        return value(directions(at, self.surface.ring.radicand), self.forms.functions[0], at[2])


def _is_before(one: Found, other: Found) -> bool:
    """Whether a pose comes before another one, by α, then θ1.

    Raises:
        OpenError: it is not decided.
    """
    if one.root is other.root:  # two poses with one α
        gap = _angle(one.point) - _angle(other.point)
    elif -1 in (one.root.axis, other.root.axis):  # 180° comes last
        return other.root.axis == -1
    else:
        gap = _angle(one.alpha) - _angle(other.alpha)
    if not gap.sign:
        raise OpenError("it is not decided which of the poses comes first")
    return gap.sign < 0


def _angle(vector: Pair) -> Interval:
    """The angle of a vector, less than 180° either way.

    Raises:
        OpenError: it may be 180°.
    """
    if vector[0].sign <= 0 and not vector[1].sign:
        raise OpenError("an angle may be 180 degrees")
    return enclosed(vector)


def closed(ends: PathEnds) -> Finding:
    """Whether it is said rightly that both ends have the same lengths."""
    says = ends.members["closed"]
    if "l1" in ends.members:
        return finding(says, "both ends have the same lengths", "both ends have the same lengths")
    if any(map(ends.is_given, ENDS)):
        legs = [ends.lengths_at(ends.place(end)).values() for end in ENDS]
        if all(x.meets(y) for x, y in zip(*legs, strict=True)):
            raise OpenError("the lengths of both ends are not told apart")
        differ = True
    else:
        first, second = (ends.lengths(end) for end in ENDS)
        differ = any(first[name] != second[name] for name in ("l1", "l2", "l3"))
    return finding(says != differ, "by the lengths of both ends", "the lengths of both ends say otherwise")


def bound_claims(ends: PathEnds) -> Iterator[Claim]:
    """The claim of the upper bound of the clearance, if there is one."""
    clearance = ends.members.get("clearance")
    if clearance is None or clearance["bound"] is None:
        return
    at, claim = "/clearance/bound", "no path between these poses has a greater clearance"
    if not isinstance(clearance["proved"], Unread) and clearance["bound"] < clearance["proved"]:
        yield Claim(at, claim, ClaimStatus.REFUSED, "this path has a greater one")
        return
    yield worked(at, claim, partial(_barred, ends, clearance["bound"]))


def _barred(ends: PathEnds, most: Fraction) -> Finding:
    """Whether no path between the ends, the fixed leg being held, has a greater clearance."""
    places = [ends.place(end) for end in ENDS]
    sign, other = (ends.singular(at).sign for at in places)
    if ends.members["between"] is not None or ends.scaled(ENDS[0]) != ends.scaled(ENDS[1]):
        raise OpenError("it is not found anew while the fixed leg varies")
    if not sign or sign != other:
        raise OpenError("J is not proved to have one sign at both poses")
    return Bottlenecks(ends.forms, places[0][2].at(BITS), sign, most).bar(places)


def _too_narrow(ends: PathEnds, bounds: Sequence[Claim]) -> Finding:
    """Whether what was asked for is beyond the bound, by the claim of this."""
    if not bounds or ends.members["clearance"]["asked"] == "best":
        return ClaimStatus.REFUSED, "no clearance is asked for, or has no bound"
    if ends.members["clearance"]["bound"] >= ends.members["clearance"]["asked"]:
        return ClaimStatus.REFUSED, "what is asked for is not beyond the bound"
    if not bounds[0].established:
        raise OpenError("the bound of the clearance is not proved")
    return ClaimStatus.PROVED, "by the bound of the clearance"


def obstacle_claims(ends: PathEnds) -> Iterator[Claim]:
    """Why there is no path."""
    obstacle, between, at = ends.members["obstacle"], ends.members["between"], "/obstacle"
    right = ends.members["connected"] is (None if obstacle == "undecided" else False)
    yield judged("/connected", "it is null if undecided, and else false", right, "as it is")
    claim, bounds = f"there is no path: {obstacle}", [*bound_claims(ends)]
    if obstacle == "opposite-signs":
        yield worked(at, claim, partial(_opposite, ends))
    elif obstacle == "too-narrow":
        yield worked(at, claim, partial(_too_narrow, ends, bounds))
    elif obstacle == "outside-limits":
        yield worked(at, claim, partial(_outside, ends))
    elif obstacle == "other-aspect":
        span = [ends.scaled(end) for end in ENDS] if between is None else _scaled(ends, between)
        yield worked(at, claim, partial(_joined, ends, span, says=False))
    elif obstacle == "undecided":
        claim = "it says neither that there is a path nor that there is none"
        yield judged(at, claim, ends.members["connected"] is None, "as it is")
    else:
        reason = "what limits or a clearance leave of aspects is not found anew"
        yield Claim(at, claim, ClaimStatus.NOT_CHECKED, reason)
    yield from bounds
    joining, at = ends.members["connecting_range"], "/connecting_range"
    if joining is not None:
        yield worked(at, "there is a path in this range", partial(_connecting, ends, joining))


def _connecting(ends: PathEnds, joining: Record) -> Finding:
    if ends.members["limits"] or ends.members.get("clearance"):
        raise OpenError("a path within limits or with a clearance is not sought")
    return _joined(ends, _scaled(ends, joining), says=True)


def _scaled(ends: PathEnds, span: Record) -> list[Fraction]:
    return [span[name] * ends.surface.unit for name in ENDS]


def _opposite(ends: PathEnds) -> Finding:
    first, second = (ends.singular(ends.place(end)).sign for end in ENDS)
    if not first or not second:
        raise OpenError("a sign of J is not decided")
    return finding(first != second, "J has different signs at both poses", "J has one sign at both poses")


def _joined(ends: PathEnds, span: Sequence[Fraction], *, says: bool) -> Finding:
    """Whether both ends are in one aspect, or not, as is said: of a slice, or while the fixed leg varies."""
    unit, own, lengths = ends.surface.unit, [ends.scaled(end) for end in ENDS], sorted(set(span))
    if any(not lengths[0] <= x <= lengths[-1] for x in own):
        return ClaimStatus.REFUSED, "a length of the fixed leg at an end is beyond its range"
    slices, classes = joined_aspects([ends.surface.at(x / unit) for x in lengths])
    first, second = (_aspect(ends, slices, lengths, classes, ends.place(end)) for end in ENDS)
    wrong = "both are in one aspect" if first == second else "both are in different aspects"
    return finding((first == second) is says, "gaps between arcs, joined through the lines", wrong)


def _aspect(
    ends: PathEnds,
    slices: Sequence[Topology],
    lengths: Sequence[Fraction],
    classes: Classes[tuple[int, Cell]],
    at: Place,
) -> tuple[int, Cell]:
    """The aspect of a pose: J has its sign in one of the slices, too, as J/L is linear in the length."""
    sign = ends.singular(at).sign
    for n, (own, length) in enumerate(zip(slices, lengths, strict=True)):
        there = at[0], at[1], Interval.of(length, at[2].bits)
        if sign and ends.singular(there).sign == sign:
            return classes.root((n, _gap(own, ends, there)))
    raise OpenError("a pose is not placed between arcs of the singular curve")


def _gap(topology: Topology, ends: PathEnds, at: Place) -> Cell:
    """The gap between arcs of J = 0 in which a pose lies: J is not 0 in all of its box in the chart."""
    here = directions(at, ends.surface.ring.radicand)
    try:
        t, u = topology.chart.half_tangents(here.alpha, here.theta)
    except ZeroDivisionError:
        raise OpenError("a pose is at the edge of the chart") from None
    slab = topology.slab_of(u)
    if slab is None or not value_at(topology.chart.values(u, inverted=False), t).sign:
        raise OpenError("a pose is not placed between arcs of the singular curve")
    return slab, (topology.chart.count_below(t.middle, u.middle) - 1) % max(topology.arcs[slab], 1)


def _outside(ends: PathEnds) -> Finding:
    limits: Record = ends.members["limits"] or {}
    for end in ENDS:
        # those that are printed of a given pose are rounded
        lengths = ends.lengths_at(ends.place(end)) if ends.is_given(end) else ends.lengths(end)
        for name, limit in limits.items():
            if any(_side(lengths[name], limit[bound]) == sign for bound, sign in (("min", -1), ("max", 1))):
                return ClaimStatus.PROVED, "a length of an end is beyond a limit"
    return ClaimStatus.REFUSED, "no length of an end is proved to be beyond a limit"


def _side(length: Fraction | Interval, bound: Fraction | None) -> int:
    """The sign of a length less a bound; 0 if there is none, or it is open."""
    if bound is None:
        return 0
    if isinstance(length, Fraction):
        return (length > bound) - (length < bound)
    return (length - Interval.of(bound, length.bits)).sign
