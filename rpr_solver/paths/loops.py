"""Loops round a cusp: from one pose to another of the same joint vector, without a singularity, by proof.

A loop is one Bézier parabola in (α, θ). Its size shrinks until balls prove that J keeps its sign along it and
that its image turns once round the image of the cusp, and not round those of the other cusps of the slice but
its twins, which have the same image. The first alone would not do: two poses near a cusp can also be joined
beside it.

The local algebra at a cusp gives the places of its three poses, and on which side of the singular curve they
lie.

Let v be the unit tangent of J = 0 in (α, θ), which spans the kernel of DF there, n = ∇J/|∇J|, U = DF·n, and

    β = ⟨D²F(v, v)/2, U⟩ / |U|²,        κ = (J_vv / (2|∇J|) − β) / 3.

At the pose c + x n + y v, J is |∇J| (x + (β + 3κ) y²), and the image is X = x + β y² along U and
Y = y (X + κ y²) along another direction, all to leading order. So the poses over (X, Y) = (−κ s², 0) are
y = ±s, where J has the sign of κ, and y = 0, where it has the other. The parabola
x(y) = b s² − (β + κ + b) y², where b has the sign of κ, leads from y = s to y = −s. On it J / |∇J| runs from
2κ s² over b s² to 2κ s², and its image goes once round that of the cusp.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from itertools import pairwise
from math import floor
from typing import Unpack

from flint import acb, arb, ctx

from rpr_solver.contract import check_type, number_of
from rpr_solver.errors import InputError, SolverError, Unproved
from rpr_solver.exact.rationals import Exact, exact_str
from rpr_solver.exact.real_roots import ball_of, fraction_of
from rpr_solver.model.joint_points import JointPoint, free_legs
from rpr_solver.model.lengths import Bounds, slice_length
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.conditioning import PathCondition
from rpr_solver.paths.corridors import Corridors, WideLoops
from rpr_solver.paths.path import Path, path_of
from rpr_solver.paths.proofs import (
    PROOF_BITS,
    Clearance,
    PathLimits,
    PathProof,
    ProvedRoute,
    Unfinished,
    finished_route,
    outside,
)
from rpr_solver.paths.question import PathOptions, PathTerms
from rpr_solver.paths.routes import Angles, Arc, DecimalPose, Image, IsolatedPose, Route, expanded, local_map
from rpr_solver.slices import Eliminant, kept_eliminant
from rpr_solver.slices.cusp_table import solve_slice
from rpr_solver.slices.slice_table import SliceTable
from rpr_solver.transitions.check_report import CheckReport


@dataclass(frozen=True)
class CuspFrame:
    """A cusp with its local algebra: approximate, for starting points of what is then proved."""

    cusp: Angles
    normal: Angles
    tangent: Angles
    beta: arb
    kappa: arb

    @classmethod
    def at(cls, slice_map: SliceMap, length: arb, cusp: Angles) -> CuspFrame:
        """The frame of a cusp (radians) of the slice of a scaled length."""
        cusp = cusp[0].mid(), cusp[1].mid()
        local = local_map(slice_map, length, cusp, 3)
        j = local.singularity()
        slope = j.alpha.value, j.theta.value
        steepness = (slope[0] ** 2 + slope[1] ** 2).sqrt()
        n = slope[0] / steepness, slope[1] / steepness
        v = -n[1], n[0]
        image = [leg.alpha.value * n[0] + leg.theta.value * n[1] for leg in (local.f, local.g)]

        def bend(jet_alpha_alpha: arb, jet_alpha_theta: arb, jet_theta_theta: arb) -> arb:
            return (
                jet_alpha_alpha * v[0] ** 2 + 2 * jet_alpha_theta * v[0] * v[1] + jet_theta_theta * v[1] ** 2
            ) / 2

        bends = [
            bend(w.alpha.alpha.value, w.alpha.theta.value, w.theta.theta.value) for w in (local.f, local.g, j)
        ]
        beta = (bends[0] * image[0] + bends[1] * image[1]) / (image[0] ** 2 + image[1] ** 2)
        kappa = (bends[2] / steepness - beta) / 3
        numbers = [w.mid() for w in (*n, *v, beta, kappa)]
        return cls(cusp, (numbers[0], numbers[1]), (numbers[2], numbers[3]), numbers[4], numbers[5])

    @property
    def sign(self) -> int:
        """The sign of J along a loop."""
        return 1 if self.kappa > 0 else -1

    def outer(self, s: arb) -> Angles:
        """The pose y = s, s of either sign, over the point of the cusp's axis."""
        return self._place(-(self.kappa + self.beta) * s * s, s)

    def middle(self, s: arb, width: arb) -> Angles:
        """The middle control point of the Bézier parabola from y = s to y = −s, for b = ``width`` · κ."""
        # a Bézier parabola passes half-way between the middle of its ends and its control point
        x = (2 * width * self.kappa + self.kappa + self.beta) * s * s
        return self._place(x, arb(0))

    def _place(self, x: arb, y: arb) -> Angles:
        n, v = self.normal, self.tangent
        return (self.cusp[0] + x * n[0] + y * v[0]).mid(), (self.cusp[1] + x * n[1] + y * v[1]).mid()


