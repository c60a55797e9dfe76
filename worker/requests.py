"""What a client asks for, in canonical form, and the job id that follows from it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from rpr_solver import SOLVER_VERSION, Manipulator, exact_str


@dataclass(frozen=True)
class TableRequest:
    """A cusp table that is wanted: a geometry and the slices of it.

    All fields are canonical strings and plain numbers, so equal questions are equal objects.
    """

    geometry: Mapping[str, str]
    geometry_hash: str
    fixed_leg: int
    digits: int
    l1: tuple[str, ...]

    @classmethod
    def of(
        cls, manipulator: Manipulator, l1: Iterable[Fraction], *, fixed_leg: int = 1, digits: int = 90
    ) -> TableRequest:
        """Build a request from exact values; a slice that is asked for twice is kept once."""
        return cls(
            geometry=manipulator.to_json(),
            geometry_hash=manipulator.geometry_hash,
            fixed_leg=fixed_leg,
            digits=digits,
            l1=tuple(dict.fromkeys(exact_str(x) for x in l1)),
        )

    @classmethod
    def from_json(cls, text: str | bytes) -> TableRequest:
        """The inverse of `to_json`."""
        data = json.loads(text)
        return cls(**{**data, "l1": tuple(data["l1"])})

    def to_json(self) -> str:
        """The request as it is kept in the job's record."""
        return json.dumps(
            {
                "geometry": dict(self.geometry),
                "geometry_hash": self.geometry_hash,
                "fixed_leg": self.fixed_leg,
                "digits": self.digits,
                "l1": self.l1,
            },
            separators=(",", ":"),
        )

    @cached_property
    def job_id(self) -> str:
        """The id of the job that computes this table: a hash of its content and the solver's version."""
        content = json.dumps([SOLVER_VERSION, self.geometry_hash, self.fixed_leg, self.digits, self.l1])
        return "ct-" + hashlib.sha256(content.encode()).hexdigest()[:40]

    def __hash__(self) -> int:
        return hash(self.job_id)
