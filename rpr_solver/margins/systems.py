"""The functions whose common zeros are degenerate cusps, over any ring, the six lengths being variables too.

In slice_map.py the lengths of base and platform are integers; here they are elements of the ring, so that all
can be differentiated by them. The fixed leg has the length λ/μ (μ = 1, or λ = 1 to include infinite lengths).
With the sinusoids of legs.py, half the squared length of a moving leg is, up to a factor and a constant,

    F = λ (p − b) − μ r,        F_θ = λ φ,

and K = F_α γ − φ G_α is J without its factors; v = (−λ φ, F_α) is tangent to F = const.

How the length of a transition changes with the lengths of the manipulator: ∂L*/∂g, with proved digits.

A transition is a simple zero of three functions of (α, θ, L), which depend on the six lengths g too
(mathematics.md#sensitivities). By the implicit function theorem ∂L*/∂g is the last row of −T_x⁻¹ T_g, here
computed in balls that hold the pose as it is printed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from flint import arb, arb_mat, arb_series, ctx

from rpr_solver.contract import LENGTHS
from rpr_solver.exact.decimals import round_ball
from rpr_solver.exact.plane import PlaneNumber
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.legs import Derivatives, Sinusoids, Waves, free_points
from rpr_solver.model.jets import Jet
from rpr_solver.model.joint_points import PoseKind
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.triangles import CW

Pair = tuple[Any, Any]
"""Two coordinates, or λ and μ."""

Choice = Callable[[Any, Any], Any]
"""Of an element for leg f and one for leg g, where a ring's elements stand for many boxes."""


def orientation_of(manipulator: Manipulator) -> int:
    """1 for a counter-clockwise platform, −1 for a clockwise and 0 for a flat one."""
    if manipulator.area16 == 0:
        return 0
    return -1 if manipulator.orientation == CW else 1


def third_corner(sides: Sequence[Any], orientation: int) -> Pair:
    """The third corner of a platform with the first two on the axis of x.

    Args:
        sides: d1, d2 and d3, in a ring with division and roots.
        orientation: 1 for counter-clockwise, -1 for clockwise, 0 for a flat platform.
    """
    d1, d2, d3 = sides
    along = (d1 - (d2 - d3) * (d2 + d3) / d1) / 2
    if not orientation:
        return along, d1 - d1
    area16 = (d1 + d2 + d3) * (d2 + d3 - d1) * (d1 + d3 - d2) * (d1 + d2 - d3)
    height = area16.sqrt() / d1 / 2
    return along, -height if orientation < 0 else height


def moving_legs(lengths: Sequence[Any], corner: Pair, fixed_leg: int) -> tuple[Waves, Waves]:
    """The waves of the two moving legs at α = θ = 0.

    Args:
        lengths: those of :data:`~rpr_solver.contract.LENGTHS`, in any ring.
        corner: the platform's third.
        fixed_leg: 1, 2 or 3.
    """
    a2x, a3x, a3y, d1, *_ = lengths
    f, g = free_points((a2x, a3x, a3y), (d1, *corner), fixed_leg, d1 - d1)
    return Waves.of(*f), Waves.of(*g)


@dataclass(frozen=True)
class _Slopes:
    """F_α and φ of one leg, as jets in α and θ."""

    alpha: Jet[Any]
    phi: Jet[Any]


