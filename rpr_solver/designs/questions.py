"""Reading questions about designs: what is sought, what may vary, and for how long."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypedDict, Unpack

from rpr_solver.contract import check_integer, check_type
from rpr_solver.designs.space import (
    DEFAULT_DECIMALS,
    DEFAULT_VARY,
    Space,
    Vary,
    not_negative,
)
from rpr_solver.errors import InputError, shown
from rpr_solver.exact.rationals import Exact, exact_or_none, exact_str
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.transitions.requirement import Requirement

LONGEST_RANGE, LEAST_CHANGE = "longest-range", "least-change"
LARGEST_MARGIN, MOST_CUSPS = "largest-margin", "most-cusps"
OBJECTIVES = (LONGEST_RANGE, LEAST_CHANGE, LARGEST_MARGIN, MOST_CUSPS)

DEADLINE, CANCELED = "deadline", "canceled"
"""Why a search was stopped from outside."""

DEFAULT_BUDGET, LEAST_BUDGET, MOST_CENSUSES = 300, 2, 10_000
DEFAULT_SEED, MOST_SEED = 1, 2**32 - 1


class SearchStopped(Exception):  # noqa: N818 - not an error
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
    ignore_windows: Exact
    budget: int
    seed: int


@dataclass(frozen=True)
class Plan:
    """A question about a design, read: what is sought, where, and for how long."""

    space: Space
    objective: str
    requirement: Requirement
    ignore_windows: Fraction
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
        if objective not in OBJECTIVES:
            raise InputError.of("objective", f"is {shown(objective)}; give one of {', '.join(OBJECTIVES)}")
        if objective == LONGEST_RANGE and requirement.stop is None:
            raise InputError.of(
                "requirement.range", "is open; the longest range is sought between two lengths"
            )
        narrow = not_negative(options.get("ignore_windows", 0), "ignore_windows")
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
        return cls(space, objective, requirement, narrow, family, budget, seed)

    def to_json(self) -> dict[str, Any]:
        """What is asked, as documents have it; bounds stand for shares, and what is fixed has none."""
        bounds = {
            name: {"from": exact_str(low), "to": exact_str(high)}
            for name, (low, high) in self.space.bounds.items()
        }
        return {
            "objective": self.objective,
            "requirement": self.requirement.to_json(),
            "vary": bounds,
            "family": self.family,
            "decimals": self.space.decimals,
            "min_height": exact_or_none(self.space.min_height),
            "ignore_windows": exact_str(self.ignore_windows),
            "budget": {"censuses": self.budget},
            "seed": self.seed,
        }
