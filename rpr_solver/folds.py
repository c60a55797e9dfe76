"""Transitions seen from the cusps that meet there: where a curve of cusps turns back in L.

Needed where events are not isolated (discriminant.py), so that no system of equations gives their poses. A
tube that leads two cusps into each other holds a pose at which D = J_x E_y − J_y E_x vanishes: a swallowtail
or, with ∇J = 0, lips or beaks. Krawczyk's test on three equations in (x, y, z) encloses it, to any precision.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction

from flint import arb, arb_mat, ctx

from rpr_solver.cusps import MIN_DIGITS
from rpr_solver.errors import SolverError
from rpr_solver.events import Event, critical_kind, swallowtail_kind
from rpr_solver.following import Follower
from rpr_solver.jets import LocalMap, Pose
from rpr_solver.neighbourhood import (
    CuspForms,
    Expansion,
    Frame,
    Neighbourhood,
    Place,
    Three,
    at_parameter,
    values,
)
from rpr_solver.roots import omega_ball
from rpr_solver.survey import Survey
from rpr_solver.tracker import Tracker
from rpr_solver.tubes import Tube

_FIRST_BITS, _MAX_BITS = 256, 1 << 12
_NEWTON_STEPS = 64
Box = tuple[Place, arb]
"""A pose and its length (scaled)."""


@dataclass(frozen=True)
class Fold:
    """A pose at which two cusps meet: ``box`` holds it, and no other zero of its equations is near.

    "Near" is within ``radius`` of the origin of ``frame``.
    """

    forms: CuspForms
    kind: str
    frame: Frame
    radius: arb
    box: Box

    @property
    def exact_length(self) -> None:
        """Not known as an algebraic number."""
        return None

    def scaled_length(self, bits: int) -> arb:
        """L (scaled) as a ball."""
        return self._refined(bits)[1]

    def coordinates(self, bits: int) -> tuple[arb, arb, arb, arb]:
        """α and θ in degrees, and the free legs in the user's unit."""
        box = self._refined(bits)
        with ctx.workprec(bits):
            surface, pose = self.forms.surface, _pose(self.forms, box, bits)
            f, g = LocalMap.at(surface, pose, 0).squared_lengths(surface, pose)
            scale = surface.scale_ball()
            return box[0].alpha.degrees(), box[0].theta.degrees(), f.sqrt() / scale, g.sqrt() / scale

    def holds(self, box: Box) -> bool:
        """Proof that a box lies where there is no other zero."""
        with ctx.workprec(_MAX_BITS):
            return all(abs(x) < self.radius for x in self.frame.inside(*box))

    def _refined(self, bits: int) -> Box:
        found = _enclosed(self.forms, self.box, bits, critical=self.kind != "swallowtail")
        if found is None or not self.holds(found.box):
            raise SolverError("a transition of merging cusps could not be refined")
        return found.box


def with_folds(found: Survey) -> Survey:
    """A survey in which the transitions that had no pose have those of the cusps that merge there."""
    if all(any(event.kind for event in group) for group in found.groups):
        return found
    tracker = Tracker(found.eliminant, MIN_DIGITS)
    groups = []
    for k, group in enumerate(found.groups):
        named = any(event.kind for event in group)
        lengths = (table.length for table in found.slices[k : k + 2])
        groups.append(group if named else (*group, *_folds_between(tracker, *lengths)))
    return replace(found, groups=tuple(groups))


def _folds_between(tracker: Tracker, below: Fraction, above: Fraction) -> tuple[Event, ...]:
    """The folds between two slices; none at all if one of them could not be enclosed."""
    ways = list(_turning(tracker, below, above))
    folds = [fold for way in ways if (fold := _fold(tracker.forms, way)) is not None]
    return tuple(folds) if len(folds) == len(ways) else ()


def _turning(tracker: Tracker, below: Fraction, above: Fraction) -> Iterator[Follower]:
    """For each two cusps that meet between two slices the way from one to the other."""
    everything = range(tracker.table(below).count)
    upwards = {i: tracker.follower((below, i), upwards=True) for i in everything}
    met = tracker.destinations(upwards, below, above)
    yield from (upwards[i] for i, (length, j) in met.items() if length == below and i < j)
    arrived = {j for length, j in met.values() if length == above}
    born = [i for i in range(tracker.table(above).count) if i not in arrived]
    downwards = {i: tracker.follower((above, i), upwards=False) for i in born}
    met = tracker.destinations(downwards, below, above)
    yield from (downwards[i] for i, (length, j) in met.items() if length == above and i < j)


def _fold(forms: CuspForms, way: Follower) -> Fold | None:
    """The one place at which a way turns back in L; None where it is not enclosed."""
    found = [fold for tube in way.turns if (fold := _fold_in(forms, tube)) is not None]
    # neighbouring tubes may hold the same one
    return found[0] if found and all(found[0].holds(fold.box) for fold in found) else None