CUSP_DIGITS = 60
"""The digits of the cusps from which loops are searched."""
_LARGEST, _RATIO, _SMALLEST = 1.0, 0.7, 1e-8
_LEAST_RATIO = 1e-4
"""By which the size shrinks at most. The pieces of a long leg's loop are about as its root, so that the share
of a loop that is proved says by how much."""
_WIDTHS = (4, 3, 2)
_PROBES = 24
_LEG_ACCURACY, _ANGLE_ACCURACY = 0.1, 0.01
_TRIED = 8
"""Cusps of a range round which a loop is tried."""


def cusp_loop(
    manipulator: Manipulator,
    length: Exact,
    cusp: int | str,
    **options: Unpack[PathOptions],
) -> Path:
    """A loop of the leg lengths round a cusp, which carries one pose to another without a singularity.

    The loop begins and ends at one joint vector. The platform follows continuously, J ≠ 0 all along, and
    yet it arrives at another pose: the manipulator changes its assembly mode, which is possible in other
    ways too (assembly-modes.md#cusps-and-assembly-modes). Run backwards (``reversed``) the loop carries
    the second pose to the first. It turns round this cusp counter-clockwise, and round no other cusp of
    the slice but its twins, which have the same joint vector, as for congruent triangles.

    Args:
        manipulator: the geometry.
        length: of the fixed leg, exact, > 0, in the user's unit.
        cusp: the number of the cusp, from 1, in the table of the slice, or its letter A, B, ….
        options: as :class:`~rpr_solver.paths.question.PathOptions` says: ``limits``, ``fixed_leg``,
            ``digits``, ``samples``, ``timing`` and ``duration``.

    Raises:
        InputError: naming the argument at fault, the length by its leg (``l1``).
        SolverError: the slice or the loop could not be decided.

    >>> from rpr_solver import EXAMPLES
    >>> loop = cusp_loop(EXAMPLES["innocenti"], 27, "B", samples=3)
    >>> cusp_loop(EXAMPLES["innocenti"], 27, "B", limits={"l2": (8, 20)}, samples=3).limits
    {2: (Fraction(8, 1), Fraction(20, 1))}
    >>> loop.winding, [sample.lengths[1] for sample in loop.samples]
    (1, ['15.5000000000000', '6.41622823487786', '15.5000000000000'])
    """
    terms = PathTerms.of(**options)
    exact, eliminant = slice_length(length, terms.leg), kept_eliminant(manipulator, terms.leg)
    return loop_in_slice(eliminant, slice_for_loops(eliminant, exact), cusp, terms, manipulator)


def slice_for_loops(eliminant: Eliminant, length: Exact) -> SliceTable:
    """The cusps of a slice, to as many digits as the search for a loop needs.

    Raises:
        InputError: naming the length by its leg.
        SolverError: the slice could not be decided.
    """
    return solve_slice(eliminant, length, CUSP_DIGITS)


def loop_in_slice(
    eliminant: Eliminant,
    table: SliceTable,
    cusp: int | str,
    terms: PathTerms,
    manipulator: Manipulator | None = None,
) -> Path:
    """As :func:`cusp_loop`, for a slice that is known (see :func:`slice_for_loops`).

    The manipulator is needed if it is given by other points than that of the eliminant.

    Raises:
        InputError: naming ``cusp``: the slice has no such cusp; or ``limits``, which exclude it.
        SolverError: the loop could not be decided.
    """
    cusp = number_of(cusp, table.count)
    check_type(table, SliceTable, "table")
    search = _Search(eliminant.slice_map, table, cusp, terms.bounds)
    route, proof = search.found()
    clearance = None
    if terms.clearance is not None:
        (route, proof), clearance = search.widened((route, proof), terms.clearance)
    given = eliminant.manipulator if manipulator is None else manipulator
    condition = None
    if terms.condition is not None:
        scale, most = terms.condition.scale(given), terms.condition.most
        condition = PathCondition.of(route, scale, most)
        if not condition.is_kept and clearance is None:
            route, proof = search.widened((route, proof), Fraction(0))[0]
            condition = PathCondition.of(route, scale, most)
        if not condition.is_kept:
            least = exact_str(condition.greatest)
            raise Unproved(f"no loop with these condition numbers was found; one has at most {least}")
    winding = proof.windings[0]
    if winding < 0:
        route, winding = route.reversed(), -winding
    round_cusp = cusp, winding, search.twins
    return path_of(
        given, (route, proof), terms, round_cusp=round_cusp, clearance=clearance, condition=condition
    )


