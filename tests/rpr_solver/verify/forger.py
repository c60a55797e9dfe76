"""The random forger: true documents are made false in consistent ways, and none may be established.

    python -m tests.rpr_solver.verify.forger [--kind KIND ...] [--minutes 10] [--seed 1] [--first 0]

A forgery changes several members together, one to three times, as somebody would who knows the verifier: what
is false is told by the change. A document is *accepted* as false if it is established, or if its first line
does not name a member of the false claim. Document n is the same in every run with the same seed. Prints
every document that is accepted, then how many of each change were tried; exits with status 1 if any was.
"""

from __future__ import annotations

import argparse
import json
import random
import sys
import time
from collections import Counter
from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import replace
from fractions import Fraction

from rpr_solver import (
    InputError,
    Manipulator,
    Requirement,
    SolverError,
    check,
    cusp_curves,
    poses,
)
from rpr_solver.verify.core.members import POSE_KINDS
from tests.rpr_solver.verify import motion_forger, path_forger, singular_forger
from tests.rpr_solver.verify.forgeries import first_line
from tests.rpr_solver.verify.forging import Document, Forge, Forged, digit, is_fooled, leading_digit, rehashed
from tests.rpr_solver.verify.long_run import (
    Drawn,
    a_report,
    drawn,
    some_margin,
    some_motion,
    some_path,
    some_singular_curves,
    table,
    whole_census,
)
from tests.support.mutations import OF_MARGINS, Mutation, other_digit
from tests.support.verified import is_refused

_DIGITS = (15, 15, 15, 15, 15, 15, 15, 30, 90, 200)
"""Mostly few, as with many each document takes long."""


def _poses(question: Drawn) -> Document:
    lengths = [question.scale * Fraction(question.draw.randint(10, 250), 10) for _ in range(3)]
    return poses(question.manipulator, *lengths, digits=question.draw.choice([15, 30])).to_json()


def _curves(question: Drawn) -> Document:
    start = question.scale * Fraction(question.draw.randint(1, 300), 10)
    stop = start + question.scale
    curves = cusp_curves(question.manipulator, digits=15, fixed_leg=question.leg)
    if question.draw.random() < 0.3:
        return curves.to_json(certificate="full")
    lengths = [start + (stop - start) * Fraction(k, 3) for k in (1, 2)]
    form = question.draw.choice(["short", "full"])
    return curves.part(start, stop, lengths=lengths).to_json(certificate=form)


def _point(draw: random.Random, rows: list[Document]) -> Document | None:
    return draw.choice(rows) if rows else None


def another_geometry(draw: random.Random, document: Document) -> Forged:
    """Another corner or side, with the hash that belongs to it: another one of its first digits."""
    geometry, name = document["geometry"], draw.choice(["a2x", "a3y", "d1", "d2"])
    changed = leading_digit(draw, geometry[name])
    if changed is None or "/" in geometry[name] or not _has_points(document):
        return None
    geometry[name] = changed
    rehashed(document)
    return "another geometry", "/"


def _has_points(document: Document) -> bool:
    """Whether a document has digits that depend on the sides."""
    parts = document.get("slices") or document.get("curves") or []
    examples = [part["example"] for part in document.get("violations", [])]
    return bool(
        document.get("poses")
        or "from" in document
        or any(strand["vertices"] for part in document.get("components", ()) for strand in part["strands"])
        or document.get("transitions")
        or any(part.get("cusps") or part.get("points") for part in [*parts, *examples])
        or ("violations" in document and len(document["intervals"]) > 1)
    )


def _slice(draw: random.Random, document: Document) -> tuple[int, Document] | None:
    numbers = [n for n, part in enumerate(document["slices"]) if part.get("cusps")]
    return (n := draw.choice(numbers), document["slices"][n]) if numbers else None  # type: ignore[return-value]


def _taken(part: Document, n: int) -> Document:
    """Takes a cusp out, with its count."""
    part["count"] -= 1
    return part["cusps"].pop(n)


def cusp_dropped(draw: random.Random, document: Document) -> Forged:
    """A cusp less, its count too, and perhaps its root."""
    if (found := _slice(draw, document)) is None:
        return None
    n, part = found
    _taken(part, draw.randrange(len(part["cusps"])))
    if draw.random() < 0.3:
        part["certificate"]["real_roots"] -= 1
    return "a cusp dropped", f"/slices/{n}"


