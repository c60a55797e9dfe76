"""The regions of the plane of the free legs, between parts of the image of J = 0; some may be too thin."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial
from itertools import pairwise
from math import isqrt

from rpr_solver.verify.arrangement import Arrangement
from rpr_solver.verify.claims import Claim, ClaimStatus, Finding, OpenError, finding, judged, worked
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.krawczyk import Box
from rpr_solver.verify.core.reader import Record, spend
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.folded import Picture, picture_of
from rpr_solver.verify.fronts import BITS, Front, Point, Vector
from rpr_solver.verify.images import OUTSIDE, Leaf, Side
from rpr_solver.verify.mirrored import shape_of
from rpr_solver.verify.pieces import Patches, traced
from rpr_solver.verify.poses import number_of_poses
from rpr_solver.verify.special_points import SpecialPoints
from rpr_solver.verify.tips import image_of_flat
from rpr_solver.verify.topology import Chain

_THIN, _MOST_LINES, _FEW_LINES, _LEAST_RADIUS = 4, 150, 12, 1 << 10


class Regions:
    """The regions of a document, and the image of J = 0, which has the special points that are found."""

    def __init__(self, points: SpecialPoints, members: Record) -> None:
        self.points, self.surface, self.length, self.members = points, points.surface, points.length, members

    @property
    def cusps(self) -> Sequence[Box]:
        """All cusps.

        Raises:
            OpenError: it is not proved that they are all.
        """
        cusps = self.points.cusps[1]
        if not cusps.complete:
            raise OpenError("it is not proved that these cusps are all")
        return cusps.boxes

    def claims(self) -> Iterator[Claim]:
        """Their claims."""
        regions: Sequence[Record] = self.members["regions"]
        for n, region in enumerate(regions):
            at, claim = f"/regions/{n}", f"{region['poses']} poses at its point"
            yield worked(f"{at}/poses", claim, partial(self._poses_at, region))
            claim = "the region is bounded" if region["bounded"] else "the region is unbounded"
            yield worked(f"{at}/bounded", claim, partial(self._bounded, n))
        right = [region["bounded"] for region in regions].count(False) == 1
        yield judged("/regions", "one region is unbounded", right, "that of all legs that are long enough")
        thin = self.members["thin_regions"]
        more = f", and at most {thin} without a point," if thin else ""
        yield worked("/regions", f"these {len(regions)} regions{more} are all", self._all_regions)
        if thin:
            size = f"{float(_THIN * self.members['tolerance']):.3g}"
            claim = f"no region without a point has room for a circle with a radius of {size} of the picture"
            yield worked("/thin_regions", claim, self._thin_regions)

    def _start(self, chain: Chain) -> Point:
        """A point of a component, on the arc that is longest in θ.

        Raises:
            OpenError: none is proved there.
        """
        topology, radicand = self.points.topology, self.points.slice.system.ring.radicand
        arc = max((step.arc for step in chain.steps), key=lambda arc: topology.width(arc[0])[1])
        alpha, theta = topology.middle_of(arc)
        point = self._front.near(int(alpha * (1 << BITS)), int(theta * (1 << BITS)))
        if point is not None:
            first, second = (
                Interval(x - point.error, x + point.error, BITS) for x in (point.alpha, point.theta)
            )
            here = Box(first, second, radicand).directions
            try:
                if topology.place(*topology.chart.half_tangents(here.alpha, here.theta)) == arc:
                    return point
            except ZeroDivisionError:
                pass
        raise OpenError("a component of the singular curve is too small for intervals")

    @cached_property
    def _placed(self) -> tuple[Arrangement, list[Side]] | OpenError:
        """The image of J = 0, and in which regions of the plane the points of the regions are."""
        try:
            arrangement = self.image()
            sides = [arrangement.region(point) for point in self.scaled_points()]
            arrangement.complete()
        except OpenError as error:
            return error
        return arrangement, [arrangement.root(side) for side in sides]

    @cached_property
    def _front(self) -> Front:
        return Front.of(self.points.slice.system, self.cusps)

    @cached_property
    def _folded(self) -> Picture | None:
        """The image where all poses come in pairs; None of other slices."""
        shape = shape_of(self.surface)
        return picture_of(shape, self.length) if shape and shape.area else None

    @property
    def shifts(self) -> tuple[int, int]:
        """The powers of 2 by which the squared legs of the image are divided."""
        if self._folded:
            return self._folded.shifts
        return self._front.legs[0].shift, self._front.legs[1].shift

    def image(self) -> Arrangement:
        """The image of J = 0.

        Raises:
            OpenError: it is not found.
        """
        if self._folded:
            return self._folded.arrangement()
        chains = list(self.points.topology.chains())
        open_ones = sum(bool(chain.ends and chain.steps) for chain in chains)
        shape = shape_of(self.surface)
        if shape and not shape.ratio and all(chain.ends for chain in chains):
            return image_of_flat(self._front, open_ones)
        if any(chain.ends for chain in chains):
            raise OpenError("the image of a singular curve that is not smooth is not found anew")
        return Arrangement([traced(self._front, self._start(chain)) for chain in chains], Patches())

    def scaled_points(self) -> Iterator[tuple[Fraction, Fraction]]:
        """The squares of the lengths of the regions' points, in the units of the waves."""
        unit = self.surface.unit if self._folded else self.points.slice.system.unit
        for region in self.members["regions"]:
            first, second = (
                (region["point"][f"l{leg}"] * unit) ** 2 / Fraction(2) ** shift
                for leg, shift in zip(self.surface.free, self.shifts, strict=True)
            )
            yield first, second

    @property
    def _sides(self) -> tuple[Arrangement, list[Side]]:
        """The same.

        Raises:
            OpenError: that is not found.
        """
        if isinstance(self._placed, OpenError):
            raise self._placed
        return self._placed

    def _all_regions(self) -> Finding:
        arrangement, sides = self._sides
        number, listed = arrangement.number, len(sides)
        if len(set(sides)) < listed:
            return ClaimStatus.REFUSED, "two of the points are in one region"
        right = listed <= number <= listed + self.members["thin_regions"]
        return finding(right, "by Euler's formula, each point being in another one", f"there are {number}")

    def _thin_regions(self) -> Finding:
        arrangement, sides = self._sides
        faces = {arrangement.root(side) for side in arrangement.sides} - set(sides)
        circle = _Circle(arrangement, self.shifts, _THIN * self.members["tolerance"])
        if any(circle.fits(face) for face in faces):
            return ClaimStatus.REFUSED, "a region without a point has room for one"
        if any(not circle.is_too_large(face) for face in faces):
            raise OpenError("a region without a point is not proved to be thin")
        return ClaimStatus.PROVED, "by lines through them in both directions"

    def _poses_at(self, region: Record) -> Finding:
        lengths = {**region["point"], f"l{self.surface.fixed}": self.length}
        squares = lengths["l1"] ** 2, lengths["l2"] ** 2, lengths["l3"] ** 2
        number = number_of_poses(self.surface.geometry, squares)
        if number is None:
            raise OpenError("two poses coalesce there, or are not told apart")
        return finding(number == region["poses"], "by Descartes' rule of signs", f"there are {number}")

    def _bounded(self, number: int) -> Finding:
        region: Record = self.members["regions"][number]
        far = any(
            _is_beyond_reach(self.surface, self.length, leg, region["point"][f"l{leg}"])
            for leg in self.surface.free
        )
        if far:
            reason = "at no pose a leg is as long as at its point, or longer"
            return finding(not region["bounded"], reason, "its point is beyond the reach of a leg")
        if region["bounded"] and region["poses"]:
            found = self._poses_at(region)
            return found if found[0] is not ClaimStatus.PROVED else (found[0], "there are no poses far away")
        arrangement, sides = self._sides
        right = (sides[number] == arrangement.root(OUTSIDE)) != region["bounded"]
        return finding(right, "by a line from its point to infinity")


