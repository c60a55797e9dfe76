"""Forgeries of paths, and of documents that say there is none, for the random forger."""

from __future__ import annotations

import random
from collections.abc import Sequence
from copy import deepcopy
from fractions import Fraction

from mpmath import mp, mpf, nstr

from rpr_solver import exact_str
from rpr_solver.exact.decimals import round_fraction
from tests.rpr_solver.verify.forging import Document, Forge, Forged, digit, leading_digit
from tests.support.replay import DIGITS, Place, Replay

ENDS = ("from", "to")
_LEGS = ("l1", "l2", "l3")
_LOOKED_AT, _MOST_DIGITS = 200, 30


def is_found(document: Document) -> bool:
    """Whether there is a path."""
    return "obstacle" not in document


def _fixed(document: Document) -> str:
    return f"l{document['fixed_leg']}"


def theta_of(document: Document) -> str:
    """The name of the fixed leg's angle."""
    return f"theta{document['fixed_leg']}_deg"


def lengths_of(document: Document, end: str) -> Document:
    """What has the leg lengths of an end."""
    return document[end] if "l1" in document[end] else document


def fraction_of(x: mpf) -> Fraction:
    """A number, exact to its last digits but five."""
    with mp.workdps(DIGITS):
        return Fraction(nstr(x, DIGITS - 5))


def replay_of(document: Document) -> Replay:
    """The motion.

    Raises:
        IndexError: an earlier change has left none.
    """
    try:
        return Replay.of(document)
    except (ArithmeticError, AssertionError, TypeError, ValueError) as error:
        raise IndexError from error


def _along(document: Document) -> tuple[Replay, list[Place]]:
    """The motion, and points of it from end to end."""
    replay = replay_of(document)
    count = len(document["certificate"]["arcs"])
    return replay, [replay.at(Fraction(count * n, _LOOKED_AT)) for n in range(_LOOKED_AT + 1)]


def end_changed(draw: random.Random, document: Document) -> Forged:
    """Another digit, or number, of an end; a turn more in its sample too; or both ends exchanged."""
    end = draw.choice(ENDS)
    row = document[end]
    match draw.randrange(4):
        case 0:
            if digit(draw, row, "") is None:
                return None
            return "another digit of an end", f"/{end}"
        case 1 if row["pose"] is not None:
            row["pose"] = draw.choice([n for n in range(1, 7) if n != row["pose"]])
            return "another number of a pose", f"/{end}"
        case 2 if is_found(document):
            document["from"], document["to"] = document["to"], document["from"]
            return "ends exchanged", "/"
        case 3 if is_found(document):
            name, turn = draw.choice(["alpha", theta_of(document)[:-4]]), draw.choice([-1, 1])
            document["certificate"]["turns"][end][name] += turn
            sample = document["samples"][0 if end == "from" else -1]
            old = Fraction(sample[f"{name}_deg"])
            sample[f"{name}_deg"] = round_fraction(old + 360 * turn, document["digits"])
            # a path that runs another way to its end keeps its sign, or not
            wrong = end == "from" or _has_both_signs(document)
            return (
                ("another turn of an end", "/certificate/turns" if end == "from" else "/sign")
                if wrong
                else None
            )
        case _:
            return None


def _has_both_signs(document: Document) -> bool:
    replay, points = _along(document)
    values = [replay.determinant(point) for point in points]
    return min(values) < -(10**-6) * max(map(abs, values)) and max(values) > 10**-6 * max(map(abs, values))


def lengths_changed(draw: random.Random, document: Document) -> Forged:
    """Another leg length of an end, or of both; legs exchanged; closed as open, and open as closed."""
    end = draw.choice(ENDS)
    own = lengths_of(document, end)
    match draw.randrange(3):
        case 0:
            name = draw.choice(_LEGS)
            if (changed := leading_digit(draw, own[name])) is None or "/" in own[name]:
                return None
            own[name] = changed
            return "another length of an end", f"/{end}"
        case 1:
            one, two = draw.sample(_LEGS, 2)
            if own[one] == own[two]:
                return None
            own[one], own[two] = own[two], own[one]
            return "lengths of an end exchanged", f"/{end}"
        case _ if is_found(document):
            first, second = ([lengths_of(document, name)[leg] for leg in _LEGS] for name in ENDS)
            if document["closed"] != (first == second):  # it would be true again
                return None
            document["closed"] = not document["closed"]
            if not document["closed"] and "l1" in document:
                if draw.random() < 0.5:
                    document.update(cusp=None, winding=None)
                    document.pop("twins", None)
                lengths = {name: document.pop(name) for name in _LEGS}
                for name in ENDS:
                    document[name].update(lengths)
            return "closed as open, or open as closed", "/closed"
        case _:
            return None


def sign_changed(_draw: random.Random, document: Document) -> Forged:
    """The other sign of J, in all samples too."""
    if not is_found(document):
        return None
    document["sign"] = -document["sign"]
    for sample in document["samples"]:
        text = sample["determinant"]
        sample["determinant"] = text[1:] if text.startswith("-") else f"-{text}"
    return "the other sign", "/sign"


