"""Documents with one fault: each mutation of a right document, which a verification must refuse."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator
from copy import deepcopy
from fractions import Fraction
from typing import Any

from rpr_solver import Manipulator, exact_str
from rpr_solver.exact.decimals import rounded_down
from rpr_solver.margins.problems import validity

Document = dict[str, Any]
Mutation = Callable[[random.Random, Document], str | None]
"""Changes a document in place; returns what it did, or None where that is impossible."""

COORDINATES = ("alpha_deg", "theta1_deg", "theta2_deg", "theta3_deg", "l1", "l2", "l3", "b1_x", "b1_y")


def other_digit(draw: random.Random, text: str) -> str:
    """The number with one significant digit changed."""
    mantissa = text.partition("e")[0]
    first = next(i for i, c in enumerate(mantissa) if c in "123456789")
    place = draw.choice([i for i, c in enumerate(mantissa) if i >= first and c.isdigit()])
    digit = draw.choice([d for d in "0123456789" if d != text[place] and (d != "0" or place > first)])
    return text[:place] + digit + text[place + 1 :]


def _change_a_digit(draw: random.Random, place: Document) -> str:
    """Changes a digit of one coordinate that is not 0; returns its name."""
    name = draw.choice([name for name in COORDINATES if name in place and place[name] != "0"])
    place[name] = other_digit(draw, place[name])
    return name


def _slice(draw: random.Random, document: Document) -> Document | None:
    parts = [part for part in document["slices"] if part.get("cusps")]
    return draw.choice(parts) if parts else None


def digit_of_a_cusp(draw: random.Random, document: Document) -> str | None:
    """One digit of one coordinate of a cusp."""
    if (part := _slice(draw, document)) is None:
        return None
    point = draw.choice(part["cusps"])
    name = _change_a_digit(draw, point)
    return f"a digit of {name}"


def missing_cusp(draw: random.Random, document: Document) -> str | None:
    """A cusp left out, and the count less."""
    if (part := _slice(draw, document)) is None:
        return None
    del part["cusps"][draw.randrange(len(part["cusps"]))]
    part["count"] -= 1
    return "a missing cusp"


def doubled_cusp(draw: random.Random, document: Document) -> str | None:
    """A cusp twice, and the count more."""
    if (part := _slice(draw, document)) is None:
        return None
    n = draw.randrange(len(part["cusps"]))
    part["cusps"].insert(n, dict(part["cusps"][n]))
    part["count"] += 1
    return "a doubled cusp"


def other_count(draw: random.Random, document: Document) -> str:
    """Another count."""
    draw.choice(document["slices"])["count"] += draw.choice([-2, -1, 1, 2])
    return "another count"


def other_length(draw: random.Random, document: Document) -> str | None:
    """Another length of the fixed leg."""
    if (part := _slice(draw, document)) is None:
        return None
    name = f"l{document['fixed_leg']}"
    part[name] += "01" if "." in part[name] else ".001"
    return f"another {name}"


def other_geometry(draw: random.Random, document: Document) -> str:
    """Another corner of the base."""
    geometry = document["geometry"]
    name = draw.choice(["a2x", "a3y"])
    geometry[name] += "01" if "." in geometry[name] else ".001"
    return f"another {name}"


def other_factor(draw: random.Random, document: Document) -> str | None:
    """Another multiplicity or number of real roots in the certificate."""
    if (part := _slice(draw, document)) is None:
        return None
    certificate = part["certificate"]
    if draw.random() < 0.5:
        certificate["real_roots"] += 2
    else:
        draw.choice(certificate["factors"])["multiplicity"] += 1
    return "another certificate"


OF_TABLES: tuple[Mutation, ...] = (
    digit_of_a_cusp,
    missing_cusp,
    doubled_cusp,
    other_count,
    other_length,
    other_geometry,
    other_factor,
)


def _pose(draw: random.Random, document: Document) -> Document | None:
    return draw.choice(document["poses"]) if document["poses"] else None


def digit_of_a_pose(draw: random.Random, document: Document) -> str | None:
    """One digit of one coordinate of a pose."""
    if (pose := _pose(draw, document)) is None:
        return None
    name = _change_a_digit(draw, pose)
    return f"a digit of {name}"


def missing_pose(draw: random.Random, document: Document) -> str | None:
    """A pose left out, and both counts less."""
    if (pose := _pose(draw, document)) is None:
        return None
    document["poses"].remove(pose)
    document["count"] -= 1
    document["count_with_multiplicity"] -= pose["multiplicity"]
    return "a missing pose"


def other_multiplicity(draw: random.Random, document: Document) -> str | None:
    """Another multiplicity, and the sum."""
    if (pose := _pose(draw, document)) is None:
        return None
    change = 1 if pose["multiplicity"] < 3 else -1
    pose["multiplicity"] += change
    document["count_with_multiplicity"] += change
    return "another multiplicity"


def other_leg(draw: random.Random, document: Document) -> str:
    """Another length of a leg."""
    name = draw.choice(["l1", "l2", "l3"])
    document[name] += "01" if "." in document[name] else ".001"
    return f"another {name}"


def other_coefficient(draw: random.Random, document: Document) -> str:
    """Another coefficient of the polynomial."""
    coefficients = document["polynomial"]["coefficients"]
    n = draw.randrange(len(coefficients))
    coefficients[n] = str(int(coefficients[n]) + 1)
    return "another coefficient"


OF_POSES: tuple[Mutation, ...] = (
    digit_of_a_pose,
    missing_pose,
    other_multiplicity,
    other_leg,
    other_coefficient,
    other_geometry,
)


def _move(document: Document, n: int, text: str) -> None:
    """Gives a transition another length, in the intervals beside it too."""
    document["transitions"][n][f"l{document['fixed_leg']}"] = text
    document["intervals"][n]["to"] = document["intervals"][n + 1]["from"] = text


def moved_transition(draw: random.Random, document: Document) -> str | None:
    """Another digit of the length of a transition."""
    if not document["transitions"]:
        return None
    n = draw.randrange(len(document["transitions"]))
    _move(document, n, other_digit(draw, document["intervals"][n]["to"]))
    return "a moved transition"


def digit_of_an_event(draw: random.Random, document: Document) -> str | None:
    """One digit of one coordinate of a degenerate pose."""
    events = [event for row in document["transitions"] for event in row["events"]]
    if not events:
        return None
    event = draw.choice(events)
    name = _change_a_digit(draw, event)
    return f"a digit of {name} of an event"


def missing_transition(draw: random.Random, document: Document) -> str | None:
    """A transition left out, the intervals beside it made one, with the count of either."""
    changes = [
        n for n, row in enumerate(document["transitions"]) if row["count_before"] != row["count_after"]
    ]
    if not changes:
        return None
    n = draw.choice(changes)
    del document["transitions"][n]
    before, after = document["intervals"][n : n + 2]
    document["intervals"][n : n + 2] = [
        draw.choice([before, after]) | {"from": before["from"], "to": after["to"]}
    ]
    return "a missing transition"


def other_kind(draw: random.Random, document: Document) -> str | None:
    """Another kind of an event, and of its transition."""
    rows = [row for row in document["transitions"] if len(row["events"]) == 1]
    if not rows:
        return None
    row = draw.choice(rows)
    kinds = [kind for kind in ("swallowtail", "lips", "beak-to-beak") if kind != row["kind"]]
    row["kind"] = row["events"][0]["kind"] = draw.choice(kinds)
    return "another kind"


def other_interval_count(draw: random.Random, document: Document) -> str:
    """Another number of cusps between two transitions, and beside them."""
    n = draw.randrange(len(document["intervals"]))
    change = draw.choice([-2, 2, 4])
    document["intervals"][n]["count"] += change
    if n:
        document["transitions"][n - 1]["count_after"] += change
    if n < len(document["transitions"]):
        document["transitions"][n]["count_before"] += change
    return "another number of cusps in an interval"


OF_CENSUSES: tuple[Mutation, ...] = (
    moved_transition,
    digit_of_an_event,
    missing_transition,
    other_kind,
    other_interval_count,
    other_geometry,
)


def other_verdict(_draw: random.Random, document: Document) -> str:
    """The other verdict."""
    document["passed"] = not document["passed"]
    return "the other verdict"


def other_report_count(draw: random.Random, document: Document) -> str:
    """Another number of cusps in an interval that is no violation, and is none then."""
    rows = document["intervals"]
    n = draw.randrange(len(rows))
    for row in (rows[n], *(v for v in document["violations"] if v["from"] == rows[n]["from"])):
        row["count"] += 1
    return "another number of cusps in an interval"


def moved_cut(draw: random.Random, document: Document) -> str | None:
    """Another digit of a length between two intervals."""
    rows = document["intervals"]
    if len(rows) < 2:
        return None
    n = draw.randrange(1, len(rows))
    old = rows[n]["from"]
    new = other_digit(draw, old)
    for row in (*rows, *document["violations"]):
        for end in ("from", "to"):
            row[end] = new if row[end] == old else row[end]
    return "a moved cut"


def digit_of_an_example(draw: random.Random, document: Document) -> str | None:
    """One digit of a cusp of an example."""
    cusps = [cusp for row in document["violations"] for cusp in row["example"]["cusps"]]
    if not cusps:
        return None
    cusp = draw.choice(cusps)
    name = _change_a_digit(draw, cusp)
    return f"a digit of {name} of an example"


OF_REPORTS: tuple[Mutation, ...] = (
    other_verdict,
    other_report_count,
    moved_cut,
    digit_of_an_example,
    other_geometry,
)


def _curve(draw: random.Random, document: Document) -> Document | None:
    curves = [curve for curve in document["curves"] if curve["points"]]
    return draw.choice(curves) if curves else None


def digit_of_a_curve(draw: random.Random, document: Document) -> str | None:
    """One digit of one coordinate of a point of a curve."""
    if (curve := _curve(draw, document)) is None:
        return None
    point = draw.choice(curve["points"])
    name = draw.choice(
        [x for x in COORDINATES if x in point and point[x] != "0" and x != f"l{document['fixed_leg']}"]
    )
    point[name] = other_digit(draw, point[name])
    return f"a digit of {name} of a curve"


def doubled_curve(draw: random.Random, document: Document) -> str | None:
    """A curve twice, by another name."""
    if (curve := _curve(draw, document)) is None:
        return None
    document["curves"].append(curve | {"name": f"C{len(document['curves']) + 1}"})
    return "a doubled curve"


def missing_curve(draw: random.Random, document: Document) -> str | None:
    """A curve left out, and the cusps numbered anew."""
    if (curve := _curve(draw, document)) is None:
        return None
    document["curves"].remove(curve)
    length = f"l{document['fixed_leg']}"
    lost = {point[length]: point["cusp"] for point in curve["points"]}
    for other in document["curves"]:
        for point in other["points"]:
            point["cusp"] -= point["cusp"] > lost.get(point[length], 99)
    return "a missing curve"


def moved_end(draw: random.Random, document: Document) -> str | None:
    """Another digit of the length at which a curve begins."""
    curves = [curve for curve in document["curves"] if curve["from"]["events"]]
    if not curves:
        return None
    end, name = draw.choice(curves)["from"], f"l{document['fixed_leg']}"
    end[name] = other_digit(draw, end[name])
    return "a moved end"


def other_number(draw: random.Random, document: Document) -> str | None:
    """Another number of a cusp."""
    if (curve := _curve(draw, document)) is None:
        return None
    draw.choice(curve["points"])["cusp"] += 1
    return "another number of a cusp"


OF_CURVES: tuple[Mutation, ...] = (
    digit_of_a_curve,
    doubled_curve,
    missing_curve,
    moved_end,
    other_number,
    other_geometry,
)


def _scaled(document: Document, factor: Fraction) -> None:
    """The radii of a margin in another unit: weights, and the tolerance, so many times as great."""
    for names in (document["weights"], document["asked"].get("tolerance", {})):
        for name in names:
            names[name] = exact_str(Fraction(names[name]) * factor)
    exact = validity(Manipulator(**document["geometry"]), [Fraction(x) for x in document["weights"].values()])
    document["validity"] = None if exact is None else exact_str(rounded_down(exact, 6))


def wider_margin(_draw: random.Random, document: Document) -> str | None:
    """A radius that is proved beyond three times the first-order one, and no counter-example."""
    first, proved = document["first_order"], document["proved"]
    if proved in (None, "0") or first is None:
        return None
    factor = Fraction(math.ceil(3 * Fraction(first["radius"]) / Fraction(proved)) + 1)
    document["counterexample"] = None
    _scaled(document, factor)
    return "a wider margin"


def refuted_as_proved(_draw: random.Random, document: Document) -> str | None:
    """A radius that is proved beyond a counter-example, which is left out."""
    example = document["counterexample"]
    if example is None:
        return None
    document["counterexample"] = None
    if document["verdict"] is None:
        document["proved"] = exact_str(Fraction(example["radius"]) * Fraction(101, 100))
    else:
        document.update(proved="1", verdict="proved")
    return "a refuted margin as a proved one"


def missing_part(draw: random.Random, document: Document) -> str | None:
    """A part of a proof left out; a cut as well could leave a coarser proof of the same."""
    full = document["certificate"].get("full")
    if not full:
        return None
    n = draw.randrange(len(full["cuts"]))
    place = draw.choice([k for k, sign in enumerate(full["cuts"][n]) if sign == "."])
    full["cuts"][n] = full["cuts"][n][:place] + full["cuts"][n][place + 1 :]
    return "a missing part"


def parts_as_one(draw: random.Random, document: Document) -> str | None:
    """A proof that does not cut the torus."""
    full = document["certificate"].get("full")
    if not full:
        return None
    full["cuts"][draw.randrange(len(full["cuts"]))] = "0.."
    return "parts as one"


def other_margin_count(draw: random.Random, document: Document) -> str | None:
    """Another number of cusps."""
    if document["count"] is None:
        return None
    document["count"] += draw.choice([-2, 2]) if document["count"] > 1 else 2
    return "another number of cusps of a margin"


def other_example_count(_draw: random.Random, document: Document) -> str | None:
    """A counter-example with a number of cusps that is neither its own nor that of the margin."""
    example = document["counterexample"]
    if example is None or example["count"] is None:
        return None
    example["count"] = 24 if document["count"] != 24 else 22
    return "another number of cusps of a counter-example"


def moved_example(draw: random.Random, document: Document) -> str | None:
    """A counter-example at another distance than it says."""
    example = document["counterexample"]
    if example is None:
        return None
    name = draw.choice([g for g in ("a2x", "a3y", "d1") if document["weights"][g] != "0"] or ["d2"])
    away = Fraction(example["radius"]) * Fraction(document["weights"][name]) + 1
    example["geometry"][name] = exact_str(Fraction(document["geometry"][name]) + away)
    return "a moved counter-example"


def other_validity(_draw: random.Random, document: Document) -> str:
    """Another radius from which on geometries may be flat."""
    validity = document["validity"]
    document["validity"] = "1" if validity in (None, "0") else exact_str(Fraction(validity) * 2)
    return "another validity"


OF_MARGINS: tuple[Mutation, ...] = (
    wider_margin,
    missing_part,
    other_margin_count,
    refuted_as_proved,
    parts_as_one,
    other_example_count,
    moved_example,
    other_validity,
)


def mutated(
    document: Document, mutations: tuple[Mutation, ...], count: int, seed: int
) -> Iterator[tuple[str, Document]]:
    """Yields ``count`` mutations of a document, of each kind in turn, with what was done."""
    draw = random.Random(seed)
    for n in range(count):
        wrong = deepcopy(document)
        done = mutations[n % len(mutations)](draw, wrong)
        if done is not None:
            yield done, wrong


def _chain(draw: random.Random, document: Document) -> Document:
    return draw.choice(document["certificate"]["full"]["chains"])


def digit_of_a_tube(draw: random.Random, document: Document) -> str:
    """Another leading digit of the origin of a tube."""
    tube = draw.choice(_chain(draw, document)["tubes"])
    pair = tube[draw.choice(["half_alpha", "half_theta"])]
    n = draw.randrange(2)
    first = next(i for i, c in enumerate(pair[n]) if c.isdigit())
    digit = draw.choice([d for d in "123456789" if d != pair[n][first]])
    pair[n] = pair[n][:first] + digit + pair[n][first + 1 :]
    return "a moved tube"


def narrow_tube(draw: random.Random, document: Document) -> str:
    """A tube with radii that are not proved."""
    tube = draw.choice(_chain(draw, document)["tubes"])
    tube["radii"] = ["1e-60", "1e-60"]
    return "a narrow tube"


def missing_tube(draw: random.Random, document: Document) -> str | None:
    """A tube left out of the middle of a chain."""
    tubes = _chain(draw, document)["tubes"]
    if len(tubes) < 5:
        return None
    del tubes[len(tubes) // 2 - 1 : len(tubes) // 2 + 1]
    return "missing tubes"


def exchanged_tubes(draw: random.Random, document: Document) -> str | None:
    """The tubes of two chains exchanged."""
    chains = document["certificate"]["full"]["chains"]
    if len(chains) < 2:
        return None
    first, second = draw.sample(chains, 2)
    first["tubes"], second["tubes"] = second["tubes"], first["tubes"]
    return "exchanged tubes"


def missing_chain(draw: random.Random, document: Document) -> str:
    """A chain left out."""
    chains = document["certificate"]["full"]["chains"]
    chains.remove(draw.choice(chains))
    return "a missing chain"


def other_end(draw: random.Random, document: Document) -> str | None:
    """A chain past an end that is said to lead to another curve."""
    pairs = [
        (chain["from"], chain["to"])
        for chain in document["certificate"]["full"]["chains"]
        if chain["from"]["curve"] != chain["to"]["curve"]
    ]
    others = [curve["name"] for curve in document["curves"]]
    if not pairs or len(others) < 3:
        return None
    start, stop = draw.choice(pairs)
    stop["curve"] = draw.choice([name for name in others if name not in (start["curve"], stop["curve"])])
    return "another end"


OF_CHAINS: tuple[Mutation, ...] = (
    digit_of_a_tube,
    narrow_tube,
    missing_tube,
    exchanged_tubes,
    missing_chain,
    other_end,
)
"""Of curves with a full certificate."""
