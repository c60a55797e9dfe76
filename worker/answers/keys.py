"""The names of the Redis keys of results."""

from __future__ import annotations

from dataclasses import dataclass

from rpr_solver import SOLVER_VERSION

UNNAMED = "4"
"""The version of the solver that had no version in the names of its jobs and documents, and keeps them."""


def kind_of(name: str, version: str) -> str:
    """Returns a kind of keys as it stands in their names, so that no two versions of the solver share one."""
    return name if version == UNNAMED else f"{name}-{version}"


@dataclass(frozen=True)
class ResultKeys:
    """Key names with one prefix. The keys of results contain the solver's version."""

    prefix: str
    version: str = SOLVER_VERSION

    def slice(self, geometry_hash: str, fixed_leg: int, digits: int, l1: str) -> str:
        """A slice's result; its content never changes. `z`: it is compressed, see `packed`."""
        return f"{self._content('slice', geometry_hash, fixed_leg)}:{digits}:z:{l1}"

    def digits(self, geometry_hash: str, fixed_leg: int) -> str:
        """The set of the digits of a geometry's slice results."""
        return self._content("digits", geometry_hash, fixed_leg)

    def eliminant(self, geometry_hash: str, fixed_leg: int) -> str:
        """The cached eliminant of a geometry."""
        return self._content("eliminant", geometry_hash, fixed_leg)

    def eliminant_lock(self, geometry_hash: str, fixed_leg: int) -> str:
        """Held while one worker computes the eliminant."""
        return self._content("eliminant-lock", geometry_hash, fixed_leg)

    def document(self, content_hash: str) -> str:
        """A document that was computed in one piece; the hash depends on the solver's version."""
        return self._by_hash("document", content_hash)

    def document_lock(self, content_hash: str) -> str:
        """Held while one worker computes a document that several jobs need."""
        return self._by_hash("document-lock", content_hash)

    def answer_lock(self, content_hash: str) -> str:
        """Held while one worker answers a question of several batches; documents have another lock."""
        return self._by_hash("answer-lock", content_hash)

    def locks(self, holder: str) -> str:
        """The locks of one holder."""
        return f"{self.prefix}:locks:{holder}"

    def census_digits(self, content_hash: str) -> str:
        """The set of the digits of known whole censuses."""
        return self._by_hash("census-digits", content_hash)

    def question(self, job_id: str) -> str:
        """A question that was answered without a job; its id is that of the job that would answer it."""
        return self._by_hash("question", job_id)

    def _content(self, kind: str, geometry_hash: str, fixed_leg: int) -> str:
        return f"{self.prefix}:{kind}:{self.version}:{geometry_hash.removeprefix('sha256:')}:{fixed_leg}"

    def _by_hash(self, kind: str, name: str) -> str:
        return f"{self.prefix}:{kind_of(kind, self.version)}:{name}"
