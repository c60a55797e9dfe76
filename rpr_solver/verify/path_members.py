"""The closed schema of the document of a path, or of why there is none."""

from __future__ import annotations

from collections.abc import Mapping

from rpr_solver.contract import LEAST_SAMPLES, LEGS, MOST_CUSPS, MOST_POSES, MOST_SAMPLES
from rpr_solver.verify.conditioning import ALONG
from rpr_solver.verify.members import IN_GIVEN_FRAME, Leg
from rpr_solver.verify.numbers import NOT_NEGATIVE, POSITIVE, exact_within, printed
from rpr_solver.verify.reader import (
    Read,
    Record,
    anything,
    count,
    either,
    no_claim,
    nothing_or,
    record,
    refusal,
    rows,
    truth,
    word,
)

OBSTACLES = (
    "opposite-signs",
    "other-aspect",
    "outside-limits",
    "separated-by-limits",
    "too-narrow",
    "ill-conditioned",
    "undecided",
)
_BOUND_DIGITS, _MOST_ARCS, _MOST_CONTROLS = 6, 1000, 8
_MOST_TURNS, _MOST_DEGREES = 9, 3600
_OF_LEGS = record({}, dict.fromkeys(LEGS, POSITIVE))
_RANGE = record({"from": POSITIVE, "to": POSITIVE})
_CLEARANCE = record(
    {
        "asked": lambda value, at: value if value == "best" else NOT_NEGATIVE(value, at),
        "bound": nothing_or(POSITIVE),
        **dict.fromkeys(("proved", "legs"), NOT_NEGATIVE),
        "radius": nothing_or(POSITIVE),
    }
)
_ASKED: dict[str, Read] = {"clearance": _CLEARANCE, "condition": ALONG}
_LAW = record({**dict.fromkeys(("shares", "speeds"), rows(anything)), "tick": POSITIVE, "window": count(1)})


def path(leg: Leg) -> Read:
    """The document of a path, or of why there is none."""
    head = _head(leg)
    document = either(lambda value: "obstacle" in value, _none(head), _found(leg, head))

    def read(value: object, at: str) -> Record:
        members: Record = document(value, at)
        common = [name in members for name in LEGS]
        for end in ("from", "to"):
            own = [name in members[end] for name in LEGS]
            if any(x == y for x, y in zip(common, own, strict=True)) or len(set(common)) > 1:
                raise refusal(f"{at}/{end}", "lengths are those of the document, or of each end, not of both")
        return members

    return read


def _head(leg: Leg) -> dict[str, Read]:
    """What both documents have."""
    limit = record(dict.fromkeys(("min", "max"), nothing_or(NOT_NEGATIVE)))
    numbered = record({"pose": count(1, MOST_POSES), **leg.angles}, dict.fromkeys(LEGS, POSITIVE))
    own = {leg.length: POSITIVE, **dict.fromkeys(leg.free, leg.positive)}
    given = record({"pose": nothing_or(count(1, 1)), **own, **leg.angles})
    pose = either(lambda value: value.get("pose", 0) is None, given, numbered)
    return {
        **leg.on_leg,
        "between": nothing_or(_RANGE),
        "limits": nothing_or(record({}, dict.fromkeys(LEGS, limit))),
        "from": pose,
        "to": pose,
    }


def _found(leg: Leg, head: Mapping[str, Read]) -> Read:
    bound = printed(_BOUND_DIGITS, 0, zero=False)
    numbers = dict.fromkeys(("alpha_deg", leg.theta, "determinant"), leg.number)
    lengths = dict.fromkeys(LEGS, leg.positive)
    places = dict.fromkeys(("time", "place"), NOT_NEGATIVE)
    sample = record(
        {**places, **lengths, **numbers, "clearance_deg": bound},
        {"condition": leg.positive, **IN_GIVEN_FRAME},
    )
    angles = ("alpha", leg.theta.removesuffix("_deg"))
    turns = record(dict.fromkeys(angles, count(-_MOST_TURNS, _MOST_TURNS)))
    certificate = record(
        {
            "arcs": rows(rows(_control(leg), 2, _MOST_CONTROLS), 1, _MOST_ARCS),
            "turns": record({"from": turns, "to": turns}),
            "pieces": no_claim(count(0, 10**9)),
            "least_determinant": bound,
        },
        {"motion": rows(_LAW, 1, _MOST_ARCS)},
    )
    cusp = count(1, MOST_CUSPS)
    asked: dict[str, Read] = {
        "motion": record(
            {"speed": _OF_LEGS, "acceleration": _OF_LEGS, "stops": rows(POSITIVE)}, {"jerk": _OF_LEGS}
        ),
        "sampling": record({}, dict.fromkeys(("step", "chord"), POSITIVE)),
        "deviation": record(dict.fromkeys(LEGS, NOT_NEGATIVE)),
    }
    members: dict[str, Read] = {
        **head,
        "connected": truth,
        "cusp": nothing_or(cusp),
        "closed": truth,
        "sign": count(-1, 1),
        "winding": nothing_or(count(-1000, 1000)),
        "others": nothing_or(rows(anything)),
        "duration": POSITIVE,
        "timing": word("cosine", "trapezoid", "constant", "motion"),
        "samples": rows(sample, LEAST_SAMPLES, MOST_SAMPLES),
        "certificate": certificate,
    }
    twins = {"twins": rows(cusp, 1, MOST_CUSPS)}
    return record(members, {**dict.fromkeys(LEGS, POSITIVE), **twins, **_ASKED, **asked})


def _none(head: Mapping[str, Read]) -> Read:
    members: dict[str, Read] = {
        **head,
        "connected": nothing_or(truth),
        "obstacle": word(*OBSTACLES),
        "connecting_range": nothing_or(_RANGE),
        "resolution": no_claim(anything),
        "samples": rows(anything, 0, 0),
    }
    return record(members, {**dict.fromkeys(LEGS, POSITIVE), **_ASKED, "near_pose": no_claim(anything)})


def _control(leg: Leg) -> Read:
    """A control point of an arc: ``"from"``, ``"to"``, or an exact one by its numbers."""
    angle = exact_within(-_MOST_DEGREES, _MOST_DEGREES)
    point, end = record({"alpha_deg": angle, leg.theta: angle, leg.length: POSITIVE}), word("from", "to")

    def read(value: object, at: str) -> object:
        return end(value, at) if isinstance(value, str) else tuple(point(value, at).values())

    return read
