"""Censuses, cusp curves and margins on the command line."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from itertools import combinations
from typing import Any

from service.cli import asking
from service.cli.asking import Options, command
from service.cli.pages import (
    Page,
    Section,
    about,
    counted,
    counted_range,
    degenerate_notes,
    rows_of,
    tolerance_words,
)
from service.cli.parsers import Command
from service.schemas.censuses import CensusRequest
from service.schemas.curves import CuspCurvesRequest, MarginRequest


def _census(document: Mapping[str, Any]) -> Page:
    """Find every length at which the number of cusps changes, with its kind and poses, and the number of
    cusps in between. The list is proved complete. With --tolerance it holds for every manipulator whose
    lengths are so close to the given ones: each transition has bounds of its length.

    examples:
      rpr-cusps census innocenti --digits 20
      rpr-cusps census innocenti --l1-range 28:31 --format json
      rpr-cusps census robot.json --l2-range :40 --format csv     leg 2 fixed
      rpr-cusps census robot.json --l1-range 20:30 --digits 15 --sensitivities
      rpr-cusps census robot.json --l1-range 20:30 --tolerance 0.001
      rpr-cusps census robot.json --l1-range 20:30 --tolerance d1=0.005,a3x=0.001
    """
    leg = f"l{document['fixed_leg']}"
    intervals, transitions = document["intervals"], document["transitions"]
    ends = document["range"]
    below = "" if ends["to"] is None else f" up to {ends['to']}"
    counts = [interval["count"] for interval in intervals]
    cusps = counted_range(min(counts), max(counts), "cusp")
    title = f"{leg.upper()} from {ends['from']}{below}: {cusps}, {counted(len(transitions), 'transition')}"
    rows = [["from", "to", "cusps", "aspects"]]
    rows += ([i["from"], i["to"] or "∞", str(i["count"]), str(i.get("aspects") or "")] for i in intervals)
    events = [
        {leg: t[leg], "cusps": f"{t['count_before']} → {t['count_after']}", **event}
        for t in transitions
        for event in t["events"]
    ]
    sections = [Section(title, rows, degenerate_notes(document))]
    if events:
        others = (leg, "cusps", "sensitivity", "singular")
        keys = [leg, "cusps", *(key for key in events[0] if key not in others)]
        sections.append(Section("Transitions", rows_of(events, keys)))
    sections += _sensitivities(leg, transitions)
    sections += _within_tolerance(leg, document)
    return Page(about(document), sections, document["digits"])


def _sensitivities(leg: str, transitions: Sequence[Mapping[str, Any]]) -> Iterator[Section]:
    """The table of sensitivities, if the census has them, and what is said of transitions that have none."""
    moving, notes = [], []
    for transition in transitions:
        length, events = transition[leg], transition["events"]
        moves = [event["sensitivity"] for event in events if "sensitivity" in event]
        if not moves:
            notes.append(f"{leg.upper()} = {length}: no pose is known, so neither is its sensitivity")
        for event in events:
            if event.get("singular"):
                notes.append(
                    f"{leg.upper()} = {length}: {event['kind']}: not a simple transition; changes of the "
                    "geometry may resolve it at once, so the margin there is 0"
                )
            elif event.get("sensitivity"):
                shown = {g: slope or "" for g, slope in event["sensitivity"].items()}
                moving.append({leg: length, "kind": event["kind"], **shown})
        if any(_differ(one, other) for one, other in combinations(filter(None, moves), 2)):
            notes.append(
                f"{leg.upper()} = {length}: {len(events)} poses, which changes of the geometry move apart"
            )
    if any("sensitivity" in event for transition in transitions for event in transition["events"]):
        title = f"Sensitivities: how fast {leg.upper()} of each transition changes with each length"
        yield Section(title, rows_of(moving), notes)


def _within_tolerance(leg: str, document: Mapping[str, Any]) -> Iterator[Section]:
    """Where the transitions of all geometries within a tolerance are, and what is open, if there is one."""
    if "tolerance" not in document:
        return
    rows = [
        {leg: t[leg], "kind": t["kind"], "from": t["from"] or "?", "to": t["to"] or "?"}
        for t in document["transitions"]
    ]
    notes = [
        f"Open from {part['from']} to {part['to'] or '∞'}: {part['reason']}." for part in document["open"]
    ]
    if document["complete"]:
        notes = ["Every geometry has these transitions in this order, with these numbers of cusps between."]
    title = f"With {tolerance_words(document['tolerance'])}: the bounds of each transition"
    yield Section(title, rows_of(rows), notes)


def _differ(one: Mapping[str, str | None], other: Mapping[str, str | None]) -> bool:
    """Whether two sensitivities differ by more than their roundings."""
    for a, b in zip(one.values(), other.values(), strict=True):
        if a is not None and b is not None:
            x, y = Decimal(a), Decimal(b)
            units = (Decimal(1).scaleb(int(number.as_tuple().exponent)) for number in (x, y))
            if abs(x - y) > max(units):
                return True
    return False


_OPTIONS = Options(
    CuspCurvesRequest,
    {
        "range": "the range of lengths (default: all); with STEP, also the lengths of points",
        "l1": "a length at which to compute points; repeatable",
        "samples": "number of points of each curve in every window between transitions",
    },
)


def _run_curves(args: argparse.Namespace) -> int:
    """Follow each cusp, by proof, as the length of one leg varies, from the transition at which it is born to
    the one at which it vanishes. The names of the curves depend only on the manipulator and the leg, not on
    the requested range or points.

    examples:
      rpr-cusps curves innocenti --digits 15
      rpr-cusps curves innocenti --l1-range 27:29:0.1 --format csv
      rpr-cusps curves robot.json --l2-range 10:40 --samples 20 --format json
    """
    question = _OPTIONS.asked(args)
    document = asking.answer_of(args.url, question, "steps")
    has_points = bool(question.slices or question.samples)
    asking.write(CuspCurvesRequest, document, _page(document, has_points), args.format)
    return 0


def _page(document: Mapping[str, Any], has_points: bool) -> Page:
    leg = f"l{document['fixed_leg']}"
    curves = document["curves"]
    rows = [["curve", "from", "kind", "joins", "to", "kind", "joins"]]
    for curve in curves:
        ends = ((end[leg] or "∞", end["kind"], end["joins"] or "") for end in (curve["from"], curve["to"]))
        rows.append([curve["name"], *(cell for end in ends for cell in end)])
    title = f"{leg.upper()}: {counted(len(curves), 'cusp curve')}"
    sections = [Section(title, rows if curves else (), degenerate_notes(document))]
    points = [{"curve": curve["name"], **point} for curve in curves for point in curve["points"]]
    if has_points and points:
        sections.append(Section("Points", rows_of(points)))
    return Page(about(document), sections, document["digits"])


PROVED, NOT_PROVED = 0, 1


def _margin(document: Mapping[str, Any]) -> Page:
    """Prove how far the lengths of a manipulator may change before the number of cusps of a slice does,
    before a requirement is violated, or before a window with a number of cusps vanishes. With --tolerance,
    decide whether a tolerance is small enough.

    What is proved holds for every geometry within the radius; a counter-example is exact, and can be posed
    again. The first-order radius is an estimate, no bound.

    Exit status: 0 proved (without a tolerance: a radius > 0), 1 refuted or open, 2 bad input.

    examples:
      rpr-cusps margin innocenti --l1 28.1
      rpr-cusps margin innocenti --l1 28.1 --tolerance 0.0005
      rpr-cusps margin innocenti --l1 28.1 --tolerance d1=0.004,a3x=0.0002
      rpr-cusps margin robot.json --l1-range 21:26 --max-cusps 6 --weights a2x=0
      rpr-cusps margin innocenti --window 28.1 --tolerance 0.01
    """
    asked, leg = document["asked"], f"l{document['fixed_leg']}"
    count = document["count"]
    cusps = "the requirement" if count is None else counted(count, "cusp")
    place = f" at {leg.upper()} = {asked[leg]}" if leg in asked else ""
    place = f" in the window at {asked['window']}" if "window" in asked else place
    values = [("verdict", document["verdict"]), ("proved within", document["proved"])]
    values += [("why not more", document["reason"]), ("flat, or no manipulator, from", document["validity"])]
    first, example = document["first_order"], document["counterexample"]
    if first is not None:
        movers = ", ".join(f"{mover['kind']} at {mover[leg]}" for mover in first["binding"])
        values.append(("first order (an estimate)", f"{first['radius']}: {movers}"))
    if example is not None:
        values.append(("refuted at", example["radius"]))
    title = f"Margin of {cusps}{place}"
    if document["verdict"] is not None:
        title += "; radii are multiples of the tolerance"
    sections = [Section(title, [["", ""], *([name, text] for name, text in values if text is not None)])]
    if first is not None:
        rows = [{"transition": mover[leg], **mover["sensitivity"]} for mover in first["binding"]]
        sections.append(Section("Sensitivities of the transitions that bind it", rows_of(rows)))
    if example is not None:
        found = (
            "no length has as many cusps" if example["count"] is None else counted(example["count"], "cusp")
        )
        at = "" if example[leg] is None else f" at {leg.upper()} = {example[leg]}"
        sections.append(Section(f"Counter-example: {found}{at}", rows_of([example["geometry"]])))
    return Page(about(document), sections, document["digits"])


def _status(document: Mapping[str, Any]) -> int:
    if document["verdict"] is None:
        return PROVED if document["proved"] not in (None, "0") else NOT_PROVED
    return PROVED if document["verdict"] == "proved" else NOT_PROVED


COMMANDS = {
    "census": command(
        Options(
            CensusRequest,
            {
                "range": "the range of lengths; either end may be omitted (default: all)",
                "tolerance": "a change of all lengths, or of single ones, as d1=0.01,a3x=0.002; the others "
                "are exact then. The census is to hold for every manipulator within it",
            },
        ),
        page=_census,
        steps="steps",
    ),
    "curves": Command.of(_run_curves, _OPTIONS.configure),
    "margin": command(
        Options(
            MarginRequest,
            {
                "l1": "the slice whose number of cusps is to stay",
                "requirement": "or the range of a requirement; either end may be omitted",
                "window": "or a length between two transitions: slices with the number of cusps there are to "
                "exist",
                "tolerance": "a change of all lengths, or of single ones, as d1=0.01,a3x=0.002; the others "
                "are exact then",
                "weights": "how much lengths may change in comparison, as d1=2,a2x=0 (default: 1; 0: exact)",
            },
        ),
        page=_margin,
        steps="boxes",
        status=_status,
    ),
}
