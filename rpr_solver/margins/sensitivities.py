"""How the length of a transition changes with the lengths of the manipulator: ∂L*/∂g, with proved digits.

A transition is a simple zero of three functions of (α, θ, L), which depend on the six lengths g too
(mathematics.md#sensitivities). By the implicit function theorem ∂L*/∂g is the last row of −T_x⁻¹ T_g, here
computed in balls that hold the pose as it is printed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from flint import arb, arb_mat, arb_series, ctx

from rpr_solver.exact.decimals import round_ball
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.margins.questions import LENGTHS
from rpr_solver.margins.systems import Systems, moving_legs, orientation_of
from rpr_solver.model.classify import PoseKind
from rpr_solver.model.manipulator import Manipulator

_POSE = 3
"""α, θ and L come first among the variables."""
_BITS_PER_DIGIT, _MORE_BITS = 4, 128


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
    manipulator, leg = Manipulator.from_json(document["geometry"]), document["fixed_leg"]
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
        start += (ball_of(getattr(manipulator, name)) for name in LENGTHS)
        systems = [
            _systems(
                [arb_series([x, k == moved], prec=2) for k, x in enumerate(start)], manipulator, fixed_leg
            )
            for moved in range(len(start))
        ]
        f, g = (sum(abs(x[0].mid()) for x in systems[0].tangent(leg)) for leg in (0, 1))
        columns = [[function[1] for function in _functions(x, kind, int(f < g))] for x in systems]
        at_pose, beside = (arb_mat(part).transpose() for part in (columns[:_POSE], columns[_POSE:]))
        try:
            solved = at_pose.solve(beside)
        except ZeroDivisionError:
            return None
        slopes = {name: -solved[_POSE - 1, k] for k, name in enumerate(LENGTHS)}
    if orientation_of(manipulator) == 0:
        slopes.update(dict.fromkeys(("d1", "d2", "d3"), arb("nan")))
    return slopes


def _systems(at: Sequence[arb_series], manipulator: Manipulator, fixed_leg: int) -> Systems:
    alpha, theta, fixed, *lengths = at
    between = alpha - theta
    turn, direction, difference = ((angle.cos(), angle.sin()) for angle in (alpha, theta, between))
    legs = moving_legs(lengths, orientation_of(manipulator), fixed_leg)
    return Systems(turn, direction, difference, (fixed, 1), legs)


def _functions(systems: Systems, kind: str, leg: int) -> list[arb_series]:
    """Those of which the pose of an event is a common zero."""
    k = systems.singularity
    if kind != PoseKind.SWALLOWTAIL:
        return [k.value, k.alpha.value, k.theta.value]
    e = systems.along(leg, k)
    return [k.value, e.value, systems.along(leg, e).value]


def _printed(text: str, digits: int) -> arb:
    """A ball that holds the number which is printed so, correctly rounded."""
    x = Fraction(text)
    return ball_of(x) + arb(0, ball_of(abs(x) / 10 ** (digits - 1)))


def _text(x: arb, digits: int) -> str | None:
    """As many digits as are proved, at most ``digits``; None if there is none."""
    with ctx.workprec(_BITS_PER_DIGIT * digits + _MORE_BITS):
        return next((text for n in range(digits, 0, -1) if (text := round_ball(x, n)) is not None), None)
