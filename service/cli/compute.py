"""The group Compute: cusps, their transitions and curves, poses, singular curves and aspects."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing
from decimal import Decimal
from functools import partial
from itertools import combinations
from typing import TYPE_CHECKING, Any

from rpr_solver import Progress
from rpr_solver.contract import LEGS, document_head
from rpr_solver.errors import InputError
from rpr_solver.notebook import counted, near_words
from service.cli import arguments, asking, output, parsers
from service.cli.asking import command
from service.cli.output import progress_bar
from service.cli.pages import (
    SIGNS,
    Page,
    Section,
    about,
    all_legs,
    counted_range,
    degenerate_notes,
    ends_in_words,
    failures,
    rows_of,
    say_near,
    tolerance_words,
    write_table,
)
from service.cli.parsers import Command
from service.schemas.answers import csv_header, csv_lines, ndjson_line
from service.schemas.document import named, unnamed
from service.schemas.lengths import split_ends, split_range
from worker.answers import Store, tables

if TYPE_CHECKING:  # a command loads the question that it asks, and no other
    from service.schemas.curves import CuspCurvesRequest
    from service.schemas.tables import CuspTableRequest

_LATEX = "latex"
_STREAMED = ("csv", "ndjson")
"""Formats that are printed slice by slice."""


def _solve(question: type[CuspTableRequest]) -> Command:
    """Compute cusp tables and print them.

    Options:
        method: article: the article's own algorithm with an audit; slower, leg 1 only

    examples:
      rpr-cusps solve innocenti --l1 14.98
      rpr-cusps solve innocenti --l1 14.98 --method article
      rpr-cusps solve zein-flat --l1 2 --l1 5/2 --digits 200 --format json
      rpr-cusps solve robot.json --l1-range 0.1:50.1:0.1 --format csv > cusps.csv
      rpr-cusps solve innocenti --l1 14.98 --format latex --digits 8 > table.tex
      rpr-cusps solve - --l2 17 < robot.json                      leg 2 fixed

    JSON, CSV and NDJSON have all computed digits. CSV and NDJSON are printed slice by slice, so Ctrl-C loses
    nothing that is done.
    """
    options = asking.Options(question, parsers.said_of(_solve), dict.fromkeys((*LEGS, "fixed_leg"), ""))

    def configure(parser: argparse.ArgumentParser) -> None:
        text = "the fixed length of a slice; repeatable (--l2: leg 2 is fixed, …)"
        parsers.add_options(parser, "--l{}", "slices", "X", text)
        text = "slices from FROM to TO in steps of STEP; TO is included if a step reaches it"
        parsers.add_options(parser, "--l{}-range", "slices", "FROM:TO:STEP", text)
        parsers.add_fixed_leg(parser, "slices")
        options.configure(parser, _LATEX)

    def run(args: argparse.Namespace) -> int:
        return _solved(args, options.asked(args, **_slices_of(args)))

    return Command(parsers.text_of(_solve), configure, run)


def _slices_of(args: argparse.Namespace) -> dict[str, object]:
    """Returns the fixed leg and its lengths, as members of the question."""
    leg = arguments.leg_of(args.slices, args.fixed_leg, "slices")
    origin, lengths = arguments.source(), list[object]()
    for option, text in args.slices:
        lengths += arguments.range_values(text, option, origin) if option.endswith("-range") else [text]
    if not lengths:
        raise InputError.of(f"--l{leg}", f"is missing; give a slice, for example --l{leg} 14.98")
    return {"fixed_leg": leg, f"l{leg}": lengths}


def _solved(args: argparse.Namespace, question: CuspTableRequest) -> int:
    request = question.job_request()
    count = len(request.content["l1"])
    head: Mapping[str, Any]
    slices: Iterable[Mapping[str, Any]]
    with ExitStack() as stack:
        progress = stack.enter_context(progress_bar(count, is_streamed=args.format in _STREAMED))
        if args.url is None:
            head, slices = tables.head(request), _counted(tables.solved(request, Store()), count, progress)
        else:
            head, slices = _of_service(args, question, count, progress, stack)
        table = {**head, "slices": _printed(head, slices, args.format)}
    if args.format == _LATEX:
        from rpr_solver.exports import latex_table  # as for a terminal, few need it

        with named("--digits"), unnamed("digits"):
            output.write(latex_table(table, min(arguments.printed_digits(args), table["digits"])))
    elif args.format not in _STREAMED:
        write_table(table, args.format, arguments.printed_digits(args))
    return report(table)


def _of_service(
    args: argparse.Namespace, question: CuspTableRequest, count: int, progress: Progress, stack: ExitStack
) -> tuple[Mapping[str, Any], Iterable[Mapping[str, Any]]]:
    """Returns the head of a table and its slices, as the service at `--url` computes them."""
    from service.client import Asked

    if args.format not in _STREAMED:
        table = asking.document_of(args.url, question, progress)
        return table, table["slices"]
    client = stack.enter_context(asking.client_of(args.url))
    head = document_head(question.geometry, question.digits, question.fixed_leg)
    head["solver_version"] = client.version()["solver_version"]
    slices = stack.enter_context(closing(client.slices(Asked.of(question))))  # which withdraws the question
    return head, _counted(slices, count, progress)


def _counted(
    slices: Iterable[Mapping[str, Any]], count: int, progress: Progress
) -> Iterator[Mapping[str, Any]]:
    """Yields slices as they are solved."""
    progress(0, count)
    for done, part in enumerate(slices, 1):
        yield part
        progress(done, count)


def _printed(
    head: Mapping[str, Any], slices: Iterable[Mapping[str, Any]], form: str
) -> list[Mapping[str, Any]]:
    """Returns the slices; as CSV or NDJSON each is printed at once, and only those without an answer are
    kept."""
    if form not in _STREAMED:
        return list(slices)
    failed = []
    if form == "csv":
        output.write(csv_header(head))
    for part in slices:
        with output.unbroken():
            output.write(csv_lines(head, part) if form == "csv" else ndjson_line(head, part))
            output.flush()
        if "error" in part:
            failed.append(part)
    output.flush()
    say_near(near_words(head))
    return failed


def report(table: dict[str, Any]) -> int:
    """Report the slices without an answer on stderr; returns the exit status."""
    failed = failures(table)
    for where, error in failed:
        output.say(f"rpr-cusps solve: {where}: no answer ({error['type']}): {error['detail']}")
    if not failed:
        return 0
    return 2 if any(error["type"] == "input-error" for _, error in failed) else 1


def _census(document: Mapping[str, Any]) -> Page:
    """Find every length at which the number of cusps changes, with its kind and poses, and the number of
    cusps in between. The list is proved complete. With --tolerance the census is valid for every manipulator
    whose lengths differ from the given ones by at most the tolerance, and each transition has bounds for its
    length.

    Options:
        range: the range of lengths; either end may be omitted (default: all)
        tolerance: how far all lengths may be off, or single ones, as d1=0.01,a3x=0.002; the others are exact
            then. The census is then valid for every manipulator within the tolerance
        ignore_windows: mark windows narrower than this width, and do not count them in the first line
        sensitivities: give the derivatives of each transition by the lengths of the geometry

    examples:
      rpr-cusps census innocenti --digits 20
      rpr-cusps census innocenti --l1-range 28:31 --format json
      rpr-cusps census robot.json --l2-range :40 --format csv     leg 2 fixed
      rpr-cusps census robot.json --l1-range 20:30 --digits 15 --sensitivities
      rpr-cusps census robot.json --l1-range 20:30 --tolerance 0.001
      rpr-cusps census robot.json --l1-range 20:30 --tolerance d1=0.005,a3x=0.001
    """
    leg = f"l{document['fixed_leg']}"
    transitions = document["transitions"]
    title, rows = _intervals(document)
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


def _intervals(document: Mapping[str, Any]) -> tuple[str, list[list[str]]]:
    """The numbers of cusps of a census in one line, without ignored windows, and its intervals as a table."""
    ends, found = document["range"], document["intervals"]
    narrow = {(x["from"], x["to"]): x["width"] for x in document.get("ignored_windows", ())}
    rows = [["from", "to", "cusps", "aspects", *(["ignored, of width"] if narrow else [])]]
    for x in found:
        width = [narrow.get((x["from"], x["to"]), "")] if narrow else []
        rows.append([x["from"], x["to"] or "∞", str(x["count"]), str(x.get("aspects") or ""), *width])
    counts = [x["count"] for x in found if (x["from"], x["to"]) not in narrow] or [x["count"] for x in found]
    below = "" if ends["to"] is None else f" up to {ends['to']}"
    parts = [counted_range(min(counts), max(counts), "cusp")]
    parts += [counted(len(document["transitions"]), "transition")]
    parts += [f"{counted(len(narrow), 'window')} ignored"] if narrow else []
    return f"L{document['fixed_leg']} from {ends['from']}{below}: {', '.join(parts)}", rows


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


def _curves(question: type[CuspCurvesRequest]) -> Command:
    """Follow each cusp, by proof, as the length of one leg varies, from the transition at which it is born to
    the one at which it vanishes. The names of the curves depend only on the manipulator and the leg, not on
    the requested range or points.

    Options:
        range: the range of lengths (default: all); with STEP, also the lengths of points
        l1: a length at which to compute points; repeatable
        samples: number of points of each curve in every window between transitions

    examples:
      rpr-cusps cusp-curves innocenti --digits 15
      rpr-cusps cusp-curves innocenti --l1-range 27:29:0.1 --format csv
      rpr-cusps cusp-curves robot.json --l2-range 10:40 --samples 20 --format json
    """
    options = asking.Options(question, parsers.said_of(_curves))

    def run(args: argparse.Namespace) -> int:
        asked = options.asked(args)
        document = asking.answer_of(args.url, asked, "steps")
        has_points = bool(asked.slices or asked.samples)
        shown = asking.shown(args, asked, document, "steps")
        asking.write(question, document, _curves_page(shown, has_points), args.format)
        return 0

    return Command(parsers.text_of(_curves), options.configure, run)


def _curves_page(document: Mapping[str, Any], has_points: bool) -> Page:
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


_KEYS = ("alpha_deg", "theta1_deg", "theta2_deg", "theta3_deg", "b1_x", "b1_y", "multiplicity")
_IN_GIVEN_FRAME = ("x", "y", "phi_deg")
"""What poses have beside these if base or platform were given by points."""


def _poses(table: Mapping[str, Any]) -> Page:
    """Compute all poses of the platform for given leg lengths (direct kinematics), with multiplicities. The
    list is proved complete. With a range for one leg: the lengths at which poses merge, and the number of
    poses in between. With angles of legs, instead of lengths or as well: the poses that agree with all of
    them.

    Options:
        l1: the length of leg 1 or, if this leg moves, its range, such as 0:12
        l2: the same for leg 2
        l3: the same for leg 3
        angle1: the angle of leg 1 from A1 to B1, in degrees, in the frame of the base's points, or else of
            the article
        angle2: the same for leg 2
        angle3: the same for leg 3
        angle_tolerance_deg: by how many degrees angles may be off that are given in addition to three lengths
            or angles
        condition: give the condition number of each pose, and its distance from singular poses
        length_scale: the length that converts rotations to lengths for condition numbers (default: the root
            of the mean squared distance of the platform's joints from their centroid)

    examples:
      rpr-cusps poses innocenti --l1 14.98 --l2 15 --l3 30
      rpr-cusps poses innocenti --l1 14.98 --l2 15 --l3 30 --condition --digits 6
      rpr-cusps poses robot.json --l1 14.98 --l2 15 --l3 61/2 --digits 200 --format json
      rpr-cusps poses innocenti --l1 17 --l3 15 --l2-range 0:40
      rpr-cusps poses innocenti --l1 15 --angle2 150 --angle3 45
      rpr-cusps poses innocenti --l1 14.98 --l2 15 --l3 30 --angle1 23.6 --angle-tolerance 0.1
    """
    if "intervals" in table:
        return _along_leg(table)
    if "sensed" in table:
        return _sensed(table)
    title = f"{all_legs(table)}: {counted(table['count'], 'pose')}"
    if table["count"] != table["count_with_multiplicity"]:
        title += f", {table['count_with_multiplicity']} with multiplicity"
    keys = (*_KEYS, *_IN_GIVEN_FRAME) if any("x" in pose for pose in table["poses"]) else _KEYS
    rows = table["poses"]
    if (asked := table.get("condition")) is not None:
        keys = (*keys, "condition", "clearance_deg")
        rows = [{**pose, "condition": pose["condition"] or "infinite"} for pose in rows]
    notes = [f"α = {curve['alpha_deg']}: {curve['description']}" for curve in table["curves"]]
    if asked is not None:
        scale = f"length scale {asked['length_scale']}, about the centroid of the platform's joints"
        notes.append(f"Condition numbers: {scale}. The clearance is that with L1 held.")
    return Page(about(table), [Section(title, rows_of(rows, keys), notes)], table["digits"])


def _sensed(document: Mapping[str, Any]) -> Page:
    sensed = document["sensed"]
    words = [
        f"{name.upper()} = {x}" if name in LEGS else f"angle {name[-1]} = {x}°" for name, x in sensed.items()
    ]
    count = "a whole curve of poses" if document["is_curve"] else counted(document["count"], "pose")
    notes = ["No pose is missed: proved."] if not document["is_curve"] else []
    notes += [f"No pose agrees with angle {name[-1]}." for name in document["disagree"]]
    sections = [Section(f"{', '.join(words)}: {count}", _sensed_rows(document["poses"]), notes)]
    if document["others"]:
        sections.append(Section("Poses that disagree with an angle", _sensed_rows(document["others"])))
    return Page(about(document), sections, document["digits"])


def _sensed_rows(poses: Sequence[Mapping[str, Any]]) -> list[list[str]]:
    keys = [key for key in (*_KEYS[:6], *LEGS, *_IN_GIVEN_FRAME) if any(key in pose for pose in poses)]
    rows = [
        {
            **{key: pose.get(key, "") for key in keys},
            **{f"angle {name[-1]} off by [deg]": text for name, text in pose["off_deg"].items()},
        }
        for pose in poses
    ]
    return rows_of(rows)


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
                "sign of J": SIGNS[pose["sign"]],
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
            Section(f"{held}, {moving.upper()} {ends_in_words(document[moving])}", rows_of(rows), notes),
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
      rpr-cusps singular-curves innocenti --l1 14.98
      rpr-cusps singular-curves innocenti --l1 27 --tolerance 0.0001 --format csv
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


def _workspace(document: Mapping[str, Any]) -> Page:
    """Find the positions that the limits of the legs allow at one orientation: the regions
    where J is positive or negative, and the singular conic between them. With a range of orientations: areas
    and numbers of regions at each. Vertices, regions and areas are exact.

    Options:
        phi: the orientation in degrees, or FROM:TO:STEP: the angle of the platform's frame in that of the
            base; without points it is α
        limits: a leg

    examples:
      rpr-cusps workspace innocenti --phi 30 --l1-limits 5:30 --l2-limits 5:25 --l3-limits 5:25
      rpr-cusps workspace robot.json --phi -90:90:5 --l1-limits 5:30 --l2-limits 5:25 --format csv
    """
    if "orientations" in document:
        return _sweep(document)
    limits = ", ".join(f"{leg.upper()} {_within(ends)}" for leg, ends in document["limits"].items())
    rows = [
        {
            "sign of J": SIGNS[region["sign"]],
            "area": region["area"],
            "bounded by": ", ".join(
                dict.fromkeys(_bound(arc) for loop in region["boundary"] for arc in loop)
            ),
            "holes": str(len(region["boundary"]) - 1),
        }
        for region in document["regions"]
    ]
    conic, kind = document["conic"], document["conic"]["kind"]
    powers = dict(zip(("xx", "xy", "yy", "x", "y", "1"), ("x²", "xy", "y²", "x", "y", "1"), strict=True))
    terms = [{"term of J": powers[name], "coefficient": text} for name, text in conic["coefficients"].items()]
    notes = ["All regions, their signs and areas: proved."]
    notes += [f"A single place: vertex {number}." for number in document["isolated"]]
    notes += [f"A curve without places beside it: {_bound(arc)}." for arc in document["thin"]]
    vertices = [
        {
            **{name: x for name, x in vertex.items() if name != "on"},
            "on": ", ".join(map(_curve, vertex["on"])),
        }
        for vertex in document["vertices"]
    ]
    title = f"φ = {document['phi_deg']}°, {limits}: {counted(len(rows), 'region')}"
    singular = "every place" if kind == "plane" else kind
    return Page(
        about(document),
        [
            Section(title, rows_of(rows), notes),
            Section(f"J = 0: {singular}", rows_of(terms)),
            Section("Vertices", rows_of(vertices)),
        ],
        document["digits"],
    )


def _sweep(document: Mapping[str, Any]) -> Page:
    ends = document["phi_deg"]
    columns = {
        "phi_deg": "φ [deg]", "conic": "J = 0", "positive": "area J > 0", "positive_regions": "regions",
        "negative": "area J < 0", "negative_regions": "regions ", "singular": "area J = 0",
    }  # fmt: skip
    used = [name for name in columns if any(name in row for row in document["orientations"])]
    rows = [{columns[name]: str(row.get(name, "")) for name in used} for row in document["orientations"]]
    title = f"φ from {ends['from']}° to {ends['to']}° in steps of {ends['step']}°"
    notes = ["The areas and numbers of regions at each of these orientations: proved."]
    return Page(about(document), [Section(title, rows_of(rows), notes)], document["digits"])


def _within(ends: Mapping[str, str | None]) -> str:
    return ends_in_words({"from": ends["min"] or "0", "to": ends["max"]})


def _bound(arc: Mapping[str, Any]) -> str:
    return " = ".join(map(_curve, arc["on"].split()))


def _curve(name: str) -> str:
    leg, _, end = name.partition("_")
    return f"{end}. {leg.upper()}" if end else "J = 0"


def _turns(text: str) -> object:
    return split_range(text) if ":" in text else text


COMMANDS = {
    "solve": _solve,
    "census": partial(command, page=_census, steps="steps"),
    "cusp-curves": _curves,
    "poses": partial(
        command,
        page=_poses,
        readers=dict.fromkeys(LEGS, _length),
        others={leg: f"--{leg}-range" for leg in LEGS},
        names={"angle_tolerance_deg": "--angle-tolerance"},
    ),
    "singular-curves": partial(command, page=_singular),
    "aspects": partial(command, page=_aspects),
    "workspace": partial(command, page=_workspace, readers={"phi": _turns}, steps="orientations"),
}
