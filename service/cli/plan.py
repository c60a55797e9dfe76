"""The group Plan paths: paths without a singularity, changes of assembly mode, and which poses are joined."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

import rpr_solver
from rpr_solver.contract import LEGS, letter
from rpr_solver.notebook import counted
from service.cli.asking import command
from service.cli.check.reports import short
from service.cli.pages import (
    SIGNS,
    Page,
    Section,
    about,
    all_legs,
    ends_in_words,
    nearby,
    rows_of,
    tolerance_words,
)

_SHOWN_ROWS = 25


def _paths(document: Mapping[str, Any]) -> Page:
    """Find a path without a singularity: a loop round a cusp to another pose of the same leg lengths, or a
    path between any two poses, or the reason why there is none. The proof covers the whole path, not only the
    samples.

    Options:
        l1: the length of the fixed leg, or all three
        from: the first pose: its number in the table of poses, or l1=27,l2=20,l3=20,pose=1 for other leg
            lengths, or alpha=12.5,theta1=-30,l1=27 by its angles in degrees
        to: the last pose, likewise
        between: poses
        limits: a leg, along the whole path
        clearance: how far to keep from singular poses, or best for as far as possible
        condition: give the condition number of each sample, and its bounds along the path
        length_scale: the length that converts rotations to lengths for condition numbers (default: the root
            of the mean squared distance of the platform's joints from their centroid)
        max_condition: the greatest condition number that a pose of the path may have
        cusp: the number or letter of the cusp in the table of the slice (default: A)
        motion.speed: the greatest speed, for all legs or for each (10, or l2=10,l3=5); the times follow from
            the limits
        motion.acceleration: the greatest acceleration, likewise: 10, or l2=10,l3=5
        motion.jerk: the greatest jerk, likewise (default: any): 10, or l2=10,l3=5
        others: follow the other poses of the joint vector, too, until the fold at which they vanish
        sampling.step: the time between samples, instead of their number
        sampling.chord: as many samples as are needed for legs that move linearly between them to deviate by
            less than X

    examples:
      rpr-cusps path innocenti --l1 27 --cusp B
      rpr-cusps path innocenti --l1 28.1 --cusp 7 --samples 501 --duration 10 --format csv
      rpr-cusps path innocenti --l1 27 --cusp B --speed 10 --acceleration 20 --jerk 200 --chord 0.01
      rpr-cusps path innocenti --l1 27 --l2 25.7 --l3 9.2 --from 2 --to 4
      rpr-cusps path innocenti --l1 27 --l2 25.7 --l3 9.2 --from 2 --to 4 --between 27:30
      rpr-cusps path innocenti --from l1=27,l2=20,l3=20,pose=1 --to l1=30,l2=21,l3=19,pose=1
      rpr-cusps path innocenti --l1 27 --l2 20 --l3 20 --from 1 --to alpha=-40,theta1=140,l1=27
      rpr-cusps path innocenti --l1 27 --l2 25.7 --l3 9.2 --from 1 --to 3 --clearance best
      rpr-cusps path innocenti --l1 27 --cusp B --l2-limits 8:20 --l3-limits :18
      rpr-cusps path innocenti --l1 27 --l2 20 --l3 20 --from 1 --to 2 --max-condition 12
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
    notes += _conditions(document)
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


def _conditions(document: Mapping[str, Any]) -> list[str]:
    """The condition numbers of a path, or of the best one that was found."""
    found = document.get("condition")
    if found is None:
        return []
    whose = "" if document["connected"] else " of the best path that was found"
    scale = f"length scale {found['length_scale']}, about the centroid of the platform's joints"
    return [f"Condition numbers{whose} are from {found['min']} to {found['max']} ({scale})."]


def _advice(document: Mapping[str, Any]) -> list[str]:
    """What is said of two poses without a path."""
    leg, span = document["fixed_leg"], document["connecting_range"]
    if document["obstacle"] == rpr_solver.Obstacle.OPPOSITE_SIGNS:
        return ["J has different signs at both poses, so every path between them meets a singularity."]
    if document["obstacle"] == rpr_solver.Obstacle.UNDECIDED:
        lines = [*_clear(document), *_conditions(document), *_resolution(document)]
        return ["No path was found, and none is excluded.", *lines]
    if document["obstacle"] == rpr_solver.Obstacle.TOO_NARROW:
        return ["Every path comes nearer to a singular pose than is asked for.", *_clear(document)]
    if document["obstacle"] == rpr_solver.Obstacle.ILL_CONDITIONED:
        return ["One of the poses has a greater condition number than is asked for.", *_conditions(document)]
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


DECIDED, UNDECIDED = 0, 1


def _modes(document: Mapping[str, Any]) -> Page:
    """Decide whether the assembly mode can change without a singularity: whether some joint vector of a
    slice, or of a range of the fixed leg, has two poses that a path within joint limits joins.

    If it can, the answer has such a path and its clearance from singular poses. If it cannot, this is proved
    for all joint vectors. With --clearance and --tolerance, only changes count that keep this far from
    singular poses, for all parts within the tolerance.

    Exit status: 0 possible or impossible, 1 undecided, 2 bad input.

    Options:
        l1: the length of the fixed leg in a slice
        range: or the lengths between which it may vary; 45: has no upper end
        limits: another leg
        clearance: how far a change must keep from singular poses, in degrees
        tolerance: how far all lengths may be off, or single ones, as d1=0.01,a3x=0.002 (the others are exact
            then); the answer is valid within this tolerance

    examples:
      rpr-cusps assembly-modes innocenti --l1 27
      rpr-cusps assembly-modes innocenti --l1 27 --clearance 0.5 --tolerance 0.05
      rpr-cusps assembly-modes innocenti --l1-range 0.05:0.1
      rpr-cusps assembly-modes robot.json --l1-range 20:30 --l2-limits 12:30 --l3-limits 12:30
      rpr-cusps assembly-modes robot.json --l1-range 45: --l2-limits :20
    """
    leg, asked = document["fixed_leg"], document["asked"]
    span = asked.get("range")
    where = f"L{leg} = {asked[f'l{leg}']}" if span is None else f"L{leg} {ends_in_words(span)}"
    limited = "" if asked["limits"] is None else ", within the joint limits"
    wide = f", {asked['clearance']} degrees off singular poses" if "clearance" in asked else ""
    within = f", with {tolerance_words(asked['tolerance'])}" if "tolerance" in asked else ""
    title = f"{where}{limited}: a change of assembly mode{wide}{within} is {document['change']}"
    sections = [Section(title, (), list(_notes_of_modes(document)))]
    if document["regions"] is not None:
        rows = [
            {**region["point"], "poses": str(region["poses"]), "joined": _groups(region["joined"])}
            for region in document["regions"]
        ]
        sections.append(Section("Regions, and which of their poses are joined", rows_of(rows)))
    return Page(about(document), sections, document["digits"])


def _notes_of_modes(document: Mapping[str, Any]) -> Iterator[str]:
    witness = document["witness"]
    if witness is not None:
        cusp = witness["path"]["cusp"]
        kind = "a path" if cusp is None else f"a loop round cusp {letter(cusp)}"
        yield f"Proved by {kind} from pose {witness['from']} to pose {witness['to']} of {all_legs(witness)}."
        kept = short(witness["path"]["clearance"]["proved"])
        yield f"It keeps at least {kept} degrees off all singular poses."
        if "tolerance" in document["asked"]:
            own = document["asked"].get("clearance")
            off = "" if own is None else f", at least {own} degrees off its singular poses"
            yield f"Every geometry within the tolerance can change its mode along it{off}."
    elif document["change"] == "impossible":
        proof = document["certificate"]
        how = _THEOREMS.get(proof["method"]) or f"{proof['pairs']} pairs of boxes"
        what = "region" if proof["method"] == "regions" else "aspect"
        of_all = ", for every geometry within the tolerance" if "tolerance" in document["asked"] else ""
        yield f"Proved by {how}: every {what} maps one to one{of_all}."
    else:
        yield f"Neither a path nor a proof was found: {document['reason']}."


_THEOREMS = {
    "similar": "the theorem for similar triangles (docs/mathematics.md, Theorem 41)",
    "shared-joints": "the lemma on shared joints (docs/mathematics.md, Shared joints)",
}


def _groups(joined: list[list[int]] | None) -> str:
    if joined is None:
        return "not decided"
    return ", ".join("-".join(map(str, group)) for group in joined) or "none"


def _connections(document: Mapping[str, Any]) -> Page:
    """Find which poses of a joint vector, or of two, are joined by paths without a singularity: all pairs at
    once, each with the proved reason if there is no path.

    Options:
        fixed_leg: the fixed leg (default: 1)
        to: a second joint vector, whose poses are included: l1=30,l2=21,l3=19
        between: joint vectors
        limits: a leg, along the whole paths
        parts: also count the parts of the allowed region (all poses in the slice or range that are not
            singular and keep the limits), with the poses in each
        clearance: how far the paths must keep from singular poses, in degrees
        tolerance: how far all lengths may be off, or single ones, as d1=0.01,a3x=0.002 (the others are exact
            then), for which the paths must exist

    examples:
      rpr-cusps pose-connections innocenti --l1 27 --l2 25.7 --l3 9.2
      rpr-cusps pose-connections innocenti --l1 27 --l2 25.7 --l3 9.2 --clearance 5
      rpr-cusps pose-connections innocenti --l1 27 --l2 25.7 --l3 9.2 --between 27:30
      rpr-cusps pose-connections innocenti --l1 27 --l2 20 --l3 20 --l2-limits :22 --parts
      rpr-cusps pose-connections innocenti --l1 27 --l2 20 --l3 20 --to l1=30,l2=21,l3=19
      rpr-cusps pose-connections innocenti --l1 27 --l2 20 --l3 20 --l2-limits 5:21 --format svg > matrix.svg
    """
    poses = document["poses"]
    of_two = LEGS[0] not in document
    vectors = dict.fromkeys(all_legs(part) for part in (poses if of_two else [document]))
    title = f"{' and '.join(vectors)}: {counted(len(poses), 'pose')}"
    columns = (
        [*(LEGS if of_two else ()), "pose", *(name for name in poses[0] if name.endswith("_deg"))]
        if poses
        else []
    )
    rows = [
        {"": str(place), **{name: str(pose[name]) for name in columns}, "sign of J": SIGNS[pose["sign"]]}
        for place, pose in enumerate(poses, 1)
    ]
    joined = [
        {"": str(place), **{str(k): word for k, word in enumerate(row, 1)}}
        for place, row in enumerate(document["matrix"], 1)
    ]
    sections = [
        Section(title, rows_of(rows)),
        Section("Which are joined", rows_of(joined), list(_notes_of_connections(document))),
        *_allowed(document),
    ]
    return Page(about(document), sections, document["digits"])


def _allowed(document: Mapping[str, Any]) -> Iterator[Section]:
    """The parts of the allowed region."""
    if (region := document.get("allowed")) is None:
        return
    rows = [
        {
            "": str(number),
            "sign of J": SIGNS[part["sign"]],
            "poses": ", ".join(map(str, part["poses"])) or "none of these",
            "with": "" if part["pose"] is None else nearby(part["pose"]),
            "is one": "yes" if part["is_one"] else f"undecided near {nearby(part['near'])}",
        }
        for number, part in enumerate(region["parts"], 1)
    ]
    count = (
        "a number of parts that stays undecided" if region["count"] is None else f"{region['count']} parts"
    )
    yield Section(f"The allowed region: {count}", rows_of(rows))


def _notes_of_connections(document: Mapping[str, Any]) -> Iterator[str]:
    groups = ", ".join("-".join(map(str, group)) for group in document["groups"])
    yield f"Joined with each other: {groups or 'none'}."
    if size := document["resolution"]:
        length = "" if size["length"] is None else f" × {size['length']}"
        yield f"Poses were examined in boxes of {size['angle_deg']}° × {size['angle_deg']}°{length}."
    for pair in document.get("undecided", ()):
        yield f"{'-'.join(map(str, pair['poses']))} stays undecided near {nearby(pair['near'])}."


COMMANDS = {
    "path": partial(command, page=_paths, names={"sampling.number": ""}),  # which is --samples
    "assembly-modes": partial(
        command,
        page=_modes,
        status=lambda document: UNDECIDED if document["change"] == "undecided" else DECIDED,
    ),
    "pose-connections": partial(command, page=_connections),
}
