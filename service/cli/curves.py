"""Censuses, cusp curves, margins and paths on the command line."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from itertools import combinations
from typing import Any

import rpr_solver
from rpr_solver.contract import LEGS, letter
from rpr_solver.notebook import counted
from service.cli import asking
from service.cli.asking import Options, command
from service.cli.pages import (
    Page,
    Section,
    about,
    all_legs,
    counted_range,
    degenerate_notes,
    nearby,
    rows_of,
    tolerance_words,
)
from service.cli.parsers import Command, said_of
from service.schemas.censuses import CensusRequest
from service.schemas.curves import CuspCurvesRequest, MarginRequest
from service.schemas.paths import PathRequest


def _census(document: Mapping[str, Any]) -> Page:
    """Find every length at which the number of cusps changes, with its kind and poses, and the number of
    cusps in between. The list is proved complete. With --tolerance it holds for every manipulator whose
    lengths differ from the given ones by at most the tolerance: each transition has bounds of its length.

    Options:
        range: the range of lengths; either end may be omitted (default: all)
        tolerance: a change of all lengths, or of single ones, as d1=0.01,a3x=0.002; the others are exact
            then. The census must hold for every manipulator within it
        sensitivities: say how fast the transition of each event moves when the lengths of the geometry change

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


def _run_curves(args: argparse.Namespace) -> int:
    """Follow each cusp, by proof, as the length of one leg varies, from the transition at which it is born to
    the one at which it vanishes. The names of the curves depend only on the manipulator and the leg, not on
    the requested range or points.

    Options:
        range: the range of lengths (default: all); with STEP, also the lengths of points
        l1: a length at which to compute points; repeatable
        samples: number of points of each curve in every window between transitions

    examples:
      rpr-cusps curves innocenti --digits 15
      rpr-cusps curves innocenti --l1-range 27:29:0.1 --format csv
      rpr-cusps curves robot.json --l2-range 10:40 --samples 20 --format json
    """
    question = _OPTIONS.asked(args)
    document = asking.answer_of(args.url, question, "steps")
    has_points = bool(question.slices or question.samples)
    shown = asking.shown(args, question, document, "steps")
    asking.write(CuspCurvesRequest, document, _page(shown, has_points), args.format)
    return 0


_OPTIONS = Options(CuspCurvesRequest, said_of(_run_curves))


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

    What is proved holds for every geometry within the radius; a counter-example is exact, and can be checked
    again. The first-order radius is an estimate, no bound.

    Exit status: 0 proved (without a tolerance: a radius > 0), 1 refuted or open, 2 bad input.

    Options:
        l1: the slice whose number of cusps must stay
        requirement: or the range of a requirement; either end may be omitted
        window: or a length between two transitions: slices with the number of cusps there must exist
        tolerance: a change of all lengths, or of single ones, as d1=0.01,a3x=0.002; the others are exact then
        weights: how much lengths may change in comparison, as d1=2,a2x=0 (default: 1; 0: exact)

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


_SHOWN_ROWS = 25


