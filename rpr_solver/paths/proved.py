"""From a route and its proof to the path in decimals, with the numbers of its poses."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from flint import ctx

from rpr_solver.exact.decimals import round_down
from rpr_solver.kinematics.pose_table import poses
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.lengths import Bounds
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.paths.ends import numbered
from rpr_solver.paths.path import Path, PathCertificate, SamplingPlan
from rpr_solver.paths.proofs import PathProof
from rpr_solver.paths.route import Route

PROOF_BITS = 160
"""The working precision of the proofs."""
_BOUND_DIGITS = 6


def path_of(
    manipulator: Manipulator,
    route: Route,
    proof: PathProof,
    plan: SamplingPlan,
    digits: int,
    round_cusp: tuple[int, int, tuple[int, ...]] | None = None,
    *,
    between: tuple[Fraction, Fraction] | None = None,
    limits: Mapping[int, Bounds] | None = None,
) -> Path:
    """The path in decimals; ``round_cusp`` has the number of the cusp, the winding of a loop, and the twins.

    ``between`` and ``limits`` are what it was to keep.

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
    cusp, winding, twins = round_cusp or (None, None, ())
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
        twins=twins,
        start=start,
        stop=stop,
        route=route,
        certificate=certificate,
        between=between,
        limits=dict(limits or {}),
        **plan.members(route, (start, stop), digits),
    )
