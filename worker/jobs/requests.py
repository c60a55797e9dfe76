"""What a client asks for, in canonical form, and the job id that follows from it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, Literal

from rpr_solver import SOLVER_VERSION, Manipulator, exact_str

DocumentKind = Literal["poses", "census", "check", "cusp-curves", "article-table"]
Kind = Literal["cusp-table"] | DocumentKind

_PREFIXES: Mapping[Kind, str] = {
    "cusp-table": "ct-",
    "poses": "po-",
    "census": "ce-",
    "check": "ch-",
    "cusp-curves": "cc-",
    "article-table": "at-",
}


def kind_of(job_id: str) -> Kind | None:
    """What a job of this id computes; None when it is no id of a job."""
    return next((kind for kind, prefix in _PREFIXES.items() if job_id.startswith(prefix)), None)


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

    @property
    def parts(self) -> tuple[str, ...]:
        """What is computed and counted one by one: the slices."""
        return self.l1

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
        return _PREFIXES["cusp-table"] + hashlib.sha256(content.encode()).hexdigest()[:40]

    def __hash__(self) -> int:
        return hash(self.job_id)


@dataclass(frozen=True)
class DocumentRequest:
    """A document that is wanted and computed in one piece.

    `content` is canonical and plain JSON, so equal questions are equal objects.
    """

    kind: DocumentKind
    content: Mapping[str, Any]

    @property
    def parts(self) -> tuple[str, ...]:
        """What is computed and counted one by one: only the whole."""
        return (self.kind,)

    def to_json(self) -> str:
        """The request as it is kept in the job's record."""
        return json.dumps({"kind": self.kind, "content": self.content}, separators=(",", ":"))

    @cached_property
    def content_hash(self) -> str:
        """Names the question among those that this version of the solver answers."""
        content = json.dumps([SOLVER_VERSION, self.kind, self.content], sort_keys=True)
        return hashlib.sha256(content.encode()).hexdigest()

    @property
    def job_id(self) -> str:
        """The id of the job that computes this document."""
        return _PREFIXES[self.kind] + self.content_hash[:40]

    def __hash__(self) -> int:
        return hash(self.content_hash)


ALL_LENGTHS: Mapping[str, str | None] = {"from": "0", "to": None}
"""The range without ends, in a request's content."""


def scan_content(
    manipulator: Manipulator, fixed_leg: int, digits: int, start: Fraction, stop: Fraction | None
) -> dict[str, Any]:
    """The content of a request that concerns a range of lengths of one leg; None is no end."""
    return {
        "geometry": manipulator.to_json(),
        "fixed_leg": fixed_leg,
        "digits": digits,
        "range": {"from": exact_str(start), "to": None if stop is None else exact_str(stop)},
    }


def content_range(content: Mapping[str, Any]) -> tuple[Fraction, Fraction | None]:
    """The range of a request's content."""
    start, stop = content["range"]["from"], content["range"]["to"]
    return Fraction(start), None if stop is None else Fraction(stop)


JobRequest = TableRequest | DocumentRequest
"""Whatever a job may be asked for."""


def request_from_json(text: str | bytes) -> JobRequest:
    """The inverse of `to_json`."""
    data = json.loads(text)
    if "kind" in data:
        return DocumentRequest(**data)
    return TableRequest(**{**data, "l1": tuple(data["l1"])})
