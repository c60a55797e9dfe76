"""Assembly modes: the faces of the plane of the free legs, each with its proved number of poses.

The curve J = 0 bounds the part of the torus with J > 0, which lies on its left and is mapped to the plane
with its orientation. So the winding number of the curve's image about a joint vector is the number of its
poses with J > 0. As many have J < 0, since the map of a closed surface to the plane has degree 0. The number
is confirmed by the sextic of direct kinematics at a rational point of each face
(mathematics.md#poses-counted-by-windings).
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import chain, islice, pairwise
from math import floor, frexp, hypot, inf, ldexp, log10, pi
from typing import Any, NamedTuple

from rpr_solver.errors import SolverError
from rpr_solver.exact.modular import simple_and_finite
from rpr_solver.exact.rationals import exact_str
from rpr_solver.exact.real_roots import number_of_real_roots
from rpr_solver.model.fibre import DEGREE, Closure, fibre
from rpr_solver.model.float_slice import FloatSlice, drawn
from rpr_solver.model.joint_points import coordinate_names
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.notebook import counted, shortened
from rpr_solver.singular.arrangement import FINER_GRID, Face, Point, Polyline, faces
from rpr_solver.singular.neighbours import separated
from rpr_solver.singular.polygons import polygon_area
from rpr_solver.singular.tracing import FINEST

_LEVELS = (0.5, 0.27, 0.73, 0.13, 0.87, 0.38, 0.62)
_MANY_LEVELS = tuple((k + 0.5) / 128 for k in range(128))
_CLEAR = 1e-7
_ASIDE = 0.17
_MOST_ASIDE = 2
"""How many slices aside are tried."""
_GREATEST_EXPONENT = 300
"""Of the size of a picture, as a power of 2 or its inverse: doubles hold the squares."""
_MOST_PLACES = 290
"""Of decimals that a double holds as integers."""


@dataclass(frozen=True)
class Region:
    """A region of the plane of the free legs, in which the number of poses is constant.

    Attributes:
        poses: the number of real poses of each joint vector, half of them with J > 0.
        point: a joint vector in the region: the free legs' lengths, exact, at which the number is proved.
        rings: closed polylines of the free legs' lengths, in floats: the outer boundary first, then those of
            holes. The unbounded region has only holes.
        bounded: whether it is bounded.

    >>> from rpr_solver import EXAMPLES, singular_curves
    >>> [region.poses for region in singular_curves(EXAMPLES["innocenti"], "14.98").regions]
    [6, 4, 4, 2, 2, 2, 2, 0]
    >>> singular_curves(EXAMPLES["zein-flat"], 34).regions[0]
    <Region of 4 poses at (37.3, 10.3)>
    """

    poses: int
    point: tuple[Fraction, Fraction]
    rings: tuple[tuple[Point, ...], ...]
    bounded: bool

    def __repr__(self) -> str:
        place = ", ".join(shortened(exact_str(x)) for x in self.point)
        return (
            f"<Region of {counted(self.poses, 'pose')} at ({place}){'' if self.bounded else ', unbounded'}>"
        )

    def to_json(self, fixed_leg: int) -> dict[str, Any]:
        """The document's region object."""
        _, _, *names = coordinate_names(fixed_leg)
        return {
            "poses": self.poses,
            "bounded": self.bounded,
            "point": dict(zip(names, map(exact_str, self.point), strict=True)),
            "rings": [
                dict(zip(names, map(drawn, zip(*ring, strict=True)), strict=True)) for ring in self.rings
            ],
        }


@dataclass(frozen=True)
class Regions:
    """The regions of the plane of the free legs.

    Attributes:
        regions: by falling number of poses, then by falling area.
        thin: the number of further regions, narrower than the tolerance: faces of the drawing in which the
            number of poses is proved, and those that are points of the drawing.
    """

    regions: tuple[Region, ...]
    thin: int


