"""Cuts from the document of a census: a part of its range, fewer digits, CSV; and rows of an atlas of many.

The functions work on the JSON of a document, so that an answer need not be computed again. A row of an atlas
is a random manipulator and what its census says.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import inf
from typing import Any

from rpr_solver.contract import MIN_DIGITS, check_digits
from rpr_solver.errors import InputError, SolverError
from rpr_solver.exact.decimals import shorten
from rpr_solver.exact.numerals import double
from rpr_solver.exact.rationals import Exact
from rpr_solver.model.joint_points import shortened_points
from rpr_solver.model.lengths import LengthRange, intervals_json
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.notebook import csv_text, degenerate_words
from rpr_solver.transitions.census import census
from rpr_solver.transitions.degeneracies import Degeneracy
from rpr_solver.triangles import CCW, CW


def restrict_census(
    document: Mapping[str, Any], start: Exact | None, stop: Exact | None, digits: int | None = None
) -> dict[str, Any] | None:
    """Cuts the part from ``start`` to ``stop`` out of a census document, and rounds it to fewer digits.

    Args:
        document: the contract's census document of all lengths (:meth:`Census.to_json`).
        start: the lower end of the range, exact, in the user's unit; None is an open end.
        stop: the upper end; None is an open end.
        digits: significant digits of the result, 15 to 10000; None keeps all digits.

    Returns:
        The document, or None if the digits of ``document`` are insufficient to decide: a tie in rounding, or
        an end within the last digit of a transition.

    Raises:
        InputError: naming ``start``, ``stop`` or ``digits``.

    >>> from rpr_solver import EXAMPLES, census
    >>> whole = census(EXAMPLES["zein-flat"], digits=20)
    >>> part = restrict_census(whole.to_json(), 35, 36, digits=15)
    >>> part["intervals"][1]
    {'from': '35.2127837717642', 'to': '36', 'count': 6, 'aspects': 2}
    """
    have = int(document["digits"])
    kept_digits = have if digits is None else check_digits(digits)
    if kept_digits > have:
        return None
    span = LengthRange.of(start, stop)
    inside = _transitions_within(document, span, kept_digits)
    degenerate = _degenerate_within(document, span, kept_digits)
    if inside is None or degenerate is None:
        return None
    below = sum(Fraction(interval["from"]) <= span.start for interval in document["intervals"])
    kept = document["intervals"][below - 1 : below + len(inside)]
    counts = [interval["count"] for interval in kept]
    aspects = [interval["aspects"] for interval in kept if "aspects" in interval]
    first, last = span.to_json().values()
    ends = [first, *(transition[f"l{document['fixed_leg']}"] for transition in inside), last]
    return {
        **document,
        "digits": kept_digits,
        "range": span.to_json(),
        "transitions": inside,
        "intervals": intervals_json(ends, counts, aspects),
        "degenerate": degenerate,
    }


def _transitions_within(
    document: Mapping[str, Any], span: LengthRange, digits: int
) -> list[dict[str, Any]] | None:
    """The transitions in a part of a range, with fewer digits; None if the digits do not decide."""
    leg, inside = f"l{document['fixed_leg']}", []
    for transition in document["transitions"]:
        length = Fraction(transition[leg])
        if _is_near_an_end(length, span, document["digits"]):
            return None
        if span.start < length and (span.stop is None or length < span.stop):
            text = shorten(transition[leg], digits)
            events = shortened_points(transition["events"], digits)
            if text is None or events is None:
                return None
            inside.append({**transition, leg: text, "events": events})
    return inside


def _degenerate_within(
    document: Mapping[str, Any], span: LengthRange, digits: int
) -> list[dict[str, Any]] | None:
    """What is degenerate in a part of a range, likewise."""
    found = []
    for whole in document.get("degenerate", ()):
        lengths = [Fraction(end) for end in (whole["from"], whole["to"]) if end not in ("0", None)]
        if any(_is_near_an_end(length, span, document["digits"]) for length in lengths):
            return None
        if (part := Degeneracy.from_json(whole, document["fixed_leg"]).within(span)) is not None:
            entry, exact = part.to_json(), span.to_json().values()
            short = {end: shorten(entry[end], digits) for end in ("from", "to") if entry[end] not in exact}
            if None in short.values():
                return None
            found.append({**entry, **short})
    return found


def _is_near_an_end(length: Fraction, span: LengthRange, digits: int) -> bool:
    """Whether an end of a range is so close to a length that these digits do not separate them."""
    doubt = length / 10 ** (digits - 1)
    return any(abs(length - end) <= doubt for end in (span.start, span.stop) if end)


def census_csv(document: Mapping[str, Any]) -> str:
    """A census document as CSV: a line for each interval, with the transition at its end.

    ``degenerate`` says what is degenerate in each slice of the interval, or in one of them as a whole curve.
    If the events have sensitivities, so has the line: ``sensitivity_a2x`` … of the transition at its end.
    With a tolerance it has the bounds of this transition, ``transition_from`` and ``transition_to``.

    >>> from rpr_solver import EXAMPLES, census
    >>> print(census_csv(census(EXAMPLES["zein-flat"], start=38, stop=39, digits=15).to_json()))
    from,to,count,transition_at_end,degenerate
    38,39,4,,
    <BLANKLINE>
    """
    leg = f"l{document['fixed_leg']}"
    at_end = {t[leg]: _of_transition(document, t) for t in document["transitions"]}
    records = [
        {
            **item,
            **at_end.get(item["to"], {}),
            "degenerate": "; ".join(
                degenerate_words(part, document["fixed_leg"])
                for part in document.get("degenerate", ())
                if _overlap(part, item)
            ),
        }
        for item in document["intervals"]
    ]
    columns = ["from", "to", "count", "transition_at_end", "degenerate"]
    more = (name for cells in at_end.values() for name in cells)
    return csv_text(list(dict.fromkeys([*columns, *more])), records)


def _of_transition(document: Mapping[str, Any], transition: Mapping[str, Any]) -> dict[str, str | None]:
    """The columns of a transition, with those that only some censuses have."""
    bounds = {f"transition_{end}": transition[end] for end in ("from", "to") if end in transition}
    moves = _sensitivities(document, transition["events"])
    return {"transition_at_end": transition["kind"], **bounds, **moves}


def _sensitivities(document: Mapping[str, Any], events: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """The columns ``sensitivity_a2x`` … of a transition; empty if the census has none.

    Several events have their numbers in order, with semicolons between; a singular one has that word.
    """
    moves = [event["sensitivity"] for event in events if "sensitivity" in event]
    if not moves:
        return {}
    return {
        f"sensitivity_{g}": "; ".join("singular" if one is None else one[g] or "" for one in moves)
        for g in document["geometry"]
        if g != "orientation"
    }


def _overlap(part: Mapping[str, Any], interval: Mapping[str, Any]) -> bool:
    """Whether something degenerate occurs in an interval, or at its end."""
    (low, high), (start, stop) = (
        (Fraction(x["from"]), inf if x["to"] is None else Fraction(x["to"])) for x in (part, interval)
    )
    return start < low <= stop if low == high else low < stop and start < high


_BASE, _DECIMALS = 10, 3
_FAR, _HIGH, _LONG = 20, 20, 40
_FLAT = Fraction(1, 20)
"""Of the longest side: the least height of both triangles."""


def atlas_geometry(seed: int, index: int) -> Manipulator:
    """The manipulator of a row, which depends on the seed and the number of the row alone.

    A1A2 is 10; A3 is uniform in [−20, 20] × (0, 20], the sides of the platform in (0, 40], each in steps of
    0.001, and the orientation is either. Triangles whose least height is less than a twentieth of their
    longest side are drawn again.

    >>> atlas_geometry(1, 0) == atlas_geometry(1, 0) != atlas_geometry(1, 1)
    True
    """
    numbers = random.Random(f"rpr-cusps atlas {seed} {index}")
    unit = 10**_DECIMALS
    while True:
        a3x = Fraction(numbers.randint(-_FAR * unit, _FAR * unit), unit)
        a3y = Fraction(numbers.randint(1, _HIGH * unit), unit)
        sides = [Fraction(numbers.randint(1, _LONG * unit), unit) for _ in range(3)]
        orientation = numbers.choice((CCW, CW))
        try:
            found = Manipulator(_BASE, a3x, a3y, sides[0], sides[1], sides[2], orientation)
        except InputError:
            continue
        base = max(Fraction(_BASE) ** 2, (_BASE - a3x) ** 2 + a3y**2, a3x**2 + a3y**2)
        longest = max(sides) ** 2
        if (_BASE * a3y) ** 2 >= (_FLAT * base) ** 2 and found.area16 >= 4 * (_FLAT * longest) ** 2:
            return found


def atlas_row(seed: int, index: int) -> dict[str, Any]:
    """A row of an atlas, computed.

    >>> row = atlas_row(1, 0)
    >>> row["index"], row["most_cusps"] >= max(int(n) for n in row["lengths"])
    (0, True)
    """
    manipulator = atlas_geometry(seed, index)
    try:
        document = census(manipulator, digits=MIN_DIGITS).to_json()
    except SolverError as error:
        return failed_row(seed, index, str(error))
    return row_of(seed, index, document)


def failed_row(seed: int, index: int, why: str) -> dict[str, Any]:
    """The row of a manipulator whose census could not be decided."""
    return {"seed": seed, "index": index, **atlas_geometry(seed, index).identity_json(), "error": why}


def row_of(seed: int, index: int, document: Mapping[str, Any]) -> dict[str, Any]:
    """A row of an atlas from the census of its manipulator over all lengths of leg 1.

    ``l1`` is the middle of the widest window with the most cusps, and ``width`` its width, None if it has no
    end; ``lengths`` has the total length of all windows of each number of cusps, None if one has no end;
    ``aspects`` the largest number of aspects, None if none is known.
    """
    windows = [
        (
            interval["count"],
            Fraction(interval["from"]),
            None if interval["to"] is None else Fraction(interval["to"]),
        )
        for interval in document["intervals"]
    ]
    most = max(count for count, *_ in windows)
    best = [(start, stop) for count, start, stop in windows if count == most]
    start, stop = max(best, key=lambda one: (one[1] is None, 0 if one[1] is None else one[1] - one[0]))
    known = [x["aspects"] for x in document["intervals"] if x.get("aspects") is not None]
    return {
        "seed": seed,
        "index": index,
        **{name: document[name] for name in ("geometry", "geometry_hash", "near") if name in document},
        "most_cusps": most,
        "l1": _text(start + 1 if stop is None else (start + stop) / 2),
        "width": None if stop is None else _text(stop - start),
        "transitions": len(document["transitions"]),
        "aspects": max(known, default=None),
        "lengths": {str(n): _total(windows, n) for n in sorted({count for count, *_ in windows})},
    }


def _total(windows: list[tuple[int, Fraction, Fraction | None]], number: int) -> str | None:
    total = Fraction(0)
    for count, start, stop in windows:
        if count == number:
            if stop is None:
                return None
            total += stop - start
    return _text(total)


def _text(x: Fraction) -> str:
    return f"{double(x):.12g}"
