"""The errors of the solver.

ValueError
└── InputError          an argument is not a valid manipulator, length, number, …
Exception
└── SolverError         the input is valid, but this version has no answer
    ├── NotInstalledError   an optional part, which the question needs, is not installed
    └── Unproved        the answer, or a step to it, is still undecided at the highest precision

A plain SolverError is an unsupported case (an eliminant that vanishes identically), or a failed identity that
should be reported, such as ``DivisionError`` (exact/quadratic.py). What is control flow between functions of
the solver, and never reaches a caller, is a :class:`ControlFlow`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

_SHOWN = 40


@dataclass(frozen=True)
class FieldProblem:
    """A problem with one input field: its dotted name, and a message that says what is expected.

    >>> FieldProblem("digits", "is 3; give 15 to 10000")
    FieldProblem(field='digits', message='is 3; give 15 to 10000')
    """

    field: str
    message: str


class InputError(ValueError):
    """Invalid input, reported before anything is computed.

    ``problems`` names every field at fault: an argument by its name (``digits``), the length of a leg by
    the leg (``l2``), a member of a document by its path (``geometry.d3``). The text is one line.

    >>> error = InputError([FieldProblem("l2", "is 0; a leg length must be > 0")])
    >>> str(error), error.problems[0].field
    ('l2: is 0; a leg length must be > 0', 'l2')
    """

    def __init__(self, problems: Sequence[FieldProblem]) -> None:
        self.problems = tuple(problems)
        super().__init__("; ".join(f"{p.field}: {p.message}" for p in self.problems))

    @classmethod
    def of(cls, field: str, message: str) -> InputError:
        """The error of a single field."""
        return cls([FieldProblem(field, message)])


class ControlFlow(Exception):  # noqa: N818 - its subclasses are no errors
    """What one function of the solver tells another by raising it; it never reaches a user of the solver."""


class SolverError(Exception):
    """No answer could be proved, or this version does not support the case. The solver never guesses.

    >>> from rpr_solver import Manipulator, article_table
    >>> article_table(Manipulator(30, 0, 40, 30, 50, 40), 5)
    Traceback (most recent call last):
    rpr_solver.errors.SolverError: the article's eliminant vanishes identically in this slice: ...
    """


def installing(extra: str) -> str:
    """How an optional part is installed; no package of this name is published.

    >>> installing("design")
    "in your copy of the repository: pip install -c constraints.txt '.[design]'"
    """
    return f"in your copy of the repository: pip install -c constraints.txt '.[{extra}]'"


class NotInstalledError(SolverError):
    """The question needs an optional part that is not installed; the text says how to install it."""

    def __init__(self, what: str, extra: str) -> None:
        super().__init__(f"{what}; {installing(extra)}")


class Unproved(SolverError):  # noqa: N818 - a verdict, not a fault
    """A step of the proof, named by the text, is undecided at every precision up to the limit.

    >>> issubclass(Unproved, SolverError)
    True
    """


def clipped(text: str, most: int = _SHOWN) -> str:
    """A text as error messages have it: of a long one the beginning, and an ellipsis.

    >>> clipped("17.04"), clipped("3.14159", 4)
    ('17.04', '3.14…')
    """
    return text if len(text) <= most else f"{text[:most]}…"


def shown(value: object) -> str:
    """A value as error messages quote it, shortened if it is long."""
    try:
        text = repr(value)
    except ValueError:  # Python does not print integers of more than 4300 digits
        return f"an {type(value).__name__} of more than 4300 digits"
    return text if len(text) <= _SHOWN else f"{clipped(text)} ({len(text)} characters)"
