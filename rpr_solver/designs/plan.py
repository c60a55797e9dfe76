"""Reading questions about designs: what is sought, what may vary, and for how long."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import inf
from typing import Any, TypedDict, Unpack

from rpr_solver.contract import LENGTHS, check_integer, check_type
from rpr_solver.designs.space import DEFAULT_DECIMALS, DEFAULT_VARY, Space, Vary
from rpr_solver.errors import ControlFlow, InputError, shown
from rpr_solver.exact.numerals import check_doubles, double
from rpr_solver.exact.rationals import Exact, exact_or_none, exact_str
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.transitions import Requirement

LONGEST_RANGE, LEAST_CHANGE = "longest-range", "least-change"
LARGEST_MARGIN, MOST_CUSPS = "largest-margin", "most-cusps"
OBJECTIVES = (LONGEST_RANGE, LEAST_CHANGE, LARGEST_MARGIN, MOST_CUSPS)

NEEDED = ("cma", "scipy")
"""Modules of the extra ``design``, without which there is no search."""

DEADLINE, CANCELED = "deadline", "canceled"
"""Why a search was stopped from outside."""

REQUIRED, EXCLUDED = "required", "excluded"
MOST_ASPECTS = 1000
"""The most that can be asked for; slices have few."""

DEFAULT_BUDGET, LEAST_BUDGET, MOST_CENSUSES = 300, 2, 10_000
DEFAULT_SEED, MOST_SEED = 1, 2**32 - 1


class SearchStopped(ControlFlow):
    """A search is to end with the best that it has found so far.

    Attributes:
        reason: :data:`DEADLINE` or :data:`CANCELED`.
    """

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason


class Options(TypedDict, total=False):
    """What varies, and how long to search; see :func:`design`."""

    vary: Vary
    fixed: Sequence[str]
    decimals: int
    min_height: Exact | None
    family: str | None
    loop: str | None
    min_aspects: int | None
    max_aspects: int | None
    budget: int
    seed: int


@dataclass(frozen=True)
class Constraints:
    """What is wanted of the whole range besides numbers of cusps; None where anything will do.

    Attributes:
        loop: ``"required"`` if, in some slice of the range, a loop round a cusp within the joint limits is to
            be proved; ``"excluded"`` if there is to be none in any slice. There is one if a cusp lies
            strictly within the limits: small enough, it keeps them. If none does, there is none: what the
            limits allow is a rectangle of the joint plane, and no closed curve in it goes round a point
            outside or on its edge. So counts of cusps prove that there is none.
        min_aspects: the least number of aspects in every slice, whatever the joint limits.
        max_aspects: the greatest one.
    """

    loop: str | None = None
    min_aspects: int | None = None
    max_aspects: int | None = None

    def __bool__(self) -> bool:
        return self != NO_CONSTRAINTS

    @property
    def bound_aspects(self) -> bool:
        """Whether numbers of aspects matter."""
        return self.min_aspects is not None or self.max_aspects is not None

    @classmethod
    def of(cls, options: Options) -> Constraints:
        """Reads constraints.

        Raises:
            InputError: naming the argument at fault.
        """
        loop, least, most = options.get("loop"), options.get("min_aspects"), options.get("max_aspects")
        if loop not in (None, REQUIRED, EXCLUDED):
            raise InputError.of("loop", f"is {shown(loop)}; it must be {REQUIRED} or {EXCLUDED}")
        for name, count in (("min_aspects", least), ("max_aspects", most)):
            if count is not None:
                check_integer(count, name, f"1 to {MOST_ASPECTS}", 1, MOST_ASPECTS)
        if least is not None and most is not None and most < least:
            raise InputError.of("max_aspects", f"is {most}, less than min_aspects = {least}")
        return cls(loop, least, most)

    def to_json(self) -> dict[str, Any]:
        """What is asked, without what is not."""
        return {name: value for name, value in vars(self).items() if value is not None}


NO_CONSTRAINTS = Constraints()


@dataclass(frozen=True)
class Goal:
    """An objective within a range of lengths.

    Attributes:
        objective: one of OBJECTIVES.
        requirement: which numbers of cusps are wanted, in which range, within which joint limits, and which
            windows are ignored.
        constraints: what else is wanted of the whole range.
    """

    objective: str
    requirement: Requirement
    constraints: Constraints = NO_CONSTRAINTS

    @property
    def ends(self) -> tuple[float, float]:
        """The ends of the range."""
        stop = self.requirement.stop
        return double(self.requirement.start), inf if stop is None else double(stop)


@dataclass(frozen=True)
class Plan:
    """A question about a design, read: what is sought, where, and for how long."""

    space: Space
    goal: Goal
    family: str | None
    budget: int
    seed: int

    @classmethod
    def of(
        cls, manipulator: Manipulator, objective: str, requirement: Requirement, **options: Unpack[Options]
    ) -> Plan:
        """Reads a question.

        Raises:
            InputError: naming the argument at fault.
        """
        check_type(manipulator, Manipulator, "manipulator")
        check_type(requirement, Requirement, "requirement")
        requirement.of_cusps_alone()
        manipulator.geometry.apart_from_shared()
        if objective not in OBJECTIVES:
            raise InputError.of("objective", f"is {shown(objective)}; give one of {', '.join(OBJECTIVES)}")
        if objective == LONGEST_RANGE and requirement.stop is None:
            raise InputError.of(
                "requirement.range", "is open; the longest range is sought between two lengths"
            )
        bounds = zip(LENGTHS, manipulator.bounds(), strict=True)
        lengths = {f"geometry.{name}": high if high > 0 else low for name, (low, high) in bounds}
        ends = {"from": requirement.start, "to": requirement.stop or Fraction(0)}
        lengths |= {f"requirement.range.{end}": x for end, x in ends.items()}
        check_doubles({**lengths, "requirement.ignore_windows": requirement.ignore_windows}, "designs")
        vary, fixed = options.get("vary", DEFAULT_VARY), tuple(options.get("fixed", ()))
        decimals, family = options.get("decimals", DEFAULT_DECIMALS), options.get("family")
        budget = check_integer(
            options.get("budget", DEFAULT_BUDGET),
            "budget",
            f"{LEAST_BUDGET} to {MOST_CENSUSES}",
            LEAST_BUDGET,
            MOST_CENSUSES,
        )
        seed = check_integer(options.get("seed", DEFAULT_SEED), "seed", f"0 to {MOST_SEED}", 0, MOST_SEED)
        space = Space.of(manipulator, vary, fixed, decimals, options.get("min_height"), family)
        goal = Goal(objective, requirement, Constraints.of(options))
        return cls(space, goal, family, budget, seed)

    def to_json(self) -> dict[str, Any]:
        """What is asked, as documents have it; bounds stand for shares, and what is fixed has none."""
        bounds = {
            name: {"from": exact_str(low), "to": exact_str(high)}
            for name, (low, high) in self.space.bounds.items()
        }
        return {
            "objective": self.goal.objective,
            "requirement": self.goal.requirement.to_json(),
            "vary": bounds,
            "family": self.family,
            "decimals": self.space.decimals,
            "min_height": exact_or_none(self.space.min_height),
            **self.goal.constraints.to_json(),
            "budget": {"censuses": self.budget},
            "seed": self.seed,
        }
