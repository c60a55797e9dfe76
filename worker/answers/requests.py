"""A request for a document in canonical form, and the names that follow from it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from rpr_solver import SOLVER_VERSION, Manipulator
from rpr_solver.model.manipulator import hash_of_canonical


@dataclass(frozen=True)
class Kind:
    """A kind of document: its name, and how its jobs are named and counted.

    Attributes:
        name: as jobs and their records carry it.
        prefix: the beginning of its job ids.
        unit: what the progress of its jobs counts.
        by_slices: whether each slice is computed, kept and counted by itself.
    """

    name: str
    prefix: str
    unit: str = "steps"
    by_slices: bool = False


@dataclass(frozen=True)
class JobRequest:
    """What a job is asked for.

    `content` is canonical and plain JSON, so equal questions are equal requests with one id.
    """

    kind: Kind
    content: Mapping[str, Any]

    @property
    def geometry(self) -> Mapping[str, str]:
        """The manipulator, each number in its canonical text."""
        geometry: Mapping[str, str] = self.content["geometry"]
        return geometry

    @cached_property
    def geometry_hash(self) -> str:
        """The hash of the manipulator."""
        return hash_of_canonical(self.geometry)

    def identity_json(self) -> dict[str, object]:
        """The geometry and its hash, as the head of a document has them."""
        return {"geometry": self.geometry, "geometry_hash": self.geometry_hash}

    @cached_property
    def manipulator(self) -> Manipulator:
        """The manipulator itself, for a computation; nothing that is known already needs it."""
        return Manipulator.from_json(self.geometry, max_digits=1 << 20)

    @property
    def fixed_leg(self) -> int:
        """The leg whose length is fixed in a slice."""
        return int(self.content["fixed_leg"])

    @property
    def digits(self) -> int:
        """Significant digits of the answer."""
        return int(self.content["digits"])

    @property
    def parts(self) -> Sequence[str]:
        """What is computed and counted one by one: the slices, or only the whole."""
        parts: Sequence[str] = self.content["l1"] if self.kind.by_slices else (self.kind.name,)
        return parts

    @cached_property
    def content_hash(self) -> str:
        """Names the question among those that this version of the solver answers."""
        question = (
            [self.geometry_hash, self.fixed_leg, self.digits, self.parts]
            if self.kind.by_slices
            else [self.kind.name, self.content]
        )
        return hashlib.sha256(json.dumps([SOLVER_VERSION, *question], sort_keys=True).encode()).hexdigest()

    @property
    def job_id(self) -> str:
        """The id of the job that computes this document."""
        return self.kind.prefix + self.content_hash[:40]

    def __hash__(self) -> int:
        return hash(self.content_hash)

    def to_json(self) -> str:
        """The request as it is kept in the job's record."""
        return json.dumps({"kind": self.kind.name, "content": self.content}, separators=(",", ":"))


ALL_LENGTHS: Mapping[str, str | None] = {"from": "0", "to": None}
"""The range without ends, in a request's content."""


def content_range(content: Mapping[str, Any]) -> tuple[Fraction, Fraction | None]:
    """The range of a request's content."""
    start, stop = content["range"]["from"], content["range"]["to"]
    return Fraction(start), None if stop is None else Fraction(stop)