@dataclass(frozen=True)
class _Circle:
    """A circle in the plane of lengths, for which regions have room or not; in units of 2^−32.

    Attributes:
        shifts: those of the waves of both legs.
        size: the radius, as a part of the larger side of the box round the image.
    """

    arrangement: Arrangement
    shifts: Sequence[int]
    size: Fraction

    @cached_property
    def radius(self) -> int:
        """The radius.

        Raises:
            OpenError: it is too small for these units.
        """
        ends = [leaf.piece.ends[0] for chain in self.arrangement.chains for leaf in chain]
        box = [
            self._length(max(x.image[k] - x.blur for x in ends), k)
            - self._length(min(x.image[k] + x.blur for x in ends), k)
            for k in (0, 1)
        ]
        radius = int(self.size * max(box))
        if radius < _LEAST_RADIUS:
            raise OpenError("the region is too small for intervals")
        return radius

    def _length(self, square: int, k: int) -> int:
        """A length, rounded down, from its square in the units of the waves."""
        up = self.shifts[k] + 64 - BITS
        return isqrt(max(square, 0) << up if up >= 0 else max(square, 0) >> -up)

    def _square(self, length: int, k: int) -> int:
        """The square of a length, rounded down by far less than a radius."""
        up = self.shifts[k] + 64 - BITS
        return length**2 >> up if up >= 0 else length**2 << -up

    def _box(self, leaf: Leaf) -> tuple[Vector, Vector]:
        """Bounds of both lengths on a leaf."""
        a, b, c, d = leaf.piece.box
        first, second = (
            (self._length(a, 0), self._length(b, 0) + 1),
            (self._length(c, 1), self._length(d, 1) + 1),
        )
        return first, second

    def _bounds(self, face: Side) -> tuple[Vector, Vector]:
        """Bounds of both lengths in a bounded region."""
        edges = [x for x in self.arrangement.sides if x != OUTSIDE and self.arrangement.root(x) == face]
        boxes = [self._box(leaf) for edge in edges for leaf in self.arrangement.span(edge)]
        first, second = ((min(x[k][0] for x in boxes), max(x[k][1] for x in boxes)) for k in (0, 1))
        return first, second

    def _chords(self, face: Side, k: int, places: Iterable[int]) -> Iterator[tuple[int, int, int]]:
        """The parts in a bounded region of lines on which one length has these values, by the other one."""
        for place in places:
            for x, y in pairwise(self.arrangement.line((1 - k, k), self._square(place, k))):
                if self.arrangement.root(y.before) == face:
                    low, high = (-y.high, -x.low) if k else (x.low, y.high)
                    yield place, self._length(low, 1 - k), self._length(high, 1 - k) + 2

    def fits(self, face: Side) -> bool:
        """Whether a place is found in a region where the circle fits, even larger by an eighth."""
        arrangement = self.arrangement
        if face == arrangement.root(OUTSIDE):
            return True
        for k, (low, high) in enumerate(self._bounds(face)):
            step = (high - low) // _FEW_LINES + 1
            chords = sorted(
                self._chords(face, k, range(low + step // 2, high, step)), key=lambda x: x[1] - x[2]
            )
            for place, first, last in chords[:_FEW_LINES]:
                middle = (first + last) // 2
                x, y = (middle, place) if k else (place, middle)
                squares = self._square(x, 0), self._square(y, 1)
                if (
                    self._is_long((place, first, last))
                    and self._is_clear((self._length(squares[0], 0), self._length(squares[1], 1)))
                    and arrangement.root(arrangement.region((_scaled(squares[0]), _scaled(squares[1]))))
                    == face
                ):
                    return True
        return False

    def _is_clear(self, middle: Vector) -> bool:
        """Whether it is proved that no point of the image is in the larger circle about a point."""
        leaves = [leaf for chain in self.arrangement.chains for leaf in chain]
        while leaves:
            spend(len(leaves), BITS)
            boxes = [(leaf, self._box(leaf)) for leaf in leaves]
            near = [x for x in boxes if 8 * _distance(x[1], middle) < 9 * self.radius + 100]
            if any(8 * max(b - a for a, b in box) < self.radius for _, box in near):
                return False
            leaves = [half for leaf, _ in near for half in leaf.halves]
        return True

    def is_too_large(self, face: Side) -> bool:
        """Whether it is proved that a bounded region has no room for the circle.

        Lines in both directions are 0.9 radii apart. A circle that fits meets one of each in more than
        1.7 radii, less than half a radius from its middle, so these chords cross each other.
        """
        step, bounds = self.radius * 9 // 10, self._bounds(face)
        if any(high - low > _MOST_LINES * self.radius for low, high in bounds):
            return False
        first, second = (
            [x for x in self._chords(face, k, range(low + step // 2, high, step)) if self._is_long(x)]
            for k, (low, high) in enumerate(bounds)
        )
        return not any(c <= x <= d and a <= y <= b for x, a, b in first for y, c, d in second)

    def _is_long(self, chord: tuple[int, int, int]) -> bool:
        return 10 * (chord[2] - chord[1]) > 17 * self.radius


def _scaled(square: int) -> Fraction:
    return Fraction(square, 1 << BITS)


def _distance(box: tuple[Vector, Vector], point: Vector) -> int:
    """The distance of a point from a box, rounded down."""
    x, y = (max(low - z, z - high, 0) for (low, high), z in zip(box, point, strict=True))
    return isqrt(x * x + y * y)


def _is_beyond_reach(surface: Surface, length: Fraction, leg: int, free: Fraction) -> bool:
    """Whether a free leg is longer than at any pose: than L + |base side| + |side of the platform|."""
    geometry, fixed = surface.geometry, surface.fixed
    (ax, ay), (px, py) = geometry.base[leg - 1], geometry.base[fixed - 1]
    base, side = (ax - px) ** 2 + (ay - py) ** 2, geometry.side_squared(leg, fixed)
    rest = free - length
    # √base + √side < rest
    square = rest * rest - base - side
    return rest > 0 and square > 0 and square * square > 4 * base * side
