"""Lengths that are alike in the digits of a document, with as many digits as tell them apart."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from itertools import pairwise
from typing import Any, TypeAlias

from rpr_solver.contract import LEGS
from rpr_solver.errors import InputError
from service.errors import ServiceError

Place: TypeAlias = tuple[str | int, ...]
_LENGTHS = ("from", "to", *LEGS)
_MOST = 1000
_LISTS = ("intervals", "transitions", "curves", "violations")


def are_alike(document: Mapping[str, Any]) -> bool:
    """Whether two successive transitions, or both ends of a window or a curve, are printed alike."""
    leg = f"l{document['fixed_leg']}" if "fixed_leg" in document else ""
    lengths = [one[leg] for one in document.get("transitions", ())]
    ends = [
        (end(part["from"], leg), end(part["to"], leg))
        for name in ("intervals", "curves", "violations")
        for part in document.get(name, ())
        if "from" in part
    ]
    return any(low == high for low, high in (*pairwise(lengths), *ends))


def end(value: Any, leg: str) -> Any:
    """Returns the length at an end, which may be an object."""
    return value.get(leg) if isinstance(value, Mapping) else value


def told_apart(document: dict[str, Any], ask: Callable[[int], dict[str, Any]]) -> dict[str, Any]:
    """Returns a document for a reader, in which lengths that differ are not alike.

    `ask` returns the same document with more digits: twice as many each time, while lengths are alike. A
    limit of digits, here or of a service, ends it.
    """
    digits, finer = document.get("digits", _MOST), document
    while digits < _MOST and are_alike(finer):
        digits = min(2 * digits, _MOST)
        try:
            finer = ask(digits)
        except (InputError, ServiceError):
            break
    return document if finer is document else apart(document, finer)


def apart(document: Mapping[str, Any], finer: Mapping[str, Any]) -> dict[str, Any]:
    """Returns a document in which lengths that are alike have the digits that tell them apart.

    `finer` is the same document with more digits.
    """
    shown = dict(document)
    alike: dict[str, dict[Place, str]] = defaultdict(dict)
    for place, text in _texts(document, ()):
        more = _at(finer, place)
        if isinstance(more, str):
            alike[text][place] = more
    for text, texts in alike.items():
        different = set(texts.values())
        if len(different) > 1:
            for place, more in texts.items():
                shown = _with(shown, place, _short(more, different, len(text)))
    return shown


def _short(text: str, others: set[str], least: int) -> str:
    """A number of a set in as few digits as tell all of them apart, but not in fewer characters."""
    from rpr_solver.exact.decimals import shorten  # it loads FLINT, which `--help` does not need

    for count in range(1, len(text)):
        texts = [shorten(other, count) for other in others]
        short = shorten(text, count)
        if short and len(short) > least and None not in texts and len(set(texts)) == len(others):
            return short
    return text


def _texts(value: Any, place: Place) -> Iterator[tuple[Place, str]]:
    """The lengths in the lists of a document, with their places."""
    if isinstance(value, Mapping):
        for name, part in value.items():
            if name in (_LENGTHS if place else _LISTS):
                yield from _texts(part, (*place, name))
    elif isinstance(value, list):
        for number, part in enumerate(value):
            if isinstance(part, Mapping):
                yield from _texts(part, (*place, number))
    elif isinstance(value, str) and "." in value:
        yield place, value


def _at(value: Any, place: Place) -> Any:
    try:
        for step in place:
            value = value[step]
    except (KeyError, IndexError, TypeError):
        return None
    return value


def _with(value: Any, place: Place, text: str) -> Any:
    """A copy in which one place has another text."""
    if not place:
        return text
    copy = value.copy()
    copy[place[0]] = _with(value[place[0]], place[1:], text)
    return copy
