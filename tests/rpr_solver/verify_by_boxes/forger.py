"""The random forger: true documents are made false in consistent ways, and none may be verified.

    python -m tests.rpr_solver.verify_by_boxes.forger [--kind KIND ...] [--minutes 10] [--seed 1] [--first 0]

One to three things are changed, and what follows from them: counts of lists, numbers before and after
transitions, the verdict of a report, the hash of a geometry. A false document is *accepted* if the first line
calls it verified, or does not name a member that was changed. Document n is the same in every run with the
same seed. Prints every document that is accepted, then how many of each change were tried; exits with
status 1 if any was.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import random
import re
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from copy import deepcopy
from fractions import Fraction
from typing import Any

from tests.rpr_solver.verify_by_boxes.forgeries import first_line
from tests.rpr_solver.verify_by_boxes.true_documents import KINDS, question, true_document

Document = Any
Change = Callable[[random.Random, Document], str | None]
"""Changes a document in place; returns the pointer of what is false then, None where it cannot be changed."""

_DECIMAL = re.compile(r"-?[0-9]+\.[0-9]+(e[+-][0-9]+)?")
_POSE_KINDS = ("swallowtail", "lips", "beak-to-beak", "isolated-point", "node", "quadruple", "higher")
_FEW_DIGITS = (15, 15, 15, 15, 30, 90)

POINTS = {
    "tables": ["slices/*/cusps/*"],
    "poses": ["poses/*"],
    "censuses": ["transitions/*/events/*"],
    "reports": ["violations/*/example/cusps/*"],
    "curves": ["curves/*/points/*", "curves/*/from/events/*", "curves/*/to/events/*"],
    "singular": ["components/*/strands/*/vertices/*"],
    "paths": ["from", "to", "samples/*"],
}
"""Objects with printed numbers of poses."""
LISTS = {
    "tables": ["slices/*/cusps"],
    "poses": ["poses"],
    "censuses": ["transitions/*/events"],
    "reports": ["violations", "violations/*/example/cusps"],
    "curves": ["curves"],
    "singular": ["components", "components/*/strands/*/vertices", "regions", "aspects"],
}
"""Lists of which each element is one of all that there are."""
NUMBERS = {
    "poses": ["poses/*/multiplicity"],
    "censuses": ["intervals/*/count", "intervals/*/aspects"],
    "reports": ["intervals/*/count"],
    "curves": ["curves/*/points/*/cusp"],
    "margins": ["count"],
    "singular": ["regions/*/poses"],
    "paths": ["from/pose", "to/pose", "cusp", "winding", "certificate/turns/from/*"],
}
"""Integers."""


def places(document: Document, pattern: str, at: str = "") -> Iterator[tuple[str, Document, Any]]:
    """The members that a pattern names: pointers, what has them, and their names there."""
    step, _, rest = pattern.partition("/")
    keys = [step] if step != "*" else range(len(document)) if isinstance(document, list) else list(document)
    for key in keys:
        if isinstance(document, dict) and key not in document:
            continue
        where = f"{at}/{key}"
        if not rest:
            yield where, document, key
        elif isinstance(document[key], dict | list):
            yield from places(document[key], rest, where)


def chosen(draw: random.Random, document: Document, patterns: list[str]) -> tuple[str, Document, Any] | None:
    """One of the members that some patterns name."""
    found = [place for pattern in patterns for place in places(document, pattern)]
    return draw.choice(found) if found else None


def other_digit(draw: random.Random, text: str, most: int = 1000) -> str:
    """A decimal with another digit among so many that are significant, and the first one not 0."""
    first = next(k for k, letter in enumerate(text) if letter in "123456789")
    end = min(len(text.partition("e")[0]), first + most)
    k = draw.choice([k for k in range(first, end) if text[k].isdigit()])
    return text[:k] + draw.choice([x for x in "123456789" if x != text[k]]) + text[k + 1 :]


def digit(kind: str) -> Change:
    """Another digit of a pose."""

    def change(draw: random.Random, document: Document) -> str | None:
        if (place := chosen(draw, document, POINTS[kind])) is None:
            return None
        at, owner, key = place
        row, bounds = owner[key], ("clearance_deg", "time", "place")
        names = [
            x for x, y in row.items() if isinstance(y, str) and _DECIMAL.fullmatch(y) and x not in bounds
        ]
        if document.get("fixed_leg") and "points" in at:
            names = [name for name in names if name != f"l{document['fixed_leg']}"]
        if not names:
            return None
        name = draw.choice(names)
        row[name] = other_digit(draw, row[name])
        return at

    return change


def row_dropped(kind: str) -> Change:
    """An element of a list less."""

    def change(draw: random.Random, document: Document) -> str | None:
        place = chosen(draw, document, LISTS[kind])
        if place is None or not place[1][place[2]]:
            return None
        at, owner, key = place
        del owner[key][draw.randrange(len(owner[key]))]
        return at.rpartition("/")[0] if key == "cusps" else at

    return change


def row_doubled(kind: str) -> Change:
    """An element of a list twice, or in the place of another."""

    def change(draw: random.Random, document: Document) -> str | None:
        place = chosen(draw, document, LISTS[kind])
        if place is None or not place[1][place[2]]:
            return None
        at, owner, key = place
        rows = owner[key]
        k, n = draw.randrange(len(rows)), draw.randrange(len(rows))
        if k == n or rows[k] == rows[n]:
            rows.insert(k, deepcopy(rows[k]))
        else:
            rows[k] = deepcopy(rows[n])
        return at.rpartition("/")[0] if key == "cusps" else at

    return change


def number(kind: str) -> Change:
    """Another integer."""

    def change(draw: random.Random, document: Document) -> str | None:
        place = chosen(draw, document, NUMBERS[kind])
        if place is None or place[1][place[2]] is None:
            return None
        at, owner, key = place
        owner[key] = max(owner[key] + draw.choice([-2, -1, 1, 2]), -1 if key == "winding" else 0)
        return {"cusp": "/winding", "alpha": "/certificate/turns"}.get(
            at.rpartition("/")[2], at
        ).removesuffix("/pose")

    return change


def another_kind(draw: random.Random, document: Document) -> str | None:
    """Another kind of a degenerate pose."""
    patterns = [
        "slices/*/degenerate_points/*",
        "transitions/*/events/*",
        *POINTS["curves"],
        *POINTS["singular"],
    ]
    place = chosen(draw, document, patterns)
    if place is None or place[1][place[2]].get("kind") in (None, "cusp", "curve"):
        return None
    at, owner, key = place
    owner[key]["kind"] = draw.choice([kind for kind in _POSE_KINDS if kind != owner[key]["kind"]])
    return at


def another_geometry(draw: random.Random, document: Document) -> str | None:
    """Another one of the first digits of a side, so that no printed digit hides it, with its hash."""
    geometry, name = document["geometry"], draw.choice(["a2x", "a3y", "d1", "d2"])
    if "/" in geometry[name] or not re.search("[1-9]", geometry[name]):
        return None
    whole, _, part = other_digit(draw, geometry[name], 4).partition(".")
    geometry[name] = f"{whole}.{part}".rstrip("0").rstrip(".") if part else whole
    return "/"


def moved_to_degenerate(draw: random.Random, document: Document) -> str | None:
    """A cusp as a degenerate pose, or a degenerate pose as a cusp."""
    at, owner, key = chosen(draw, document, ["slices/*"]) or ("", {}, "")
    part = owner[key]
    if part.get("cusps") and draw.random() < 0.6:
        cusp = part["cusps"].pop(draw.randrange(len(part["cusps"])))
        part["degenerate_points"].append({"kind": draw.choice(_POSE_KINDS), **cusp})
        return at
    points = [point for point in part.get("degenerate_points", ()) if "alpha_deg" in point]
    if not points:
        return None
    point = draw.choice(points)
    part["degenerate_points"].remove(point)
    part["cusps"].append({name: x for name, x in point.items() if name != "kind"})
    return at


def another_length(draw: random.Random, document: Document) -> str | None:
    """Another length of the fixed leg of a slice with cusps."""
    name = f"l{document['fixed_leg']}"
    parts = [
        (n, part) for n, part in enumerate(document["slices"]) if part.get("cusps") and "/" not in part[name]
    ]
    if not parts:
        return None
    n, part = draw.choice(parts)
    part[name] = str(int(part[name].partition(".")[0]) + draw.choice([1, 2, 7]))
    return f"/slices/{n}"


def transition_hidden(draw: random.Random, document: Document) -> str | None:
    """A transition that changes the number left out, with the number of either side."""
    rows, parts = document["transitions"], document["intervals"]
    changing = [n for n, row in enumerate(rows) if row["count_before"] != row["count_after"]]
    if not changing:
        return None
    n = draw.choice(changing)
    del rows[n]
    low, high = parts[n : n + 2]
    parts[n : n + 2] = [{**draw.choice([low, high]), "from": low["from"], "to": high["to"]}]
    return "/"


def transition_moved(draw: random.Random, document: Document) -> str | None:
    """A transition elsewhere, in the intervals beside it, too."""
    if not document["transitions"]:
        return None
    n, name = draw.randrange(len(document["transitions"])), f"l{document['fixed_leg']}"
    text = other_digit(draw, document["transitions"][n][name])
    document["transitions"][n][name] = text
    document["intervals"][n]["to"] = document["intervals"][n + 1]["from"] = text
    return "/"


def interval_hidden(draw: random.Random, document: Document) -> str | None:
    """An interval of a report as a part of the one beside it."""
    rows = document["intervals"]
    if len(rows) < 2:
        return None
    n = draw.randrange(len(rows) - 1)
    first, second = rows[n : n + 2]
    rows[n : n + 2] = [{**draw.choice([first, second]), "from": first["from"], "to": second["to"]}]
    return "/"


def tails_exchanged(draw: random.Random, document: Document) -> str | None:
    """Two curves that go on as each other from some point."""
    pairs = [curve for curve in document["curves"] if len(curve["points"]) > 1]
    if len(pairs) < 2:
        return None
    first, second = draw.sample(pairs, 2)
    name = f"l{document['fixed_leg']}"
    common = {p[name] for p in first["points"]} & {p[name] for p in second["points"]}
    if len(common) < 2:
        return None
    cut = sorted(common, key=Fraction)[1]
    tails = [[p for p in curve["points"] if Fraction(p[name]) >= Fraction(cut)] for curve in (first, second)]
    for curve, own, other in ((first, *tails), (second, *tails[::-1])):
        curve["points"] = curve["points"][: len(curve["points"]) - len(own)] + other
    first["to"], second["to"] = second["to"], first["to"]
    return "/"


def end_changed(draw: random.Random, document: Document) -> str | None:
    """An end of a curve that joins nobody, or another curve, or is open."""
    curve, side = draw.choice(document["curves"] or [None]), draw.choice(["from", "to"])
    if curve is None or not curve[side]["joins"]:
        return None
    others = [x["name"] for x in document["curves"] if x["name"] not in (curve["name"], curve[side]["joins"])]
    if others and draw.random() < 0.5:
        curve[side]["joins"] = draw.choice(others)
    elif draw.random() < 0.5:
        curve[side]["joins"] = None
    else:
        length = "0" if side == "from" else None
        curve[side] = {f"l{document['fixed_leg']}": length, "kind": "open", "joins": None, "events": []}
    return "/curves"


def margin_changed(draw: random.Random, document: Document) -> str | None:
    """A radius that is proved beyond the counter-example, or none; the other verdict."""
    example = document["counterexample"]
    if example is not None and draw.random() < 0.6:
        radius = Fraction(example["radius"])
        document["counterexample"] = None
        if document["verdict"] is None:
            document["proved"] = (
                str(radius * 2) if (radius * 2).denominator == 1 else f"{float(radius * 2):.6f}"
            )
        else:
            document.update(proved="1", verdict="proved")
        return "/"
    if document["verdict"] is None:
        return None
    document["verdict"] = {"proved": "open", "open": "proved", "refuted": "open"}[document["verdict"]]
    return "/verdict"


def path_changed(draw: random.Random, document: Document) -> str | None:
    """Another sign, a bound that is too great, another law of time, no path, or another reason for it."""
    if "obstacle" in document:
        document["obstacle"] = draw.choice(
            [x for x in ("opposite-signs", "outside-limits") if x != document["obstacle"]]
        )
        document["connected"] = False
        return None if document["limits"] else "/obstacle"
    sort = draw.randrange(5)
    if sort == 0:
        document["sign"] = -document["sign"]
        return "/sign"
    if sort == 1:
        sizes = [abs(float(sample["determinant"])) for sample in document["samples"]]
        document["certificate"]["least_determinant"] = f"{min(sizes) * 1.001 + 1e-9:#.6g}"
        return "/certificate/least_determinant" if min(sizes) > 1e-4 else None
    if sort == 2:
        draw.choice(document["samples"])["clearance_deg"] = "300.000"
        return "/samples"
    if sort == 3:
        document["timing"] = "cosine" if document["timing"] == "constant" else "constant"
        return "/timing" if len(document["samples"]) > 3 else None
    names = (
        "geometry",
        "geometry_hash",
        "fixed_leg",
        "digits",
        "solver_version",
        "between",
        "limits",
        "from",
        "to",
    )
    kept = {name: document[name] for name in (*names, "l1", "l2", "l3") if name in document}
    more = {"connected": False, "obstacle": draw.choice(["opposite-signs", "other-aspect"])}
    document.clear()
    document.update({**kept, **more, "connecting_range": None, "resolution": None, "samples": []})
    return "/obstacle"


def settled(document: Document) -> None:
    """What follows from the members that are changed."""
    text = ";".join(f"{name}={x}" for name, x in document["geometry"].items())
    document["geometry_hash"] = "sha256:" + hashlib.sha256(f"3-RPR;{text}".encode()).hexdigest()
    for part in document.get("slices", ()):
        if "cusps" in part:
            part["cusps"].sort(key=lambda cusp: Fraction(cusp[f"theta{document['fixed_leg']}_deg"]))
            part["count"] = len(part["cusps"])
    if "poses" in document:
        document["count"] = len(document["poses"])
        document["count_with_multiplicity"] = sum(pose["multiplicity"] for pose in document["poses"])
    for n, row in enumerate(document.get("transitions", ())):
        row["count_before"], row["count_after"] = (document["intervals"][n + k]["count"] for k in (0, 1))
        kinds = {event["kind"] for event in row["events"]}
        row["kind"] = kinds.pop() if len(kinds) == 1 else "several" if kinds else "unclassified"
    if "violations" in document:
        rows, most, least = (
            document["intervals"],
            *(document["requirement"][x] for x in ("max_cusps", "min_cusps")),
        )
        counts = [row["count"] for row in rows]
        document.update(max_cusps_found=max(counts), min_cusps_found=min(counts))
        wrong = [x for x in counts if (most is not None and x > most) or (least is not None and x < least)]
        document["passed"] = not wrong
        if not wrong:
            document["violations"] = []


def _of(kind: str) -> list[Change]:
    own: dict[str, list[Change]] = {
        "tables": [moved_to_degenerate, another_length, another_kind],
        "censuses": [transition_hidden, transition_moved, another_kind],
        "reports": [interval_hidden],
        "curves": [tails_exchanged, end_changed, another_kind],
        "margins": [margin_changed],
        "singular": [another_kind],
        "paths": [path_changed],
    }
    makers: list[tuple[Mapping[str, list[str]], list[Callable[[str], Change]]]] = [
        (POINTS, [digit]),
        (LISTS, [row_dropped, row_doubled]),
        (NUMBERS, [number]),
    ]
    found = [make(kind) for table, makes in makers if kind in table for make in makes]
    return [*found, *own.get(kind, []), *([another_geometry] if kind in POINTS else [])]


CHANGES = {kind: _of({"motions": "paths"}.get(kind, kind)) for kind in KINDS}


def is_named(line: str, at: str) -> bool:
    """Whether a first line refuses a document, or names a false member, or one above or below it."""
    if line.startswith("REFUSED"):
        return True
    steps = ["*" if step.isdigit() else step for step in at.strip("/").split("/") if step]
    pattern = "/".join("(?:[0-9]+|[*])" if step == "*" else re.escape(step) for step in steps[:2])
    return line.startswith("NOT VERIFIED") and re.search("/" + pattern, line) is not None


def run(kind: str, n: int, seed: int, counts: Counter[str]) -> None:
    """Forges document n in several ways."""
    true = true_document(kind, n, seed, _FEW_DIGITS)
    if true is None:
        counts["no document"] += 1
        return
    for k in range(6):
        draw, wrong, done = random.Random(f"{seed} {kind} {n} {k}"), deepcopy(true), []
        for change in draw.choices(CHANGES[kind], k=draw.choice([1, 1, 2, 3])):
            try:
                at = change(draw, wrong)
            except (KeyError, IndexError, StopIteration):  # an earlier change has left nothing to change
                continue
            if at is not None:
                done.append((change.__qualname__.partition(".")[0], at))
        settled(wrong)
        if not done or wrong == true or (has_no_points(wrong) and done[0][0] == "another_geometry"):
            continue
        line = first_line(json.dumps(wrong))
        named = any(is_named(line, at) for _, at in done)
        counts["refused" if line.startswith("REFUSED") else "named as open" if named else "ACCEPTED"] += 1
        counts.update(f"  {what}" for what, _ in done)
        if not named:
            about = f"{kind} {n}.{k}: {question(seed, kind, n).sort}"
            print(f"{about}: ACCEPTED {done}: {line[:300]}", flush=True)


def has_no_points(document: Document) -> bool:
    """Whether nothing in a document depends on the last digits of its geometry."""
    return not any(
        x for patterns in POINTS.values() for pattern in patterns for x in places(document, pattern)
    )


def main() -> int:
    """Runs the forger."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kind", action="append", choices=[*KINDS], help="all if none is given")
    parser.add_argument("--minutes", type=float, default=10, help="of each kind")
    parser.add_argument("--first", type=int, default=0, help="number of the first document")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    fooled = False
    for kind in arguments.kind or KINDS:
        counts: Counter[str] = Counter()
        stop, n = time.monotonic() + 60 * arguments.minutes, arguments.first
        while time.monotonic() < stop:
            run(kind, n, arguments.seed, counts)
            n += 1
        print(f"{kind}: documents {arguments.first} to {n - 1}")
        print(*(f"  {number:5} {name}" for name, number in sorted(counts.items())), sep="\n", flush=True)
        fooled = fooled or bool(counts["ACCEPTED"])
    return 1 if fooled else 0


if __name__ == "__main__":
    sys.exit(main())
