"""Poses of three leg lengths, singular curves of a slice, and aspects of a range, on the command line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from service.cli.pages import Page, Section, about, all_legs, counted, rows_of
from service.cli.questions import command
from service.schemas.numbers import FIXED_LEGS
from service.schemas.poses import PosesRequest, RangeAspectsRequest, SingularCurvesRequest

_POSES = """\
Compute all poses of the platform for given leg lengths (direct kinematics), with multiplicities. The list
is proved complete."""
_POSES_EXAMPLES = """\
examples:
  rpr-cusps poses innocenti --l1 14.98 --l2 15 --l3 30
  rpr-cusps poses robot.json --l1 14.98 --l2 15 --l3 61/2 --digits 200 --format json
"""

_KEYS = ("alpha_deg", "theta1_deg", "theta2_deg", "theta3_deg", "b1_x", "b1_y", "multiplicity")


def _poses(table: Mapping[str, Any]) -> Page:
    title = f"{all_legs(table)}: {counted(table['count'], 'pose')}"
    if table["count"] != table["count_with_multiplicity"]:
        title += f", {table['count_with_multiplicity']} with multiplicity"
    notes = [f"α = {curve['alpha_deg']}: {curve['description']}" for curve in table["curves"]]
    return Page(about(table), [Section(title, rows_of(table["poses"], _KEYS), notes)], table["digits"])


_SINGULAR = """\
Draw the singular curves of a slice, with the number of poses in each region of the free legs' lengths, and
the aspects. The topology of the curves is proved; samples keep the tolerance."""
_SINGULAR_EXAMPLES = """\
examples:
  rpr-cusps singular innocenti --l1 14.98
  rpr-cusps singular innocenti --l1 27 --tolerance 0.0001 --format csv
"""


def _singular(document: Mapping[str, Any]) -> Page:
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
        notes.append(f"{counted(thin, 'face')} of the drawing too thin for its tolerance.")
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


_ASPECTS = """\
Find the aspects of a manipulator while the length of one leg varies within a range: the connected sets of
poses without a singularity. Their number is exact."""
_ASPECTS_EXAMPLES = """\
examples:
  rpr-cusps aspects innocenti --l1-range 27:30
  rpr-cusps aspects robot.json --l2-range 10: --format json     leg 2 varies, without an upper end
"""


def _aspects(document: Mapping[str, Any]) -> Page:
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


COMMANDS = {
    "poses": command(
        PosesRequest,
        _POSES,
        _POSES_EXAMPLES,
        page=_poses,
        words={f"l{leg}": f"length of leg {leg}" for leg in FIXED_LEGS},
    ),
    "singular": command(
        SingularCurvesRequest,
        _SINGULAR,
        _SINGULAR_EXAMPLES,
        page=_singular,
        words={
            "l1": "the length of the fixed leg",
            "tolerance": "largest deviation of the drawn curves, relative to the size of the picture "
            "(default: 0.001)",
        },
    ),
    "aspects": command(
        RangeAspectsRequest,
        _ASPECTS,
        _ASPECTS_EXAMPLES,
        page=_aspects,
        words={"range": "the range of lengths; either end may be omitted (default: all)"},
    ),
}
