"""The closed schema of documents of singular curves, whose samples are floats for drawing."""

from __future__ import annotations

from collections.abc import Mapping

from rpr_solver.contract import MOST_CUSPS, MOST_POSES
from rpr_solver.verify.core.numbers import POSE_KINDS, POSITIVE, Leg, exact
from rpr_solver.verify.core.reader import (
    Read,
    Record,
    count,
    drawn,
    record,
    refusal,
    rows,
    told,
    truth,
    word,
)

_MOST = 100_000


def singular_curves(leg: Leg) -> Read:
    """The document of the singular curves of a slice."""
    angle = f"theta{leg.fixed}"
    names = ("alpha_deg", leg.theta, *leg.free)

    def columns(*names: str) -> Read:
        read = record(dict.fromkeys(names, rows(drawn)))

        def alike(value: object, at: str) -> Record:
            found: Record = read(value, at)
            if len({len(column) for column in found.values()}) > 1:
                raise refusal(at, "has columns of different lengths")
            return found

        return alike

    point = {"index": count(0, _MOST), **leg.degenerate_point}
    cusp = record({**point, **leg.point, "kind": word("cusp"), "cusp": count(1, MOST_CUSPS)})
    other = record({**point, "kind": word("turning", "closed-leg", *POSE_KINDS)})

    def vertex(value: object, at: str) -> Record:
        is_cusp = isinstance(value, Mapping) and value.get("kind") == "cusp"
        return (cusp if is_cusp else other)(value, at)  # type: ignore[no-any-return]

    strand = record(
        {
            "closed": truth,
            "turns": record({"alpha": count(-9, 9), angle: count(-9, 9)}),
            **dict.fromkeys(names, told(rows(drawn, 1))),
            "vertices": rows(vertex, 0, 1000),
        }
    )
    region = record(
        {
            "poses": count(0, MOST_POSES),
            "bounded": truth,
            "point": record(dict.fromkeys(leg.free, POSITIVE)),
            "rings": told(rows(columns(*leg.free))),
        }
    )
    aspect = record(
        {
            "sign": count(-1, 1),
            "share": told(drawn),
            "polygons": told(rows(columns("alpha_deg", leg.theta))),
        }
    )
    return record(
        {
            **leg.on_leg,
            leg.length: POSITIVE,
            "tolerance": told(exact),
            "components": rows(record({"strands": rows(strand, 1, 1000)}), 0, 1000),
            "regions": rows(region, 0, 1000),
            "thin_regions": told(count()),
            "aspects": rows(aspect, 0, 1000),
        }
    )
