"""Poses of leg lengths, singular curves and aspects, and which poses paths join, on the command line."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rpr_solver.contract import LEGS, letter
from rpr_solver.notebook import counted
from service.cli.asking import command
from service.cli.pages import Page, Section, about, all_legs, nearby, rows_of
from service.schemas.lengths import split_ends
from service.schemas.modes import AssemblyModesRequest, PoseConnectionsRequest
from service.schemas.poses import PosesRequest, RangeAspectsRequest, SingularCurvesRequest

_KEYS = ("alpha_deg", "theta1_deg", "theta2_deg", "theta3_deg", "b1_x", "b1_y", "multiplicity")
_IN_GIVEN_FRAME = ("x", "y", "phi_deg")
"""What poses have beside these if base or platform were given by points."""


def _poses(table: Mapping[str, Any]) -> Page:
    """Compute all poses of the platform for given leg lengths (direct kinematics), with multiplicities. The
    list is proved complete. With a range for one leg: at which of its lengths poses merge, and how many poses
    there are between.

    Options:
        l1: the length of leg 1, or its range, such as 0:12, if it is the one that moves
        l2: that of leg 2
        l3: that of leg 3

    examples:
      rpr-cusps poses innocenti --l1 14.98 --l2 15 --l3 30
      rpr-cusps poses robot.json --l1 14.98 --l2 15 --l3 61/2 --digits 200 --format json
      rpr-cusps poses innocenti --l1 17 --l3 15 --l2-range 0:40
    """
    if "intervals" in table:
        return _along_leg(table)
    title = f"{all_legs(table)}: {counted(table['count'], 'pose')}"
    if table["count"] != table["count_with_multiplicity"]:
        title += f", {table['count_with_multiplicity']} with multiplicity"
    keys = (*_KEYS, *_IN_GIVEN_FRAME) if any("x" in pose for pose in table["poses"]) else _KEYS
    notes = [f"α = {curve['alpha_deg']}: {curve['description']}" for curve in table["curves"]]
    return Page(about(table), [Section(title, rows_of(table["poses"], keys), notes)], table["digits"])


def _along_leg(document: Mapping[str, Any]) -> Page:
    moving = f"l{document['moving_leg']}"
    held = ", ".join(f"{leg.upper()} = {document[leg]}" for leg in LEGS if leg != moving)
    rows, of_poses = [], []
    for interval in document["intervals"]:
        rows.append({"from": interval["from"], "to": interval["to"] or "∞", "poses": str(interval["count"])})
        of_poses += [
            {
                moving: interval["at"],
                **{name: pose[name] for name in _KEYS[:4]},
                "sign of J": _SIGNS[pose["sign"]],
                "aspect": "?" if pose["aspect"] is None else str(pose["aspect"]),
            }
            for pose in interval["poses"]
        ]
    ends = [
        {moving: end[moving], "kind": end["kind"], **{name: pose.get(name, "") for name in _KEYS[:4]}}
        for end in document["ends"]
        for pose in end["poses"] or [{}]
    ]
    notes = ["All lengths at which poses merge, and all poses, none missed: proved."]
    return Page(
        about(document),
        [
            Section(f"{held}, {moving.upper()} {_range(document[moving])}", rows_of(rows), notes),
            Section("Where poses are singular", rows_of(ends)),
            Section("Poses inside the intervals", rows_of(of_poses)),
        ],
        document["digits"],
    )


def _length(text: str) -> object:
    return split_ends(text) if ":" in text else text


def _singular(document: Mapping[str, Any]) -> Page:
    """List the singular curves of a slice, the number of poses in each region of the free legs' lengths, and
    the aspects; plot draws them. The topology of the curves is proved; samples keep the tolerance.

    Options:
        l1: the length of the fixed leg
        tolerance: largest deviation of the drawn curves, relative to the size of the picture (default: 0.001)

    examples:
      rpr-cusps singular innocenti --l1 14.98
      rpr-cusps singular innocenti --l1 27 --tolerance 0.0001 --format csv
    """
    leg = f"l{document['fixed_leg']}"
    components = document["components"]
    vertices = [
        {
            "component": number,
            "kind": vertex["kind"] + (f" {vertex['cusp']}" if "cusp" in vertex else ""),
            **{key: value for key, value in vertex.items() if key not in ("index", "kind", "cusp")},
        }
        for number, component in enumerate(components, 1)
        for strand in component["strands"]
        for vertex in strand["vertices"]
    ]
    title = f"{leg.upper()} = {document[leg]}: {counted(len(components), 'component')}"
    regions = [{"poses": r["poses"], **r["point"]} for r in document["regions"]]
    notes = ["The number of poses is proved at the point beside it, and the same in the whole region."]
    if thin := document["thin_regions"]:
        notes.append(f"{counted(thin, 'more region')} narrower than the tolerance.")
    aspects = [
        {"sign of J": "+" if aspect["sign"] > 0 else "−", "share": f"{100 * aspect['share']:.1f} %"}
        for aspect in document["aspects"]
    ]
    return Page(
        about(document),
        [
            Section(title, rows_of(vertices)),
            Section(f"Joint space: {counted(len(regions), 'region')}", rows_of(regions), notes),
            Section(f"Poses: {counted(len(aspects), 'aspect')}", rows_of(aspects)),
        ],
        document["digits"],
    )


def _aspects(document: Mapping[str, Any]) -> Page:
    """Find the aspects of a manipulator while the length of one leg varies within a range: the connected sets
    of poses without a singularity. Their number is exact.

    Options:
        range: the range of lengths; either end may be omitted (default: all)

    examples:
      rpr-cusps aspects innocenti --l1-range 27:30
      rpr-cusps aspects robot.json --l2-range 10: --format json     leg 2 varies, without an upper end
    """
    leg, ends, found = document["fixed_leg"], document["range"], document["aspects"]
    below = "" if ends["to"] is None else f" up to {ends['to']}"
    rows = [
        {
            "sign of J": "+" if aspect["sign"] > 0 else "−",
            f"aspects at {ends['from']}": str(aspect["at_start"]),
            f"aspects at {ends['to'] or '∞'}": str(aspect["at_stop"]),
        }
        for aspect in found
    ]
    title = f"L{leg} from {ends['from']}{below}: {counted(len(found), 'aspect')}"
    return Page(about(document), [Section(title, rows_of(rows))], document["digits"])


DECIDED, UNDECIDED = 0, 1


def _modes_page(document: Mapping[str, Any]) -> Page:
    """Decide whether the assembly mode can change without a singularity: whether some joint vector of a
    slice, or of a range of the fixed leg, has two poses that a path joins, within joint limits.

    That it can is shown by such a path. That it cannot is proved for all joint vectors.

    Exit status: 0 possible or impossible, 1 undecided, 2 bad input.

    Options:
        l1: the length of the fixed leg in a slice
        range: or the lengths between which it may vary; 45: has no upper end
        limits: another leg

    examples:
      rpr-cusps modes innocenti --l1 27
      rpr-cusps modes innocenti --l1-range 0.05:0.1
      rpr-cusps modes robot.json --l1-range 20:30 --l2-limits 12:30 --l3-limits 12:30
      rpr-cusps modes robot.json --l1-range 45: --l2-limits :20
    """
    leg, asked = document["fixed_leg"], document["asked"]
    span = asked.get("range")
    where = f"L{leg} = {asked[f'l{leg}']}" if span is None else f"L{leg} {_range(span)}"
    limited = "" if asked["limits"] is None else ", within the joint limits"
    title = f"{where}{limited}: a change of assembly mode is {document['change']}"
    sections = [Section(title, (), list(_modes_notes(document)))]
    if document["regions"] is not None:
        rows = [
            {**region["point"], "poses": str(region["poses"]), "joined": _groups(region["joined"])}
            for region in document["regions"]
        ]
        sections.append(Section("Regions, and which of their poses are joined", rows_of(rows)))
    return Page(about(document), sections, document["digits"])


def _range(span: Mapping[str, str | None]) -> str:
    return f"from {span['from']}" + ("" if span["to"] is None else f" to {span['to']}")


def _modes_notes(document: Mapping[str, Any]) -> Iterator[str]:
    witness = document["witness"]
    if witness is not None:
        cusp = witness["path"]["cusp"]
        kind = "a path" if cusp is None else f"a loop round cusp {letter(cusp)}"
        yield f"Proved by {kind} from pose {witness['from']} to pose {witness['to']} of {all_legs(witness)}."
    elif document["change"] == "impossible":
        proof = document["certificate"]
        how = _THEOREMS.get(proof["method"]) or f"{proof['pairs']} pairs of boxes"
        yield f"Proved by {how}: every aspect maps one to one."
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


def _connections_page(document: Mapping[str, Any]) -> Page:
    """Find which poses of a joint vector, or of two, are joined by paths without a singularity: all pairs at
    once, each with the proved reason if there is no path.

    Options:
        fixed_leg: the fixed leg (default: 1)
        to: a second joint vector, whose poses are included: l1=30,l2=21,l3=19
        between: joint vectors
        limits: a leg, along the whole paths
        parts: count the parts of the allowed region, too, with the poses in each: of all poses that are not
            singular, in the slice or in the range, and keep the limits

    examples:
      rpr-cusps connections innocenti --l1 27 --l2 25.7 --l3 9.2
      rpr-cusps connections innocenti --l1 27 --l2 25.7 --l3 9.2 --between 27:30
      rpr-cusps connections innocenti --l1 27 --l2 20 --l3 20 --l2-limits :22 --parts
      rpr-cusps connections innocenti --l1 27 --l2 20 --l3 20 --to l1=30,l2=21,l3=19
      rpr-cusps connections innocenti --l1 27 --l2 20 --l3 20 --l2-limits 5:21 --format svg > matrix.svg
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
        {"": str(place), **{name: str(pose[name]) for name in columns}, "sign of J": _SIGNS[pose["sign"]]}
        for place, pose in enumerate(poses, 1)
    ]
    joined = [
        {"": str(place), **{str(k): word for k, word in enumerate(row, 1)}}
        for place, row in enumerate(document["matrix"], 1)
    ]
    sections = [
        Section(title, rows_of(rows)),
        Section("Which are joined", rows_of(joined), list(_connections_notes(document))),
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
            "sign of J": _SIGNS[part["sign"]],
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


_SIGNS = {1: "+", -1: "−", 0: "0", None: "?"}


def _connections_notes(document: Mapping[str, Any]) -> Iterator[str]:
    groups = ", ".join("-".join(map(str, group)) for group in document["groups"])
    yield f"Joined with each other: {groups or 'none'}."
    if size := document["resolution"]:
        length = "" if size["length"] is None else f" × {size['length']}"
        yield f"Poses were examined in boxes of {size['angle_deg']}° × {size['angle_deg']}°{length}."
    for pair in document.get("undecided", ()):
        yield f"{'-'.join(map(str, pair['poses']))} stays undecided near {nearby(pair['near'])}."


COMMANDS = {
    "poses": command(
        PosesRequest,
        page=_poses,
        readers=dict.fromkeys(LEGS, _length),
        others={leg: f"--{leg}-range" for leg in LEGS},
    ),
    "singular": command(SingularCurvesRequest, page=_singular),
    "aspects": command(RangeAspectsRequest, page=_aspects),
    "modes": command(
        AssemblyModesRequest,
        page=_modes_page,
        status=lambda document: UNDECIDED if document["change"] == "undecided" else DECIDED,
    ),
    "connections": command(PoseConnectionsRequest, page=_connections_page),
}
