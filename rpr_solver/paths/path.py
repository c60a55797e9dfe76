"""A proved path from one pose to another.

The document of :meth:`Path.to_json`::

    {"geometry": {…}, "geometry_hash": "sha256:…", "fixed_leg": 1, "digits": 15, "solver_version": "…",
     "l1": "27", "l2": "24.1", "l3": "16.8", "connected": true,
     "cusp": 1, "closed": true, "sign": -1, "winding": 1,
     "between": null, "limits": {"l2": {"min": "5", "max": null}},
     "from": {"pose": 2, "alpha_deg": "…", "theta1_deg": "…"}, "to": {"pose": 4, …},
     "others": [{"from": {"pose": 1, …}, "to": {"pose": 1, …}, "fold": null},
                {"from": {"pose": 3, …}, "to": null, "fold": {"l1": "27", "l2": "…", "l3": "…", …}}],
     "duration": "1", "timing": "cosine",
     "samples": [{"time": "0", "l1": "…", "l2": "…", "l3": "…", "alpha_deg": "…", "theta1_deg": "…",
                  "determinant": "…", "clearance_deg": "…", "place": "0"}, …],
     "certificate": {"arcs": [["from", {"alpha_deg": "…", "theta1_deg": "…", "l1": "27"}, "to"]],
                     "turns": {"from": {"alpha": 0, "theta1": 0}, "to": {"alpha": 0, "theta1": 1}},
                     "pieces": 32, "least_determinant": "…"}}

Along the path angles are continuous and not confined to a turn: in the arcs, α of the pose ``"to"`` is its
``alpha_deg`` and 360° times its ``turns``. The path begins in the turn (−180°, 180°].

``closed`` says that the leg lengths at the end are those at the start. ``cusp`` and ``winding`` are null for
a path that is no loop round a cusp, ``between`` and ``limits`` where none are given. A loop round a cusp
whose joint vector other cusps share has their numbers too: ``"twins": [4]``. If the leg lengths at the end
are not those at the start, ``from`` and ``to`` have their own ``l1``, ``l2`` and ``l3``, and the document has
none; a pose that was given by its angles has no number. If a clearance was asked for, there is also
``"clearance": {"asked": "best", "proved": "8.25", "bound": "8.62", "legs": "0.0046", "radius": "1.9"}``. If
condition numbers were, samples have ``condition``, and there is ``"condition": {"length_scale": "3",
"reference": "centroid", "asked": "40", "min": "2.77452", "max": "9.68012"}``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, TypedDict

from flint import ctx

from rpr_solver.contract import document_head, letter
from rpr_solver.errors import InputError
from rpr_solver.exact.decimals import round_down
from rpr_solver.exact.rationals import Exact, exact_str
from rpr_solver.model.given_poses import IN_GIVEN_FRAME
from rpr_solver.model.lengths import Bounds, MotionQuestion, Sampling, limits_json
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.pose_table import poses
from rpr_solver.notebook import Row, counted, csv_text, html_table, shortened, with_floats
from rpr_solver.notebook.figure import Figure, Pictured, draw, shown_as_svg
from rpr_solver.paths.conditioning import PathCondition
from rpr_solver.paths.motion import Motion
from rpr_solver.paths.other_poses import OtherPose, other_poses
from rpr_solver.paths.path_poses import PathPose, numbered
from rpr_solver.paths.proofs import BOUND_DIGITS, PROOF_BITS, Clearance, ProvedRoute
from rpr_solver.paths.question import PathTerms, document_lengths, span_json
from rpr_solver.paths.routes import IsolatedPose, Route
from rpr_solver.paths.samples import PathSample, turns_of
from rpr_solver.paths.sampling import SamplingPlan
from rpr_solver.paths.timing import Deviation
from rpr_solver.singular import SingularCurves
from rpr_solver.triangles import UserFrame


class PathCertificate(TypedDict):
    """The proof of a path.

    ``arcs`` has the control points of its Bézier arcs in (α, θ, L), exact; ``"from"`` and ``"to"`` are the
    poses at its ends, and ``turns`` the whole turns by which their angles on the arcs exceed those of the
    poses. On each of ``pieces`` pieces of the arcs balls prove the sign of J; |J| / (L1 L2 L3) is nowhere
    less than ``least_determinant``.
    """

    arcs: list[list[dict[str, str] | str]]
    turns: dict[str, dict[str, int]]
    pieces: int
    least_determinant: str


@dataclass(frozen=True)
class Path(Pictured):
    """A path along which the manipulator meets no singularity, from one pose to another of the same legs.

    Proved: J has one sign all along, both ends are poses of the joint vector, the image of a loop goes round
    the cusp as often as ``winding`` says, and every printed digit is right.

    Attributes:
        manipulator: the geometry.
        fixed_leg: the leg whose length is held in the slice.
        digits: significant digits of every printed number but the bounds, which have 6.
        lengths: L1, L2 and L3 at both ends, exact, in the user's unit; None if each end has its own.
        cusp: the number, from 1, of the cusp in the table of the slice; None if the path is no loop.
        sign: of J along the path.
        winding: how often the path goes round the cusp in the plane of the two other legs (the one of smaller
            number to the right, the other upwards), counter-clockwise; None if the path is no loop.
        start: the pose at the start.
        stop: the pose at the end.
        samples: points of the path, at equal intervals of time unless chosen by a chord.
        timing: the law of time: ``"cosine"``, ``"trapezoid"``, ``"constant"``, or ``"motion"``.
        duration: the time of the last sample.
        route: the exact path.
        certificate: how the path is proved.
        others: what happens to the other poses; None unless asked for (:meth:`with_others`).
        between: the lengths between which the fixed leg was free; None if it was held.
        limits: the joint limits that the path keeps, proved; by the legs' numbers.
        twins: the numbers of the other cusps round which the loop goes as often: those with the same joint
            vector, to 60 digits, as for congruent triangles.
        plan: how the samples were chosen.
        motion: the motion within limits; None if a law of time was given.
        deviation: bounds, for L1, L2 and L3, of what legs that move linearly between rows deviate from the
            path, proved; None unless ``motion`` or ``sampling`` was asked for.
        clearance: how far it keeps from singular poses; None unless asked for.
        condition: bounds of its condition numbers; None unless asked for.

    >>> from rpr_solver import EXAMPLES, cusp_loop
    >>> loop = cusp_loop(EXAMPLES["innocenti"], 27, "A")
    >>> loop
    <Path round cusp A of L1=27, from pose 1 to pose 2: J < 0, 101 samples, 15 digits>
    >>> back = loop.reversed()
    >>> back.start == loop.stop, back.winding
    (True, -1)
    """

    manipulator: Manipulator
    fixed_leg: int
    digits: int
    lengths: tuple[Fraction, Fraction, Fraction] | None
    cusp: int | None
    sign: int
    winding: int | None
    start: PathPose
    stop: PathPose
    samples: tuple[PathSample, ...]
    timing: str
    duration: Fraction
    route: Route = field(compare=False, repr=False)
    certificate: PathCertificate
    others: tuple[OtherPose, ...] | None = None
    between: tuple[Fraction, Fraction] | None = None
    limits: Mapping[int, Bounds] = field(default_factory=dict)
    twins: tuple[int, ...] = ()
    plan: SamplingPlan = field(default_factory=SamplingPlan.of, compare=False, repr=False)
    motion: Motion | None = field(default=None, compare=False, repr=False)
    deviation: Deviation | None = None
    clearance: Clearance | None = None
    condition: PathCondition | None = None

    def __repr__(self) -> str:
        what = ""
        if self.cusp is not None and self.lengths is not None:
            length = shortened(exact_str(self.lengths[self.fixed_leg - 1]))
            what = f"round cusp {letter(self.cusp)} of L{self.fixed_leg}={length}, "
        ends = f"from {self.start.name} to {self.stop.name}"
        sign = "J > 0" if self.sign > 0 else "J < 0"
        return f"<Path {what}{ends}: {sign}, {counted(len(self.samples), 'sample')}, {self.digits} digits>"

    def resampled(
        self,
        samples: int | None = None,
        *,
        timing: str | None = None,
        duration: Exact | None = None,
        motion: MotionQuestion | None = None,
        sampling: Sampling | None = None,
    ) -> Path:
        """The same path with other samples; they lie on the proved path, however many they are.

        Args:
            samples: their number, 2 to 10001; 101 unless given.
            timing: the law of time over the arc length in joint space: ``"cosine"`` (the speed rises and
                falls as half a sine wave) unless given, ``"trapezoid"`` (it rises for a third of the time,
                stays, and falls for a third) or ``"constant"``.
            duration: the time of the last sample, exact, > 0; 1 unless given.
            motion: the greatest ``speed`` and ``acceleration``, and perhaps ``jerk``, of all legs or by leg:
                ``{"speed": 10, "acceleration": {"l2": 30, "l3": 20}}``. The duration follows from them, and
                the legs rest where the path has corners.
            sampling: instead of ``samples``, ``{"step": …}``, the time between them, or ``{"chord": …}``,
                the greatest deviation from the path of a leg that moves linearly from row to row.

        Raises:
            InputError: naming ``samples``, ``timing``, ``duration``, ``motion`` or ``sampling``.
            SolverError: the digits of a sample could not be proved.

        >>> from rpr_solver import EXAMPLES, cusp_loop
        >>> loop = cusp_loop(EXAMPLES["innocenti"], 27, "B", samples=2)
        >>> fast = loop.resampled(motion={"speed": 10, "acceleration": 20}, sampling={"chord": "0.01"})
        >>> len(fast.samples), float(fast.duration), max(fast.deviation) <= Fraction("0.01")
        (116, 4.7590944, True)
        """
        return self._sampled(SamplingPlan.of(samples, timing, duration, motion, sampling))

    def _sampled(self, plan: SamplingPlan) -> Path:
        frame = UserFrame.of(self.manipulator.geometry)
        scale = None if self.condition is None else self.condition.scale
        found = plan.sampled(self.route, (self.start.angles, self.stop.angles), self.digits, frame, scale)
        return replace(self, plan=plan, timing=plan.timing, **vars(found))

    def reversed(self) -> Path:
        """The same path run backwards, sampled in the same way."""
        route, proof = _begun(self.route.reversed(), self.stop), self.certificate
        backwards = replace(
            self,
            route=route,
            start=self.stop,
            stop=self.start,
            winding=None if self.winding is None else -self.winding,
            certificate=_certificate(route, self.start, proof["pieces"], proof["least_determinant"]),
        )
        backwards = backwards._sampled(self.plan)
        return backwards if self.others is None else backwards.with_others()

    def with_others(self) -> Path:
        """The same path, with what happens to the other poses of the joint vector.

        Each is followed by proof while the legs take the lengths of the path, to the end or to the fold on
        which it meets another one. This takes longer than the path itself.

        Raises:
            InputError: the path does not come back to its leg lengths.
            SolverError: two poses could not be separated.
        """
        if self.lengths is None:
            raise InputError.of("others", "are followed on paths that come back to their leg lengths")
        table = poses(self.manipulator, *self.lengths, digits=self.digits)
        return replace(self, others=other_poses(self.route, table, (self.start, self.stop)))

    def to_json(self) -> dict[str, Any]:
        """The document described at the top of this module."""
        leg = self.fixed_leg
        return {
            **document_head(self.manipulator, self.digits, leg),
            **document_lengths(self.lengths),
            "connected": True,
            "cusp": self.cusp,
            "closed": self.lengths is not None,
            "sign": self.sign,
            "winding": self.winding,
            **({"twins": list(self.twins)} if self.twins else {}),
            "between": span_json(self.between),
            "limits": limits_json(self.limits) or None,
            **({} if self.clearance is None else {"clearance": self.clearance.to_json()}),
            **({} if self.condition is None else {"condition": self.condition.to_json()}),
            "from": self.start.to_json(leg),
            "to": self.stop.to_json(leg),
            "others": None if self.others is None else [other.to_json(leg) for other in self.others],
            "duration": exact_str(self.duration),
            "timing": self.timing,
            **({} if self.motion is None else {"motion": self.motion.to_json()}),
            **self.plan.json(),
            **({} if self.deviation is None else {"deviation": document_lengths(self.deviation)}),
            "samples": [sample.to_json(leg) for sample in self.samples],
            "certificate": {
                **self.certificate,
                **({} if self.motion is None else {"motion": self.motion.certificate()}),
            },
        }

    def figure(self, curves: SingularCurves | None = None) -> Figure:
        """A picture of the path in motion: the leg lengths in joint space, and the mechanism beside it.

        Args:
            curves: the singular curves of the slice, to be drawn too.

        Raises:
            InputError: the lengths are too large to be drawn.
        """
        return draw(self.to_json(), curves=None if curves is None else curves.to_json())

    def _repr_svg_(self) -> str | None:
        return shown_as_svg(self)

    def rows(self) -> list[Row]:
        """A row for each sample, for ``pandas.DataFrame(path.rows())``.

        Lengths and angles are floats; ``l2_text`` has all digits of ``l2``, and so on.
        """
        return with_floats(sample.to_json(self.fixed_leg) for sample in self.samples)

    def _repr_html_(self) -> str:
        samples = [sample.to_json(self.fixed_leg) for sample in self.samples]
        return html_table(repr(self)[1:-1], samples, first=self.manipulator.remark)


def path_of(
    manipulator: Manipulator,
    proved: ProvedRoute,
    terms: PathTerms,
    *,
    between: tuple[Fraction, Fraction] | None = None,
    round_cusp: tuple[int, int, tuple[int, ...]] | None = None,
    named: tuple[PathPose, PathPose] | None = None,
    clearance: Clearance | None = None,
    condition: PathCondition | None = None,
) -> Path:
    """From a route and its proof to the path in decimals, with the numbers of its poses.

    ``between`` is the range of the fixed leg that it was to keep; ``round_cusp`` has the number of the cusp,
    the winding of a loop, and the twins. ``named`` are the poses at the ends, if they are known; otherwise
    they are found among those of their common joint vector. ``condition`` are the bounds of its condition
    numbers, if they are asked for.

    Raises:
        SolverError: digits could not be proved.
    """
    route, proof = proved
    slice_map, leg, digits = route.slice_map, route.slice_map.fixed_leg, terms.digits
    start, stop = named or _numbered(manipulator, route, digits)
    lengths = None
    if start.lengths is None and isinstance(route.start, IsolatedPose):
        lengths = route.start.lengths
    route, frame = _begun(route, start), UserFrame.of(manipulator.geometry)
    cusp, winding, twins = round_cusp or (None, None, ())
    scale = None if condition is None else condition.scale
    with ctx.workprec(PROOF_BITS):
        least = round_down((proof.least / slice_map.scale_ball()).lower(), BOUND_DIGITS)
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
        certificate=_certificate(route, stop, proof.pieces, least),
        between=between,
        limits=dict(terms.bounds),
        timing=terms.plan.timing,
        plan=terms.plan,
        clearance=clearance,
        condition=condition,
        **vars(terms.plan.sampled(route, (start.angles, stop.angles), digits, frame, scale)),
    )


def _numbered(manipulator: Manipulator, route: Route, digits: int) -> tuple[PathPose, PathPose]:
    """The poses at the ends of a route that comes back to its leg lengths."""
    assert isinstance(route.start, IsolatedPose), "poses that are given are known"
    assert isinstance(route.stop, IsolatedPose), "poses that are given are known"
    table, leg = poses(manipulator, *route.start.lengths, digits=digits), route.slice_map.fixed_leg
    return numbered(route.start, table, leg), numbered(route.stop, table, leg)


def _begun(route: Route, start: PathPose) -> Route:
    """The route, with the angles of its start in the turn in which they are printed."""
    alpha, theta = turns_of(route.start.angles, start.angles)
    return route.turned((-alpha, -theta)) if alpha or theta else route


def _certificate(route: Route, stop: PathPose, pieces: int, least: str) -> PathCertificate:
    """The certificate of a route that begins in the turn of its start."""
    names = "alpha", f"theta{route.slice_map.fixed_leg}"
    ends = {"from": (0, 0), "to": turns_of(route.stop.angles, stop.angles)}
    return {
        "arcs": route.to_json(),
        "turns": {end: dict(zip(names, turns, strict=True)) for end, turns in ends.items()},
        "pieces": pieces,
        "least_determinant": least,
    }


def path_csv(document: Mapping[str, Any]) -> str:
    """The document of a path as CSV: a line for each sample.

    >>> from rpr_solver import EXAMPLES, cusp_loop
    >>> loop = cusp_loop(EXAMPLES["innocenti"], 27, "B", samples=2)
    >>> print(path_csv(loop.to_json()).splitlines()[0])
    time,l1,l2,l3,alpha_deg,theta1_deg,determinant,clearance_deg
    """
    angle = f"theta{document['fixed_leg']}_deg"
    columns = ["time", "l1", "l2", "l3", "alpha_deg", angle, "determinant", "clearance_deg"]
    columns += [name for name in ("condition", *IN_GIVEN_FRAME) if name in document["samples"][0]]
    return csv_text(columns, document["samples"])
