"""A request for a document in canonical form, and the ids derived from it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

from rpr_solver import SOLVER_VERSION, Manipulator
from rpr_solver.model.manipulator import hash_of_canonical

_HASH = "content_hash"


@dataclass(frozen=True)
class Kind:
    """A kind of document, and the naming and counting of its jobs.

    Attributes:
        name: the name in jobs and their records.
        prefix: the prefix of job ids.
        unit: the unit of its jobs' progress.
        by_slices: whether each slice is computed, kept and counted separately.
        by_items: whether a job consists of questions of its own, as a batch does.
    """

    name: str
    prefix: str
    unit: str = "steps"
    by_slices: bool = False
    by_items: bool = False


@dataclass(frozen=True)
class JobRequest:
    """A request for a document, which a job computes.

    `content` is canonical plain JSON, so equal questions are equal requests with one id. `version`: of the
    solver that is to answer it, or has. Of a request that is `cut`, the content has the hash alone, by which
    the answer is found.
    """

    kind: Kind
    content: Mapping[str, Any]
    version: str = SOLVER_VERSION

    @property
    def geometry(self) -> Mapping[str, str]:
        """The manipulator, with each number as canonical text."""
        geometry: Mapping[str, str] = self.content["geometry"]
        return geometry

    @cached_property
    def geometry_hash(self) -> str:
        """The hash of the manipulator."""
        return hash_of_canonical(self.geometry)

    def identity_json(self) -> dict[str, object]:
        """Returns the geometry and its hash, as in the head of a document."""
        return {"geometry": self.geometry, "geometry_hash": self.geometry_hash}

    @cached_property
    def manipulator(self) -> Manipulator:
        """The manipulator, for a computation; known answers do not need it."""
        return Manipulator.from_json(self.geometry, max_digits=1 << 20)

    @property
    def fixed_leg(self) -> int:
        """The leg with the fixed length."""
        return int(self.content["fixed_leg"])

    @property
    def digits(self) -> int:
        """Significant digits of the answer."""
        return int(self.content["digits"])

    @property
    def parts(self) -> Sequence[str]:
        """The parts that are computed and counted separately: the slices, the positions of the items, or only
        the whole document."""
        if self.kind.by_items:
            return [str(index) for index in range(self.content["count"])]
        parts: Sequence[str] = self.content["l1"] if self.kind.by_slices else (self.kind.name,)
        return parts

    def of_slices(self, l1: Sequence[str]) -> JobRequest:
        """Returns the question for other slices of the same table."""
        return replace(self, content={**self.content, "l1": list(l1)})

    @cached_property
    def content_hash(self) -> str:
        """The hash of the question and the solver's version."""
        if self.is_cut:
            return str(self.content[_HASH])
        question: list[object] = [self.kind.name, self.content]
        if self.kind.by_slices:
            question = [self.geometry_hash, self.fixed_leg, self.digits, self.parts]
        elif self.kind.by_items:  # known before its items are
            question = [self.kind.name, self.content["batch"]]
        return hashlib.sha256(json.dumps([self.version, *question], sort_keys=True).encode()).hexdigest()

    @property
    def is_cut(self) -> bool:
        """Whether only the hash of the question is left."""
        return _HASH in self.content

    def cut(self) -> JobRequest:
        """Returns the same without the question."""
        return replace(self, content={_HASH: self.content_hash})

    @property
    def job_id(self) -> str:
        """The id of the job that computes this document."""
        return self.kind.prefix + self.content_hash[:40]

    def __hash__(self) -> int:
        return hash(self.content_hash)

    def to_json(self) -> str:
        """Returns the request as text for the job's record."""
        return json.dumps({"kind": self.kind.name, "content": self.content}, separators=(",", ":"))


ALL_LENGTHS: Mapping[str, str | None] = {"from": "0", "to": None}
"""The unbounded range in a request's content."""


def content_range(content: Mapping[str, Any]) -> tuple[Fraction, Fraction | None]:
    """Returns the range in a request's content."""
    start, stop = content["range"]["from"], content["range"]["to"]
    return Fraction(start), None if stop is None else Fraction(stop)
