"""Paths without a singularity, on the command line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import rpr_solver
from rpr_solver.contract import LEGS, letter
from service.cli.asking import Options, command
from service.cli.pages import Page, Section, about, all_legs, counted, nearby, rows_of
from service.schemas.paths import PathRequest

_SHOWN_ROWS = 25
_MOST = "10, or l2=10,l3=5"
_WORDS = {
    "l1": "the length of the fixed leg, or all three",
    "from": "the first pose: its number in the table of poses, or l1=27,l2=20,l3=20,pose=1 for other leg "
    "lengths, or alpha=12.5,theta1=-30,l1=27 by its angles in degrees",
    "to": "the last pose, likewise",
    "between": "poses",
    "limits": "a leg, along the whole path",
    "clearance": "how far to keep from singular poses, or best for as far as possible",
    "cusp": "the number or letter of the cusp in the table of the slice (default: A)",
    "motion.speed": f"the greatest speed of all legs or of each; times follow from the limits: {_MOST}",
    "motion.acceleration": f"the greatest acceleration, likewise: {_MOST}",
    "motion.jerk": f"the greatest jerk, likewise (default: any): {_MOST}",
    "sampling.step": "the time between samples, instead of their number",
    "sampling.chord": "as many samples as are needed for legs that move linearly between to deviate less",
}


def _page(document: Mapping[str, Any]) -> Page:
    """Find a path without a singularity: a loop round a cusp to another pose of the same leg lengths, or a
    path between any two poses, or the reason why there is none. It is proved along the whole path, not only
    at the samples.

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
    near = document.get("near")
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


COMMANDS = {"paths": command(Options(PathRequest, _WORDS), page=_page)}