def cusp_demoted(draw: random.Random, document: Document) -> Forged:
    """A cusp among the degenerate points."""
    if (found := _slice(draw, document)) is None:
        return None
    n, part = found
    kind = draw.choice(POSE_KINDS)
    point = {"kind": kind, **_taken(part, draw.randrange(len(part["cusps"])))}
    part["degenerate_points"].append(point)
    return f"a cusp as {kind}", f"/slices/{n}"


def degenerate_promoted(draw: random.Random, document: Document) -> Forged:
    """A degenerate point among the cusps."""
    rows = [(n, part) for n, part in enumerate(document["slices"]) if part.get("degenerate_points")]
    if not rows:
        return None
    n, part = draw.choice(rows)
    point = part["degenerate_points"].pop()
    if point["kind"] == "curve":
        return "a curve dropped", f"/slices/{n}"
    del point["kind"]
    part["cusps"].append(point)
    part["cusps"].sort(key=lambda cusp: Fraction(cusp[f"theta{document['fixed_leg']}_deg"]))
    part["count"] += 1
    return "a degenerate pose as a cusp", f"/slices/{n}"


def another_kind_of_point(draw: random.Random, document: Document) -> Forged:
    """Another kind of a degenerate point."""
    rows = [
        (n, p) for n, s in enumerate(document["slices"]) for p in s.get("degenerate_points", []) if len(p) > 2
    ]
    if not rows:
        return None
    n, point = draw.choice(rows)
    point["kind"] = draw.choice([kind for kind in POSE_KINDS if kind != point["kind"]])
    return f"another kind of point, {point['kind']}", f"/slices/{n}/degenerate_points"


def cusp_doubled(draw: random.Random, document: Document) -> Forged:
    """A cusp in the place of another, or twice."""
    if (found := _slice(draw, document)) is None:
        return None
    n, part = found
    cusps = part["cusps"]
    k = draw.randrange(len(cusps))
    near = k + 1 if k + 1 < len(cusps) else k - 1
    if near >= 0 and near != k and draw.random() < 0.5 and cusps[near] != cusps[k]:
        cusps[near] = deepcopy(cusps[k])
        return "a cusp in the place of another", f"/slices/{n}"
    cusps.insert(k, deepcopy(cusps[k]))
    part["count"] += 1
    return "a cusp doubled", f"/slices/{n}"


def cusp_moved(draw: random.Random, document: Document) -> Forged:
    """Another digit of a cusp."""
    if (found := _slice(draw, document)) is None:
        return None
    n, part = found
    k = draw.randrange(len(part["cusps"]))
    if digit(draw, part["cusps"][k], "") is None:
        return None
    return "another digit of a cusp", f"/slices/{n}"


def another_length(draw: random.Random, document: Document) -> Forged:
    """Another fixed length."""
    if (found := _slice(draw, document)) is None:
        return None
    n, part = found
    name = f"l{document['fixed_leg']}"
    if (changed := leading_digit(draw, part[name])) is None:
        return None
    part[name] = changed
    return "another length", f"/slices/{n}"


def exact_zero(draw: random.Random, document: Document) -> Forged:
    """A small or large number as an exact 0."""
    if (found := _slice(draw, document)) is None:
        return None
    n, part = found
    cusp = draw.choice(part["cusps"])
    name = draw.choice([name for name in cusp if name.endswith("_deg")])
    if cusp[name] == "0":
        return None
    cusp[name] = "0"
    return "an angle as exactly 0", f"/slices/{n}"