@dataclass(frozen=True)
class Picture:
    """The image of the singular curves of a slice, with J > 0 on their left, in the user's unit.

    Attributes:
        slice_map: the integer model.
        floats: the slice in floats.
        length: of the fixed leg.
        curves: images of the strands, with their ends by name and the angles of their points.
        cusps: those among their points.
        least: regions that are points of the drawing.
        extent: the size of the picture.
        tolerance: the deviation of the curves, relative to it.
        exponent: the drawn curves, points and sizes are in the user's unit times 2 to this power.
    """

    slice_map: SliceMap
    floats: FloatSlice
    length: Fraction
    curves: Sequence[Polyline]
    cusps: Sequence[Point]
    least: Sequence[Point]
    extent: float
    tolerance: float
    exponent: int = 0

    def in_doubles(self, extent: float) -> Picture:
        """The same in a unit in which doubles hold the squares of lengths, for a picture of this extent.

        It is the user's but for a power of 2, by which no digits change.
        """
        exponent = frexp(extent)[1]
        if abs(exponent) <= _GREATEST_EXPONENT:
            return self
        return replace(
            self,
            floats=replace(self.floats, unit=ldexp(self.floats.unit, exponent)),
            curves=[replace(x, points=_scaled(x.points, -exponent)) for x in self.curves],
            cusps=_scaled(self.cusps, -exponent),
            least=_scaled(self.least, -exponent),
            extent=ldexp(self.extent, -exponent),
            exponent=exponent,
        )

    @property
    def finest(self) -> float:
        """The distance below which curves are not told apart."""
        return FINEST * self.extent

    def drawable(self) -> list[Polyline]:
        """The curves without repeated points; one whose image is a point joins its ends."""
        return list(_drawable(self.curves, self.finest))

    def separated(self) -> tuple[Sequence[Polyline], bool] | None:
        """The curves, finer where others are near, and whether they cross as often; None if they coincide."""
        return separated(self.floats, self.drawable(), self.extent)

    def poses(self, point: tuple[Fraction, Fraction]) -> int:
        """The number of poses of a joint vector, exactly."""
        return number_of_poses(self.slice_map, (self.length**2, point[0] ** 2, point[1] ** 2))

    def is_thin_region(self, face: Face) -> bool:
        """Whether a narrow face has, at a point in it, the number of poses of its winding.

        A sliver between parts of the curve that coincide has not: there the number changes by 4, or stays. A
        face too narrow for floats is one if it reaches from a cusp to another one, as that of lips or a
        swallowtail.
        """
        point, clearance = next(_inner_points(face, _LEVELS, self.exponent))
        if clearance < self.finest:
            tips = [tip for tip in self.cusps if _touches(face, [tip])]
            return any(hypot(x[0] - y[0], x[1] - y[1]) > self.finest for x, y in pairwise(tips))
        return self.poses(point) == 2 * face.winding


def regions_of(picture: Picture, aside: Iterable[Picture]) -> Regions:
    """The regions between the curves of a slice, proved.

    Args:
        picture: of the slice.
        aside: those of slices close by with the same topology. Where some faces of a drawing are no regions,
            since curves cross in it that do not, these are tried in turn.

    Raises:
        SolverError: a number of poses contradicts the winding number, or doubles do not tell points apart.
    """
    aside = (other.in_doubles(picture.extent) for other in aside)
    picture = picture.in_doubles(picture.extent)
    drawable = picture.drawable()
    if picture.curves and not drawable:
        raise SolverError("the curves are too small beside their distance from 0 for double precision")
    best = drawn = _Listed.of(picture, picture, faces(drawable))
    separate = picture.separated()
    if not drawn.others and (separate is None or separate[1]):
        return drawn.regions
    if separate is not None:
        best = _Listed.of(picture, picture, faces(separate[0], FINER_GRID))
    for other in islice(aside, _MOST_ASIDE if best.others else 0):
        separate = other.separated()
        if separate is None:
            break
        closer = _Listed.of(picture, other, faces(separate[0], FINER_GRID))
        best = min(best, closer, key=lambda listed: listed.others)
        if not best.others:
            break
    return replace(best.regions, regions=drawn.regions.regions) if drawn.is_alike(best) else best.regions


