"""`rpr-cusps poses`, `census` and `curves`: one document for one manipulator, computed here."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import rpr_solver
from rpr_solver.curves.cusp_curves import part_of
from rpr_solver.errors import InputError
from service.cli.pages import Page, Progress, Section, about, counted, rows_of, write_document
from service.cli.solve import MAX_LOCAL_SLICES, read_geometry
from service.schemas.exact_json import JsonNumber
from service.schemas.lengths import parse_range
from service.schemas.limits import Limits
from service.schemas.numbers import digits_in_range, fixed_leg, number, read_samples, whole
from service.schemas.ranges import LengthRange, parse_length_range

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


def census(
    source: str, ranges: Sequence[tuple[str, str]], leg: str | None, digits: str | None, form: str
) -> int:
    """Run `rpr-cusps census`; returns the exit status.

    Raises:
        InputError: naming the option or the field at fault.
        SolverError: nothing could be proved.
    """
    limits = Limits()
    count = digits_option(digits, limits)
    chosen, wanted = leg_and_range(ranges, leg, limits)
    manipulator = read_geometry(source, limits)

    with Progress(1, "steps") as progress:
        document = rpr_solver.census(
            manipulator,
            fixed_leg=chosen,
            digits=count,
            start=wanted.start,
            stop=wanted.stop,
            progress=progress.update,
        ).to_json()
    if form == "csv":
        sys.stdout.write(rpr_solver.census_csv(document))
    else:
        write_document(document, _census_page(document), form)
    return 0


def curves(
    source: str,
    ranges: Sequence[tuple[str, str]],
    given: Sequence[tuple[str, str]],
    samples: str | None,
    leg: str | None,
    digits: str | None,
    form: str,
) -> int:
    """Run `rpr-cusps curves`; returns the exit status.

    Raises:
        InputError: naming the option or the field at fault.
        SolverError: nothing could be proved.
    """
    limits = Limits(max_slices=MAX_LOCAL_SLICES)
    count = digits_option(digits, limits)
    lengths: list[Fraction] = []
    if len(ranges) == 1 and ranges[0][1].count(":") == 2:
        [(option, text)] = ranges
        lengths = parse_range(text, option, limits.max_number_digits).values(limits.max_slices)
        ranges = [(option, text.rpartition(":")[0])]
    leg = leg or next((option[3] for option, _ in given), None)
    chosen, wanted = leg_and_range(ranges, leg, limits)
    wanted.check_inside(lengths, wanted.field)
    for option, text in given:
        if option != f"--l{chosen}":
            raise InputError.of(option, f"with fixed leg {chosen} the lengths are --l{chosen}")
        length = number(text, option, limits)
        wanted.check_inside([length], option)
        lengths.append(length)
    each = None if samples is None else read_samples(JsonNumber(samples), limits)
    manipulator = read_geometry(source, limits)
    with Progress(1, "steps") as progress:
        found = rpr_solver.cusp_curves(manipulator, fixed_leg=chosen, digits=count, progress=progress.update)
        part = part_of(found, wanted.start, wanted.stop, lengths, each, progress.update)
    document = part.to_json()
    if form == "csv":
        sys.stdout.write(rpr_solver.curves_csv(document))
    else:
        write_document(document, _curves_page(document, with_points=bool(lengths or each)), form)
    return 0


def leg_and_range(
    ranges: Sequence[tuple[str, str]], leg: str | None, limits: Limits
) -> tuple[int, LengthRange]:
    """Read `--fixed-leg` and the one range, of which `--l2-range` and `--l3-range` imply their leg."""
    if len(ranges) > 1:
        raise InputError.of(ranges[1][0], "is one range too many; give one")
    chosen = None if leg is None else fixed_leg(JsonNumber(leg))
    if not ranges:
        return chosen or 1, LengthRange()
    [(option, text)] = ranges
    implied = int(option[3])
    if chosen not in (None, implied):
        raise InputError.of(option, f"with --fixed-leg {chosen} the range is --l{chosen}-range")
    return implied, parse_length_range(text, option, limits)


def digits_option(text: str | None, limits: Limits, default: int | None = None) -> int:
    """Read `--digits`."""
    if text is None:
        return limits.default_digits if default is None else default
    return digits_in_range(whole(JsonNumber(text), "digits", "15 to 1000"), limits)


def _census_page(document: Mapping[str, Any]) -> Page:
    leg = f"l{document['fixed_leg']}"
    intervals, transitions = document["intervals"], document["transitions"]
    ends = document["range"]
    below = "" if ends["to"] is None else f" up to {ends['to']}"
    counts = [interval["count"] for interval in intervals]
    span = (
        counted(max(counts), "cusp")
        if min(counts) == max(counts)
        else f"{min(counts)} to {max(counts)} cusps"
    )
    title = f"{leg.upper()} from {ends['from']}{below}: {span}, {counted(len(transitions), 'transition')}"
    rows = [["from", "to", "cusps"], *([i["from"], i["to"] or "∞", str(i["count"])] for i in intervals)]
    events = [
        {
            leg: transition[leg],
            "cusps": f"{transition['count_before']} → {transition['count_after']}",
            **event,
        }
        for transition in transitions
        for event in transition["events"]
    ]
    sections = [Section(title, rows)]
    if events:
        keys = [leg, "cusps", *(key for key in events[0] if key not in (leg, "cusps"))]
        sections.append(Section("Transitions", rows_of(events, keys)))
    return Page(about(document), sections, document["digits"])


def _curves_page(document: Mapping[str, Any], *, with_points: bool) -> Page:
    leg = f"l{document['fixed_leg']}"
    found = document["curves"]
    rows = [["curve", "from", "kind", "joins", "to", "kind", "joins"]]
    for curve in found:
        ends = ((end[leg] or "∞", end["kind"], end["joins"] or "") for end in (curve["from"], curve["to"]))
        rows.append([curve["name"], *(cell for end in ends for cell in end)])
    sections = [Section(f"{leg.upper()}: {counted(len(found), 'cusp curve')}", rows if found else ())]
    points = [{"curve": curve["name"], **point} for curve in found for point in curve["points"]]
    if with_points and points:
        sections.append(Section("Points", rows_of(points)))
    return Page(about(document), sections, document["digits"])


def _pose_page(table: Mapping[str, Any]) -> Page:
    legs = ", ".join(f"L{i} = {table[f'l{i}']}" for i in (1, 2, 3))
    title = f"{legs}: {counted(table['count'], 'pose')}"
    if table["count"] != table["count_with_multiplicity"]:
        title += f", {table['count_with_multiplicity']} with multiplicity"
    notes = [f"α = {curve['alpha_deg']}: {curve['description']}" for curve in table["curves"]]
    return Page(about(table), [Section(title, rows_of(table["poses"], _POSE_KEYS), notes)], table["digits"])
