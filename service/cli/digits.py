"""The digits of a document that a reader sees: few, but as many as tell lengths apart that differ."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from itertools import pairwise
from typing import Any, TypeAlias

from rpr_solver.contract import LEGS
from rpr_solver.errors import InputError
from service.errors import ServiceError

Place: TypeAlias = tuple[str | int, ...]

PRINTED = 15
"""The significant digits of a printed number, unless `--digits` says how many: a line of a page holds four
such numbers, and a double has no more."""

_NUMBER = re.compile(r"-?(\d+\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_LENGTHS = ("from", "to", *LEGS)
_MOST = 1000
_LISTS = ("intervals", "transitions", "curves", "violations", "ignored_windows")


def printed(document: dict[str, Any], digits: int, ask: Callable[[int], dict[str, Any]]) -> dict[str, Any]:
    """Returns a document for a reader: with so many significant digits, but more for lengths that
    differ and would be alike.

    `ask` returns the same document with more digits: twice as many each time, while lengths are alike. A
    limit of digits, here or of a service, ends it.
    """
    shown, finer = rounded(document, digits), document
    if not are_alike(shown):
        return shown
    count = document.get("digits", _MOST)
    while count < _MOST and are_alike(finer):
        count = min(2 * count, _MOST)
        try:
            finer = ask(count)
        except (InputError, ServiceError):
            break
    return shown if finer is shown else apart(shown, finer)


def rounded(document: dict[str, Any], digits: int) -> dict[str, Any]:
    """Returns a document whose numbers have at most this number of significant digits, correctly rounded.

    Only numbers with all digits of the document change, and sensitivities, which have fewer. Bounds, and
    numbers as they were given, are exact.

    >>> rounded({"digits": 15, "l1": "12.500", "cusps": [{"l2": "26.7863808708888"}]}, 6)["cusps"]
    [{'l2': '26.7864'}]
    """
    computed = document.get("digits", 0)

    def short(value: Any, is_slope: bool = False) -> Any:
        if isinstance(value, str):
            match = _NUMBER.fullmatch(value)
            count = len(match[1].lstrip("0.").replace(".", "")) if match else 0
            return (
                rounded_text(value, digits) if count == computed or (is_slope and count > digits) else value
            )
        if isinstance(value, Mapping):
            return {
                name: part if name == "geometry" else short(part, is_slope or name == "sensitivity")
                for name, part in value.items()
            }
        return [short(part, is_slope) for part in value] if isinstance(value, list) else value

    return document if computed <= digits else short(document)


def rounded_text(text: str, digits: int) -> str:
    """Returns a correctly rounded decimal with this number of digits, or more if they do not decide how it is
    rounded.

    >>> rounded_text("26.7863808708888", 6), rounded_text("0.125000000000000", 2)
    ('26.7864', '0.125')
    """
    from rpr_solver.exact.decimals import shorten  # it loads FLINT, which `--help` does not need

    return next(short for count in range(digits, len(text) + 1) if (short := shorten(text, count)))


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
    elif isinstance(value, str) and value[:1].isdigit():
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
