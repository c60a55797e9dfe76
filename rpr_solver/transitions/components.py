"""The curves of the torus (α, θ) on which the degenerate poses of all slices lie, each with L as a function.

J/L is linear in L. Its factors without L are *walls*, curves that are singular for every L; one factor
p0 + L p1 is left, a *graph*: L = −p0/p1. Degenerate poses of the graph are on walls or have v·∇L = 0 there,
those of a wall h have v·∇h = e0 + L e1 = 0. So they lie on finitely many irreducible curves, each with L =
−zeroth/first (mathematics.md#events-on-components). This serves where the events
are not isolated.

On a component L is a rational function, and the degenerate poses of a slice are its points of that length. So
they appear, vanish or meet only where L is critical along the curve, where another curve crosses it, or at a
*resting* pose, where numerator and denominator of L vanish. Near a resting pose L has finitely many limits,
roots of the lowest coefficient of an eliminant (mathematics.md#events-on-components)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

from flint import fmpq, fmpz_mpoly

from rpr_solver.errors import SolverError
from rpr_solver.exact.biform import (
    BiForm,
    L,
    along_alpha,
    along_theta,
    by_length,
    curves,
    divides,
    leading_coefficient,
    rational_form,
    value,
)
from rpr_solver.exact.factors import roots_of
from rpr_solver.exact.number_field import (
    Algebraic,
    Extension,
    Polynomial,
    adjoin_real_roots,
    evaluate,
    squarefree_part,
    trimmed,
)
from rpr_solver.exact.real_roots import fraction_of
from rpr_solver.model.jets import Pose
from rpr_solver.model.joint_points import ExactPose, PoseKind, common_poses, tan_half
from rpr_solver.model.slice_map import Leg, SliceMap, excess, half_angles, slopes
from rpr_solver.transitions.event_systems import Event, Landmark, System
from rpr_solver.transitions.exact_events import DirectedEvent, event, event_at, limits_at, special_lengths

_T, _U, _L = range(3)
_NEAR, _NEAR_BITS = Fraction(1, 1 << 20), 64


@dataclass(frozen=True)
class Component:
    """An irreducible curve of degenerate poses, those of the length L = −zeroth/first.

    Its points with ``turning`` = 0 are critical for L along the curve; where one of ``crossing`` is 0, it
    meets another such curve. If it is ``live``, its cusps are other points, else only resting poses may be.
    """

    curve: BiForm
    zeroth: BiForm
    first: BiForm
    turning: BiForm
    crossing: tuple[BiForm, ...]
    live: bool


@dataclass(frozen=True)
class Components:
    """All components of one slice map, and where they are not smooth functions of L.

    ``graph`` is p0 + L p1 as (p0, p1), None if J has no such factor; ``walls`` says whether it has others.
    """

    slice_map: SliceMap
    components: tuple[Component, ...]
    graph: tuple[BiForm, BiForm] | None
    walls: bool

    @classmethod
    def of(cls, slice_map: SliceMap) -> Components:
        """Factors J and the conditions of a cusp.

        Raises:
            SolverError: the coefficients are not rational.
        """
        singular = slice_map.singular
        if singular.b:
            raise SolverError("the census of this degenerate geometry is not supported: irrational height")
        rho = slice_map.rho
        factors = list(curves(singular, rho))
        walls = [(curve, multiplicity) for curve, multiplicity in factors if curve.a.degrees()[2] == 0]
        graphs = [by_length(curve) for curve, _ in factors if curve.a.degrees()[2] > 0]
        graph = graphs[0] if graphs else None
        gradients = [_Gradient.of(leg) for leg in (slice_map.f, slice_map.g)]
        names = [curve for curve, _ in walls]
        components = [] if graph is None else list(_of_graph(*graph, gradients[0], names, rho))
        for wall, multiplicity in walls:
            if multiplicity == 1:
                others = [curve for curve in names if curve is not wall]
                components += _of_wall(wall, gradients, others, graph, rho)
        return cls(slice_map, tuple(components), graph, bool(walls))

    def events(self) -> Iterator[Event]:
        """Every L > 0 at which a number of degenerate poses can change, with those that cusps may meet."""
        for component in self.components:
            for form in (component.turning, *component.crossing):
                for pose in _located(self.slice_map, component, form):
                    yield Landmark(pose.length)
                    for landmark in event(self.slice_map, pose) if component.live else ():
                        yield replace(landmark, lasting=self._crosses(landmark))
        for pose in self._resting:
            yield from self._beside(pose, special_lengths(self.slice_map, pose))
            for component in self.components:
                for limit in _limits(component, pose):
                    yield Landmark(limit.root)
                    yield from self._beside(pose, event_at(self.slice_map, pose, limit))

    def _beside(self, pose: Pose[Algebraic], landmarks: Iterable[Landmark]) -> Iterator[Landmark]:
        """Those at a pose that is singular for every L, and whether they last."""
        for landmark in landmarks:
            yield replace(landmark, lasting=self._crosses(landmark) or _lasts(self.slice_map, pose, landmark))

    def _crosses(self, landmark: Landmark) -> bool:
        """Whether two parts of the singular curve cross at an event, as they do nearby in other slices."""
        kinds = (PoseKind.NODE, PoseKind.ISOLATED_POINT)
        return self.walls and landmark.pose is not None and landmark.pose.kind in kinds

    def limit_events(self, leg: Leg, square: Fraction) -> Iterator[Event]:
        """The lengths L > 0 at which a cusp has, or may have, the squared free leg ``square`` (scaled).

        Raises:
            NotGeneric: these lengths are not isolated.
        """
        for component in self.components:
            if component.live:
                for pose in _located(self.slice_map, component, _at_square(component, leg, square)):
                    yield Landmark(pose.length)
        for pose in self._resting:
            yield from map(Landmark, limits_at(self.slice_map, pose, leg, square))

    @cached_property
    def _resting(self) -> list[Pose[Algebraic]]:
        """The poses at which L is undetermined, their lengths 1 a placeholder."""
        poses = [] if self.graph is None else list(_zeros(self.slice_map, *self.graph))
        for component in self.components:
            first, second = component.first, component.zeroth
            if divides(component.curve, first):
                first, second = second, first
            zeros = _zeros(self.slice_map, component.curve, first)
            poses += (pose for pose in zeros if _value(second, pose).is_zero)
        return poses


@dataclass(frozen=True)
class _Gradient:
    """A leg's f_α/2 = f0 + L f1 and f_θ/2 = L φ as forms of degree 2 in t and u."""

    f0: BiForm
    f1: BiForm
    phi: BiForm

    @classmethod
    def of(cls, leg: Leg) -> _Gradient:
        along, across = (half_angles(p, (1, 1), leg.rho, leg.radicand) for p in slopes(leg))
        return cls(*by_length(along), across)


