"""The search: it asks for generations of candidates, and is told their documents.

It begins with an evolution strategy (CMA-ES), which needs values alone, and goes on with *climbs*: from the
best candidates linear programmes on the derivatives of the transitions; but to a larger margin of what meets
the requirement the strategy alone comes farther. All generations have the same size, and all randomness
comes from the seed, so that the answers do not depend on who computes them.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from itertools import count
from math import inf
from typing import Any, TypeAlias

import numpy as np

from rpr_solver.designs.goals import Profile, Vector, cost, is_met, most_cusps, value
from rpr_solver.designs.plan import (
    CANCELED,
    DEADLINE,
    LARGEST_MARGIN,
    MOST_CUSPS,
    NEEDED,
    Plan,
    SearchStopped,
)
from rpr_solver.designs.programmes import proposals, radius
from rpr_solver.errors import NotInstalledError, SolverError
from rpr_solver.model.manipulator import Manipulator

GENERATION = 12
"""Candidates of a generation."""
_FIRST = 2
"""Generations of the evolution strategy before the first climbs, and between climbs that have ended."""
_CLIMBS = 4
"""Climbs at a time."""
_SIGMA = 0.25
"""The first step of the evolution strategy, in bounds."""
_PARTS = (1.0, 0.25, 0.06)
"""Steps of different lengths, as shares of the trust region."""
_TRUST, _LEAST_TRUST, _MOST_TRUST = 0.15, 0.0005, 0.5
_APART = 0.2
"""Climbs do not begin nearer to each other, or to where others have been."""
_TRIES = 3

Documents: TypeAlias = Sequence[Mapping[str, Any] | None]
Told: TypeAlias = "Callable[[Candidate], object]"
Examining: TypeAlias = Callable[[Sequence[Manipulator]], Documents]
Asking: TypeAlias = Generator[list[Manipulator], Documents, "Outcome"]


def cma_alone() -> Any:
    """Returns the package `cma` without what it loads for plots and surrogates: 1.8 s for each process."""
    unused: dict[str, Any] = dict.fromkeys(
        {"scipy.stats", "matplotlib", "matplotlib.pyplot"} - sys.modules.keys()
    )
    sys.modules.update(unused)
    try:
        with warnings.catch_warnings(action="ignore"):
            import cma
    finally:
        for name in unused:
            del sys.modules[name]
    return cma


@dataclass(frozen=True)
class Candidate:
    """A geometry that was examined.

    Attributes:
        number: that of its census, from 1; the start is the first.
        profile: its numbers of cusps.
        cost: what the search makes small.
        value: what it reaches, in the unit of the objective.
        met: whether the requirement is satisfied, apart from what is ignored.
    """

    number: int
    profile: Profile
    cost: float
    value: float
    met: bool

    @property
    def manipulator(self) -> Manipulator:
        """The geometry."""
        return self.profile.manipulator


@dataclass(frozen=True)
class Outcome:
    """What a search found.

    Attributes:
        candidates: the improvements, from the start on; the last one is the best.
        censuses: how many geometries were examined.
        stopped: ``"budget"``, ``"converged"``, or why it was stopped from outside.
    """

    candidates: tuple[Candidate, ...]
    censuses: int
    stopped: str


@dataclass
class _Climb:
    """Steps from one candidate to a better one, within a trust region that grows and shrinks."""

    best: Candidate
    trust: float = _TRUST
    failures: int = 0

    @property
    def has_ended(self) -> bool:
        return self.trust < _LEAST_TRUST or self.failures > _TRIES

    def tell(self, found: Iterable[Candidate]) -> None:
        better = min(found, key=lambda candidate: candidate.cost, default=None)
        if better is not None and better.cost < self.best.cost:
            step = float(np.abs(better.profile.place - self.best.profile.place).max())
            gain = self.best.cost - better.cost
            self.failures = 0 if gain > 1e-3 * max(abs(self.best.cost), 1e-3) else self.failures + 1
            self.best = better
            self.trust = min(2 * step, _MOST_TRUST)
        else:
            self.trust /= 4
            self.failures += 1


@dataclass
class _Search:
    plan: Plan
    told: Told
    known: dict[str, Candidate | None] = field(default_factory=dict)
    best: list[Candidate] = field(default_factory=list)
    censuses: int = 0

    def run(self) -> Asking:
        """Asks for generations of geometries, is told their documents, and returns what was found.

        The first generation is the start alone. If it is thrown a SearchStopped in place of documents, it
        returns what it has found so far.
        """
        try:
            reason = yield from self._search()
        except SearchStopped as stopped:
            reason = stopped.reason
        return Outcome(tuple(self.best), self.censuses, reason)

    def _search(self) -> Generator[list[Manipulator], Documents, str]:
        """Examines candidates for as long as there is reason to; returns why it ends."""
        [start] = yield from self._examine([self.plan.space.start])
        if start is None:
            return "start"
        self.random = np.random.default_rng(self.plan.seed)
        begun: list[Vector] = []
        while self.censuses < self.plan.budget:
            before = self.censuses
            yield from self._evolve()
            yield from self._climb(begun)
            if self.censuses == before:
                return "converged"
        return "budget"

    def _examine(
        self, wanted: Sequence[Manipulator | None]
    ) -> Generator[list[Manipulator], Documents, list[Candidate | None]]:
        """The candidates of some geometries; None for those that are too flat, fail or exceed the budget."""
        new: dict[str, Manipulator] = {}
        for manipulator in wanted:
            if manipulator is not None and manipulator.geometry_hash not in self.known:
                new.setdefault(manipulator.geometry_hash, manipulator)
        asked = list(new.values())[: self.plan.budget - self.censuses]
        documents = (yield asked) if asked else []
        for manipulator, document in zip(asked, documents, strict=True):
            self.censuses += 1
            self.known[manipulator.geometry_hash] = self._candidate(manipulator, document)
        return [None if m is None else self.known.get(m.geometry_hash) for m in wanted]

    def _candidate(self, manipulator: Manipulator, document: Mapping[str, Any] | None) -> Candidate | None:
        if document is None or (document["degenerate"] and self.best):
            return None
        profile = Profile(self.plan.space, manipulator, document)
        near = self._radius(profile)
        costs = cost(profile, self.plan.goal, near)
        reached = value(profile, self.plan.goal, near)
        found = Candidate(self.censuses, profile, costs, reached, is_met(profile, self.plan.goal))
        if not self.best or found.cost < self.best[-1].cost:
            self.best.append(found)
            self.told(found)
        return found

    def _radius(self, profile: Profile) -> float:
        """The radius for the goal; geometries with fewer cusps than the best one do not need it."""
        is_climbing = self.plan.goal.objective == MOST_CUSPS and bool(self.best)
        if is_climbing and most_cusps(profile, self.plan.goal) < self.best[-1].value:
            return inf
        return radius(profile, self.plan.goal)

    def _evolve(self) -> Generator[list[Manipulator], Documents, None]:
        """Generations of an evolution strategy: about the start at first, later anywhere.

        To a larger margin it goes on alone.
        """
        cma = cma_alone()
        size = len(self.plan.space.names)
        first = len(self.known) == 1 and self.plan.goal.objective != MOST_CUSPS
        centre = self.best[0].profile.place if first else self.random.random(size)
        options = {
            "popsize": GENERATION,
            "bounds": [0, 1],
            "randn": lambda *shape: self.random.standard_normal(shape),
            "seed": np.nan,
            "verbose": -9,
        }
        if size == 1:  # cma 4.5 fails where it would keep the steps of one variable below its own bound
            options["maxstd"] = np.inf
        strategy = cma.CMAEvolutionStrategy(np.clip(centre, 0.01, 0.99), _SIGMA, options)
        for generation in count():
            if generation >= _FIRST and (strategy.stop() or not self._is_safe):
                return
            places = strategy.ask()
            found = yield from self._examine([self.plan.space.manipulator(list(place)) for place in places])
            if self.censuses >= self.plan.budget:
                return
            worst = max((one.cost for one in found if one), default=0.0) + 1.0
            strategy.tell(places, [worst if one is None else one.cost for one in found])

    @property
    def _is_safe(self) -> bool:
        """Whether a margin is sought, and there is one."""
        return self.plan.goal.objective == LARGEST_MARGIN and self.best[-1].met

    def _climb(self, begun: list[Vector]) -> Generator[list[Manipulator], Documents, None]:
        """Climbs until all have ended."""
        climbs = self._begin(begun)
        while climbs and self.censuses < self.plan.budget:
            steps = self._steps(climbs)
            found = yield from self._examine([step for _, some in steps for step in some])
            results = iter(found)
            for climb, some in steps:
                climb.tell([one for one in (next(results) for _ in some) if one is not None])
                begun.append(climb.best.profile.place)
            climbs = [climb for climb in climbs if not climb.has_ended]

    def _begin(self, begun: list[Vector]) -> list[_Climb]:
        """Climbs from the best candidates where none has been."""
        climbs: list[_Climb] = []
        for candidate in sorted((one for one in self.known.values() if one), key=lambda one: one.cost):
            if len(climbs) < _CLIMBS and self._is_apart(candidate.profile.place, begun):
                climbs.append(_Climb(candidate))
                begun.append(candidate.profile.place)
        return climbs

    def _is_apart(self, place: Vector, begun: Sequence[Vector]) -> bool:
        return all(np.abs(place - other).max() > _APART for other in begun)

    def _steps(self, climbs: Sequence[_Climb]) -> list[tuple[_Climb, list[Manipulator]]]:
        """A generation of new geometries, shared between the climbs."""
        share = GENERATION // len(climbs)
        taken: set[str] = set(self.known)
        steps: list[tuple[_Climb, list[Manipulator]]] = []
        for climb in climbs:
            chosen: list[Manipulator] = []
            for place in self._places(climb):
                one = self.plan.space.manipulator(list(place))
                if one is not None and one.geometry_hash not in taken:
                    taken.add(one.geometry_hash)
                    chosen.append(one)
                if len(chosen) == share:
                    break
            steps.append((climb, chosen))
        return steps

    def _places(self, climb: _Climb) -> Iterator[Vector]:
        """Where a climb may go: long and short steps, by the most promising programmes first.

        A programme is solved when its place is asked for.
        """
        profile = climb.best.profile
        steps = [proposals(profile, self.plan.goal, part * climb.trust) for part in _PARTS]
        for last in count():  # shorter steps begin later
            found = [place for one in steps[: last + 1] if (place := next(one, None)) is not None]
            yield from found
            if not found and last >= len(steps):
                return


def searched(plan: Plan, examine: Examining, told: Told = lambda _: None) -> Outcome:
    """Searches; ``examine`` gives the documents of the geometries of a generation.

    Args:
        plan: what is asked.
        examine: for one geometry see :func:`~rpr_solver.designs.goals.document_of`. If it raises
            SearchStopped, the search ends with the best found so far.
        told: is called with every improvement.

    Raises:
        SolverError: the given geometry could not be decided, or not before the search was stopped; or what a
            search needs is not installed.
    """
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        raise NotInstalledError(f"a search needs {' and '.join(missing)}", "design")
    asking = _Search(plan, told).run()
    try:
        asked = next(asking)
        while True:
            try:
                documents = examine(asked)
            except SearchStopped as stopped:
                asked = asking.throw(stopped)
            else:
                asked = asking.send(documents)
    except StopIteration as ended:
        outcome: Outcome = ended.value
    if not outcome.candidates:
        is_early = outcome.stopped in (DEADLINE, CANCELED)
        why = "was not examined in time" if is_early else "could not be decided"
        raise SolverError(f"the given geometry {why}")
    return outcome