def _fold_in(forms: CuspForms, tube: Tube) -> Fold | None:
    """The pose in a tube at which its curve turns back in L, with its kind."""
    bits = _FIRST_BITS
    while bits <= _MAX_BITS:
        with ctx.workprec(bits):
            turn = _enclosed(forms, tube.turn(), bits, critical=False)
            if turn is None or not tube.holds(*turn.box):
                return None
            local = LocalMap.at(forms.surface, _pose(forms, turn.box, bits), 4)
            if (kind := swallowtail_kind(local)) is not None:
                return replace(turn, kind=kind)
            critical = _enclosed(forms, turn.box, bits, critical=True)
            if (
                critical is not None
                and turn.holds(critical.box)
                and (kind := critical_kind(local)) is not None
            ):
                return replace(critical, kind=kind)
        bits *= 2
    return None


def _enclosed(forms: CuspForms, near: Box, bits: int, *, critical: bool) -> Fold | None:
    """The fold to which Newton's method leads, in a box that holds no other; None without such a box."""
    work = 2 * bits
    with ctx.workprec(work):
        box, tiny = near, arb(2) ** -(bits + bits // 2)
        for _ in range(_NEWTON_STEPS):
            around = Neighbourhood.at(forms, *box, work)
            origin = arb(0), arb(0), arb(0)
            step = _newton_step(*_equations(around, origin, critical))
            if step is None:
                return None
            box = around.frame.outside(step[0], step[1]), around.frame.length * (1 + step[2])
            if all(abs(x) < tiny for x in step):
                break
        around = Neighbourhood.at(forms, *box, work)
        radius = arb(2) ** -(bits // 2)
        inner = _krawczyk(around, radius, critical)
        if inner is None:
            return None
        x, y, z = inner
        frame = around.frame
        return Fold(forms, "", frame, radius, (frame.outside(x, y), frame.length * (1 + z)))


def _krawczyk(around: Neighbourhood, radius: arb, critical: bool) -> Three | None:
    """The image of a box about the origin, if it lies within: it holds the one zero that the box has."""
    values_there, slopes_there = _equations(around, (arb(0), arb(0), arb(0)), critical)
    around_it = arb(0, radius), arb(0, radius), arb(0, radius)
    _, slopes = _equations(around, around_it, critical)
    try:
        inverse = _middles(_middles(slopes_there).inv())
    except ZeroDivisionError:
        return None
    identity = arb_mat(3, 3, [int(i == j) for i in range(3) for j in range(3)])
    box = arb_mat(3, 1, list(around_it))
    image = (identity - inverse * slopes) * box - inverse * values_there
    x, y, z = (image[i, 0] for i in range(3))
    return (x, y, z) if all(abs(w) < radius for w in (x, y, z)) else None


def _newton_step(values_there: arb_mat, slopes: arb_mat) -> Three | None:
    try:
        step = _middles(slopes).solve(_middles(values_there))
    except ZeroDivisionError:
        return None
    x, y, z = (-step[i, 0].mid() for i in range(3))
    return (x, y, z) if all(w.is_finite() and abs(w) < 1 for w in (x, y, z)) else None


def _middles(m: arb_mat) -> arb_mat:
    return arb_mat(m.nrows(), m.ncols(), [x.mid() for x in m.entries()])


def _equations(around: Neighbourhood, at: Three, critical: bool) -> tuple[arb_mat, arb_mat]:
    """J, E, D (or J, J_x, J_y) and their derivatives by x, y, z, over a box in local coordinates."""
    j, e = (_derivatives(form, at) for form in around.forms)
    if critical:
        column = [j["0"], j["x"], j["y"]]
        rows = [[j["x"], j["y"], j["z"]], [j["xx"], j["xy"], j["xz"]], [j["xy"], j["yy"], j["yz"]]]
        return arb_mat(3, 1, column), arb_mat(rows)
    column = [j["0"], e["0"], j["x"] * e["y"] - j["y"] * e["x"]]
    last = [
        j["x" + w] * e["y"] + j["x"] * e["y" + w] - j["y" + w] * e["x"] - j["y"] * e["x" + w] for w in "xyz"
    ]
    return arb_mat(3, 1, column), arb_mat([[j[w] for w in "xyz"], [e[w] for w in "xyz"], last])


def _derivatives(form: Expansion, at: Three) -> dict[str, arb]:
    x, y, z = at
    still = values(at_parameter(form, z), x, y, 2)
    moving = values(form[1] + form[2] * (2 * z), x, y)
    found = {"0": still[0, 0], "x": still[1, 0], "y": still[0, 1], "z": moving[0, 0]}
    found |= {"xx": still[2, 0], "xy": still[1, 1], "yx": still[1, 1], "yy": still[0, 2]}
    return found | {"xz": moving[1, 0], "yz": moving[0, 1]}


def _pose(forms: CuspForms, box: Box, bits: int) -> Pose[arb]:
    (cos_a, sin_a), (cos_t, sin_t) = box[0].alpha.cos_sin(), box[0].theta.cos_sin()
    return Pose(cos_a, sin_a, cos_t, sin_t, box[1], omega_ball(forms.surface.radicand, bits))