@dataclass(frozen=True)
class Systems:
    """The functions at one pose.

    Attributes:
        turns: z, e and z ē: the turns by α, θ and α − θ.
        scales: λ and μ; a 1 may be an integer.
        legs: the waves of the moving legs f and g at α = θ = 0.
        order: that of the derivatives of K that are wanted: 0 for K alone, 1 for E and ∇K too, 2 for S.
        limited: whether squared lengths are wanted, too.
        sinusoids: those of both legs, without λ and with μ; from the turns, unless given.
        known: K to a lower order, if it is known.
    """

    turns: Sequence[PlaneNumber[Any]]
    scales: Pair
    legs: tuple[Waves, ...]
    order: int = 2
    limited: bool = True
    sinusoids: tuple[Sinusoids, ...] = ()
    known: Jet[Any] | None = None

    @cached_property
    def _sinusoids(self) -> tuple[Sinusoids, ...]:
        if self.sinusoids:
            return self.sinusoids
        (alpha, theta, between), (_, mu) = self.turns, self.scales
        return tuple(
            leg._replace(platform=leg.platform * mu).turned(between, theta, alpha) for leg in self.legs
        )

    @cached_property
    def _slopes(self) -> tuple[_Slopes, _Slopes]:
        f, g = (leg.slope_derivatives(self.scales[0]) for leg in self._sinusoids)
        return self._jets(f), self._jets(g)

    def _jets(self, slopes: tuple[Derivatives, Derivatives]) -> _Slopes:
        alpha, phi = (Jet.build(self.order, slope) for slope in slopes)
        return _Slopes(alpha, phi)

    @cached_property
    def singularity(self) -> Jet[Any]:
        """K, zero at singular poses."""
        f, g = self._slopes

        def entry(i: int, j: int) -> Any:
            if self.known is not None and i + j <= self.known.order:
                return self.known.table[i][j]
            return f.alpha.of_product(g.phi, i, j) - f.phi.of_product(g.alpha, i, j)

        return Jet.build(self.order, entry)

    def _chosen(self, leg: int | Choice) -> _Slopes:
        """Those of one leg, as far as derivatives of K along it need them."""
        if isinstance(leg, int):
            return self._slopes[leg]

        f, g = ([x.up_to(max(self.order - 1, 0)) for x in (own.alpha, own.phi)] for own in self._slopes)
        return _Slopes(*(x.joined(y, leg) for x, y in zip(f, g, strict=True)))

    def along(self, leg: int | Choice, function: Jet[Any]) -> Jet[Any]:
        """v·∇function for leg f (0) or g (1), or for the one that is chosen."""
        slopes, lam = self._chosen(leg), self.scales[0]
        across = slopes.phi * function.alpha
        across = Jet.build(across.order, lambda i, j: across.table[i][j] * lam)
        return slopes.alpha * function.theta - across

    def swallowtails(self, leg: int | Choice) -> list[Jet[Any]]:
        """K, E and S, all zero where four poses coalesce, with v of leg f (0) or g (1)."""
        e = self.along(leg, self.singularity)
        return [self.singularity, e, self.along(leg, e)]

    @property
    def critical(self) -> list[Jet[Any]]:
        """K and its derivatives by α and θ, all zero where the singular curve is not smooth."""
        k = self.singularity
        return [k, k.alpha, k.theta]

    def of_pose(self, kind: str, leg: int) -> list[Any]:
        """Those of which a degenerate pose of some kind is a common zero."""
        found = self.swallowtails(leg) if kind == PoseKind.SWALLOWTAIL else self.critical
        return [jet.value for jet in found]

    def tangent(self, leg: int | Choice) -> Pair:
        """The components of v, the first without λ, for leg f (0) or g (1), or for the one that is chosen."""
        slopes = self._chosen(leg)
        return slopes.phi.value, slopes.alpha.value

    def mapped(self, function: Callable[[Any], Any], order: int) -> Systems:
        """The same functions, with all that they are made of mapped to another ring."""

        def number(of: PlaneNumber[Any]) -> PlaneNumber[Any]:
            return PlaneNumber(function(of.real), function(of.imag))

        lam, mu = (scale if isinstance(scale, int) else function(scale) for scale in self.scales)
        legs = tuple(Waves(*map(number, leg)) for leg in self.legs) if self.limited else ()
        sinusoids = tuple(Sinusoids(*map(function, leg)) for leg in self._sinusoids)
        known = self.singularity.mapped(function)
        return Systems((), (lam, mu), legs, order, self.limited, sinusoids, known)

    def excess(self, leg: int, square: Any) -> Any:
        """The squared length of leg f (0) or g (1), less ``square``; for μ = 1 alone."""
        lam, (m, a, _) = self.scales[0], self.legs[leg]
        rest = lam * lam - square
        for x in (m.real, m.imag, a.real, a.imag):
            rest = rest + x * x
        return self._sinusoids[leg].value(lam) * 2 + rest


_POSE = 3
"""α, θ and L come first among the variables."""
_BITS_PER_DIGIT = 4
"""Working precision for each digit, a little more than log₂ 10."""
_MORE_BITS = 128
"""Working precision beyond that of the digits, for what cancels."""


