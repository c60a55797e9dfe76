"""Documents of cusp tables, censuses and cusp curves: fewer digits from more, parts of a range, CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from rpr_solver.exact.decimals import angle_text, shorten
from rpr_solver.exact.rationals import exact_str
from rpr_solver.slices.joint_points import free_legs


def shorten_slice(slice_json: Mapping[str, Any], have_digits: int, digits: int) -> dict[str, Any] | None:
    """A slice object rounded to fewer digits, or None where the stored digits hide the answer.

    Every printed number is correctly rounded, as if it had been computed with ``digits``.
    """
    if digits > have_digits:
        return None
    result = dict(slice_json)
    for name in ("cusps", "degenerate_points"):
        points = []
        for point in slice_json.get(name, ()):
            short = {key: _shorten(key, text, digits) for key, text in point.items()}
            if None in short.values():
                return None
            points.append(short)
        if name in slice_json:
            result[name] = points
    return result


def table_csv(table: Mapping[str, Any]) -> str:
    """A cusp table document as CSV, a cusp a line; a slice without cusps, or with an error, has one line."""
    leg = table["fixed_leg"]
    first, second = free_legs(leg)
    angle = f"theta{leg}_deg"
    columns = [f"l{leg}", "count", "cusp", "alpha_deg", angle, f"l{first}", f"l{second}", "error"]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)
    for item in table["slices"]:
        length = item[f"l{leg}"]
        if "error" in item:
            writer.writerow([length, "", "", "", "", "", "", item["error"]["detail"]])
            continue
        if not item["cusps"]:
            writer.writerow([length, item["count"], "", "", "", "", "", ""])
        for number, cusp in enumerate(item["cusps"], 1):
            values = [cusp[key] for key in ("alpha_deg", angle, f"l{first}", f"l{second}")]
            writer.writerow([length, item["count"], number, *values, ""])
    return out.getvalue()


def curves_csv(document: Mapping[str, Any]) -> str:
    """A document of cusp curves as CSV: a point a line, curve by curve."""
    leg = document["fixed_leg"]
    first, second = free_legs(leg)
    columns = [f"l{leg}", "cusp", "alpha_deg", f"theta{leg}_deg", f"l{first}", f"l{second}"]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["curve", *columns])
    for curve in document["curves"]:
        for point in curve["points"]:
            writer.writerow([curve["name"], *(point[column] for column in columns)])
    return out.getvalue()


def restrict_census(
    document: Mapping[str, Any], start: Fraction | None, stop: Fraction | None, digits: int | None = None
) -> dict[str, Any] | None:
    """A census document for the lengths from ``start`` to ``stop`` and with fewer digits.

    None for an end means that end of the whole range. The answer is None where the stored digits
    cannot tell: a tie in rounding, or a bound within the last digit of a transition.
    """
    have = int(document["digits"])
    wanted = have if digits is None else digits
    if wanted > have:
        return None
    leg = f"l{document['fixed_leg']}"
    low, high = start or Fraction(0), stop
    kept = []
    for transition in document["transitions"]:
        length = Fraction(transition[leg])
        doubt = length / 10 ** (have - 1)
        if any(bound is not None and bound > 0 and abs(length - bound) <= doubt for bound in (low, high)):
            return None
        if low < length and (high is None or length < high):
            kept.append(_short_transition(transition, leg, wanted))
    if None in kept:
        return None
    inside = [t for t in kept if t is not None]
    counts = [_count_above(document, low), *(t["count_after"] for t in inside)]
    ends = [exact_str(low), *(t[leg] for t in inside), None if high is None else exact_str(high)]
    return {
        **document,
        "digits": wanted,
        "range": {"from": ends[0], "to": ends[-1]},
        "transitions": inside,
        "intervals": [
            {"from": a, "to": b, "count": count} for a, b, count in zip(ends, ends[1:], counts, strict=False)
        ],
    }


def census_csv(document: Mapping[str, Any]) -> str:
    """A census document as CSV: an interval a line, with the transition at its end."""
    leg = f"l{document['fixed_leg']}"
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["from", "to", "count", "transition_at_end"])
    kinds = {t[leg]: t["kind"] for t in document["transitions"]}
    for item in document["intervals"]:
        writer.writerow([item["from"], item["to"] or "", item["count"], kinds.get(item["to"], "")])
    return out.getvalue()


def _short_transition(transition: Mapping[str, Any], leg: str, digits: int) -> dict[str, Any] | None:
    length = shorten(transition[leg], digits)
    points = [
        {key: _shorten(key, text, digits) for key, text in point.items()} for point in transition["events"]
    ]
    if length is None or any(None in point.values() for point in points):
        return None
    return {**transition, leg: length, "events": points}


def _count_above(document: Mapping[str, Any], length: Fraction) -> int:
    """The count of the interval that begins at ``length`` or holds it."""
    counts = [i["count"] for i in document["intervals"] if Fraction(i["from"]) <= length]
    return int(counts[-1])


def _shorten(key: str, text: str, digits: int) -> str | None:
    if key in ("kind", "equation"):
        return text
    short = shorten(text, digits)
    return angle_text(short) if short is not None and key.endswith("_deg") else short