def pose_swapped(draw: random.Random, document: Document) -> Forged:
    """A pose in the place of another, or dropped, or of another multiplicity."""
    rows = document["poses"]
    if not rows:
        return None
    k = draw.randrange(len(rows))
    if len(rows) > 1 and draw.random() < 0.4:
        near = k + 1 if k + 1 < len(rows) else k - 1
        if rows[near] == rows[k]:
            return None
        document["count_with_multiplicity"] += rows[k]["multiplicity"] - rows[near]["multiplicity"]
        rows[near] = deepcopy(rows[k])
        return "a pose in the place of another", "/poses"
    if draw.random() < 0.5:
        lost = rows.pop(k)
        document["count"] -= 1
        if rows and draw.random() < 0.5:
            other = draw.choice(rows)
            other["multiplicity"] = min(6, other["multiplicity"] + lost["multiplicity"])
        document["count_with_multiplicity"] = sum(row["multiplicity"] for row in rows)
        return "a pose dropped", "/poses"
    change = 1 if rows[k]["multiplicity"] < 6 else -1
    rows[k]["multiplicity"] += change
    document["count_with_multiplicity"] += change
    return "another multiplicity", "/poses"


def pose_moved(draw: random.Random, document: Document) -> Forged:
    """Another digit of a pose."""
    row = _point(draw, document["poses"])
    if row is None or digit(draw, row, "") is None:
        return None
    return "another digit of a pose", "/poses"


def another_leg(draw: random.Random, document: Document) -> Forged:
    """Another length of a leg, or the lengths of two exchanged."""
    first, second = draw.sample(["l1", "l2", "l3"], 2)
    if document[first] == document[second] or not document["poses"]:
        return None
    document[first], document[second] = document[second], document[first]
    return "two legs exchanged", "/"


def transition_hidden(draw: random.Random, document: Document) -> Forged:
    """A transition left out, with the count of either side, and perhaps its box, its root, or its sign."""
    rows, parts = document["transitions"], document["intervals"]
    if not rows:
        return None
    n = draw.randrange(len(rows))
    low, high = parts[n : n + 2]
    kept = draw.choice([low, high])
    changes = low["count"] != high["count"]
    del rows[n]
    parts[n : n + 2] = [kept | {"from": low["from"], "to": high["to"]}]
    for k, row in enumerate(rows):
        row["count_before"], row["count_after"] = parts[k]["count"], parts[k + 1]["count"]
    return ("a transition hidden", "/") if changes else None


def transition_added(draw: random.Random, document: Document) -> Forged:
    """A transition where there is none, with the event of another one or none."""
    parts, rows, name = document["intervals"], document["transitions"], f"l{document['fixed_leg']}"
    n = draw.randrange(len(parts))
    low = Fraction(parts[n]["from"])
    high = 2 * low + 1 if parts[n]["to"] is None else Fraction(parts[n]["to"])
    place = low + (high - low) * Fraction(draw.randint(200, 800), 1000)
    if not Fraction(1) <= place < 1000:
        return None
    digits = document["digits"]
    whole = len(str(int(place)))
    number = str(int(place * 10 ** (digits - whole)))
    text = f"{number[:whole]}.{number[whole:]}"
    events = []
    if rows and draw.random() < 0.5:
        events = deepcopy(draw.choice(rows)["events"])
    change, count = draw.choice([0, 0, 2, -2]), parts[n]["count"]
    if not 0 <= count + change <= 24:
        return None
    kinds = {event["kind"] for event in events}
    kind = kinds.pop() if len(kinds) == 1 else "several" if kinds else "unclassified"
    rows.insert(n, {name: text, "kind": kind, "count_before": count, "count_after": count + change})
    rows[n]["events"] = events
    parts[n : n + 1] = [parts[n] | {"to": text}, parts[n] | {"from": text, "count": count + change}]
    if n + 1 < len(rows):
        rows[n + 1]["count_before"] = count + change
    return f"a transition added, {len(events)} events, {change:+d} cusps", "/"


def count_changed(draw: random.Random, document: Document) -> Forged:
    """Other numbers of cusps of an interval, of a run of intervals, or of all."""
    parts, rows = document["intervals"], document["transitions"]
    start = draw.randrange(len(parts))
    stop = draw.randint(start, len(parts) - 1)
    change = draw.choice([-2, -1, 1, 2])
    for part in parts[start : stop + 1]:
        part["count"] += change
    if any(not 0 <= part["count"] <= 24 for part in parts):
        return None
    for k, row in enumerate(rows):
        row["count_before"], row["count_after"] = parts[k]["count"], parts[k + 1]["count"]
    return "other numbers of cusps", "/"


