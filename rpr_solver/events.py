"""The events of a manipulator: each pose at which cusps of the slices meet, with its L, proved by balls.

An event is a real common zero of one of the systems of transitions.py with L = −J0/J1 > 0. That
leaves out poses that are singular at every L, which are looked at exactly, one by one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from flint import arb, ctx, fmpz_poly, nmod_poly

from rpr_solver.errors import SolverError
from rpr_solver.jets import LocalMap, Pose
from rpr_solver.poses import HalfTangent, common_root
from rpr_solver.roots import RealPolynomial, RealRoot, omega_ball, real_roots
from rpr_solver.surface import Surface
from rpr_solver.transitions import EventSystems, Form, NotGeneric, System

_START_BITS = 256
_MAX_BITS = 1 << 15
_CHECK_PRIMES = 4


@dataclass(frozen=True)
class EventBalls:
    """One event at one precision: the fixed length L (scaled), the pose, the squared free legs, the kind."""

    length: arb
    t: HalfTangent
    u: arb
    f: arb
    g: arb
    kind: str


@dataclass(frozen=True)
class Event:
    """A real event; ``balls`` computes it to any precision."""

    surface: Surface
    system: System
    root: RealRoot
    swallowtail: bool

    def length(self, bits: int) -> arb | None:
        """L (scaled), whatever its sign."""
        located = self._located(bits)
        return located and located[0]

    def balls(self, bits: int) -> EventBalls | None:
        """The event with about ``bits`` bits, or None where that precision does not prove its kind."""
        located = self._located(bits)
        if located is None:
            return None
        length, t, u = located
        with ctx.workprec(bits + 64):
            pose = _pose(self.surface, t, u, length, bits + 64)
            local = LocalMap.at(self.surface, pose, 4)
            kind = _swallowtail(local) if self.swallowtail else _critical(local)
            f, g = local.squared_lengths(self.surface, pose)
            if kind is None or not (f > 0 and g > 0):
                return None
            return EventBalls(length, t, u, f, g, kind)

    def _located(self, bits: int) -> tuple[arb, HalfTangent, arb] | None:
        work = bits + 64
        u = self.root.refined(bits)
        with ctx.workprec(work):
            first, second = (
                [RealPolynomial(*row[0], self.surface.radicand).ball(work)(u) for row in form.coefficients]
                for form in (self.system.first, self.system.second)
            )
            t = common_root(first, second)
            length = t and _length(self.surface, t, u, work)
            return (length, t, u) if t is not None and length is not None else None


def events(systems: EventSystems) -> Iterator[Event]:
    """All events with L > 0, in no order.

    Raises:
        NotGeneric: an event is not simple, so balls cannot tell it apart.
        SolverError: the sign of an L could not be decided.
    """
    for system, swallowtail in ((systems.swallowtails, True), (systems.critical, False)):
        if not _simple(systems.surface, system.eliminant):
            raise NotGeneric
        for root in real_roots(system.eliminant.real(systems.surface.radicand)):
            event = Event(systems.surface, system, root, swallowtail)
            if _positive(event):
                yield event


def _simple(surface: Surface, form: Form) -> bool:
    """Proof that the form has no root at infinity and no multiple one."""
    a, b = form.pair
    for (p, omega), _ in zip(surface.primes(), range(_CHECK_PRIMES), strict=False):
        residue = _modulo(a, p) + _modulo(b, p) * omega
        if residue.degree() == form.degree and residue.gcd(residue.derivative()).degree() == 0:
            return True
    return False


def _positive(event: Event) -> bool:
    bits = _START_BITS
    while bits <= _MAX_BITS:
        length = event.length(bits)
        if length is not None and not length.contains(0):
            return bool(length > 0)
        bits *= 2
    raise SolverError("the sign of a transition's length could not be decided")


def _length(surface: Surface, t: HalfTangent, u: arb, work: int) -> arb | None:
    """L = −J0/J1, from J at L = 1 and at L = −1."""
    plus, minus = (
        LocalMap.at(surface, _pose(surface, t, u, arb(sign), work), 1).singularity().value for sign in (1, -1)
    )
    length = (minus - plus) / (plus + minus)
    return length if length.is_finite() else None


def _pose(surface: Surface, t: HalfTangent, u: arb, length: arb, work: int) -> Pose[arb]:
    return Pose(*t.cos_sin(), *HalfTangent(u, arb(1)).cos_sin(), length, omega_ball(surface.radicand, work))


def _swallowtail(local: LocalMap[arb]) -> str | None:
    j = local.singularity()
    fourth = local.along(local.f, local.along(local.f, local.along(local.f, j)))
    rank = not all(x.value.contains(0) for x in (local.f.alpha, local.f.theta))
    smooth = not all(x.value.contains(0) for x in (j.alpha, j.theta))
    return "swallowtail" if rank and smooth and not fourth.value.contains(0) else None


def _critical(local: LocalMap[arb]) -> str | None:
    j = local.singularity()
    hessian = j.alpha.alpha.value * j.theta.theta.value - j.alpha.theta.value * j.alpha.theta.value
    third = local.along(local.f, local.along(local.f, j)).value
    if hessian.contains(0) or third.contains(0):
        return None
    return "lips" if hessian > 0 else "beak-to-beak"


def _modulo(polynomial: fmpz_poly, p: int) -> nmod_poly:
    return nmod_poly([int(c) % p for c in polynomial.coeffs()], p)
