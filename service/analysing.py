"""`rpr-cusps poses`: one document for one manipulator, computed here."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import rpr_solver
from service.json_body import JsonNumber
from service.output import Page, Section, about, counted, rows_of, write_document
from service.reading import digits_in_range, number, whole
from service.settings import Limits
from service.solving import read_geometry

_POSE_KEYS = ("alpha_deg", "theta1_deg", "theta2_deg", "theta3_deg", "b1_x", "b1_y", "multiplicity")


def poses(source: str, lengths: Mapping[str, str], digits: str | None, form: str) -> int:
    """Run `rpr-cusps poses`; returns the exit status.

    Raises:
        InputError: naming the option or the field at fault.
        SolverError: nothing could be proved.
    """
    limits = Limits()
    count = digits_option(digits, limits)
    values = [number(text, f"--{leg}", limits) for leg, text in lengths.items()]
    manipulator = read_geometry(source, limits)
    table = rpr_solver.poses(manipulator, *values, digits=count).to_json()
    write_document(table, _pose_page(table), form)
    return 0


def digits_option(text: str | None, limits: Limits, default: int | None = None) -> int:
    """Read `--digits`."""
    if text is None:
        return limits.default_digits if default is None else default
    return digits_in_range(whole(JsonNumber(text), "digits", "15 to 1000"), limits)


def _pose_page(table: Mapping[str, Any]) -> Page:
    legs = ", ".join(f"L{i} = {table[f'l{i}']}" for i in (1, 2, 3))
    title = f"{legs}: {counted(table['count'], 'pose')}"
    if table["count"] != table["count_with_multiplicity"]:
        title += f", {table['count_with_multiplicity']} with multiplicity"
    notes = [f"α = {curve['alpha_deg']}: {curve['description']}" for curve in table["curves"]]
    return Page(about(table), [Section(title, rows_of(table["poses"], _POSE_KEYS), notes)], table["digits"])
