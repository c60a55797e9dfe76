"""The members of questions, from arguments in the words of the library."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, TypeAlias

from rpr_solver import Exact, Manipulator, exact_str
from rpr_solver.model.lengths import ExactLimits, limits_json, read_limits
from service.client.bodies import Asked, M
from service.schemas.document import Source, read
from service.schemas.limits import Limits
from service.schemas.questions import Question

_NO_LIMIT = 1_000_000
Lengths: TypeAlias = Exact | Iterable[Exact]
"""One length or several."""


def asked(
    question: type[Question],
    model: type[M],
    manipulator: Manipulator,
    digits: int | None,
    deadline: float | None,
    members: Mapping[str, object],
) -> Asked[M]:
    """A question with its model of the answer.

    Raises:
        InputError: naming every fault.
    """
    # the service has the limits that count
    limits = Limits.of_environment(max_slices=_NO_LIMIT, max_article_slices=_NO_LIMIT, max_samples=_NO_LIMIT)
    own = {"geometry": manipulator, **members}
    if digits is not None:
        own["digits"] = digits
    if deadline is not None:
        own["deadline_s"] = str(deadline)
    return Asked(read(question, own, Source(limits, is_text=True)), model)


def numbers(**given: Exact | Mapping[str, Exact] | None) -> dict[str, object]:
    """Those numbers that are given, as text."""
    return {
        name: {g: text_of(x) for g, x in value.items()} if isinstance(value, Mapping) else text_of(value)
        for name, value in given.items()
        if value is not None
    }


def legs(*lengths: Exact) -> dict[str, str]:
    """Three leg lengths by name."""
    return {f"l{leg}": text_of(x) for leg, x in enumerate(lengths, 1)}


def complete(options: Mapping[str, Any], **defaults: Any) -> dict[str, Any]:
    """Returns options with the defaults of those that are not given.

    Raises:
        TypeError: there is no such option.
    """
    if unknown := options.keys() - defaults.keys():
        raise TypeError(f"unexpected keyword argument {min(unknown)!r}; known are {', '.join(defaults)}")
    return {**defaults, **options}


def lengths_of(lengths: Lengths) -> list[str]:
    """One length or several, as text."""
    if isinstance(lengths, Iterable) and not isinstance(lengths, str):
        return [text_of(x) for x in lengths]
    return [text_of(lengths)]


def range_of(start: Exact | None, stop: Exact | None) -> dict[str, str | None]:
    """A range; None is an open end."""
    return {"from": None if start is None else text_of(start), "to": None if stop is None else text_of(stop)}


def limits_of(limits: ExactLimits | None, held: int | None = None) -> dict[str, object]:
    """Joint limits as a member, if there are any; those of the leg ``held`` may be one length."""
    return {} if limits is None else {"limits": limits_json(read_limits(limits, "limits", held=held))}


def text_of(x: Exact) -> str:
    """An exact number as text."""
    return x if isinstance(x, str) else exact_str(x)
