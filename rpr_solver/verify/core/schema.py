"""The closed schema of each kind of document: all members, their types and domains."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from rpr_solver.contract import MAX_DIGITS, MIN_DIGITS, MOST_CUSPS, MOST_POSES
from rpr_solver.verify.core.members import POSE_KINDS, RANGE, Leg, either, is_kind, path, singular_curves
from rpr_solver.verify.core.numbers import (
    LENGTHS,
    MOST_DIGITS,
    POSITIVE,
    Geometry,
    exact,
    exact_within,
    integer,
    polynomial,
    short,
    short_positive,
    square_of,
)
from rpr_solver.verify.core.reader import (
    Read,
    Record,
    count,
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

LENGTH_KINDS = ("several", "unclassified", "undecided", "open")
SYSTEMS = {"swallowtails": 32, "critical poses": 18}
"""Name → the degree of its eliminant; beside shared angles it is another."""
BESIDE = "beside shared angles"
_NAME = text("C[1-9][0-9]{0,5}")
_MOST_DEGREE, _MOST_CUTS = 200, 10_000_000


@dataclass(frozen=True)
class Document:
    """A document as it was read.

    Attributes:
        kind: such as ``"cusp-table"``.
        geometry: the manipulator.
        fixed: the fixed leg; 1 for poses, which have none.
        members: all members, frozen.
    """

    kind: str
    geometry: Geometry
    fixed: int
    members: Record


def kind_of(value: Mapping[str, Any]) -> str:
    """The kind of a document that can be verified.

    Raises:
        InputError: it is none.
    """
    if not isinstance(value, Mapping):
        raise refusal("", "is not an object")
    kind = next((kind for kind, (member, _) in _KINDS.items() if member in value), None)
    if kind is None:
        other = next((f", {name}," for member, name in _OTHERS.items() if member in value), "")
        known = ", ".join(_KINDS)
        raise refusal("", f"is{other} of no kind that can be verified; known are {known}")
    return kind


def read_document(value: Mapping[str, Any]) -> Document:
    """Reads a document.

    Raises:
        InputError: naming a member that is not as documents have it.
    """
    kind = kind_of(value)
    geometry = Geometry.read(value.get("geometry"), "/geometry")
    digits = count(MIN_DIGITS, MAX_DIGITS)(value.get("digits"), "/digits")
    place: Any = value if kind != "check" else value.get("requirement")
    leg = place.get("fixed_leg") if isinstance(place, Mapping) else None
    at = "/fixed_leg" if kind != "check" else "/requirement/fixed_leg"
    fixed = 1 if kind == "poses" else count(1, 3)(leg, at)
    _, schema = _KINDS[kind]
    return Document(kind, geometry, fixed, schema(Leg(fixed, digits))(value, ""))


def _table(leg: Leg) -> Read:
    factor = record({"degree": count(1, 96), "multiplicity": count(1, 96), "origin": text()})
    theta = f"u = tan(theta{leg.fixed}/2)"
    side = record({"centre": text(most=3 * MOST_DIGITS), "radius": text()})
    full = record(
        {
            "polynomial": polynomial(theta, 24, 24),
            "squarefree": _PRIME,
            "real_roots": rows(_ISOLATED, 0, 24),
            "boxes": rows(record(dict.fromkeys(leg.point, side)), 0, MOST_CUSPS),
        }
    )
    certificate: dict[str, Read] = {
        "eliminant_degree": count(0, 96),
        "real_roots": count(0, 24),
        "factors": rows(factor, 0, 100),
        "method": told(text()),
    }
    of_article: dict[str, Read] = dict.fromkeys(certificate, unread)
    of_article["method"] = told(word("article"))
    curve = record({"kind": word("curve"), "equation": text()})
    answer: dict[str, Read] = {
        leg.length: POSITIVE,
        "count": count(0, MOST_CUSPS),
        "cusps": rows(record(leg.point), 0, MOST_CUSPS),
        "degenerate_points": rows(either(is_kind("curve"), curve, leg.event), 0, 200),
    }
    solved = record(answer, {"certificate": record(certificate, {"full": full})})
    article: dict[str, Read] = {"method": told(word("article")), "audit": unread}
    audited = record({**answer, **article}, {"certificate": record(of_article)})
    error = record({"type": text(), "detail": text(most=20_000)})
    failed = record({leg.length: exact, "error": error})
    answered = either(lambda value: "method" in value, audited, solved)
    part = either(lambda value: "error" in value, failed, answered)
    return record({**leg.on_leg, "slices": rows(part)}, {"method": told(word("article"))})


_PRIME = nothing_or(record({"prime": integer, "omega": integer}))
_ISOLATED = record({"lower": exact, "upper": exact, "multiplicity": count(1, _MOST_DEGREE)})


def _poses(leg: Leg) -> Read:
    angles = ("alpha_deg", "theta1_deg", "theta2_deg", "theta3_deg")
    pose = record(
        {
            **dict.fromkeys(angles, leg.angle),
            **dict.fromkeys(("b1_x", "b1_y"), leg.number),
            "multiplicity": count(1, MOST_POSES),
        }
    )
    factor = record({"degree": count(1, MOST_POSES), "multiplicity": count(1, MOST_POSES)})
    certificate = record(
        {
            "method": told(text()),
            "factors": rows(factor, 0, MOST_POSES),
        }
    )
    curve = record({"kind": word("curve"), "alpha_deg": word("0", "180"), "description": told(text())})
    return record(
        {
            **leg.head,
            **dict.fromkeys(("l1", "l2", "l3"), square_of),
            "count": count(0, MOST_POSES),
            "count_with_multiplicity": count(0, MOST_POSES),
            "poses": rows(pose, 0, MOST_POSES),
            "curves": rows(curve, 0, 2),
            "polynomial": polynomial("t = tan(alpha/2)", MOST_POSES, MOST_POSES),
            "certificate": certificate,
        }
    )


def _census(leg: Leg) -> Read:
    event = record(leg.degenerate_point, {"sensitivity": unread, "singular": unread})
    transition = record(
        {
            leg.length: leg.positive,
            "kind": word("several", "unclassified", *POSE_KINDS),
            "count_before": count(0, MOST_CUSPS),
            "count_after": count(0, MOST_CUSPS),
            "events": rows(event, 0, 200),
        },
        {"from": unread, "to": unread},
    )
    interval = record(
        {"from": text(), "to": nothing_or(text()), "count": count(0, MOST_CUSPS)},
        {"aspects": nothing_or(count(0, 1000))},
    )
    box = record({"kind": word(*POSE_KINDS), **leg.box(leg.length, "alpha_deg", leg.theta)})
    full = record(
        {
            "systems": rows(_system(leg.fixed), 0, 10),
            "events": rows(box, 0, 1000),
            "samples": rows(POSITIVE, 1, 1001),
        }
    )
    certificate = record(
        {
            "method": told(word("events", "components")),
            "lengths_examined": told(count()),
            "counts_by": told(text()),
        },
        {"full": full, "boxes": told(count())},
    )
    return record(
        {
            **leg.on_leg,
            "range": RANGE,
            "transitions": rows(transition, 0, 1000),
            "intervals": rows(interval, 1, 1001),
            "certificate": certificate,
        },
        {"degenerate": leg.degenerate, "tolerance": unread, "complete": unread, "open": unread},
    )


def _system(fixed: int) -> Read:
    # beside shared angles the degree is another one than in general
    return record(
        {
            "name": word(*SYSTEMS, BESIDE),
            "polynomial": polynomial(f"v = tan(theta{fixed})", 0, _MOST_DEGREE),
            "squarefree": _PRIME,
            "real_roots": rows(_ISOLATED, 0, _MOST_DEGREE),
        }
    )


def _curves(leg: Leg) -> Read:
    end = {
        "kind": word(*POSE_KINDS, *LENGTH_KINDS),
        "joins": nothing_or(_NAME),
        "events": rows(leg.event, 0, 200),
    }
    point = record({leg.length: POSITIVE, "cusp": count(1, MOST_CUSPS), **leg.point})
    curve = record(
        {
            "name": _NAME,
            "from": record({leg.length: leg.start, **end}),
            "to": record({leg.length: nothing_or(leg.start), **end}),
            "points": rows(point),
        }
    )
    place = record({"curve": _NAME, leg.length: POSITIVE})
    pair, whole = rows(short, 2, 2), rows(integer, 2, 2)
    radii = rows(short_positive, 2, 2)
    tube = record(
        {
            "parameter": word("alpha", "theta", leg.length),
            "leg": count(1, 3),
            "half_alpha": whole,
            "half_theta": whole,
            leg.length: short_positive,
            "slopes": pair,
            "bends": pair,
            "reach": short_positive,
            "radii": radii,
        }
    )
    chain = record({"from": place, "to": place, "tubes": rows(tube, 1)})
    full = record({"chains": rows(chain)})
    return record(
        {**leg.on_leg, "range": RANGE, "curves": rows(curve, 0, 1000)},
        {"degenerate": leg.degenerate, "certificate": record({"full": full})},
    )


def _requirement(leg: Leg) -> Read:
    limit = nothing_or(exact_within(0, ends=True))
    limits = record({}, dict.fromkeys(leg.free, record({"min": limit, "max": limit})))
    return record(
        {
            "fixed_leg": count(leg.fixed, leg.fixed),
            "range": RANGE,
            "max_cusps": nothing_or(count()),
            "min_cusps": nothing_or(count()),
            "degenerate": word("allowed", "refused"),
        },
        {"limits": nothing_or(limits), "mode_change": _of_modes},
    )


def _of_modes(_value: object, at: str) -> Any:
    """A change of assembly mode, which no claim of a report is verified with."""
    raise refusal(at, "is not verified: verify the path of its witness, and a report without it")


def _check(leg: Leg) -> Read:
    interval: dict[str, Read] = {
        "from": text(),
        "to": nothing_or(text()),
        "count": count(0, MOST_CUSPS),
    }
    of_margin = ("tolerance", "reason", "validity", "first_order", "counterexample", "certificate")
    margin = record({"verdict": word("proved", "refuted", "open"), **dict.fromkeys(of_margin, unread)})
    cusps = rows(record(leg.point), 0, MOST_CUSPS)
    example = record({leg.length: POSITIVE, "cusps": cusps})
    return record(
        {
            **leg.head,
            "requirement": _requirement(leg),
            "passed": truth,
            "max_cusps_found": count(0, MOST_CUSPS),
            "min_cusps_found": count(0, MOST_CUSPS),
            "intervals": rows(record(interval), 1, 2000),
            "violations": rows(record({**interval, "example": example}), 0, 2000),
            "degenerate": leg.degenerate,
        },
        {"margin": margin, "mode_change": _of_modes},
    )


def _margin(leg: Leg) -> Read:
    not_negative = exact_within(0, ends=True)
    changes = record(dict.fromkeys(LENGTHS, not_negative))
    asked = {leg.length: POSITIVE, "window": POSITIVE, "requirement": _requirement(leg)}
    cusps = nothing_or(count(0, MOST_CUSPS))
    example = {"radius": POSITIVE, "geometry": Geometry.read, leg.length: nothing_or(POSITIVE)}
    estimate = text(r"-?[0-9.]+(e[+-][0-9]+)?|-?inf|nan", 30)
    mover = {leg.length: estimate, "kind": word("several", "unclassified", *POSE_KINDS)}
    sensitivity = record(dict.fromkeys(LENGTHS, estimate))
    movers = rows(record({**mover, "sensitivity": sensitivity}), 0, 2)
    full = record(
        {"cuts": rows(text("[0-8.]*", _MOST_CUTS), 0, 2)},
        {"turn": POSITIVE, "length": POSITIVE, "rates": record(dict.fromkeys(LENGTHS, exact))},
    )
    certificate: dict[str, Read] = {
        "method": told(text()),
        "boxes": told(count(0, 10**9)),
        "arithmetic": told(text()),
    }
    return record(
        {
            **leg.on_leg,
            "asked": record({}, {**asked, "tolerance": changes}),
            "count": cusps,
            "weights": changes,
            "validity": nothing_or(not_negative),
            "first_order": told(nothing_or(record({"radius": estimate, "binding": movers}))),
            "proved": nothing_or(not_negative),
            "counterexample": nothing_or(record({**example, "count": cusps})),
            "verdict": nothing_or(word("proved", "refuted", "open")),
            "reason": told(nothing_or(text())),
            "certificate": record(certificate, {"full": full}),
        }
    )


_KINDS: Mapping[str, tuple[str, Callable[[Leg], Read]]] = {
    "cusp-table": ("slices", _table),
    "poses": ("poses", _poses),
    "census": ("transitions", _census),
    "cusp-curves": ("curves", _curves),
    "check": ("violations", _check),
    "margin": ("first_order", _margin),
    "singular-curves": ("regions", singular_curves),
    "path": ("samples", path),
}
"""Kind → the member by which it is known, poses having curves too, and its schema."""

_OTHERS: Mapping[str, str] = {
    "aspects": "a document of aspects",
    "checks": "a list of reports of checks",
    "verdict": "a verification",
}
"""A member by which another document is known, and what to call that."""