def aspects_changed(draw: random.Random, document: Document) -> Forged:
    """An interval has another number of aspects."""
    rows = [(n, row) for n, row in enumerate(document["intervals"]) if row["aspects"] is not None]
    if not rows:
        return None
    n, row = draw.choice(rows)
    row["aspects"] += draw.choice([-1, 1, 2])
    return "another number of aspects", f"/intervals/{n}/aspects"


def event_moved(draw: random.Random, document: Document) -> Forged:
    """Another digit of an event, or another kind."""
    rows = [(n, row) for n, row in enumerate(document["transitions"]) if row["events"]]
    if not rows:
        return None
    n, row = draw.choice(rows)
    event = draw.choice(row["events"])
    if draw.random() < 0.5:
        if digit(draw, event, "") is None:
            return None
        return "another digit of an event", f"/transitions/{n}"
    event["kind"] = draw.choice([kind for kind in POSE_KINDS if kind != event["kind"]])
    kinds = {event["kind"] for event in row["events"]}
    row["kind"] = kinds.pop() if len(kinds) == 1 else "several"
    return f"another kind of an event, {event['kind']}", f"/transitions/{n}"


def _forms(value: Document, at: str = "") -> list[tuple[str, Document]]:
    """All objects with a polynomial, by their pointers."""
    own = [(at, value)] if isinstance(value, dict) and "polynomial" in value else []
    rows = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return own + [found for key, x in rows for found in _forms(x, f"{at}/{key}")]


def form_changed(draw: random.Random, document: Document) -> Forged:
    """A polynomial over the root of a square, or of four times its number; or a prime there that is none."""
    if not (forms := _forms(document)):
        return None
    at, holder = draw.choice(forms)
    form, place = holder["polynomial"], holder.get("squarefree")
    if "squarefree" in holder and draw.random() < 0.5:
        # 2 is no root of a number that has none among integers, nor of 1: where Q is rational, 1 would do
        holder["squarefree"] = None if place else {"prime": str((1 << 61) - 1), "omega": "2"}
        return "a prime left out, or put", f"{at}/squarefree"
    if "omega" not in form:
        form["omega"], form["omega_coefficients"] = "sqrt(4)", [str(-int(x)) for x in form["coefficients"]]
        form["coefficients"] = [str(2 * int(x)) for x in form["coefficients"]]
        if place:
            place["omega"] = "2"
    elif any(x != "0" for x in form["omega_coefficients"]):
        form["omega"] = f"sqrt({4 * int(form['omega'][5:-1])})"
    else:
        return None
    return "a polynomial over another root", f"{at}/polynomial"


def cut_doubled(draw: random.Random, document: Document) -> Forged:
    """A transition, or a cut of a report, listed twice, with an interval of no length."""
    rows = document["intervals"]
    if len(rows) < 2:
        return None
    n = draw.randrange(1, len(rows))
    cut, number = rows[n]["from"], rows[n]["count"]
    if "transitions" not in document:
        number += draw.choice([-1, 1, 2])
        rows.insert(n, {"from": cut, "to": cut, "count": number})
        return ("a cut twice", "/") if _settled(document) else None
    rows.insert(n, rows[n] | {"from": cut, "to": cut})
    row = deepcopy(document["transitions"][n - 1])
    document["transitions"].insert(n, row | {"count_before": number, "count_after": number})
    return "a transition twice", "/transitions"


