"""Joint limits of legs, as they are asked for and told."""

from __future__ import annotations

from typing import ClassVar

from rpr_solver.model.lengths import Bounds
from service.schemas.document import Document
from service.schemas.model import Model
from service.schemas.numbers import Exact


class JointLimit(Document):
    """The joint limits of one leg; an end that is missing or null is open."""

    expected: ClassVar[str] = 'give an object with "min" and "max"'

    min: Exact | None = None
    max: Exact | None = None


class JointLimits(Document):
    """Joint limits of legs."""

    expected: ClassVar[str] = "give an object with the free legs, such as l2 and l3"

    l1: JointLimit | None = None
    l2: JointLimit | None = None
    l3: JointLimit | None = None

    def bounds(self) -> dict[int, Bounds]:
        """The limits as the solver takes them."""
        return {int(leg[1]): (limit.min, limit.max) for leg, limit in self if limit is not None}


class LegLimits(Model):
    """The joint limits of one leg, exact; null is an open end."""

    min: str | None
    max: str | None


class KeptLimits(Model):
    """The joint limits that were asked for, by legs."""

    l1: LegLimits | None = None
    l2: LegLimits | None = None
    l3: LegLimits | None = None