def with_sensitivities(document: Mapping[str, Any]) -> dict[str, Any]:
    """A census document with ``sensitivity`` in each event of its transitions.

    It is an object with ∂L*/∂g for each length g of the geometry, in proved digits. A member is None if no
    digit is proved, as of 0, or if there is no derivative, as by the sides of a flat platform. Instead of
    the object there is None, and ``"singular": True``, where the pose is not proved to be a simple one: any
    change of the geometry may resolve it, as it does a node.

    Args:
        document: :meth:`Census.to_json`.

    >>> from rpr_solver import EXAMPLES, census
    >>> table = census(EXAMPLES["innocenti"], start=27, stop="28.1", digits=15)
    >>> with_sensitivities(table.to_json())["transitions"][0]["events"][0]["sensitivity"]["a2x"]
    '-0.8645344919'
    """
    manipulator, leg = Manipulator.from_json(document["geometry"], max_digits=1 << 20), document["fixed_leg"]
    digits = document["digits"]
    transitions = []
    for transition in document["transitions"]:
        events = []
        for event in transition["events"]:
            slopes = sensitivity(manipulator, leg, transition[f"l{leg}"], event, digits)
            if slopes is None:
                events.append({**event, "sensitivity": None, "singular": True})
            else:
                events.append({**event, "sensitivity": {g: _text(x, digits) for g, x in slopes.items()}})
        transitions.append({**transition, "events": events})
    return {**document, "transitions": transitions}


def sensitivity(
    manipulator: Manipulator, fixed_leg: int, length: str, event: Mapping[str, str], digits: int
) -> dict[str, arb] | None:
    """∂L*/∂g for each length g, as balls, NaN if there is none; None if the pose is not proved to be simple.

    Args:
        manipulator: the geometry.
        fixed_leg: 1, 2 or 3.
        length: L*, a correctly rounded decimal, in the user's unit.
        event: a degenerate pose of the transition, as documents have it.
        digits: the significant digits of ``length`` and ``event``.
    """
    kind = event["kind"]
    if kind not in (PoseKind.SWALLOWTAIL, PoseKind.LIPS, PoseKind.BEAK_TO_BEAK):
        return None
    with ctx.workprec(_BITS_PER_DIGIT * digits + _MORE_BITS):
        texts = event["alpha_deg"], event[f"theta{fixed_leg}_deg"], length
        alpha, theta, fixed = (_printed(text, digits) for text in texts)
        start = [alpha * arb.pi() / 180, theta * arb.pi() / 180, fixed]
        start += manipulator.balls()
        systems = [
            _systems(
                [arb_series([x, k == moved], prec=2) for k, x in enumerate(start)], manipulator, fixed_leg
            )
            for moved in range(len(start))
        ]
        f, g = (sum(abs(x[0].mid()) for x in systems[0].tangent(leg)) for leg in (0, 1))
        columns = [[function[1] for function in x.of_pose(kind, int(f < g))] for x in systems]
        at_pose, beside = (arb_mat(part).transpose() for part in (columns[:_POSE], columns[_POSE:]))
        try:
            solved = at_pose.solve(beside)
        except ZeroDivisionError:
            return None
        slopes = {name: -solved[_POSE - 1, k] for k, name in enumerate(LENGTHS)}
    if orientation_of(manipulator) == 0:
        slopes.update(dict.fromkeys(("d1", "d2", "d3"), arb("nan")))
    return slopes


def slopes_in_floats(
    manipulator: Manipulator, fixed_leg: int, length: str, event: Mapping[str, str], digits: int
) -> tuple[float, ...] | None:
    """As :func:`sensitivity`, in floats, 0 where there is none."""
    slopes = sensitivity(manipulator, fixed_leg, length, event, digits)
    if slopes is None:
        return None
    return tuple(0.0 if slopes[g].is_nan() else float(slopes[g]) for g in LENGTHS)


def _systems(at: Sequence[arb_series], manipulator: Manipulator, fixed_leg: int) -> Systems:
    alpha, theta, fixed, *lengths = at
    between = alpha - theta
    turns = [PlaneNumber(angle.cos(), angle.sin()) for angle in (alpha, theta, between)]
    legs = moving_legs(lengths, third_corner(lengths[3:], orientation_of(manipulator)), fixed_leg)
    return Systems(turns, (fixed, 1), legs)


def _printed(text: str, digits: int) -> arb:
    """A ball that holds the number which is printed so, correctly rounded."""
    x = Fraction(text)
    return ball_of(x) + arb(0, ball_of(abs(x) / 10 ** (digits - 1)))


def _text(x: arb, digits: int) -> str | None:
    """As many digits as are proved, at most ``digits``; None if there is none."""
    with ctx.workprec(_BITS_PER_DIGIT * digits + _MORE_BITS):
        return next((text for n in range(digits, 0, -1) if (text := round_ball(x, n)) is not None), None)
