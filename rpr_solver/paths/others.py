"""Poses of a path's joint vector: those at its ends, by their numbers in the table of all poses, and what
happens to the others along the path.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from flint import arb, ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.decimals import digit_bits, round_all
from rpr_solver.model.pose_table import PlatformPose, PoseTable
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.notebook import shortened
from rpr_solver.paths.followed import Triple, follow
from rpr_solver.paths.routes import Angles, Arc, IsolatedPose, Legs, Route, by_leg, local_map
from rpr_solver.paths.samples import wrapped

_MATCH_BITS = 96


@dataclass(frozen=True)
class PathPose:
    """A pose at an end of a path.

    Attributes:
        number: of the pose, from 1, in the table of all poses of the joint vector (:func:`poses`); None if
            the pose was given by its angles.
        alpha_deg: the orientation of the platform, in degrees in (−180, 180].
        theta_deg: the angle of the fixed leg, likewise.
        lengths: L1, L2 and L3, if the other end of the path has other ones: exact, but correctly rounded for
            the free legs of a pose that was given by its angles. None if they are those of the path.

    >>> from rpr_solver import EXAMPLES, cusp_loop
    >>> cusp_loop(EXAMPLES["innocenti"], 27, "A", samples=2).start.to_json(1)
    {'pose': 1, 'alpha_deg': '-19.0937319036636', 'theta1_deg': '145.442869910252'}
    """

    number: int | None
    alpha_deg: str
    theta_deg: str
    lengths: tuple[str, str, str] | None = None

    def __repr__(self) -> str:
        angles = f"alpha_deg={shortened(self.alpha_deg)} theta_deg={shortened(self.theta_deg)}"
        return f"<PathPose{'' if self.number is None else f' {self.number}'}: {angles}>"

    @property
    def name(self) -> str:
        """The pose in sentences: its number, and its lengths if they are its own."""
        name = "a given pose" if self.number is None else f"pose {self.number}"
        return name if self.lengths is None else f"{name} of {legs_text(self.lengths)}"

    @property
    def angles(self) -> tuple[str, str]:
        """α and the angle of the fixed leg."""
        return self.alpha_deg, self.theta_deg

    def to_json(self, fixed_leg: int) -> dict[str, Any]:
        """The document's object."""
        lengths = {f"l{leg}": text for leg, text in enumerate(self.lengths or (), 1)}
        angles = {"alpha_deg": self.alpha_deg, f"theta{fixed_leg}_deg": self.theta_deg}
        return {"pose": self.number, **lengths, **angles}


def legs_text(lengths: Sequence[str]) -> str:
    """Leg lengths in sentences.

    >>> legs_text(("27", "20", "20"))
    'L1=27 L2=20 L3=20'
    """
    return " ".join(f"L{leg}={shortened(text)}" for leg, text in enumerate(lengths, 1))


def numbered(pose: IsolatedPose, table: PoseTable, fixed_leg: int) -> PathPose:
    """A pose with its number in the table of all poses of its joint vector.

    Raises:
        Unproved: it cannot be distinguished from another pose of the table.
    """
    angles = pose.refined(_MATCH_BITS)
    with ctx.workprec(_MATCH_BITS):
        digits, candidates = table.digits, enumerate(table.poses, 1)
        numbers = [k for k, other in candidates if _may_be(angles, other, fixed_leg, digits)]
    if len(numbers) != 1:
        raise Unproved("a pose could not be told from the others of its joint vector; ask for more digits")
    return of_table(table, numbers[0], fixed_leg)


def isolated(slice_map: SliceMap, legs: Legs, table: PoseTable, number: int) -> IsolatedPose:
    """The pose with this number in the table of scaled leg lengths, isolated at the working precision.

    Raises:
        Unproved: it could not be isolated.
    """
    pose = of_table(table, number, slice_map.fixed_leg)
    alpha, theta = (arb(text) * arb.pi() / 180 for text in pose.angles)
    found = IsolatedPose.near(slice_map, legs, (alpha, theta))
    if found is None or numbered(found, table, slice_map.fixed_leg) != pose:
        raise Unproved("a pose is too near a singularity")
    return found


def of_table(table: PoseTable, number: int, fixed_leg: int) -> PathPose:
    """The pose with this number in the table."""
    pose = table.poses[number - 1]
    return PathPose(number, pose.alpha_deg, _theta(pose, fixed_leg))


def _theta(pose: PlatformPose, fixed_leg: int) -> str:
    return str(pose.to_json()[f"theta{fixed_leg}_deg"])


def _may_be(angles: Angles, other: PlatformPose, fixed_leg: int, digits: int) -> bool:
    """Whether a pose may be one of the table, within the accuracy of the table's decimals."""
    doubt = arb(10) ** (4 - digits)
    for angle, text in zip(angles, (other.alpha_deg, _theta(other, fixed_leg)), strict=True):
        turns = (angle / arb.pi() * 180 - arb(text, doubt)) / 360
        if not turns.contains_integer():
            return False
    return True