def loop_in_range(report: CheckReport) -> Path | None:
    """A loop round a cusp, within the joint limits, in a slice of the range of a check; None if none could be
    proved.

    It is sought in the intervals with cusps, the widest first.
    """
    wish = report.requirement
    terms = PathTerms.of(limits=wish.limits, fixed_leg=wish.fixed_leg)
    eliminant = kept_eliminant(report.manipulator, wish.fixed_leg)
    tried = 0
    for x in sorted((x for x in report.intervals if x.count), key=lambda x: x.width, reverse=True):
        try:
            table = slice_for_loops(eliminant, x.example)
        except SolverError:
            continue
        for number in range(1, table.count + 1):
            try:
                return loop_in_slice(eliminant, table, number, terms, report.manipulator)
            except InputError:  # the limits exclude this cusp
                continue
            except SolverError:
                tried += 1
                if tried == _TRIED:
                    return None
    return None


class TooLong(Unproved):
    """No loop was proved, and some would take too many pieces, as where legs are far longer than sides."""


class _Search:
    """The search for the largest loop round one cusp of a slice."""

    def __init__(
        self, slice_map: SliceMap, table: SliceTable, cusp: int, bounds: Mapping[int, Bounds]
    ) -> None:
        self.slice_map = slice_map
        self.bounds = bounds
        self.length = table.length
        self.cusp = cusp
        self.point = table.cusps[cusp - 1]
        others = {k: point for k, point in enumerate(table.cusps, 1) if k != cusp}
        joint = self.point.coordinates[2:]
        self.twins = tuple(k for k, point in others.items() if point.coordinates[2:] == joint)
        self.others = list(others.values())
        self.wanted = [1, *(int(k in self.twins) for k in others)]
        self.digits = table.digits

    def found(self) -> ProvedRoute:
        """The route of a loop and its proof."""
        with ctx.workprec(PROOF_BITS):
            alpha, theta, *_ = (_ball(text, self.digits) for text in self.point.coordinates)
            degree = arb.pi() / 180
            self.length_ball = ball_of(self.length * self.slice_map.scale)
            self.frame = CuspFrame.at(self.slice_map, self.length_ball, (alpha * degree, theta * degree))
            self.centres = [self._image(point) for point in (self.point, *self.others)]
            self._check_limits()
            size, refusal = _LARGEST, Unproved
            # Invariant: sizes fall, by a share of 0.7 at least; none below the smallest is tried.
            while size > _SMALLEST:
                shrink = _RATIO
                for route in self._routes(size):
                    [arc] = route.at(PROOF_BITS - 64)
                    if not self._promises(arc, self._limits(route)):
                        continue
                    try:
                        proof = self._finished(route)
                    except Unfinished as cut:
                        shrink, refusal = max(_LEAST_RATIO, _RATIO**2 * cut.share**2), TooLong
                        break
                    if proof is not None:
                        return route, proof
                size *= shrink
        within = " within the limits" if self.bounds else ""
        raise refusal(f"no loop round cusp {self.cusp}{within} could be proved")

    def widened(self, known: ProvedRoute, asked: Fraction) -> tuple[ProvedRoute, Clearance]:
        """A loop that keeps farther from J = 0, if one is found; ``asked`` is the clearance it must have.

        Raises:
            Unproved: it has less.
        """
        route, _ = known
        ends, length = (route.start, route.stop), route.start.legs[0]
        corridors = Corridors.of(ends, (length, length), self.frame.sign, asked=asked)
        return WideLoops(corridors, self._proof).widest(known)

    def _limits(self, route: Route) -> PathLimits:
        return PathLimits.of(self.slice_map, self.bounds, (route.start.legs, route.stop.legs))

    def _proof(self, route: Route) -> PathProof | None:
        """The proof that a route is a loop round the cusp and its twins alone, within the limits."""
        with suppress(Unfinished):
            return self._finished(route)
        return None

    def _finished(self, route: Route) -> PathProof | None:
        """The same.

        Raises:
            Unfinished: it takes too many pieces.
        """
        found = finished_route(route, self.frame.sign, self._limits(route), self.centres)
        return found[1] if found is not None and self._winds(found[1].windings) else None

    def _check_limits(self) -> None:
        """Refuse limits that exclude the cusp: what they allow is a rectangle, and no loop in it goes round a
        point outside.

        Raises:
            InputError: naming the leg of the limit at fault.
        """
        leg = self.slice_map.fixed_leg
        if leg in outside(self.bounds, [self.length] * 3):
            raise InputError.of(f"limits.l{leg}", f"exclude the slice L{leg} = {exact_str(self.length)}")
        message = f"exclude cusp {self.cusp}, so that every loop round it exceeds them"
        free = free_legs(leg)
        for wall in PathLimits.of(self.slice_map, self.bounds).walls:
            if wall.room(self.centres[0][wall.leg]) < 0:
                raise InputError.of(f"limits.l{free[wall.leg]}", message)

    def _winds(self, windings: Sequence[int]) -> bool:
        """Whether a loop turns once round the cusp and its twins, and round no other cusp."""
        sense = windings[0]
        return abs(sense) == 1 and [n * sense for n in windings] == self.wanted

    def _promises(self, arc: Arc, limits: PathLimits) -> bool:
        """Whether J has its sign at some points of a loop, and their images keep the limits and seem to turn
        as wanted."""
        image = []
        for k in range(_PROBES + 1):
            at = expanded(self.slice_map, arc, arb(k) / _PROBES, 0)
            if not at.singularity[0] * self.frame.sign > 0:
                return False
            if limits.exclude((at.first[0], at.second[0])):
                return False
            image.append(acb(at.first[0].mid(), at.second[0].mid()))
        for (x, y), turns in zip(self.centres, self.wanted, strict=True):
            centre = acb(x.mid(), y.mid())
            angle = sum((((b - centre) / (a - centre)).arg() for a, b in pairwise(image)), arb(0))
            turned = (abs(angle) / (2 * arb.pi()) + 0.5).floor().unique_fmpz()
            if turned != turns:
                return False
        return True

    def _image(self, point: JointPoint) -> Image:
        scale = self.slice_map.scale_ball()
        first, second = (_ball(text, self.digits) * scale for text in point.coordinates[2:])
        return first * first / 2, second * second / 2

    def _routes(self, size: float) -> Iterator[Route]:
        """Candidates of one size, the widest first."""
        ends = self._ends(size)
        if ends is None:
            return
        for width in _WIDTHS:
            alpha, theta = self.frame.middle(arb(size), arb(width))
            degrees = [decimal_near(x * 180 / arb.pi(), size * _ANGLE_ACCURACY) for x in (alpha, theta)]
            middle = DecimalPose(degrees[0], degrees[1], self.length)
            yield Route(*ends, ((None, middle, None),))

    def _ends(self, size: float) -> tuple[IsolatedPose, IsolatedPose] | None:
        """The two outer poses of a joint vector of short decimals near the axis of the cusp."""
        sides = [self.frame.outer(arb(size)), self.frame.outer(arb(-size))]
        squares = local_map(self.slice_map, self.length_ball, sides[0], 0).squared_lengths()
        if not all(square > 0 for square in squares):
            return None
        scale = self.slice_map.scale_ball()
        lengths = [square.sqrt() / scale for square in squares]
        cusp = [_ball(text, self.digits) for text in self.point.coordinates[2:]]
        far = max((abs(x - y).mid() for x, y in zip(lengths, cusp, strict=True)), key=fraction_of)
        legs = [decimal_near(x, far * min(1.0, size) * _LEG_ACCURACY) for x in lengths]
        if not all(leg > 0 for leg in legs):
            return None
        scaled = [leg * self.slice_map.scale for leg in (self.length, *legs)]
        joint = scaled[0], scaled[1], scaled[2]
        first, last = (IsolatedPose.near(self.slice_map, joint, side) for side in sides)
        return (first, last) if first and last else None


def decimal_near(x: arb, accuracy: arb | float) -> Fraction:
    """A short decimal that differs from a number by less than this."""
    step = Fraction(10) ** floor(float((arb(accuracy).log() / arb(10).log()).mid()))
    return round(fraction_of(x) / step) * step


def _ball(text: str, digits: int) -> arb:
    """The numbers that round to a decimal of these digits."""
    x = Decimal(text)
    place = x.adjusted() if x else 0
    return arb(text, arb(10) ** (place + 1 - digits))