def curve_changed(draw: random.Random, document: Document) -> Forged:
    """A curve dropped or doubled, with numbers of cusps made anew; points exchanged; a digit; an end."""
    curves, name = document["curves"], f"l{document['fixed_leg']}"
    full = [curve for curve in curves if curve["points"]]
    if not full:
        return None
    curve = draw.choice(full)
    match draw.randrange(5):
        case 0:
            curves.remove(curve)
            done = "a curve dropped"
        case 1:
            curves.append(deepcopy(curve) | {"name": "C999"})
            done = "a curve doubled"
        case 2:
            if digit(draw, draw.choice(curve["points"]), name) is None:
                return None
            return "another digit of a point", "/curves"
        case 3:
            ends = [end for c in curves for end in (c["from"], c["to"]) if end["events"]]
            if not ends:
                return None
            end = draw.choice(ends)
            end[name] = other_digit(draw, end[name])
            return "an end moved", "/curves"
        case _:
            others = [c for c in full if c is not curve and len(c["points"]) == len(curve["points"]) > 1]
            if not others:
                return None
            other = draw.choice(others)
            curve["points"][0], other["points"][0] = other["points"][0], curve["points"][0]
            return "points exchanged", "/"
    by_length: dict[str, list[Document]] = {}
    for c in curves:
        for point in c["points"]:
            by_length.setdefault(point[name], []).append(point)
    for points in by_length.values():
        for k, point in enumerate(sorted(points, key=lambda p: p["cusp"]), 1):
            point["cusp"] = k
    for c in curves:
        for side in ("from", "to"):
            if c[side]["joins"] == curve["name"] and done == "a curve dropped":
                c[side]["joins"] = None
    return done, "/curves"


def end_changed(draw: random.Random, document: Document) -> Forged:
    """Ends exchanged between two curves, or said to join nobody; the tubes past them are left out."""
    curves, side = document["curves"], draw.choice(["from", "to"])
    ends = [curve for curve in curves if curve["points"] and curve[side]["joins"]]
    if not ends:
        return None
    curve = draw.choice(ends)
    if draw.random() < 0.5:
        for other in curves:
            if other is curve or other["name"] == curve[side]["joins"]:
                other[side]["joins"] = None
        done = "ends that join nobody"
    else:
        others = [c for c in curves if c["points"] and c[side]["events"] != curve[side]["events"]]
        if not others:
            return None
        other = draw.choice(others)
        curve[side], other[side] = other[side], curve[side]
        names = {curve["name"]: other["name"], other["name"]: curve["name"]}
        for c in curves:
            c[side]["joins"] = names.get(c[side]["joins"], c[side]["joins"])
        done = "ends exchanged"
    if full := document.get("certificate", {}).get("full"):
        chains = full["chains"]
        chains[:] = [chain for chain in chains if chain["from"]["curve"] == chain["to"]["curve"]]
    return done, "/curves"


def chain_changed(draw: random.Random, document: Document) -> Forged:
    """A chain dropped, its tubes exchanged or widened."""
    chains = document.get("certificate", {}).get("full", {}).get("chains", [])
    if not chains:
        return None
    chain = draw.choice(chains)
    match draw.randrange(3):
        case 0:
            chains.remove(chain)
            return "a chain dropped", "/"
        case 1:
            tube = draw.choice(chain["tubes"])
            tube["radii"] = ["100", "100"]
            return "a tube widened", "/certificate"
        case _:
            tube = draw.choice(chain["tubes"])
            tube["reach"] = "1000"
            return "a tube lengthened", "/certificate"


def tails_exchanged(draw: random.Random, document: Document) -> Forged:
    """Two curves go on as each other from some length: all later points, their ends, and chains by name."""
    curves, name = document["curves"], f"l{document['fixed_leg']}"
    pairs = [
        (one, two, common)
        for k, one in enumerate(curves)
        for two in curves[:k]
        if (common := {p[name] for p in one["points"]} & {p[name] for p in two["points"]})
    ]
    if not pairs:
        return None
    one, two, common = draw.choice(pairs)
    cut = Fraction(draw.choice(sorted(common)))
    tails = [[p for p in curve["points"] if Fraction(p[name]) >= cut] for curve in (one, two)]
    for curve, own, other in ((one, *tails), (two, *tails[::-1])):
        curve["points"] = [p for p in curve["points"] if p not in own] + other
    if not all(curve["points"] for curve in (one, two)):
        return None
    one["to"], two["to"] = two["to"], one["to"]
    names = {one["name"]: two["name"], two["name"]: one["name"]}
    for curve in curves:
        curve["to"]["joins"] = names.get(curve["to"]["joins"], curve["to"]["joins"])
    for chain in document.get("certificate", {}).get("full", {}).get("chains", []):
        for side in ("from", "to"):
            if Fraction(chain[side][name]) >= cut:
                chain[side]["curve"] = names.get(chain[side]["curve"], chain[side]["curve"])
    return "curves that go on as each other", "/"


