"""The singular curves of a slice: proved topology, exact special points, and samples for drawing.

The document of :meth:`SingularCurves.to_json`::

    {"geometry": {…}, "geometry_hash": "sha256:…", "fixed_leg": 1, "digits": 15, "solver_version": "…",
     "l1": "14.98", "tolerance": "0.001",
     "components": [{"strands": [{"closed": true, "turns": {"alpha": 0, "theta1": -1},
                                  "alpha_deg": [12.5, …], "theta1_deg": […], "l2": […], "l3": […],
                                  "vertices": [{"index": 17, "kind": "cusp", "cusp": 1, "alpha_deg": "…",
                                                "theta1_deg": "…", "l2": "…", "l3": "…"}]}]}],
     "regions": [{"poses": 4, "bounded": true, "point": {"l2": "15", "l3": "30"},
                  "rings": [{"l2": […], "l3": […]}]}], "thin_regions": 0,
     "aspects": [{"sign": 1, "share": 0.48, "polygons": [{"alpha_deg": […], "theta1_deg": […]}]}]}

Angles of samples are continuous along a strand, beyond ±180; those of vertices and polygons are not.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache, cached_property
from itertools import product
from typing import Any

from rpr_solver.contract import (
    COARSEST_TOLERANCE,
    DEFAULT_TOLERANCE,
    FINEST_TOLERANCE,
    MIN_DIGITS,
    check_digits,
    check_leg,
    check_type,
    document_head,
)
from rpr_solver.errors import InputError
from rpr_solver.exact.rationals import Exact, exact_str, parse_exact
from rpr_solver.model.joint_points import JointPoint, PoseKind, coordinate_names
from rpr_solver.model.lengths import slice_length
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.notebook import counted, csv_text, shortened
from rpr_solver.notebook.figure import Figure, Pictured, draw, shown_as_svg
from rpr_solver.singular.aspects import Aspect
from rpr_solver.singular.charts import turns_of
from rpr_solver.singular.drawing import Chain, Drawing, Strand, components
from rpr_solver.singular.regions import Picture, Region, Regions, regions_of
from rpr_solver.singular.sweep import Sweep, sweep
from rpr_solver.singular.vertices import NotPlaced, Vertex
from rpr_solver.slices import Eliminant, kept_eliminant
from rpr_solver.slices.cusp_table import solve_slice
from rpr_solver.slices.slice_table import SliceTable

_ASIDE = [Fraction(1, 10**places) for places in range(5, 13)]
"""Parts of its length by which a slice may be drawn aside of its own."""


@dataclass(frozen=True)
class SingularComponent:
    """A connected component of the singular curves: one closed strand, or several that meet in nodes.

    An isolated point is a strand with one sample.

    >>> from rpr_solver import EXAMPLES, singular_curves
    >>> [len(part.strands) for part in singular_curves(EXAMPLES["innocenti"], 27).components]
    [1, 1, 1]
    """

    strands: tuple[Strand, ...]

    def __repr__(self) -> str:
        return f"<SingularComponent: {counted(len(self.strands), 'strand')}>"


@dataclass(frozen=True)
class SingularCurves(Pictured):
    """The singular curves of one slice, complete.

    Proved: the components and how they run between their special points, and every digit of these points.
    The samples are floats and keep the tolerance.

    Attributes:
        manipulator: the geometry.
        fixed_leg: the leg that is held, 1, 2 or 3.
        length: its length, exact, in the user's unit.
        digits: the significant digits of the special points.
        tolerance: the deviation of the drawn curves, relative to the pictures in both planes.
        components: the connected components.
        table: the cusps and degenerate points of the slice.
        regions: of the plane of the free legs, each with its proved number of poses.
        thin_regions: the number of further regions, which are narrower than the tolerance: faces of the
            drawing at a point of which the number of poses is proved, and regions too small to be drawn.
        aspects: of the slice, those with J > 0 first; their number is exact.

    >>> from rpr_solver import EXAMPLES, singular_curves
    >>> curves = singular_curves(EXAMPLES["zein-flat"], 34)
    >>> curves, sum(vertex.kind == "cusp" for vertex in curves.vertices)
    (<SingularCurves L1=34: 1 component, 6 cusps>, 6)
    >>> [region.poses for region in curves.regions], [aspect.sign for aspect in curves.aspects]
    ([4, 4, 4, 2, 0, 0], [1, -1])
    """

    manipulator: Manipulator
    fixed_leg: int
    length: Fraction
    digits: int
    tolerance: Fraction
    components: tuple[SingularComponent, ...]
    table: SliceTable
    _drawing: Drawing = field(repr=False, compare=False)
    _chains: tuple[Chain, ...] = field(repr=False, compare=False)

    def __repr__(self) -> str:
        leg = f"L{self.fixed_leg}={shortened(exact_str(self.length))}"
        parts, cusps = counted(len(self.components), "component"), counted(self.table.count, "cusp")
        return f"<SingularCurves {leg}: {parts}, {cusps}>"

    @property
    def strands(self) -> Iterator[Strand]:
        """The strands of all components."""
        return (strand for component in self.components for strand in component.strands)

    @property
    def vertices(self) -> Iterator[Vertex]:
        """The special points of all components; a node once for each strand end."""
        return (vertex for strand in self.strands for _, vertex in strand.vertices)

    @property
    def regions(self) -> tuple[Region, ...]:
        """The regions, computed when they are first asked for."""
        return self._regions.regions

    @property
    def thin_regions(self) -> int:
        """The number of regions that are too thin to be listed."""
        return self._regions.thin

    @cached_property
    def aspects(self) -> tuple[Aspect, ...]:
        """The aspects, drawn when they are first asked for."""
        return tuple(self._drawing.aspects())

    @cached_property
    def _regions(self) -> Regions:
        return regions_of(self._picture, self._pictures_aside())

    @property
    def _picture(self) -> Picture:
        return self._drawing.picture(self.length, list(zip(self._chains, self.strands, strict=True)))

    @property
    def _topology(self) -> list[list[tuple[bool, tuple[int, int], int]]]:
        """What a slice has in common with others between the same transitions."""
        return sorted(
            sorted(
                (
                    strand.closed,
                    strand.turns,
                    sum(vertex.kind is PoseKind.CUSP for _, vertex in strand.vertices),
                )
                for strand in component.strands
            )
            for component in self.components
        )

    def _pictures_aside(self) -> Iterator[Picture]:
        """The pictures of slices close by with the same topology, the farthest first."""
        eliminant = kept_eliminant(self.manipulator, self.fixed_leg)
        for part, side in product(_ASIDE, (-1, 1)):
            length = self.length * (1 + side * part)
            if solve_slice(eliminant, length, MIN_DIGITS).count == self.table.count:
                other = trace_slice(eliminant, length, tolerance=self.tolerance)
                if other._topology == self._topology:
                    yield other._picture

    def figure(self, view: str = "joints") -> Figure:
        """A picture of the slice.

        Args:
            view: ``"joints"``: the plane of the free legs, with insets where cusps are too close to see;
                ``"torus"``: the angles α and θ, with the areas of J > 0 and J < 0.

        Raises:
            InputError: naming ``view``, or the lengths are too large to be drawn.
        """
        return draw(self.to_json(), view=view)

    def _repr_svg_(self) -> str | None:
        return shown_as_svg(self)

    def to_json(self) -> dict[str, Any]:
        """The document described at the top of this module."""
        leg = self.fixed_leg
        return {
            **document_head(self.manipulator, self.digits, leg),
            f"l{leg}": exact_str(self.length),
            "tolerance": exact_str(self.tolerance),
            "components": [
                {"strands": [strand.to_json(leg) for strand in part.strands]} for part in self.components
            ],
            "regions": [region.to_json(leg) for region in self.regions],
            "thin_regions": self.thin_regions,
            "aspects": [aspect.to_json(leg) for aspect in self.aspects],
        }


def singular_curves(
    manipulator: Manipulator,
    length: Exact,
    *,
    fixed_leg: int = 1,
    tolerance: Exact = DEFAULT_TOLERANCE,
    digits: int = MIN_DIGITS,
) -> SingularCurves:
    """The singular curves J = 0 of a slice, in the planes of (α, θ) and of the free legs.

    Args:
        manipulator: the geometry.
        length: of the fixed leg, exact (see :data:`Exact`), > 0, in the user's unit.
        fixed_leg: the leg of fixed length, 1, 2 or 3.
        tolerance: the deviation of the drawn curves, relative to the size of the pictures, 0.000001 to 0.1.
        digits: significant digits of the special points, 15 to 10000; all are proved.

    Raises:
        InputError: naming ``manipulator``, the length by its leg, ``fixed_leg``, ``tolerance`` or ``digits``.
        SolverError: the slice could not be decided, or has a curve that is not supported.

    >>> from rpr_solver import EXAMPLES
    >>> curves = singular_curves(EXAMPLES["innocenti"], "14.98")
    >>> curves
    <SingularCurves L1=14.98: 1 component, 6 cusps>
    """
    leg = check_leg(fixed_leg)
    exact, chord, digits = slice_length(length, leg), check_tolerance(tolerance), check_digits(digits)
    return trace_slice(kept_eliminant(manipulator, leg), exact, tolerance=chord, digits=digits)


def trace_slice(
    eliminant: Eliminant,
    length: Exact,
    *,
    tolerance: Exact = DEFAULT_TOLERANCE,
    digits: int = MIN_DIGITS,
) -> SingularCurves:
    """As :func:`singular_curves`; several slices of one manipulator share its eliminant.

    Args:
        eliminant: of the manipulator and its fixed leg (see :func:`eliminate`).
        length: of the fixed leg, exact, > 0, in the user's unit.
        tolerance: the deviation of the drawn curves, relative to the size of the pictures.
        digits: significant digits of the special points.

    Raises:
        InputError: naming the argument that is wrong.
        SolverError: the slice could not be decided, or has a curve that is not supported.

    >>> from rpr_solver import EXAMPLES, eliminate
    >>> eliminant = eliminate(EXAMPLES["innocenti"])
    >>> [len(trace_slice(eliminant, length).components) for length in ("14.98", 27)]
    [1, 3]
    """
    check_type(eliminant, Eliminant, "eliminant")
    slice_map = eliminant.slice_map
    eliminant.manipulator.geometry.with_drawn_curves(slice_map.fixed_leg)
    exact, digits = slice_length(length, slice_map.fixed_leg), check_digits(digits)
    chord = check_tolerance(tolerance)
    table = solve_slice(eliminant, exact, digits)

    @cache
    def finer(number: int, digits: int) -> JointPoint:
        return solve_slice(eliminant, exact, digits).cusps[number - 1]

    def drawn(topology: Sweep) -> Drawing:
        try:
            return Drawing(topology, table.cusps, finer, float(chord), digits)
        except NotPlaced:
            chart = topology.chart
            turns = turns_of(slice_map.rho)
            others = turns[turns.index((chart.alpha, chart.theta)) + 1 :]
            if not others:
                raise
            return drawn(sweep(slice_map, chart.length, others))

    drawing = drawn(sweep(slice_map, exact * slice_map.scale))
    chains = components(drawing.sweep)
    parts = tuple(SingularComponent(tuple(map(drawing.strand, part))) for part in chains)
    return SingularCurves(
        eliminant.manipulator,
        slice_map.fixed_leg,
        exact,
        digits,
        chord,
        parts,
        table,
        drawing,
        tuple(chain for part in chains for chain in part),
    )


def check_tolerance(tolerance: Exact) -> Fraction:
    """Returns a tolerance as an exact number.

    Raises:
        InputError: naming ``tolerance``: not an exact number, or out of range.
    """
    exact = parse_exact(tolerance, "tolerance")
    if not FINEST_TOLERANCE <= exact <= COARSEST_TOLERANCE:
        raise InputError.of("tolerance", f"is {exact_str(exact)}; give 0.000001 to 0.1")
    return exact


def singular_csv(document: Mapping[str, Any]) -> str:
    """The document of singular curves as CSV: a line for each sample of each strand.

    Special points have their ``kind``, and cusps their number; in these lines too the numbers are the floats
    of the samples.

    >>> from rpr_solver import EXAMPLES, singular_curves
    >>> lines = singular_csv(singular_curves(EXAMPLES["zein-flat"], 34).to_json()).splitlines()
    >>> lines[0]
    'component,strand,alpha_deg,theta1_deg,l2,l3,kind,cusp'
    >>> sum("cusp" in line for line in lines[1:])
    6
    """
    names = coordinate_names(document["fixed_leg"])
    rows: list[Mapping[str, object]] = []
    for part, component in enumerate(document["components"], 1):
        for number, strand in enumerate(component["strands"], 1):
            special = {vertex["index"]: vertex for vertex in strand["vertices"]}
            for index, values in enumerate(zip(*(strand[name] for name in names), strict=True)):
                vertex = special.get(index, {})
                kind = {"kind": vertex.get("kind"), "cusp": vertex.get("cusp")}
                rows.append(
                    {"component": part, "strand": number, **dict(zip(names, values, strict=True)), **kind}
                )
    return csv_text(["component", "strand", *names, "kind", "cusp"], rows)