class _Listed(NamedTuple):
    """The regions of a drawing, its faces, how many others there are, and the exponent of its unit."""

    regions: Regions
    faces: Sequence[Face]
    others: int
    exponent: int

    @classmethod
    def of(cls, picture: Picture, own: Picture, found: Sequence[Face]) -> _Listed:
        """Those of a picture's slice, but thin ones as they are in the drawing's own."""
        proved = [(face, _region(picture, face, own.cusps)) for face in found]
        wide = [(face, region) for face, region in proved if region is not None]
        wide.sort(key=lambda x: (-x[1].poses, -abs(polygon_area(x[0].rings[0])) if x[0].bounded else 0.0))
        thin = [face for face, region in proved if region is None and own.is_thin_region(face)]
        missed = sum(not any(_touches(face, [place]) for face in thin) for place in own.least)
        regions = Regions(tuple(region for _, region in wide), len(thin) + missed)
        return cls(regions, found, len(found) - len(wide) - len(thin), own.exponent)

    def is_alike(self, closer: _Listed) -> bool:
        """Whether its regions are in different faces of a closer drawing that has as many."""
        regions = self.regions.regions
        homes = {_home(closer.faces, region, self.exponent) for region in regions}
        return len(homes) == len(regions) == len(closer.regions.regions)


def _home(found: Sequence[Face], region: Region, exponent: int) -> int:
    """The face that holds the point of a region; −1 for the unbounded one."""
    x, y = (ldexp(float(x), -exponent) for x in region.point)
    return next((k for k, face in enumerate(found) if face.bounded and face.holds((x, y))), -1)


def number_of_poses(slice_map: SliceMap, squares: Sequence[Fraction]) -> int:
    """The number of real poses, exactly, from the squared lengths of the fixed leg and of the free legs."""
    closure = Closure.of(slice_map, squares)
    if simple_and_finite(closure.sextic, DEGREE):
        return number_of_real_roots(closure.sextic)
    return len(fibre(closure, 15).poses)


def _region(picture: Picture, face: Face, cusps: Sequence[Point]) -> Region | None:
    """The region of a face; None if it is thin, except at cusps, near which curves are drawn finer.

    Several points are tried, since one may be special: the image of a whole component may be a point.
    """
    finest, tolerance = picture.finest, picture.tolerance * picture.extent
    exponent = picture.exponent
    points = _inner_points(face, _LEVELS, exponent)
    point, clearance = next(points)
    if (
        clearance < tolerance and abs(polygon_area(face.rings[0])) > pi * tolerance**2
    ):  # it may be wide elsewhere
        points = _inner_points(face, (*_LEVELS, *_MANY_LEVELS), exponent)
        point, clearance = next(points)
    if clearance < finest or (clearance < tolerance and not _touches(face, cusps)):
        return None
    wide = clearance > 2 * tolerance
    for place in chain((point,), (other for other, room in points if room > finest)):
        poses = picture.poses(place)
        if poses == 2 * face.winding:
            rings = tuple(_scaled(ring, exponent) for ring in face.rings)
            return Region(poses, place, rings, face.bounded)
    if wide:
        raise SolverError(
            "the regions could not be drawn: one has another number of poses than its boundary says"
        )
    return None


def _touches(face: Face, cusps: Sequence[Point]) -> bool:
    near = 1e-8 * max(abs(x) for point in face.rings[0] for x in point)
    return any(hypot(x - p, y - q) < near for p, q in cusps for x, y in face.rings[0])


def _drawable(curves: Sequence[Polyline], finest: float) -> Iterator[Polyline]:
    """The curves without repeated points; a curve whose image is a point joins its ends."""
    alias: dict[Hashable, Hashable] = {}

    def name(end: Hashable) -> Hashable:
        while end in alias:
            end = alias[end]
        return end

    kept = []
    for curve in curves:
        points, angles = [curve.points[0]], [curve.angles[0]]
        for point, own in zip(curve.points[1:], curve.angles[1:], strict=True):
            if hypot(point[0] - points[-1][0], point[1] - points[-1][1]) > finest:
                points.append(point)
                angles.append(own)
        if len(points) > 2 or (len(points) == 2 and curve.start != curve.end):
            kept.append((points, angles, curve.start, curve.end))
        elif name(curve.start) != name(curve.end):
            alias[name(curve.start)] = name(curve.end)
    for points, angles, start, end in kept:
        yield Polyline(tuple(points), name(start), name(end), tuple(angles))