def arcs_changed(draw: random.Random, document: Document) -> Forged:
    """Arcs through a singularity: straight, round a turn, or one control moved; samples made anew."""
    if not is_found(document) or document["digits"] > _MOST_DIGITS:
        return None
    certificate, theta = document["certificate"], theta_of(document)
    before, kept = document["samples"][0], deepcopy(certificate)
    match draw.randrange(3):
        case 0:
            certificate["arcs"] = [["from", "to"]]
        case 1:
            certificate["turns"]["to"][draw.choice(["alpha", theta[:-4]])] += draw.choice([-1, 1])
        case _:
            arcs = certificate["arcs"]
            n, k = draw.choice([(n, k) for n, arc in enumerate(arcs) for k in range(len(arc) - 1)])
            if isinstance(arcs[n][k], str):
                return None
            moved = dict(arcs[n][k])
            name = draw.choice(["alpha_deg", theta])
            moved[name] = exact_str(Fraction(moved[name]) + draw.randint(-90, 90))
            arcs[n][k] = moved
            if k == 0:
                arcs[n - 1][-1] = moved
    replay, points = _along(document)
    values = [replay.determinant(point) for point in points]
    greatest = max(map(abs, values))
    if min(values) > -greatest / 10**6 or max(values) < greatest / 10**6:
        document["certificate"] = kept  # another true path, for which an earlier change may not be false
        return None
    certificate["least_determinant"] = round_fraction(Fraction(1, 10**9), 6)
    turned = -1 if (values[0] > 0) != (Fraction(before["determinant"]) > 0) else 1
    last = len(document["samples"]) - 1
    for n, sample in enumerate(document["samples"]):
        place = Fraction(len(certificate["arcs"]) * n, last)
        at = replay.at(place)
        numbers = dict(zip(("alpha_deg", theta, *_LEGS), (*at[:2], *replay.legs(at)), strict=True))
        numbers["determinant"] = turned * replay.determinant(at)
        for name, x in numbers.items():
            sample[name] = round_fraction(fraction_of(x), document["digits"])
        sample.update(place=exact_str(place), clearance_deg=round_fraction(Fraction(1, 10**9), 6))
    return "arcs through a singularity", "/sign"


def bound_changed(_draw: random.Random, document: Document) -> Forged:
    """A least determinant that a point between the samples has not."""
    if not is_found(document):
        return None
    replay, points = _along(document)
    least = min(fraction_of(abs(replay.determinant(point))) for point in points)
    certificate = document["certificate"]
    if not least:
        return None
    certificate["least_determinant"] = round_fraction(least * Fraction(1001, 1000), 6)
    return "a greater least determinant", "/certificate/least_determinant"


def range_changed(draw: random.Random, document: Document) -> Forged:
    """A range of the fixed leg, or a joint limit, that a point between the samples has not; or no range."""
    if not is_found(document):
        return None
    replay, points = _along(document)
    name = draw.choice(_LEGS)
    reached = [fraction_of(replay.legs(point)[int(name[1]) - 1]) for point in points]
    low, high = min(reached), max(reached)
    if high - low < high / 10**6:
        return None
    inner = (high - low) / draw.choice([3, 10, 1000])
    low, high = (x.limit_denominator(10**12) for x in (low + inner, high - inner))
    if low > high:
        return None
    if document["between"] is not None and draw.random() < 0.5:
        if name != _fixed(document):
            return None
        side = draw.choice(["from", "to", None])
        if side is None:
            document["between"] = None
        else:
            document["between"][side] = exact_str(low if side == "from" else high)
        return "a narrower range, or none", "/between"
    limits = document["limits"] = document["limits"] or {}
    limit = limits.setdefault(name, {"min": None, "max": None})
    side = draw.choice(["min", "max"])
    limit[side] = exact_str(low if side == "min" else high)
    return "a limit that is exceeded", f"/limits/{name}"


def winding_changed(draw: random.Random, document: Document) -> Forged:
    """Another winding, another cusp, a twin more or less, or a loop round a cusp where there is none."""
    if not is_found(document):
        return None
    if document["cusp"] is None:
        document.update(cusp=draw.randint(1, 6), winding=draw.choice([-1, 1, 2]))
        return "a path as a loop round a cusp", "/winding"
    own = {document["cusp"], *document.get("twins", ())}
    other = draw.choice([n for n in range(1, 13) if n not in own])
    match draw.randrange(4):
        case 0:
            document["winding"] += draw.choice([-2, -1, 1])
        case 1:
            document["cusp"] = other
        case 2:
            document["twins"] = sorted([*document.get("twins", ()), other])
        case _ if document.get("twins"):
            document["twins"].pop()
            if not document["twins"]:
                del document["twins"]
        case _:
            return None
    return "another winding", "/winding"