def _of_graph(p0: BiForm, p1: BiForm, leg: _Gradient, walls: list[BiForm], rho: int) -> Iterator[Component]:
    """The components of L = −p0/p1: where v·∇L = 0, and the walls, where it crosses them."""
    m_alpha, m_theta = (p0 * d(p1, rho) - p1 * d(p0, rho) for d in (along_alpha, along_theta))
    # −p1³ v·∇L, with v = (−L φ, f0 + L f1)
    condition = p0 * leg.phi * m_alpha + (p1 * leg.f0 - p0 * leg.f1) * m_theta
    # without v·∇L anywhere but 0, all poses of the graph are degenerate and none is a cusp
    factors = [] if condition.is_zero else list(curves(condition, rho))
    useless = (p0, p1, leg.phi, *walls)
    names = [curve for curve, _ in factors if not any(divides(curve, form) for form in useless)]
    single = [curve for curve, multiplicity in factors if multiplicity == 1]
    for curve in (*names, *walls):
        others = tuple(other for other in (*names, *walls) if other is not curve)
        turning = _determinant(curve, m_alpha, m_theta, rho)
        live = any(curve is x for x in names) and any(curve is x for x in single)
        yield _component(curve, p0, p1, turning, others, live=live)


def _component(
    curve: BiForm, zeroth: BiForm, first: BiForm, turning: BiForm, crossing: Sequence[BiForm], *, live: bool
) -> Component:
    """With no turnings and crossings where one of them is the whole curve."""
    if any(divides(curve, form) for form in (first, turning, *crossing)):
        return Component(curve, zeroth, first, rational_form(curve.a**0, 0, 0), (), live=False)
    return Component(curve, zeroth, first, turning, tuple(crossing), live=live)


def _of_wall(
    wall: BiForm,
    legs: list[_Gradient],
    others: list[BiForm],
    graph: tuple[BiForm, BiForm] | None,
    rho: int,
) -> Iterator[Component]:
    """The cusps of a wall: once for each leg, whose gradients vanish at different poses."""
    components = []
    for leg in legs:
        e0 = leg.f0 * along_theta(wall, rho)
        e1 = leg.f1 * along_theta(wall, rho) - leg.phi * along_alpha(wall, rho)
        if divides(wall, e0) and divides(wall, e1):
            return
        m_alpha, m_theta = (e0 * d(e1, rho) - e1 * d(e0, rho) for d in (along_alpha, along_theta))
        turning = _determinant(wall, m_alpha, m_theta, rho)
        crossing = list(others)
        if graph is not None:
            crossing.append(e1 * graph[0] - e0 * graph[1])
        components.append(_component(wall, e0, e1, turning, crossing, live=True))
    yield from components


def _determinant(curve: BiForm, m_alpha: BiForm, m_theta: BiForm, rho: int) -> BiForm:
    return along_alpha(curve, rho) * m_theta - along_theta(curve, rho) * m_alpha


def distinct(group: Sequence[Event]) -> list[Event]:
    """Events of one L without repetitions, and without a pose only if none has one."""
    return [each for each in once(group) if isinstance(each.pose, ExactPose)] or list(group[:1])


