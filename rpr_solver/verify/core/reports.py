"""The schemas of reports of checks and of margins."""

from __future__ import annotations

from rpr_solver.contract import MOST_CUSPS
from rpr_solver.verify.core.members import POSE_KINDS, RANGE, Leg
from rpr_solver.verify.core.numbers import LENGTHS, POSITIVE, Geometry, exact, exact_within
from rpr_solver.verify.core.reader import (
    Read,
    count,
    nothing_or,
    record,
    rows,
    text,
    told,
    truth,
    unread,
    word,
)

_MOST_CUTS = 10_000_000


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
        {"limits": nothing_or(limits)},
    )


def check(leg: Leg) -> Read:
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
        {"margin": margin},
    )


def margin(leg: Leg) -> Read:
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
        {"cuts": rows(text("[0-8.]*", _MOST_CUTS), 1, 2)},
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
