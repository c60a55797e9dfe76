"""Censuses on the command line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from service.cli.pages import Page, Section, about, counted, counted_range, degenerate_notes, rows_of
from service.cli.questions import command
from service.schemas.censuses import CensusRequest

_CENSUS = """\
Find every length at which the number of cusps changes, with its kind and poses, and the number of cusps in
between. The list is proved complete."""
_CENSUS_EXAMPLES = """\
examples:
  rpr-cusps census innocenti --digits 20
  rpr-cusps census innocenti --l1-range 28:31 --format json
  rpr-cusps census robot.json --l2-range :40 --format csv     leg 2 fixed
"""


def _page(document: Mapping[str, Any]) -> Page:
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
        keys = [leg, "cusps", *(key for key in events[0] if key not in (leg, "cusps"))]
        sections.append(Section("Transitions", rows_of(events, keys)))
    return Page(about(document), sections, document["digits"])


COMMANDS = {
    "census": command(
        CensusRequest,
        _CENSUS,
        _CENSUS_EXAMPLES,
        page=_page,
        words={"range": "the range of lengths; either end may be omitted (default: all)"},
        steps="steps",
    )
}
