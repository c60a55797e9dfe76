"""Cuts from documents of cusp tables, censuses and cusp curves: fewer digits, a part of a range, CSV.

The functions work on the JSON of a document, so that an answer need not be computed again.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from math import inf
from typing import Any

from rpr_solver.contract import check_digits
from rpr_solver.exact.decimals import angle_text, shorten
from rpr_solver.exact.rationals import Exact
from rpr_solver.model.joint_points import coordinate_names
from rpr_solver.model.lengths import LengthRange, intervals_json
from rpr_solver.notebook import degenerate_words
from rpr_solver.transitions.degenerate import Degeneracy


def shorten_slice(slice_json: Mapping[str, Any], have_digits: int, digits: int) -> dict[str, Any] | None:
    """Rounds a slice object to fewer digits; None if its digits are insufficient to decide the rounding.

    Every number is correctly rounded, as if it had been computed with ``digits``.

    Args:
        slice_json: the contract's slice object (:meth:`SliceTable.to_json`).
        have_digits: the significant digits of its numbers.
        digits: the significant digits of the result, 15 to 10000.

    Raises:
        InputError: ``digits`` is not an integer or out of range.

    >>> from rpr_solver import EXAMPLES, cusp_table
    >>> [more], [less] = (cusp_table(EXAMPLES["zein-flat"], 10, digits=digits) for digits in (30, 15))
    >>> shorten_slice(more.to_json(), 30, 15)["cusps"] == less.to_json()["cusps"]
    True
    """
    digits = check_digits(digits)
    if digits > have_digits:
        return None
    result = dict(slice_json)
    for name in {"cusps", "degenerate_points"} & slice_json.keys():
        if (points := _short_points(slice_json[name], digits)) is None:
            return None
        result[name] = points
    return result


def table_csv(table: Mapping[str, Any]) -> str:
    """A cusp table document as CSV: a line for each cusp and each degenerate point, with its ``kind``.

    A slice without either, or with an error, has one line.

    >>> from rpr_solver import EXAMPLES, cusp_table, table_json
    >>> [table] = cusp_table(EXAMPLES["zein-flat"], "0.1", digits=15)
    >>> print(table_csv(table_json(EXAMPLES["zein-flat"], 1, 15, [table.to_json()])))
    l1,count,cusp,alpha_deg,theta1_deg,l2,l3,error,kind,equation
    0.1,0,,,,,,,,
    <BLANKLINE>
    """
    leg = table["fixed_leg"]
    length = f"l{leg}"
    records: list[Mapping[str, object]] = []
    for item in table["slices"]:
        if "error" in item:
            records.append({length: item[length], "error": item["error"]["detail"]})
        else:
            head = {length: item[length], "count": item["count"]}
            points = [
                {"cusp": number, "kind": "cusp", **cusp} for number, cusp in enumerate(item["cusps"], 1)
            ]
            points += item.get("degenerate_points", ())
            records += [{**head, **point} for point in points] or [head]
    return _csv([length, "count", "cusp", *coordinate_names(leg), "error", "kind", "equation"], records)


def curves_csv(document: Mapping[str, Any]) -> str:
    """A document of cusp curves as CSV: a line for each point, curve by curve.

    After these, each thing that is degenerate throughout has a line with its ``kind`` and its description.

    >>> from rpr_solver import EXAMPLES, CurveEnd, CurvePoint, CuspCurve, CuspCurves, cusp_table
    >>> from rpr_solver import LengthKind, LengthRange
    >>> [table] = cusp_table(EXAMPLES["zein-flat"], 10, digits=15)
    >>> points = (CurvePoint(table.length, 1, table.cusps[0]),)
    >>> curve = CuspCurve("C1", CurveEnd("0", LengthKind.OPEN), CurveEnd(None, LengthKind.OPEN), points)
    >>> document = CuspCurves(EXAMPLES["zein-flat"], 1, 15, (curve,), LengthRange()).to_json()
    >>> print(curves_csv(document))
    curve,l1,cusp,alpha_deg,theta1_deg,l2,l3,kind,degenerate
    C1,10,1,31.4509403281135,-129.006918092045,25.2233542007524,35.5094864112439,cusp,
    <BLANKLINE>
    """
    leg = document["fixed_leg"]
    records: list[Mapping[str, object]] = [
        {"curve": curve["name"], "kind": "cusp", **point}
        for curve in document["curves"]
        for point in curve["points"]
    ]
    records += [
        {"kind": part["kind"], "degenerate": degenerate_words(part, leg)}
        for part in document.get("degenerate", ())
    ]
    return _csv(["curve", f"l{leg}", "cusp", *coordinate_names(leg), "kind", "degenerate"], records)


def singular_csv(document: Mapping[str, Any]) -> str:
    """The document of singular curves as CSV: a line for each sample of each strand.

    Special points have their ``kind``, and cusps their number; in these lines too the numbers are the floats
    of the samples.

    >>> from rpr_solver import EXAMPLES, singular_curves
    >>> lines = singular_csv(singular_curves(EXAMPLES["zein-flat"], 34).to_json()).splitlines()
    >>> lines[0]
    'component,strand,alpha_deg,theta1_deg,l2,l3,kind,cusp'
    >>> sum("cusp" in line for line in lines[1:])
    6
    """
    names = coordinate_names(document["fixed_leg"])
    rows: list[Mapping[str, object]] = []
    for part, component in enumerate(document["components"], 1):
        for number, strand in enumerate(component["strands"], 1):
            special = {vertex["index"]: vertex for vertex in strand["vertices"]}
            for index, values in enumerate(zip(*(strand[name] for name in names), strict=True)):
                vertex = special.get(index, {})
                kind = {"kind": vertex.get("kind"), "cusp": vertex.get("cusp")}
                rows.append(
                    {"component": part, "strand": number, **dict(zip(names, values, strict=True)), **kind}
                )
    return _csv(["component", "strand", *names, "kind", "cusp"], rows)


def path_csv(document: Mapping[str, Any]) -> str:
    """The document of a path as CSV: a line for each sample.

    >>> from rpr_solver import EXAMPLES, cusp_loop
    >>> loop = cusp_loop(EXAMPLES["innocenti"], 27, "B", samples=2)
    >>> print(path_csv(loop.to_json()).splitlines()[0])
    time,l1,l2,l3,alpha_deg,theta1_deg,determinant,clearance_deg
    """
    angle = f"theta{document['fixed_leg']}_deg"
    columns = ["time", "l1", "l2", "l3", "alpha_deg", angle, "determinant", "clearance_deg"]
    return _csv(columns, document["samples"])


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
    leg = f"l{document['fixed_leg']}"
    span = LengthRange.of(start, stop)
    low, high = span.start, span.stop
    inside = []
    for transition in document["transitions"]:
        length = Fraction(transition[leg])
        doubt = length / 10 ** (have - 1)
        if any(bound is not None and bound > 0 and abs(length - bound) <= doubt for bound in (low, high)):
            return None
        if low < length and (high is None or length < high):
            text = shorten(transition[leg], kept_digits)
            events = _short_points(transition["events"], kept_digits)
            if text is None or events is None:
                return None
            inside.append({**transition, leg: text, "events": events})
    below = sum(Fraction(interval["from"]) <= low for interval in document["intervals"])
    kept = document["intervals"][below - 1 : below + len(inside)]
    counts = [interval["count"] for interval in kept]
    aspects = [interval["aspects"] for interval in kept if "aspects" in interval]
    first, last = span.to_json().values()
    ends = [first, *(t[leg] for t in inside), last]
    if (degenerate := _restrict_degenerate(document, span, kept_digits)) is None:
        return None
    # the boxes of a full certificate are those of the whole range
    proof = {name: value for name, value in document["certificate"].items() if name != "full"}
    return {
        **document,
        "digits": kept_digits,
        "range": span.to_json(),
        "transitions": inside,
        "intervals": intervals_json(ends, counts, aspects),
        "degenerate": degenerate,
        "certificate": proof,
    }


def _restrict_degenerate(
    document: Mapping[str, Any], span: LengthRange, digits: int
) -> list[dict[str, Any]] | None:
    """What is degenerate in a part of a range, with fewer digits; None if the digits do not decide."""
    found = []
    for whole in document.get("degenerate", ()):
        lengths = [Fraction(end) for end in (whole["from"], whole["to"]) if end not in ("0", None)]
        for bound in filter(None, (span.start, span.stop)):
            if any(abs(x - bound) <= x / 10 ** (document["digits"] - 1) for x in lengths):
                return None
        if (part := Degeneracy.from_json(whole, document["fixed_leg"]).within(span)) is not None:
            entry, exact = part.to_json(), span.to_json().values()
            short = {end: shorten(entry[end], digits) for end in ("from", "to") if entry[end] not in exact}
            if None in short.values():
                return None
            found.append({**entry, **short})
    return found


def census_csv(document: Mapping[str, Any]) -> str:
    """A census document as CSV: a line for each interval, with the transition at its end.

    ``degenerate`` says what is degenerate in each slice of the interval, or in one of them as a whole curve.

    >>> from rpr_solver import EXAMPLES, census
    >>> print(census_csv(census(EXAMPLES["zein-flat"], start=38, stop=39, digits=15).to_json()))
    from,to,count,transition_at_end,degenerate
    38,39,4,,
    <BLANKLINE>
    """
    leg = f"l{document['fixed_leg']}"
    kinds = {t[leg]: t["kind"] for t in document["transitions"]}
    records = [
        {
            **item,
            "transition_at_end": kinds.get(item["to"]),
            "degenerate": "; ".join(
                degenerate_words(part, document["fixed_leg"])
                for part in document.get("degenerate", ())
                if _overlap(part, item)
            ),
        }
        for item in document["intervals"]
    ]
    return _csv(["from", "to", "count", "transition_at_end", "degenerate"], records)


def _overlap(part: Mapping[str, Any], interval: Mapping[str, Any]) -> bool:
    """Whether something degenerate occurs in an interval, or at its end."""
    (low, high), (start, stop) = (
        (Fraction(x["from"]), inf if x["to"] is None else Fraction(x["to"])) for x in (part, interval)
    )
    return start < low <= stop if low == high else low < stop and start < high


def _csv(columns: Sequence[str], records: Iterable[Mapping[str, object]]) -> str:
    """A line for each record; members without a column are left out."""
    out = io.StringIO()
    writer = csv.DictWriter(out, columns, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(records)
    return out.getvalue()


def _short_points(points: Iterable[Mapping[str, str]], digits: int) -> list[dict[str, str | None]] | None:
    """Points rounded to fewer digits; None if one of their numbers is a tie."""
    short = [{key: _shorten(key, text, digits) for key, text in point.items()} for point in points]
    return None if any(None in point.values() for point in short) else short


def _shorten(key: str, text: str, digits: int) -> str | None:
    if key in ("kind", "equation"):
        return text
    short = shorten(text, digits)
    return angle_text(short) if short is not None and key.endswith("_deg") else short
