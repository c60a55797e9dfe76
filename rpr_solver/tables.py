"""Cusp table documents: fewer digits from more, and CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from typing import Any

from rpr_solver.decimals import shorten


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
    first, second = (i for i in (1, 2, 3) if i != leg)
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


def _shorten(key: str, text: str, digits: int) -> str | None:
    if key in ("kind", "equation"):
        return text
    short = shorten(text, digits)
    if short is not None and key.endswith("_deg") and short.startswith("-180"):
        return short[1:]
    return short