def partners_exchanged(draw: random.Random, document: Document) -> Forged:
    """Two pairs of curves that join exchange their partners, in the chains past the ends too."""
    curves, side = document["curves"], draw.choice(["from", "to"])
    by_name = {curve["name"]: curve for curve in curves}
    pairs = [(c, by_name[j]) for c in curves if (j := c[side]["joins"]) in by_name and c["name"] < j]
    if len(pairs) < 2:
        return None
    (a, b), (c, d) = draw.sample(pairs, 2)
    b[side], d[side] = d[side], b[side]
    names = {b["name"]: d["name"], d["name"]: b["name"]}
    for curve, other in ((a, d), (d, a), (c, b), (b, c)):
        curve[side]["joins"] = other["name"]
    for chain in document.get("certificate", {}).get("full", {}).get("chains", []):
        ends = {chain["from"]["curve"], chain["to"]["curve"]}
        if len(ends) == 2 and ends in ({a["name"], b["name"]}, {c["name"], d["name"]}):
            for end in (chain["from"], chain["to"]):
                end["curve"] = names.get(end["curve"], end["curve"])
    return "curves that join exchanged", "/"


def pose_of_end_changed(draw: random.Random, document: Document) -> Forged:
    """Another digit, or another kind, of the event at an end, at all curves that end there."""
    ends = [curve[side] for curve in document["curves"] for side in ("from", "to") if curve[side]["events"]]
    if not ends:
        return None
    event = draw.choice(draw.choice(ends)["events"])
    old, new = dict(event), dict(event)
    if draw.random() < 0.5:
        if digit(draw, new, "") is None:
            return None
    else:
        new["kind"] = draw.choice([kind for kind in POSE_KINDS if kind != old["kind"]])
    for end in ends:
        for other in end["events"]:
            if other == old:
                other.update(new)
        if end["kind"] == old["kind"] and new in end["events"]:
            end["kind"] = new["kind"]
    return "another pose of an end", "/curves"


def verdict_changed(draw: random.Random, document: Document) -> Forged:
    """The numbers of intervals moved within the bound, and all that follows."""
    requirement, rows = document["requirement"], document["intervals"]
    if not document["violations"] or requirement["max_cusps"] is None:
        return None
    most = requirement["max_cusps"]
    if draw.random() < 0.5:
        for k, row in enumerate(rows):
            row["count"] = most - k % 2 if most else 0
        if most == 0 and len(rows) > 1:
            rows[:] = [rows[0] | {"to": rows[-1]["to"]}]
    else:
        rows[:] = [{"from": rows[0]["from"], "to": rows[-1]["to"], "count": most}]
    counts = [row["count"] for row in rows]
    document.update(passed=True, violations=[], max_cusps_found=max(counts), min_cusps_found=min(counts))
    return "passed in place of failed", "/"


def cut_moved(draw: random.Random, document: Document) -> Forged:
    """A cut between intervals moved everywhere."""
    rows = document["intervals"]
    if len(rows) < 2:
        return None
    old = rows[draw.randrange(1, len(rows))]["from"]
    new = other_digit(draw, old)
    for row in (*rows, *document["violations"]):
        for end in ("from", "to"):
            row[end] = new if row[end] == old else row[end]
    return "a cut moved", "/"


def example_changed(draw: random.Random, document: Document) -> Forged:
    """A cusp of an example doubled, dropped, or moved."""
    if not document["violations"]:
        return None
    k = draw.randrange(len(document["violations"]))
    cusps = document["violations"][k]["example"]["cusps"]
    if not cusps:
        return None
    if draw.random() < 0.5:
        if digit(draw, draw.choice(cusps), "") is None:
            return None
    elif len(cusps) > 1:
        if cusps[0] == cusps[1]:
            return None
        cusps[0] = deepcopy(cusps[1])
    else:
        cusps.pop()
    return "another example", f"/violations/{k}"


