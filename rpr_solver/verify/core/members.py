"""Members that several kinds of documents have, and the closed schemas of those with samples.

Paths: samples and a certificate, or the reason why there is none; singular curves, whose samples are floats
for drawing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rpr_solver.contract import (
    COARSEST_TOLERANCE,
    FINEST_TOLERANCE,
    LEAST_SAMPLES,
    MOST_CUSPS,
    MOST_POSES,
    MOST_SAMPLES,
)
from rpr_solver.verify.core.numbers import POSITIVE, Geometry, decimal, exact, exact_within, short_positive
from rpr_solver.verify.core.reader import (
    Read,
    Record,
    Unread,
    count,
    drawn,
    nothing_or,
    record,
    refusal,
    rows,
    text,
    told,
    truth,
    unread,
    word,
)

_MOST_PLACES = 100_000
_BOUND_DIGITS, _MOST_ARCS, _MOST_CONTROLS = 6, 1000, 8
_MOST_TURNS, _MOST_DEGREES = 9, 3600
_MOST_SPEED, _MOST_TICKS = 10**6, 10_000
_LENGTHS = ("l1", "l2", "l3")
OBSTACLES = (
    "opposite-signs",
    "other-aspect",
    "outside-limits",
    "separated-by-limits",
    "too-narrow",
    "undecided",
)


POSE_KINDS = ("swallowtail", "lips", "beak-to-beak", "isolated-point", "node", "quadruple", "higher")
"""Kinds of degenerate poses."""
RANGE = record({"from": exact_within(0, ends=True), "to": nothing_or(POSITIVE)})
_HASH = text("sha256:[0-9a-f]{64}")


def either(test: Callable[[Record], object], first: Read, second: Read) -> Read:
    """The first reader for objects of which something holds, the second one for all other values."""
    return lambda value, at: (first if isinstance(value, Mapping) and test(value) else second)(value, at)


def is_kind(name: str) -> Callable[[Record], bool]:
    """Whether the member ``kind`` of an object is this."""
    return lambda value: value.get("kind") == name


class Leg:
    """Readers of what depends on the fixed leg and the digits."""

    def __init__(self, fixed: int, digits: int) -> None:
        self.fixed, self.length = fixed, f"l{fixed}"
        self.theta = f"theta{fixed}_deg"
        self.free = tuple(f"l{leg}" for leg in (1, 2, 3) if leg != fixed)
        self.angle = decimal(digits, -180, 180)
        self.positive = decimal(digits, 0, zero=False)
        self.start = decimal(digits, 0)
        self.number = decimal(digits)
        self.head: dict[str, Read] = {
            "geometry": Geometry.read,
            "geometry_hash": _HASH,
            "digits": count(digits, digits),
            "solver_version": told(text(r"[0-9A-Za-z.+-]{1,40}")),
        }
        self.on_leg: dict[str, Read] = {**self.head, "fixed_leg": count(fixed, fixed)}
        self.point: dict[str, Read] = {
            "alpha_deg": self.angle,
            self.theta: self.angle,
            **dict.fromkeys(self.free, self.positive),
        }
        # a leg may be closed at a degenerate pose, never at a cusp
        self.degenerate_point: dict[str, Read] = {
            "kind": word(*POSE_KINDS),
            **self.point,
            **dict.fromkeys(self.free, self.start),
        }
        self.event = record(self.degenerate_point)
        part = {"kind": word("curve", *POSE_KINDS), "from": self.end, "to": nothing_or(self.end)}
        poses = record({**part, "count": count(1)})
        self.degenerate = rows(either(is_kind("curve"), record(part, {"equation": text()}), poses))

    def end(self, value: object, at: str) -> Any:
        """An end of an interval: an exact number, or a decimal of all digits."""
        try:
            return self.positive(value, at)
        except ValueError:
            return exact_within(0, ends=True)(value, at)

    def box(self, *names: str) -> dict[str, Read]:
        """Sides of a box, with a centre and a radius that are exact numbers."""
        side = record({"centre": exact, "radius": short_positive})
        return dict.fromkeys(names, side)


def _asked(value: object, at: str) -> object:
    return value if value == "best" else POSITIVE(value, at)


_NOT_NEGATIVE = exact_within(0, ends=True)


def _clear(of_path: Callable[[Read], Read]) -> dict[str, Read]:
    """The clearance; that of the path itself is not read if the path is not there."""
    own = {
        **dict.fromkeys(("proved", "legs"), of_path(_NOT_NEGATIVE)),
        "radius": of_path(nothing_or(POSITIVE)),
    }
    return {"clearance": record({"asked": _asked, "bound": nothing_or(POSITIVE), **own})}


_OF_LEGS = record({}, dict.fromkeys(_LENGTHS, POSITIVE))
_TIMED: Mapping[str, Read] = {
    "motion": record(
        {"speed": _OF_LEGS, "acceleration": _OF_LEGS, "stops": rows(POSITIVE, 0, _MOST_ARCS)},
        {"jerk": _OF_LEGS},
    ),
    "sampling": record({}, dict.fromkeys(("step", "chord"), POSITIVE)),
    "deviation": record(dict.fromkeys(_LENGTHS, _NOT_NEGATIVE)),
}
_LAW = record(
    {
        "shares": rows(POSITIVE, 1, _MOST_ARCS),
        "tick": POSITIVE,
        "speeds": rows(count(0, _MOST_SPEED), 2, _MOST_TICKS),
        "window": count(1, _MOST_TICKS),
    }
)
"""Of one run of a motion."""


def path(leg: Leg) -> Read:
    """The document of a path, or of why there is none."""
    head = _head(leg)
    found, none = _found(leg, head), _none(head)

    def read(value: object, at: str) -> Record:
        is_none = isinstance(value, Mapping) and "obstacle" in value
        members: Record = (none if is_none else found)(value, at)
        if not is_none and not members["connected"]:
            raise refusal(f"{at}/connected", "is false, but no obstacle is given")
        if not is_none and ("motion" in members) != ("motion" in members["certificate"]):
            raise refusal(f"{at}/certificate/motion", "is there if limits of motion are, and only then")
        if len(members.get("sampling", "1")) != 1:
            raise refusal(f"{at}/sampling", "has either a step or a chord")
        return _with_own_lengths(members, at)

    return read


def _found(leg: Leg, head: Mapping[str, Read]) -> Read:
    bound = decimal(_BOUND_DIGITS, 0, zero=False)
    place = exact_within(0, ends=True)
    numbers = dict.fromkeys(("alpha_deg", leg.theta, "determinant"), leg.number)
    sample = record(
        {
            **dict.fromkeys(("time", "place"), place),
            **dict.fromkeys(_LENGTHS, leg.positive),
            **numbers,
            "clearance_deg": bound,
        }
    )
    turn = count(-_MOST_TURNS, _MOST_TURNS)
    turns = record(dict.fromkeys(("alpha", leg.theta.removesuffix("_deg")), turn))
    certificate = record(
        {
            "arcs": rows(rows(_control(leg), 2, _MOST_CONTROLS), 1, _MOST_ARCS),
            "turns": record({"from": turns, "to": turns}),
            "pieces": told(count(0, 10**9)),
            "least_determinant": bound,
        },
        {"motion": rows(_LAW, 1, _MOST_ARCS)},
    )
    cusp = count(1, MOST_CUSPS)
    members: dict[str, Read] = {
        **head,
        "connected": truth,
        "cusp": nothing_or(cusp),
        "closed": truth,
        "sign": count(-1, 1),
        "winding": nothing_or(count(-1000, 1000)),
        "others": nothing_or(unread),
        "duration": POSITIVE,
        "timing": told(word("cosine", "trapezoid", "constant", "motion")),
        "samples": rows(sample, LEAST_SAMPLES, MOST_SAMPLES),
        "certificate": certificate,
    }
    return record(
        members,
        {
            **dict.fromkeys(_LENGTHS, POSITIVE),
            "twins": rows(cusp, 1, MOST_CUSPS),
            **_clear(lambda x: x),
            **_TIMED,
        },
    )


def _none(head: Mapping[str, Read]) -> Read:
    members: dict[str, Read] = {
        **head,
        "connected": nothing_or(truth),
        "obstacle": word(*OBSTACLES),
        "connecting_range": nothing_or(record({"from": POSITIVE, "to": POSITIVE})),
        "resolution": unread,
        "samples": rows(unread, 0, 0),
    }
    return record(members, {**dict.fromkeys(_LENGTHS, POSITIVE), **_clear(told), "near": unread})


def _head(leg: Leg) -> dict[str, Read]:
    """What both documents have."""
    limit = nothing_or(exact_within(0, ends=True))
    of_leg = record({"min": limit, "max": limit})
    end = {"alpha_deg": leg.angle, leg.theta: leg.angle}
    numbered = record({"pose": count(1, MOST_POSES), **end}, dict.fromkeys(_LENGTHS, POSITIVE))
    own = {leg.length: POSITIVE, **dict.fromkeys(leg.free, leg.positive)}
    given = record({"pose": nothing_or(count(1, 1)), **own, **end})
    pose = either(lambda value: value.get("pose", 0) is None, given, numbered)
    return {
        **leg.on_leg,
        "between": nothing_or(record({"from": POSITIVE, "to": POSITIVE})),
        "limits": nothing_or(record({}, dict.fromkeys(_LENGTHS, of_leg))),
        "from": pose,
        "to": pose,
    }


def _control(leg: Leg) -> Read:
    """A control point of an arc: ``"from"``, ``"to"``, or an exact one."""
    angle = exact_within(-_MOST_DEGREES, _MOST_DEGREES)
    point = record({"alpha_deg": angle, leg.theta: angle, leg.length: POSITIVE})
    end = word("from", "to")

    def read(value: object, at: str) -> object:
        return end(value, at) if isinstance(value, str) else tuple(point(value, at).values())

    return read


def _with_own_lengths(members: Record, at: str) -> Record:
    """The members, if the lengths are either those of the document or of both ends."""
    common = [name in members for name in _LENGTHS]
    for end in ("from", "to"):
        own = [name in members[end] for name in _LENGTHS]
        if any(a == b for a, b in zip(common, own, strict=True)) or len(set(common)) > 1:
            raise refusal(
                f"{at}/{end}", "the lengths are those of both ends, or of the document, not of both"
            )
    return members


def _columns(*names: str) -> Read:
    """Columns of floats, all of one length."""
    read = record(dict.fromkeys(names, rows(drawn)))

    def alike(value: object, at: str) -> Record:
        found: Record = read(value, at)
        if len({len(column) for column in found.values()}) > 1:
            raise refusal(at, "has columns of different lengths")
        return found

    return alike


def singular_curves(leg: Leg) -> Read:
    """The document of the singular curves of a slice."""
    angle = f"theta{leg.fixed}"
    names = ("alpha_deg", leg.theta, *leg.free)
    point = {"index": count(0, _MOST_PLACES), **leg.degenerate_point}
    cusp = record({**point, **leg.point, "kind": word("cusp"), "cusp": count(1, MOST_CUSPS)})
    other = record({**point, "kind": word("turning", "closed-leg", *POSE_KINDS)})

    members_of_strand = record(
        {
            "closed": truth,
            "turns": record({"alpha": count(-9, 9), angle: count(-9, 9)}),
            **dict.fromkeys(names, told(rows(drawn, 1))),
            "vertices": rows(either(is_kind("cusp"), cusp, other), 0, 1000),
        }
    )

    def strand(value: object, at: str) -> Record:
        read: Record = members_of_strand(value, at)
        lengths = {len(value[name]) for name in names}  # type: ignore[index]
        if len(lengths) > 1:
            raise refusal(at, "has columns of different lengths")
        for n, vertex in enumerate(read["vertices"]):
            if vertex["index"] >= max(lengths):
                raise refusal(f"{at}/vertices/{n}/index", "is that of no sample")
        return read

    region = record(
        {
            "poses": count(0, MOST_POSES),
            "bounded": truth,
            "point": record(dict.fromkeys(leg.free, POSITIVE)),
            "rings": told(rows(_columns(*leg.free))),
        }
    )
    aspect = record(
        {
            "sign": count(-1, 1),
            "share": told(drawn),
            "polygons": told(rows(_columns("alpha_deg", leg.theta))),
        }
    )
    members = record(
        {
            **leg.on_leg,
            leg.length: POSITIVE,
            "tolerance": exact_within(FINEST_TOLERANCE, COARSEST_TOLERANCE, ends=True),
            "components": rows(record({"strands": rows(strand, 1, 1000)}), 0, 1000),
            "regions": rows(region, 0, 1000),
            "thin_regions": count(),
            "aspects": rows(aspect, 0, 1000),
        }
    )

    def curves(value: object, at: str) -> Record:
        read: Record = members(value, at)
        return read if read["thin_regions"] else {**read, "tolerance": Unread()}  # it says nothing then

    return curves
