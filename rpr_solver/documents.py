"""Documents of cusp tables, censuses and cusp curves: fewer digits from more, parts of a range, CSV.

They work on documents as JSON has them, so that an answer need not be computed again.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from rpr_solver.contract import check_digits
from rpr_solver.exact.decimals import angle_text, shorten
from rpr_solver.exact.rationals import Exact
from rpr_solver.slices.joint_points import coordinate_names
from rpr_solver.transitions.length_range import LengthRange


def shorten_slice(slice_json: Mapping[str, Any], have_digits: int, digits: int) -> dict[str, Any] | None:
    """A slice object rounded to fewer digits, or None where the digits that it has hide the answer.

    Every number is correctly rounded, as if it had been computed with ``digits``.

    Args:
        slice_json: the contract's slice object (:meth:`SliceTable.to_json`).
        have_digits: the significant digits that it has.
        digits: those of the result, 15 to 10000.

    Raises:
        InputError: ``digits`` is no integer or out of range.

    >>> from rpr_solver import EXAMPLES, cusp_table
    >>> [more], [less] = (cusp_table(EXAMPLES["zein-flat"], 10, digits=digits) for digits in (30, 15))
    >>> shorten_slice(more.to_json(), 30, 15)["cusps"] == less.to_json()["cusps"]
    True
    """
    digits = check_digits(digits)
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
    """A cusp table document as CSV, a cusp a line; a slice without cusps, or with an error, has one line.

    >>> from rpr_solver import EXAMPLES, cusp_table, table_json
    >>> [table] = cusp_table(EXAMPLES["zein-flat"], "0.1", digits=15)
    >>> print(table_csv(table_json(EXAMPLES["zein-flat"], 1, 15, [table.to_json()])))
    l1,count,cusp,alpha_deg,theta1_deg,l2,l3,error
    0.1,0,,,,,,
    <BLANKLINE>
    """
    leg = table["fixed_leg"]
    names = coordinate_names(leg)
    columns = [f"l{leg}", "count", "cusp", *names, "error"]
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
            writer.writerow([length, item["count"], number, *(cusp[name] for name in names), ""])
    return out.getvalue()


def curves_csv(document: Mapping[str, Any]) -> str:
    """A document of cusp curves as CSV: a point a line, curve by curve.

    >>> from rpr_solver import EXAMPLES, CurveEnd, CurvePoint, CuspCurve, CuspCurves, cusp_table
    >>> from rpr_solver import LengthKind, LengthRange
    >>> [table] = cusp_table(EXAMPLES["zein-flat"], 10, digits=15)
    >>> points = (CurvePoint(table.length, 1, table.cusps[0]),)
    >>> curve = CuspCurve("C1", CurveEnd("0", LengthKind.OPEN), CurveEnd(None, LengthKind.OPEN), points)
    >>> document = CuspCurves(EXAMPLES["zein-flat"], 1, 15, (curve,), LengthRange()).to_json()
    >>> print(curves_csv(document))
    curve,l1,cusp,alpha_deg,theta1_deg,l2,l3
    C1,10,1,31.4509403281135,-129.006918092045,25.2233542007524,35.5094864112439
    <BLANKLINE>
    """
    leg = document["fixed_leg"]
    columns = [f"l{leg}", "cusp", *coordinate_names(leg)]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["curve", *columns])
    for curve in document["curves"]:
        for point in curve["points"]:
            writer.writerow([curve["name"], *(point[column] for column in columns)])
    return out.getvalue()


def restrict_census(
    document: Mapping[str, Any], start: Exact | None, stop: Exact | None, digits: int | None = None
) -> dict[str, Any] | None:
    """The part of a whole census document from ``start`` to ``stop``, with fewer digits.

    Args:
        document: the contract's census document of all lengths (:meth:`Census.to_json`).
        start: the lower end of the range, exact, in the user's unit; None is no end.
        stop: the upper end; None is no end.
        digits: significant digits of the result, 15 to 10000; None leaves them as they are.

    Returns:
        The document, or None where the digits that there are cannot tell: a tie in rounding, or an end
        within the last digit of a transition.

    Raises:
        InputError: naming ``start``, ``stop`` or ``digits``.

    >>> from rpr_solver import EXAMPLES, census
    >>> whole = census(EXAMPLES["zein-flat"], digits=20)
    >>> part = restrict_census(whole.to_json(), 35, 36, digits=15)
    >>> part["intervals"][1]
    {'from': '35.2127837717642', 'to': '36', 'count': 6}
    """
    have = int(document["digits"])
    kept_digits = have if digits is None else check_digits(digits)
    if kept_digits > have:
        return None
    leg = f"l{document['fixed_leg']}"
    span = LengthRange.of(start, stop)
    low, high = span.start, span.stop
    kept = []
    for transition in document["transitions"]:
        length = Fraction(transition[leg])
        doubt = length / 10 ** (have - 1)
        if any(bound is not None and bound > 0 and abs(length - bound) <= doubt for bound in (low, high)):
            return None
        if low < length and (high is None or length < high):
            kept.append(_short_transition(transition, leg, kept_digits))
    if None in kept:
        return None
    inside = [t for t in kept if t is not None]
    counts = [_count_above(document, low), *(t["count_after"] for t in inside)]
    first, last = span.to_json().values()
    ends = [first, *(t[leg] for t in inside), last]
    return {
        **document,
        "digits": kept_digits,
        "range": span.to_json(),
        "transitions": inside,
        "intervals": [
            {"from": a, "to": b, "count": count} for a, b, count in zip(ends, ends[1:], counts, strict=False)
        ],
    }


def census_csv(document: Mapping[str, Any]) -> str:
    """A census document as CSV: an interval a line, with the transition at its end.

    >>> from rpr_solver import EXAMPLES, census
    >>> print(census_csv(census(EXAMPLES["zein-flat"], start=38, stop=39, digits=15).to_json()))
    from,to,count,transition_at_end
    38,39,4,
    <BLANKLINE>
    """
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
