"""Cuts from the document of a census: a part of its range, fewer digits, and CSV.

The functions work on the JSON of a document, so that an answer need not be computed again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import inf
from typing import Any

from rpr_solver.contract import check_digits
from rpr_solver.exact.decimals import shorten
from rpr_solver.exact.rationals import Exact
from rpr_solver.model.joint_points import shortened_points
from rpr_solver.model.lengths import LengthRange, intervals_json
from rpr_solver.notebook import csv_text, degenerate_words
from rpr_solver.transitions.degeneracies import Degeneracy

_OF_WINDOWS = ("ignore_windows", "ignored_windows")


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
        The document, which ignores no windows, or None if the digits of ``document`` are insufficient to
        decide: a tie in rounding, or an end within the last digit of a transition.

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
        **{name: value for name, value in document.items() if name not in _OF_WINDOWS},
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
    With a tolerance it has the bounds of this transition, ``transition_from`` and ``transition_to``. Of a
    window that is ignored, ``ignored_width`` has the width.

    >>> from rpr_solver import EXAMPLES, census
    >>> print(census_csv(census(EXAMPLES["zein-flat"], start=38, stop=39, digits=15).to_json()))
    from,to,count,transition_at_end,degenerate
    38,39,4,,
    <BLANKLINE>
    """
    leg = f"l{document['fixed_leg']}"
    at_end = {t[leg]: _of_transition(document, t) for t in document["transitions"]}
    narrow = {(x["from"], x["to"]): x["width"] for x in document.get("ignored_windows", ())}
    widths = ["ignored_width"] if "ignore_windows" in document else []
    records = [
        {
            **item,
            **{name: narrow.get((item["from"], item["to"])) for name in widths},
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
    return csv_text(list(dict.fromkeys([*columns, *widths, *more])), records)


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