def once(group: Sequence[Event]) -> list[Event]:
    """Events of one L, each exact pose once: it may solve several systems."""
    kept: list[Event] = []
    for each in group:
        if not any(_is_again(each, other) for other in kept):
            kept.append(each)
    return kept


def _is_again(x: Event, y: Event) -> bool:
    if isinstance(x, DirectedEvent) and isinstance(y, DirectedEvent):
        return x.is_at(y)
    return isinstance(x.pose, ExactPose) and isinstance(y.pose, ExactPose) and x.pose.is_at(y.pose)


def _lasts(slice_map: SliceMap, pose: Pose[Algebraic], landmark: Landmark) -> bool:
    """Whether a pose that is singular for every L is of one kind at, below and above the L of an event."""
    middle = fraction_of(landmark.scaled_length(_NEAR_BITS))
    near = (pose.omega.field(middle * (1 + sign * _NEAR)) for sign in (-1, 1))
    kinds = {ExactPose.of(slice_map, replace(pose, length=x)).kind for x in near}
    return landmark.pose is not None and kinds == {landmark.pose.kind}


def _zeros(slice_map: SliceMap, first: BiForm, second: BiForm) -> Iterator[Pose[Algebraic]]:
    """The real common zeros of two forms, of length 1."""
    eliminant = System.of(slice_map, first, second).eliminant
    for root in roots_of(eliminant):
        poses = common_poses(first, second, root, 1, slice_map.rho)
        if poses is None:
            raise SolverError(
                "a curve of degenerate poses holds a line theta = const; please report this geometry"
            )
        yield from poses


def _located(slice_map: SliceMap, component: Component, form: BiForm) -> Iterator[Pose[Algebraic]]:
    """The zeros of a form on a component, with their L if it is determined, finite and > 0."""
    for pose in _zeros(slice_map, component.curve, form):
        bottom = _value(component.first, pose)
        if not bottom.is_zero:
            length = -_value(component.zeroth, pose) * bottom.inverse()
            if length.sign > 0:
                yield replace(pose, length=length)


def _value(form: BiForm, pose: Pose[Algebraic]) -> Algebraic:
    t, u = tan_half(pose.cos_alpha, pose.sin_alpha), tan_half(pose.cos_theta, pose.sin_theta)
    return value(form, t, u, pose.omega)


def _at_square(component: Component, leg: Leg, square: Fraction) -> BiForm:
    """(f − square) first² at L = −zeroth/first, up to a constant factor."""
    one, linear, quadratic = (half_angles(p, (1, 1), leg.rho, leg.radicand) for p in excess(leg, square))
    zeroth, first = component.zeroth, component.first
    return one * first * first - linear * zeroth * first + quadratic * zeroth * zeroth


def _limits(component: Component, pose: Pose[Algebraic]) -> Iterator[Extension]:
    """All L > 0 to which the L of a component tends at a pose, and perhaps a few more."""
    t, u = tan_half(pose.cos_alpha, pose.sin_alpha), tan_half(pose.cos_theta, pose.sin_theta)
    if not value(component.curve, t, u, pose.omega).is_zero:
        return
    whole = component.zeroth.a + L * component.first.a
    if component.curve.degree_t:
        eliminant, place = _eliminant(component.curve, whole, component.zeroth.degree_t, _T), u
    else:
        eliminant, place = _eliminant(component.curve, whole, component.zeroth.degree_u, _U), t
    if not eliminant:
        return
    lowest = _lowest_coefficient(eliminant, place, pose.omega)
    for extension in adjoin_real_roots(pose.omega.field, squarefree_part(lowest)):
        if extension.root.sign > 0:
            yield extension


def _eliminant(curve: BiForm, p: fmpz_mpoly, degree: int, variable: int) -> fmpz_mpoly:
    """The resultant of a curve and a form of a formal degree in the variable that is eliminated."""
    missing = degree - p.degrees()[variable]
    if curve.a.is_one():
        return p * 0 if missing else leading_coefficient(p, variable)
    return curve.a.resultant(p, "tu"[variable]) * leading_coefficient(curve.a, variable) ** missing


def _lowest_coefficient(p: fmpz_mpoly, place: Algebraic | None, one: Algebraic) -> Polynomial:
    """The lowest coefficient, a polynomial in L, of a polynomial in L and t or u about a place (None: ∞)."""
    variable = _T if p.degrees()[_T] else _U
    if place is None:
        return _in_length(leading_coefficient(p, variable), one)
    while True:
        rows: list[Polynomial] = []
        for power in range(p.degrees()[_L] + 1):
            row = {k[variable]: c for k, c in p.to_dict().items() if k[_L] == power}
            rows.append([one.field(fmpq(row.get(i, 0))) for i in range(max(row, default=-1) + 1)])
        lowest = trimmed([evaluate(row, place) for row in rows])
        if lowest:
            return lowest
        p = p.derivative(variable)


def _in_length(p: fmpz_mpoly, one: Algebraic) -> Polynomial:
    coefficients = {k[_L]: c for k, c in p.to_dict().items()}
    return [one.field(fmpq(coefficients.get(i, 0))) for i in range(max(coefficients) + 1)]