def _settled(document: Document) -> bool:
    """What follows from the intervals of a report, if no interval violates it newly."""
    requirement, rows = document["requirement"], document["intervals"]
    most, least = requirement["max_cusps"], requirement["min_cusps"]
    merged = rows[:1]
    for row in rows[1:]:
        if row["count"] == merged[-1]["count"]:
            merged[-1] = {**merged[-1], "to": row["to"]}
        else:
            merged.append(row)
    counts = [row["count"] for row in merged]
    if min(counts) < 0 or max(counts) > 24:
        return False
    violating = [
        row
        for row in merged
        if (most is not None and row["count"] > most) or (least is not None and row["count"] < least)
    ]
    known = {row["count"]: row["example"] for row in document["violations"]}
    if any(row["count"] not in known for row in violating):
        return False
    document["violations"] = [{**row, "example": known[row["count"]]} for row in violating]
    document.update(intervals=merged, max_cusps_found=max(counts), min_cusps_found=min(counts))
    document["passed"] = not violating
    return True


def number_changed(draw: random.Random, document: Document) -> Forged:
    """Another number of cusps in an interval of a report, with all that follows."""
    row = draw.choice(document["intervals"])
    row["count"] += draw.choice([-4, -2, -1, 1, 2, 4])
    return ("another number in an interval", "/") if _settled(document) else None


def interval_hidden(draw: random.Random, document: Document) -> Forged:
    """An interval of a report that is part of the one beside it."""
    rows = document["intervals"]
    if len(rows) < 2:
        return None
    n = draw.randrange(len(rows) - 1)
    first, second = rows[n : n + 2]
    rows[n : n + 2] = [{**draw.choice([first, second]), "from": first["from"], "to": second["to"]}]
    return ("an interval hidden", "/") if _settled(document) else None


Limits = dict[int, tuple[Document, Document]]


def _limits(asked: Document) -> Limits:
    limits = asked.get("limits") or {}
    return {int(name[1]): (limit["min"], limit["max"]) for name, limit in limits.items()}


def _report(document: Document, limits: Limits) -> Document:
    """The true report on what a document is about, with these limits."""
    asked = document["requirement"]
    names = ("max_cusps", "min_cusps", "degenerate")
    span, more = asked["range"], {name: asked[name] for name in names}
    other = Requirement(asked["fixed_leg"], span["from"], span["to"], limits=limits, **more)
    manipulator = Manipulator.from_json(document["geometry"])
    return json.loads(json.dumps(check(manipulator, other, digits=document["digits"]).to_json()))


def _is_true_again(document: Document) -> bool:
    """Whether changes together have made another true report."""
    return "requirement" in document and document == _report(document, _limits(document["requirement"]))


def limit_changed(draw: random.Random, document: Document) -> Forged:
    """A limit of a report put, taken away, or moved, though the report would be another one then."""
    asked, manipulator = document["requirement"], Manipulator.from_json(document["geometry"])
    limits = _limits(asked)
    size = max(manipulator.d1, abs(manipulator.a2x))
    leg = draw.choice([leg for leg in (1, 2, 3) if leg != asked["fixed_leg"]])
    new = Fraction(round(size * draw.randint(0, 300) / 100))
    limits[leg] = draw.choice([(None, None), (new, None), (None, new + 1)])
    report = _report(document, limits)
    if report["intervals"] == document["intervals"]:
        return None
    asked["limits"] = report["requirement"]["limits"]
    return "other limits", "/"


def degenerate_changed(draw: random.Random, document: Document) -> Forged:
    """What is degenerate throughout left out, added, or of another number, kind or range."""
    listed = document.setdefault("degenerate", [])
    span = document["requirement"]["range"] if "requirement" in document else document["range"]
    how = draw.randrange(4) if listed else 4
    row = draw.choice(listed) if listed else {}
    match how:
        case 0:
            listed.remove(row)
        case 1 if row["kind"] != "curve":
            row["count"] += draw.choice([-1, 1, 2])
        case 2 if row["kind"] != "curve":
            row["kind"] = draw.choice([kind for kind in POSE_KINDS if kind != row["kind"]])
        case 3 if row["to"] is not None and row["to"] != span["to"]:
            row["to"] = other_digit(draw, row["to"])
        case 4:
            kind = draw.choice(["node", "quadruple", "higher"])
            listed.append(
                {"kind": kind, "from": span["from"], "to": span["to"], "count": draw.choice([2, 4])}
            )
        case _:
            return None
    if any(part.get("count") == 0 for part in listed):
        return None
    return "another thing throughout", "/degenerate"


