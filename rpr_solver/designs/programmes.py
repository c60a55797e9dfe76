"""Linear programmes: where the first-order change of the transitions lets a geometry come nearer to its goal.

The variables are the change δ of the place, within a trust region and the bounds, and some of their own. The
transitions move by S·δ; which constraints they give depends on the objective.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise, product
from math import inf

import numpy as np

from rpr_solver.designs.goals import Cut, Profile, Vector, best_run, most_cusps, windows
from rpr_solver.designs.plan import LARGEST_MARGIN, LEAST_CHANGE, LONGEST_RANGE, MOST_CUSPS, Goal
from rpr_solver.exact.numerals import double
from rpr_solver.margins.estimates import Estimate, Mover, ways

_SHUT = 0.7
"""Windows are to get narrower than this share of the width at which they are ignored."""
_BEYOND = 0.02
"""Transitions are to pass each other by this part of their distance."""
_MISSED = 50.0
"""The cost of missing a constraint, per share of it that is missed."""
_WAYS = 6
"""How many ways to one more pair of cusps are tried."""
Stretch = tuple[int, int]
"""The numbers of the first and the last of some neighbouring intervals."""


@dataclass
class Programme:
    """A linear programme in δ and some more variables.

    Attributes:
        profile: the geometry from which it starts.
        trust: the largest change of a place.
        objective: what is minimised: the coefficients of variables, by their names.
    """

    profile: Profile
    trust: float
    objective: Mapping[str, float]
    rows: list[tuple[Vector, Mapping[str, float], float]] = field(default_factory=list)

    def at_most(self, slopes: Vector, others: Mapping[str, float], bound: float) -> None:
        """Adds slopes·δ + Σ others ≤ bound."""
        if np.isfinite(bound):
            self.rows.append((slopes, others, bound))

    def limit(self, k: int, reach: float = 1.0, moved: float = 0.0) -> None:
        """Adds |moved + δ_k| ≤ reach · ``+change``."""
        unit = np.zeros(len(self.profile.place))
        unit[k] = 1.0
        self.at_most(unit, {"+change": -reach}, -moved)
        self.at_most(-unit, {"+change": -reach}, moved)

    def solve(self) -> Vector | None:
        """The new place; None if there is none."""
        from scipy.optimize import linprog

        place = self.profile.place
        named = {name for _, others, _ in self.rows for name in others}
        names = sorted(named | set(self.objective))
        rows = [[*slopes, *(others.get(name, 0.0) for name in names)] for slopes, others, _ in self.rows]
        aims = [*np.zeros(len(place)), *(self.objective.get(name, 0.0) for name in names)]
        bounds: list[tuple[float | None, float | None]] = [
            (max(-self.trust, -x), min(self.trust, 1 - x)) if 0 <= x <= 1 else (-self.trust, self.trust)
            for x in place
        ]
        bounds += [(0, None) if name.startswith("+") else (None, None) for name in names]
        found = linprog(aims, np.array(rows), [bound for *_, bound in self.rows], bounds=bounds)
        return None if found.x is None else np.clip(place + found.x[: len(place)], 0, 1)


def proposals(profile: Profile, goal: Goal, trust: float) -> Iterator[Vector]:
    """Places that should be better, the most promising first.

    Args:
        profile: the geometry to improve.
        goal: the objective.
        trust: the largest change of a place.
    """
    if goal.objective == LONGEST_RANGE:
        programmes = _longer(profile, goal, trust)
    elif goal.objective == MOST_CUSPS:
        programmes = _more_cusps(profile, goal, trust)
    elif windows(profile, goal) or goal.objective == LEAST_CHANGE:
        programmes = _nearer(profile, goal, trust)
    else:
        return  # for a larger margin the evolution strategy alone finds more
    for programme in programmes:
        found = programme.solve()
        if found is not None:
            yield found


def radius(profile: Profile, goal: Goal) -> float:
    """To first order, the least change of the place that brings one pair of cusps more, or breaks the
    requirement; 0 where no such change is known for a requirement, infinity for more cusps."""
    if goal.objective not in (LARGEST_MARGIN, MOST_CUSPS):
        return 0.0
    known = _ways(profile, goal)
    return known[0].radius if known else inf if goal.objective == MOST_CUSPS else 0.0


def _movers(profile: Profile) -> list[Mover]:
    return [Mover(cut.length, "", tuple(cut.slopes), cut.jump) for cut in profile.cuts if cut.slopes.any()]


def _ways(profile: Profile, goal: Goal) -> list[Estimate]:
    """The nearest ways to other numbers of cusps in the range, ascending; kept with the profile."""
    if profile.ways is None:
        low, high = goal.ends
        parts = [(max(a, low), min(b, high), n) for a, b, n in profile.intervals if a < high and b > low]
        most = most_cusps(profile, goal)
        admits = (lambda n: n <= most) if goal.objective == MOST_CUSPS else goal.requirement.admits
        found = ways(parts, _movers(profile), admits, [1.0] * len(profile.place))
        profile.ways = sorted(found, key=lambda way: way.radius)
    return profile.ways


def _stretches(profile: Profile, goal: Goal, *, ignored: bool) -> list[Stretch]:
    """Numbers of the first and the last interval of each stretch that is not admitted."""
    kept = {k for *_, k in windows(profile, goal)}
    low, high = goal.ends
    found: list[Stretch] = []
    for k, (start, stop, count) in enumerate(profile.intervals):
        inside = start < high and stop > low
        wanted = (inside and k not in kept) if ignored else (not inside or k in kept)
        if wanted and not goal.requirement.admits(count):
            if found and found[-1][1] == k - 1:
                found[-1] = (found[-1][0], k)
            else:
                found.append((k, k))
    return found


def _keep_ignored(programme: Programme, goal: Goal) -> None:
    """Windows that are ignored stay narrow."""
    cuts = programme.profile.cuts
    for first, last in _stretches(programme.profile, goal, ignored=True):
        if first > 0 and last < len(cuts):
            lower, upper = cuts[first - 1], cuts[last]
            most = 0.95 * double(goal.requirement.ignore_windows)
            bound = max(most - (upper.length - lower.length), 0.0)
            programme.at_most(upper.slopes - lower.slopes, {}, bound)


def _ends_in(profile: Profile, goal: Goal, stretch: Stretch, side: int) -> list[Cut]:
    """The births (side 1) from which a stretch begins, or the deaths (-1) with which it ends.

    It is the other way round if the stretch has too few cusps, not too many.
    """
    first, last = stretch
    cuts = profile.cuts[max(first - 1, 0) : last] if side > 0 else profile.cuts[first : last + 1]
    most = goal.requirement.max_cusps
    sign = side if most is not None and profile.intervals[first][2] > most else -side
    return [cut for cut in cuts if cut.jump * sign > 0]


def _shut(programme: Programme, goal: Goal, stretch: Stretch, slack: str) -> None:
    """A stretch gets narrow enough, or vanishes."""
    profile = programme.profile
    for lower, upper in product(_ends_in(profile, goal, stretch, 1), _ends_in(profile, goal, stretch, -1)):
        width = max(upper.length - lower.length, 0.0)
        least = _SHUT * double(goal.requirement.ignore_windows) or -_BEYOND * width
        bound = least - (upper.length - lower.length)
        programme.at_most(upper.slopes - lower.slopes, {slack: -max(width, 1e-9)}, bound)


def _longer(profile: Profile, goal: Goal, trust: float) -> Iterator[Programme]:
    """The best run gets longer at both ends, from ``start`` to ``stop``.

    It ends where intervals that are not admitted do, above or below it, or the range.
    """
    run = best_run(profile, goal)
    if run is None:
        return
    programme = Programme(profile, trust, {"start": 1.0, "stop": -1.0})
    (low, high), nothing = goal.ends, np.zeros(len(profile.place))
    programme.at_most(nothing, {"start": -1.0}, -low)
    programme.at_most(nothing, {"stop": 1.0}, high)
    for stretch in _stretches(profile, goal, ignored=False):
        if stretch[0] > run[3]:
            for birth in _ends_in(profile, goal, stretch, 1):
                programme.at_most(-birth.slopes, {"stop": 1.0}, birth.length)
        elif stretch[1] < run[2]:
            for death in _ends_in(profile, goal, stretch, -1):
                programme.at_most(death.slopes, {"start": -1.0}, -death.length)
    for lower, upper in pairwise(profile.cuts[run[2] : run[3]]):  # a death below a birth stays there
        if lower.jump * upper.jump < 0:
            programme.at_most(lower.slopes - upper.slopes, {}, upper.length - lower.length)
    _keep_ignored(programme, goal)
    yield programme


def _nearer(profile: Profile, goal: Goal, trust: float) -> Iterator[Programme]:
    """The least change that shuts each window of the range, or moves it out of the range."""
    low, high = goal.ends
    programme = Programme(profile, trust, {"+change": 1.0})
    outside: list[Stretch] = []
    for k, stretch in enumerate(_stretches(profile, goal, ignored=False)):
        if profile.intervals[stretch[0]][0] < high and profile.intervals[stretch[1]][1] > low:
            slack = f"+{k}"
            programme.objective = {**programme.objective, slack: _MISSED}
            _move(programme, goal, stretch, slack)
        else:
            outside.append(stretch)
    _keep_outside(programme, goal, outside)
    _keep_ignored(programme, goal)
    _limit_change(programme)
    yield programme


def _keep_outside(programme: Programme, goal: Goal, outside: Sequence[Stretch]) -> None:
    """Stretches below or above the range stay there."""
    profile, (low, high) = programme.profile, goal.ends
    for first, last in outside:
        if last < len(profile.cuts) and profile.intervals[last][1] <= low:
            cut = profile.cuts[last]
            programme.at_most(cut.slopes, {}, low - cut.length)
        elif first > 0 and profile.intervals[first][0] >= high:
            cut = profile.cuts[first - 1]
            programme.at_most(-cut.slopes, {}, cut.length - high)


def _way(profile: Profile, goal: Goal, stretch: Stretch) -> str | None:
    """What can be done with a window by the least change."""
    low, high = goal.ends
    first, last = stretch
    cuts = profile.cuts
    ways: dict[str, tuple[float, Vector]] = {}
    if first > 0 and last < len(cuts):
        width = cuts[last].length - cuts[first - 1].length
        ways["shut"] = width, cuts[last].slopes - cuts[first - 1].slopes
    if first > 0 and high < inf:
        ways["above"] = high - cuts[first - 1].length, cuts[first - 1].slopes
    if last < len(cuts) and low > 0:
        ways["below"] = cuts[last].length - low, cuts[last].slopes
    far = {name: way / max(float(abs(slopes).sum()), 1e-12) for name, (way, slopes) in ways.items()}
    return min(far, key=far.__getitem__, default=None)


def _move(programme: Programme, goal: Goal, stretch: Stretch, slack: str) -> None:
    """A window is shut, or moved out of the range, as far as its slack is 0."""
    low, high = goal.ends
    way = _way(programme.profile, goal, stretch)
    if way == "shut":
        _shut(programme, goal, stretch, slack)
    elif way is not None:
        side, end = (1, high) if way == "above" else (-1, low)
        for cut in _ends_in(programme.profile, goal, stretch, side):
            gap = side * (end - cut.length)
            least = (1 + _BEYOND) * gap if gap > 0 else gap
            programme.at_most(-side * cut.slopes, {slack: -max(gap, 1e-9)}, -least)


def _limit_change(programme: Programme) -> None:
    """``+change`` is at least the change of each parameter, as a share of how far it may change."""
    profile, space = programme.profile, programme.profile.space
    for k, name in enumerate(space.names):
        low, high = map(double, space.bounds[name])
        way = profile.place[k] - (space.origin[name] - low) / (high - low)
        programme.limit(k, double(space.reach(name)) / (high - low), way)


def _more_cusps(profile: Profile, goal: Goal, trust: float) -> Iterator[Programme]:
    """Births and deaths pass each other so that one more pair of cusps exists between."""
    chosen: list[Estimate] = []
    for way in _ways(profile, goal):
        if not any(set(way.movers) == set(other.movers) for other in chosen):
            chosen.append(way)
        if len(chosen) == _WAYS:
            break
    for way in chosen:
        for beyond in (_BEYOND, 0.5):
            yield _passing(profile, goal, way.movers, trust, beyond)


def _passing(profile: Profile, goal: Goal, movers: Sequence[Mover], trust: float, beyond: float) -> Programme:
    """All births are below a length of the range, and all deaths above it, that some movers are to pass."""
    programme = Programme(profile, trust, {"+change": 1.0, "+missed": _MISSED})
    low, high = goal.ends
    zero = np.zeros(len(profile.place))
    programme.at_most(zero, {"length": -1.0}, -low)
    programme.at_most(zero, {"length": 1.0}, high)
    middle = _between(profile, goal, movers)
    moved = {mover.length for mover in movers}
    span = max(1e-6, *(abs(length - middle) for length in moved))
    for cut in profile.cuts:
        side = float(np.sign(cut.jump))
        if side and cut.length in moved:
            others = {"length": -side, "+missed": -span}
            programme.at_most(side * cut.slopes, others, -side * cut.length - beyond * span)
        elif side * (cut.length - middle) < 0:
            programme.at_most(side * cut.slopes, {"length": -side}, -side * cut.length)
    for k in range(len(zero)):
        programme.limit(k)
    return programme


def _between(profile: Profile, goal: Goal, movers: Sequence[Mover]) -> float:
    """A length of the interval that gets more cusps than any when some transitions pass it."""
    low, high = goal.ends
    most = most_cusps(profile, goal)
    far: dict[float, float] = {}
    for start, stop, count in profile.intervals:
        passing = [x for x in movers if (x.length <= start) == (x.jump < 0)]
        if start < high and stop > low and count + sum(abs(x.jump) for x in passing) > most:
            middle = (max(start, low) + min(stop, high, 2 * start + 1)) / 2
            far[middle] = sum(abs(x.length - middle) for x in passing)
    return min(far, key=far.__getitem__) if far else movers[0].length