def _paths(document: Mapping[str, Any]) -> Page:
    """Find a path without a singularity: a loop round a cusp to another pose of the same leg lengths, or a
    path between any two poses, or the reason why there is none. It is proved along the whole path, not only
    at the samples.

    Options:
        l1: the length of the fixed leg, or all three
        from: the first pose: its number in the table of poses, or l1=27,l2=20,l3=20,pose=1 for other leg
            lengths, or alpha=12.5,theta1=-30,l1=27 by its angles in degrees
        to: the last pose, likewise
        between: poses
        limits: a leg, along the whole path
        clearance: how far to keep from singular poses, or best for as far as possible
        cusp: the number or letter of the cusp in the table of the slice (default: A)
        motion.speed: the greatest speed of all legs or of each; times follow from the limits: 10, or
            l2=10,l3=5
        motion.acceleration: the greatest acceleration, likewise: 10, or l2=10,l3=5
        motion.jerk: the greatest jerk, likewise (default: any): 10, or l2=10,l3=5
        others: follow the other poses of the joint vector, too, until the fold at which they vanish
        sampling.step: the time between samples, instead of their number
        sampling.chord: as many samples as are needed for legs that move linearly between to deviate less

    examples:
      rpr-cusps paths innocenti --l1 27 --cusp B
      rpr-cusps paths innocenti --l1 28.1 --cusp 7 --samples 501 --duration 10 --format csv
      rpr-cusps paths innocenti --l1 27 --cusp B --speed 10 --acceleration 20 --jerk 200 --chord 0.01
      rpr-cusps paths innocenti --l1 27 --l2 25.7 --l3 9.2 --from 2 --to 4
      rpr-cusps paths innocenti --l1 27 --l2 25.7 --l3 9.2 --from 2 --to 4 --between 27:30
      rpr-cusps paths innocenti --from l1=27,l2=20,l3=20,pose=1 --to l1=30,l2=21,l3=19,pose=1
      rpr-cusps paths innocenti --l1 27 --l2 20 --l3 20 --from 1 --to alpha=-40,theta1=140,l1=27
      rpr-cusps paths innocenti --l1 27 --l2 25.7 --l3 9.2 --from 1 --to 3 --clearance best
      rpr-cusps paths innocenti --l1 27 --cusp B --l2-limits 8:20 --l3-limits :18
    """
    ends = f"from {_end(document['from'])} to {_end(document['to'])}"
    common = f" of {all_legs(document)}" if LEGS[0] in document else ""
    if not document["connected"]:
        title = f"No path {ends}{common}: {document['obstacle']}"
        return Page(about(document), [Section(title, (), _advice(document))], document["digits"])
    sign = "J > 0" if document["sign"] > 0 else "J < 0"
    cusp = document["cusp"]
    what = "Path" if cusp is None else f"Loop round cusp {letter(cusp)},"
    title = f"{what} {ends}{common}: {sign}"
    samples = document["samples"]
    step = -(-(len(samples) - 1) // (_SHOWN_ROWS - 1))
    shown = [*samples[:-1:step], samples[-1]]
    least = document["certificate"]["least_determinant"]
    twins = "".join(f" and its twin {letter(twin)}" for twin in document.get("twins", ()))
    round_it = "" if cusp is None else f"; once round the cusp{twins}, counter-clockwise"
    kept = "" if document["limits"] is None else "; all joint limits are kept"
    notes = [f"Proved along the whole path: |determinant| ≥ {least}{round_it}{kept}."]
    notes += _notes_of_motion(document)
    notes += _clear(document)
    if len(shown) < len(samples):
        notes.append(f"{counted(len(samples), 'sample')}, of which {len(shown)} are shown.")
    notes += [_fate(other) for other in document["others"] or ()]
    columns = [name for name in samples[0] if name != "place"]
    return Page(about(document), [Section(title, rows_of(shown, columns), notes)], document["digits"])


def _notes_of_motion(document: Mapping[str, Any]) -> list[str]:
    """What is said of the motion, and of the legs between rows."""
    notes = []
    if "motion" in document:
        stops, time = len(document["motion"]["stops"]), document["duration"]
        rest = f", and rest {counted(stops, 'time')} on the way" if stops else ""
        notes.append(f"All legs keep the limits of motion for the {time} units of time that it takes{rest}.")
    if "deviation" in document:
        most = ", ".join(f"{leg.upper()} by {x}" for leg, x in document["deviation"].items())
        notes.append(f"Moving linearly between samples, legs deviate at most: {most}.")
    return notes


def _end(pose: Mapping[str, Any]) -> str:
    """A pose at an end, with its own lengths."""
    name = "a given pose" if pose["pose"] is None else f"pose {pose['pose']}"
    return f"{name} of {all_legs(pose)}" if LEGS[0] in pose else name


def _fate(other: Mapping[str, Any]) -> str:
    """What becomes of another pose."""
    pose = f"Pose {other['from']['pose']}"
    if other["to"] is not None:
        return f"{pose} is carried to pose {other['to']['pose']}."
    fold = other["fold"]
    if fold is None:
        return f"{pose}: not decided."
    return f"{pose} ends on a fold at {all_legs(fold)}."


def _resolution(document: Mapping[str, Any]) -> list[str]:
    size = document["resolution"]
    if size is None:
        return []
    length = "" if size["length"] is None else f" × {size['length']}"
    examined = f"Poses were examined in boxes of {size['angle_deg']}° × {size['angle_deg']}°{length}."
    near = document.get("near_pose")
    return [examined, *([] if near is None else [f"It stays undecided near {nearby(near)}."])]


def _clear(document: Mapping[str, Any]) -> list[str]:
    """The clearance of a path, or of the best one that was found."""
    found = document.get("clearance")
    if found is None:
        return []
    whose = "Its" if document["connected"] else "The widest path that was found has a"
    least = f"{whose} clearance {'is' if document['connected'] else 'of'} at least {found['proved']}°"
    bound = "" if found["bound"] is None else f"; no path has more than {found['bound']}°"
    legs = " and ".join(leg.upper() for leg in LEGS if leg != f"l{document['fixed_leg']}")
    curved = "" if found["radius"] is None else f" Its radius of curvature is at least {found['radius']}°."
    return [f"{least}{bound}.", f"No fold is met while {legs} change by less than {found['legs']}.{curved}"]


def _advice(document: Mapping[str, Any]) -> list[str]:
    """What is said of two poses without a path."""
    leg, span = document["fixed_leg"], document["connecting_range"]
    if document["obstacle"] == rpr_solver.Obstacle.OPPOSITE_SIGNS:
        return ["J has different signs at both poses, so every path between them meets a singularity."]
    if document["obstacle"] == rpr_solver.Obstacle.UNDECIDED:
        return ["No path was found, and none is excluded.", *_clear(document), *_resolution(document)]
    if document["obstacle"] == rpr_solver.Obstacle.TOO_NARROW:
        return ["Every path comes nearer to a singular pose than is asked for.", *_clear(document)]
    if document["obstacle"] == rpr_solver.Obstacle.OUTSIDE_LIMITS:
        return ["These lengths themselves exceed the joint limits."]
    if document["obstacle"] == rpr_solver.Obstacle.SEPARATED_BY_LIMITS:
        lines = ["Every path between the poses meets a singularity or exceeds a joint limit."]
        return [*lines, *_resolution(document)]
    free = document["between"]
    where = "held" if free is None else f"between {free['from']} and {free['to']}"
    lines = [f"Every path with L{leg} {where} meets a singularity."]
    if span is not None:
        lines.append(f"With L{leg} between {span['from']} and {span['to']} there is one (--between).")
    return lines


COMMANDS = {
    "census": command(CensusRequest, page=_census, steps="steps"),
    "curves": Command.of(_run_curves, _OPTIONS.configure),
    "margin": command(
        MarginRequest,
        page=_margin,
        steps="boxes",
        status=_status,
    ),
    "paths": command(PathRequest, page=_paths),
}
