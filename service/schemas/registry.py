"""The registry of questions: what can be asked over HTTP, in batches, by clients and on the command line.

A question is loaded when it is first needed, so that a command starts quickly. A new one is a module here
with its :class:`~service.schemas.questions.Question` and its answer, and a line in :data:`QUESTIONS`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from service.schemas.questions import Question


@dataclass(frozen=True)
class Entry:
    """A question that can be asked.

    Attributes:
        place: the module of the question (after a dot: in this package), a colon, and its class.
        command: its name on the command line.
        summary: what the command does.
        group: where the help lists it.
    """

    place: str
    command: str
    summary: str
    group: str

    @property
    def question(self) -> type[Question]:
        """The question."""
        module, _, name = self.place.partition(":")
        question: type[Question] = getattr(import_module(module, __package__), name)
        return question


COMPUTE, PATHS = "Compute", "Plan paths"
DESIGN, DOCUMENTS = "Design and check", "Documents"
"""The groups of commands that ask questions."""

QUESTIONS: tuple[Entry, ...] = (
    Entry(".tables:CuspTableRequest", "solve", "compute cusp tables and print them", COMPUTE),
    Entry(
        ".censuses:CensusRequest", "census", "find every length at which the number of cusps changes", COMPUTE
    ),
    Entry(".curves:CuspCurvesRequest", "cusp-curves", "follow each cusp from its birth to its end", COMPUTE),
    Entry(".censuses:CheckRequest", "check", "prove or refute a requirement on the number of cusps", DESIGN),
    Entry(".poses:PosesRequest", "poses", "compute all poses for given leg lengths", COMPUTE),
    Entry(".paths:PathRequest", "path", "find a path to another pose without a singularity", PATHS),
    Entry(
        ".poses:SingularCurvesRequest",
        "singular-curves",
        "list the singular curves of a slice, its regions and aspects (plot draws them)",
        COMPUTE,
    ),
    Entry(
        ".workspaces:WorkspaceRequest",
        "workspace",
        "find the places that the limits of legs allow, and the singular conic",
        COMPUTE,
    ),
    Entry(".poses:AspectsRequest", "aspects", "find the aspects while a leg varies within a range", COMPUTE),
    Entry(
        ".modes:AssemblyModesRequest", "assembly-modes", "decide whether the assembly mode can change", PATHS
    ),
    Entry(
        ".modes:PoseConnectionsRequest",
        "pose-connections",
        "find which poses are joined by paths, all pairs",
        PATHS,
    ),
    Entry(
        ".curves:MarginRequest", "margin", "prove how far the lengths may change before the cusps do", DESIGN
    ),
    Entry(".designs:DesignRequest", "design", "search for a geometry whose cusps meet a goal", DESIGN),
    Entry(".plots:PlotRequest", "plot", "draw slices, censuses, cusp curves, loops and poses", DOCUMENTS),
    Entry(".plots:VerificationRequest", "verify", "verify a document by independent means", DOCUMENTS),
)
"""All questions, in the order of the contract."""


@cache
def all_questions() -> tuple[type[Question], ...]:
    """Returns all questions, loaded."""
    return tuple(entry.question for entry in QUESTIONS)


def queries() -> tuple[type[Question], ...]:
    """Returns the questions that are asked by GET too. They compute, and so need what POST needs."""
    return tuple(query for question in all_questions() if (query := question.by_query()) is not None)


@cache
def by_kind() -> Mapping[str, type[Question]]:
    """Returns the questions by the names of the kinds of documents that answer them."""
    return {kind.name: question for question in all_questions() for kind in question.kinds}