def _forge(mutation: Mutation) -> Forge:
    """A mutation as a forgery: whatever is false then, the document must not be established."""

    def forge(draw: random.Random, document: Document) -> Forged:
        done = mutation(draw, document)
        return None if done is None else (done, "/")

    return forge


KINDS: Mapping[str, tuple[Callable[[Drawn], Document], tuple[Forge, ...]]] = {
    "tables": (
        table,
        (
            cusp_dropped,
            cusp_demoted,
            degenerate_promoted,
            another_kind_of_point,
            cusp_doubled,
            cusp_moved,
            another_length,
            exact_zero,
            form_changed,
            another_geometry,
        ),
    ),
    "poses": (_poses, (pose_swapped, pose_moved, another_leg, form_changed, another_geometry)),
    "censuses": (
        whole_census,
        (
            transition_hidden,
            transition_added,
            count_changed,
            aspects_changed,
            event_moved,
            form_changed,
            cut_doubled,
            degenerate_changed,
            another_geometry,
        ),
    ),
    "curves": (
        _curves,
        (
            curve_changed,
            end_changed,
            tails_exchanged,
            partners_exchanged,
            pose_of_end_changed,
            chain_changed,
            another_geometry,
        ),
    ),
    "reports": (
        a_report,
        (
            verdict_changed,
            number_changed,
            interval_hidden,
            cut_doubled,
            limit_changed,
            degenerate_changed,
            cut_moved,
            example_changed,
            another_geometry,
        ),
    ),
    "margins": (some_margin, tuple(map(_forge, OF_MARGINS))),
    "singular": (some_singular_curves, (*singular_forger.FORGES, another_geometry)),
    "paths": (some_path, (*path_forger.FORGES, another_geometry)),
    "motions": (some_motion, (*motion_forger.FORGES, *path_forger.FORGES)),
}


def _is_there(document: Document, at: str) -> bool:
    """Whether a later change has left the member with the false claim."""
    for step in at.strip("/").split("/") if at != "/" else ():
        try:
            document = document[int(step) if step.isdigit() else step]
        except (KeyError, IndexError):
            return False
    return True


def _is_undone(document: Document, true: Document, at: str) -> bool:
    """Whether later changes have made a member of the whole document, and what is asked, as they were."""
    rows = ("regions", "aspects", "components", "thin_regions")
    name = at.strip("/")
    asked = ({key: x for key, x in own.items() if key not in rows} for own in (document, true))
    return name in rows and document.get(name) == true.get(name) and next(asked) == next(asked)


def run(kind: str, n: int, seed: int, counts: Counter[str]) -> None:
    """Forges document n in several ways."""
    make, changes = KINDS[kind]
    question = replace(drawn(seed, kind, n), digits=_DIGITS)
    try:
        true = json.loads(json.dumps(make(question)))
    except SolverError:
        counts["no document"] += 1
        return
    for k in range(6):
        draw, wrong, done = random.Random(f"{seed} {kind} {n} {k}"), deepcopy(true), []
        for forge in draw.choices(changes, k=draw.choice([1, 1, 2, 3])):
            members = set(wrong)
            try:
                if (forged := forge(draw, wrong)) is None:
                    continue
                if done and members - set(wrong):
                    done = []  # another document, made of what is false already, may be a true one
                    break
                done.append(forged)
            except (KeyError, IndexError, InputError):  # an earlier change has left nothing to change
                continue
        if not done or wrong == true:
            continue
        done = [(what, at) for what, at in done if _is_there(wrong, at) and not _is_undone(wrong, true, at)]
        line = "REFUSED" if is_refused(wrong) else first_line(json.dumps(wrong))
        fooled = any(is_fooled(line, at) for _, at in done) and not _is_true_again(wrong)
        counts["ACCEPTED" if fooled else "refused" if line.startswith("REFUSED") else "named as open"] += 1
        counts.update(f"  {what}" for what, _ in done)
        if fooled:
            about = f"{kind} {n}.{k}: {question.sort}, {question.manipulator}, leg {question.leg}"
            print(f"{about}: ACCEPTED {[what for what, _ in done]}: {line[:300]}", flush=True)


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