def samples_changed(draw: random.Random, document: Document) -> Forged:
    """A sample with another digit, time or place, in the place of another, or in another turn."""
    if not is_found(document):
        return None
    samples = document["samples"]
    n = draw.randrange(len(samples))
    sample = samples[n]
    match draw.randrange(6):
        case 0:
            if digit(draw, {k: v for k, v in sample.items() if k not in ("time", "place")}, "") is None:
                return None
            names = [k for k in sample if k not in ("time", "place", "clearance_deg") and sample[k] != "0"]
            name = draw.choice(names)
            row = {name: sample[name]}
            if digit(draw, row, "") is None:
                return None
            sample.update(row)
        case 1:
            if "deviation" in document and "motion" not in document:
                return None  # without a law of time such times need only ascend
            sample["time"] = exact_str(Fraction(sample["time"]) + Fraction(draw.choice([-1, 1]), 10**6))
            if sample["time"].startswith("-"):
                return None
        case 2:
            if not 0 < n < len(samples) - 1:
                return None
            other = draw.choice([k for k in range(len(samples)) if k != n])
            own = {k: sample[k] for k in ("time", "place")}
            if all(samples[other][k] == sample[k] for k in sample if k not in own):
                return None
            samples[n] = {**samples[other], **own}
        case 3:
            names = ["alpha_deg", theta_of(document)]
            name = draw.choice(names)
            moved = Fraction(sample[name]) + draw.choice([-360, 360])
            sample[name] = round_fraction(moved, document["digits"])
        case 4:
            text = sample["determinant"]
            sample["determinant"] = text[1:] if text.startswith("-") else f"-{text}"
        case _:
            if n in (0, len(samples) - 1) and draw.random() < 0.5:
                samples[n] = deepcopy(samples[1 if n == 0 else -2])
                return "an end without its sample", "/samples"
            sample["place"] = exact_str(Fraction(sample["place"]) + Fraction(1, 1000))
    return "another sample", "/samples"


def clearance_changed(draw: random.Random, document: Document) -> Forged:
    """A sample's clearance within which J has the other sign."""
    if not is_found(document):
        return None
    replay = replay_of(document)
    sample = draw.choice(document["samples"])
    at = replay.at(Fraction(sample["place"]))
    own = replay.determinant(at)
    reach = Fraction(sample["clearance_deg"])
    for _ in range(40):
        reach *= Fraction(6, 5)
        for k in range(24):
            step = mp.expj(2 * mp.pi * k / 24) * (mpf(reach.numerator) / reach.denominator)
            if replay.determinant((at[0] + step.real, at[1] + step.imag, at[2])) * own < 0:
                sample["clearance_deg"] = round_fraction(reach * Fraction(101, 100), 6)
                return "a greater clearance of a sample", "/samples"
        if reach > 180:
            break
    return None


def _keeps_limits(document: Document) -> bool:
    """Whether both ends are within the limits."""
    return all(
        (limit["min"] is None or Fraction(limit["min"]) <= length)
        and (limit["max"] is None or length <= Fraction(limit["max"]))
        for name, limit in (document["limits"] or {}).items()
        for length in (Fraction(lengths_of(document, end)[name]) for end in ENDS)
    )


def obstacle_claimed(draw: random.Random, document: Document) -> Forged:
    """No path though there is one; or another reason why there is none."""
    obstacle = draw.choice(["opposite-signs", "outside-limits", *["other-aspect"] * is_found(document)])
    if obstacle == "outside-limits" and not _keeps_limits(document):
        return None  # an earlier change has made this true
    if is_found(document):
        kept = {name: document[name] for name in _LEGS if name in document}
        names = ("geometry", "geometry_hash", "fixed_leg", "digits", "solver_version", "between", "limits")
        common = {name: document[name] for name in (*names, *ENDS)}
        limits = document["limits"]
        if obstacle == "outside-limits" and draw.random() < 0.5 and limits is None:
            length = Fraction(lengths_of(document, "from")["l1"])
            common["limits"] = {"l1": {"min": exact_str(length * Fraction(1, 2)), "max": None}}
            if Fraction(lengths_of(document, "to")["l1"]) < length * Fraction(1, 2):
                return None
        document.clear()
        document.update(common, **kept, connected=False, obstacle=obstacle)
        document.update(connecting_range=None, resolution=None, samples=[])
        return "no path, though there is one", "/obstacle"
    if document["obstacle"] == obstacle or document["obstacle"] in ("opposite-signs", "outside-limits"):
        return None
    document.update(obstacle=obstacle, connected=False)
    return "another obstacle", "/obstacle"


FORGES: Sequence[Forge] = (
    end_changed,
    lengths_changed,
    sign_changed,
    arcs_changed,
    arcs_changed,
    bound_changed,
    range_changed,
    winding_changed,
    samples_changed,
    samples_changed,
    clearance_changed,
    obstacle_claimed,
)
