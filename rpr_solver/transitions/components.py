"""The curves of the torus (α, θ) on which the degenerate poses of all slices lie, each with L as a function.

J/L is linear in L. Its factors without L are *walls*, curves that are singular for every L; one factor
p0 + L p1 is left, a *graph*: L = −p0/p1. Degenerate poses of the graph are on walls or have v·∇L = 0 there,
those of a wall h have v·∇h = e0 + L e1 = 0. So they lie on finitely many irreducible curves, each with L =
−zeroth/first (mathematics.md#events-on-components). This serves where the events of events.py are not
isolated.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rpr_solver.errors import SolverError
from rpr_solver.exact.biform import BiForm
from rpr_solver.exact.torus_forms import (
    along_alpha,
    along_theta,
    by_length,
    curves,
    divides,
    form_sum,
    negative,
    rational_form,
)
from rpr_solver.model.slice_map import Leg, SliceMap, half_angles, slopes


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
        factors = list(curves(singular))
        walls = [(curve, multiplicity) for curve, multiplicity in factors if curve.a.degrees()[2] == 0]
        graphs = [by_length(curve) for curve, _ in factors if curve.a.degrees()[2] > 0]
        graph = graphs[0] if graphs else None
        gradients = [_Gradient.of(leg) for leg in (slice_map.f, slice_map.g)]
        names = [curve for curve, _ in walls]
        components = [] if graph is None else list(_of_graph(*graph, gradients[0], names))
        for wall, multiplicity in walls:
            if multiplicity == 1:
                others = [curve for curve in names if curve is not wall]
                components += _of_wall(wall, gradients, others, graph)
        return cls(slice_map, tuple(components), graph, bool(walls))


@dataclass(frozen=True)
class _Gradient:
    """A leg's f_α/2 = f0 + L f1 and f_θ/2 = L φ as forms of degree 2 in t and u."""

    f0: BiForm
    f1: BiForm
    phi: BiForm

    @classmethod
    def of(cls, leg: Leg) -> _Gradient:
        along, across = (half_angles(p, (1, 1), leg.radicand) for p in slopes(leg))
        return cls(*by_length(along), across)


def _of_graph(p0: BiForm, p1: BiForm, leg: _Gradient, walls: list[BiForm]) -> Iterator[Component]:
    """The components of L = −p0/p1: where v·∇L = 0, and the walls, where it crosses them."""
    m_alpha, m_theta = (
        form_sum(p0 * along(p1), negative(p1 * along(p0))) for along in (along_alpha, along_theta)
    )
    # −p1³ v·∇L, with v = (−L φ, f0 + L f1)
    condition = form_sum(p0 * leg.phi * m_alpha, form_sum(p1 * leg.f0, negative(p0 * leg.f1)) * m_theta)
    # without v·∇L anywhere but 0, all poses of the graph are degenerate and none is a cusp
    factors = [] if condition.is_zero else list(curves(condition))
    useless = (p0, p1, leg.phi, *walls)
    names = [curve for curve, _ in factors if not any(divides(curve, form) for form in useless)]
    single = [curve for curve, multiplicity in factors if multiplicity == 1]
    for curve in (*names, *walls):
        others = tuple(other for other in (*names, *walls) if other is not curve)
        turning = _determinant(curve, m_alpha, m_theta)
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
    wall: BiForm, legs: list[_Gradient], others: list[BiForm], graph: tuple[BiForm, BiForm] | None
) -> Iterator[Component]:
    """The cusps of a wall: once for each leg, whose gradients vanish at different poses."""
    found = []
    for leg in legs:
        e0 = leg.f0 * along_theta(wall)
        e1 = form_sum(leg.f1 * along_theta(wall), negative(leg.phi * along_alpha(wall)))
        if divides(wall, e0) and divides(wall, e1):
            return
        turning = _determinant(
            wall, *(form_sum(e0 * d(e1), negative(e1 * d(e0))) for d in (along_alpha, along_theta))
        )
        crossing = list(others)
        if graph is not None:
            crossing.append(form_sum(e1 * graph[0], negative(e0 * graph[1])))
        found.append(_component(wall, e0, e1, turning, crossing, live=True))
    yield from found


def _determinant(curve: BiForm, m_alpha: BiForm, m_theta: BiForm) -> BiForm:
    return form_sum(along_alpha(curve) * m_theta, negative(along_theta(curve) * m_alpha))