_SPARE_BITS = 128


@dataclass(frozen=True)
class FoldPoint:
    """Where a pose that is followed meets another one, and both vanish: a point of a singular curve.

    Attributes:
        lengths: L1, L2 and L3 there, correctly rounded, in the user's unit.
        alpha_deg: the orientation of the platform, in degrees in (−180, 180].
        theta_deg: the angle of the fixed leg, likewise.

    >>> from rpr_solver import EXAMPLES, cusp_loop
    >>> loop = cusp_loop(EXAMPLES["innocenti"], 27, "A", samples=2).with_others()
    >>> [other.fold.lengths[0] for other in loop.others if other.fold]
    ['27.0000000000000', '27.0000000000000']
    """

    lengths: tuple[str, str, str]
    alpha_deg: str
    theta_deg: str

    def __repr__(self) -> str:
        legs = " ".join(f"l{leg}={shortened(text)}" for leg, text in enumerate(self.lengths, 1))
        return f"<FoldPoint {legs} alpha_deg={shortened(self.alpha_deg)}>"

    def to_json(self, fixed_leg: int) -> dict[str, str]:
        """The document's object."""
        l1, l2, l3 = self.lengths
        angles = {"alpha_deg": self.alpha_deg, f"theta{fixed_leg}_deg": self.theta_deg}
        return {"l1": l1, "l2": l2, "l3": l3, **angles}


@dataclass(frozen=True)
class OtherPose:
    """Another pose of the joint vector, moved by the leg lengths of a path.

    Attributes:
        start: the pose at the start.
        stop: the pose at the end, if it exists until then.
        fold: the fold at which it vanishes before; if ``stop`` is None too, this is undecided.

    >>> from rpr_solver import EXAMPLES, cusp_loop
    >>> loop = cusp_loop(EXAMPLES["innocenti"], 27, "A", samples=2).with_others()
    >>> [(other.start.number, other.stop and other.stop.number) for other in loop.others]
    [(2, None), (3, None), (4, 4)]
    """

    start: PathPose
    stop: PathPose | None
    fold: FoldPoint | None

    def to_json(self, fixed_leg: int) -> dict[str, Any]:
        """The document's object."""
        return {
            "from": self.start.to_json(fixed_leg),
            "to": self.stop and self.stop.to_json(fixed_leg),
            "fold": self.fold and self.fold.to_json(fixed_leg),
        }


def other_poses(route: Route, table: PoseTable, ends: tuple[PathPose, PathPose]) -> tuple[OtherPose, ...]:
    """The other poses of the joint vector, each followed by proof until the fold at which it vanishes.

    ``table`` has all poses of the joint vector; those that coalesce with others are left out.

    Raises:
        Unproved: two poses could not be separated.
    """
    leg, legs = route.slice_map.fixed_leg, _legs_of(route)
    bits = digit_bits(table.digits) + _SPARE_BITS
    arcs = route.at(bits)
    others = []
    for number, pose in enumerate(table.poses, 1):
        if number == ends[0].number or pose.multiplicity > 1:
            continue
        start = of_table(table, number, leg)
        with ctx.workprec(bits):
            pose_at_start = isolated(route.slice_map, legs, table, number)
            followed = follow(route.slice_map, arcs, pose_at_start.refined(bits - 32))
            stop = None if followed.end is None else _arrived(route, followed.end, table)
            fold = None
            if followed.fold is not None:
                at, place = followed.fold
                fold = _fold_point(route, arcs[at], place, table.digits)
        others.append(OtherPose(start, stop, fold))
    return tuple(others)


def _legs_of(route: Route) -> Legs:
    """The joint vector at both ends."""
    assert isinstance(route.start, IsolatedPose), "the path comes back to its leg lengths"
    return route.start.legs


def _arrived(route: Route, angles: Angles, table: PoseTable) -> PathPose | None:
    pose = IsolatedPose.near(route.slice_map, _legs_of(route), angles)
    return None if pose is None else numbered(pose, table, route.slice_map.fixed_leg)


def _fold_point(route: Route, arc: Arc, place: Triple, digits: int) -> FoldPoint | None:
    alpha, theta, tau = place
    length, scale = arc.length(tau), route.slice_map.scale_ball()
    first, second = (
        square.sqrt() / scale
        for square in local_map(route.slice_map, length, (alpha, theta), 0).squared_lengths()
    )
    texts = round_all((length / scale, first, second, wrapped(alpha), wrapped(theta)), digits)
    if texts is None:
        return None
    return FoldPoint(by_leg(route.slice_map.fixed_leg, texts[:3]), *texts[3:])
