"""From a route and its proof to the path in decimals, with the numbers of its poses."""

from __future__ import annotations

from flint import arb, ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.decimals import round_down
from rpr_solver.kinematics.pose_table import PlatformPose, PoseTable, poses
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.paths.isolated import Angles, IsolatedPose
from rpr_solver.paths.path import Path, PathCertificate, PathPose, SamplingPlan
from rpr_solver.paths.proofs import PathProof
from rpr_solver.paths.route import Route
from rpr_solver.slices.joint_points import free_legs

PROOF_BITS = 160
"""The working precision of the proofs."""
_BOUND_DIGITS = 6
_MATCH_BITS = 96


def path_of(
    manipulator: Manipulator,
    route: Route,
    proof: PathProof,
    plan: SamplingPlan,
    digits: int,
    round_cusp: tuple[int, int] | None = None,
) -> Path:
    """The path in decimals; ``round_cusp`` is the number of the cusp and the winding of a loop.

    Raises:
        SolverError: digits could not be proved.
    """
    slice_map = route.slice_map
    leg = slice_map.fixed_leg
    fixed, first, second = (length / slice_map.scale for length in route.start.legs)
    by_leg = dict(zip((leg, *free_legs(leg)), (fixed, first, second), strict=True))
    lengths = by_leg[1], by_leg[2], by_leg[3]
    table = poses(manipulator, *lengths, digits=digits)
    start, stop = (numbered(pose, table, leg) for pose in (route.start, route.stop))
    cusp, winding = round_cusp or (None, None)
    with ctx.workprec(PROOF_BITS):
        least = round_down((proof.least / slice_map.scale_ball()).lower(), _BOUND_DIGITS)
    certificate: PathCertificate = {
        "arcs": route.to_json(),
        "pieces": proof.pieces,
        "least_determinant": least,
        "working_bits": PROOF_BITS,
    }
    return Path(
        manipulator=manipulator,
        fixed_leg=leg,
        digits=digits,
        lengths=lengths,
        cusp=cusp,
        sign=proof.sign,
        winding=winding,
        start=start,
        stop=stop,
        route=route,
        certificate=certificate,
        **plan.members(route, (start, stop), digits),
    )


def numbered(pose: IsolatedPose, table: PoseTable, fixed_leg: int) -> PathPose:
    """A pose with its number in the table of all poses of its joint vector.

    Raises:
        Unproved: it cannot be told from another pose of the table.
    """
    angles = pose.refined(_MATCH_BITS)
    with ctx.workprec(_MATCH_BITS):
        digits, candidates = table.digits, enumerate(table.poses, 1)
        numbers = [k for k, other in candidates if _may_be(angles, other, fixed_leg, digits)]
    if len(numbers) != 1:
        raise Unproved("a pose could not be told from the others of its joint vector; ask for more digits")
    [number] = numbers
    found = table.poses[number - 1]
    return PathPose(number, found.alpha_deg, _theta(found, fixed_leg))


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