def _scaled(points: Sequence[Point], exponent: int) -> tuple[Point, ...]:
    """Points times a power of 2."""
    return tuple((ldexp(x, exponent), ldexp(y, exponent)) for x, y in points) if exponent else tuple(points)


def _inner_points(
    face: Face, levels: Sequence[float], exponent: int
) -> Iterator[tuple[tuple[Fraction, Fraction], float]]:
    """Rational points in a face, in the user's unit, with their distances from the boundary, farthest first.

    One is tried at each of the levels between its least and its greatest second coordinate.
    """
    xs, ys = zip(*([point for ring in face.rings for point in ring] or [(1.0, 1.0)]), strict=True)
    if not face.bounded:
        x, y = 2 * max(xs), 2 * max(ys)
        [(far_x, far_y)] = _scaled([(x, y)], exponent)
        yield (Fraction(floor(far_x) + 1), Fraction(floor(far_y) + 1)), min(x, y)
        return
    edges = [edge for ring in face.rings for edge in pairwise(ring)]
    low, high = min(ys), max(ys)
    best, clearance = (xs[0], ys[0]), 0.0
    others = []
    for level in levels:
        y = low + level * (high - low)
        gap, x = _widest_gap(edges, y)
        others.append((x + _ASIDE * gap, y))
        distance = _distance((x, y), edges, clearance) if gap / 2 > clearance else 0.0
        if distance > clearance:
            best, clearance = (x, y), distance
    if clearance < _CLEAR * (high - low + max(xs) - min(xs)):
        yield _decimal(best, [1e-9 * abs(x) for x in best], exponent), 0.0
        return
    for place in (best, *others):
        room = clearance if place == best else _distance(place, edges)
        if room > 0:
            yield _decimal(place, [room / 4] * 2, exponent), room / 2


def _widest_gap(edges: Sequence[tuple[Point, Point]], y: float) -> tuple[float, float]:
    """The width and the middle of the widest part of a face at a level; 0 if there is none."""
    cuts = sorted(
        ax + (y - ay) / (by - ay) * (bx - ax) for (ax, ay), (bx, by) in edges if (ay > y) != (by > y)
    )
    pairs = zip(cuts[::2], cuts[1::2], strict=False)
    return max(((b - a, (a + b) / 2) for a, b in pairs), default=(0.0, 0.0))


def _decimal(point: Point, errors: Sequence[float], exponent: int) -> tuple[Fraction, Fraction]:
    """A point in the user's unit, with few digits."""
    first, second = (
        _short(ldexp(x, exponent), ldexp(e, exponent)) for x, e in zip(point, errors, strict=True)
    )
    return first, second


def _short(x: float, error: float) -> Fraction:
    """A decimal > 0 with few digits near x."""
    places = max(0, -floor(log10(error))) if error > 0 else 12
    if places > _MOST_PLACES:
        return max(round(Fraction(x), places), Fraction(1, 10 ** (places + 1)))
    return max(Fraction(round(x * 10**places), 10**places), Fraction(1, 10 ** (places + 1)))


def _distance(point: Point, edges: Sequence[tuple[Point, Point]], least: float = 0.0) -> float:
    """The distance from the nearest edge, or from some edge if that is not over ``least``."""
    px, py = point
    best = inf
    for (ax, ay), (bx, by) in edges:
        dx, dy = bx - ax, by - ay
        square = dx * dx + dy * dy
        part = ((px - ax) * dx + (py - ay) * dy) / square if square else 0.0
        part = 0.0 if part < 0 else 1.0 if part > 1 else part
        away = hypot(ax + part * dx - px, ay + part * dy - py)
        if away < best:
            best = away
            if best <= least:
                break
    return best
