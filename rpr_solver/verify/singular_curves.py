"""Singular curves of a slice: cusps and numbers of aspects are found anew, all else is not verified."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from functools import partial

from rpr_solver.contract import COARSEST_TOLERANCE, FINEST_TOLERANCE, MOST_CUSPS, MOST_POSES, Progress
from rpr_solver.verify.aspects import SIGNS, number_of_aspects
from rpr_solver.verify.claims import Claim, claim_by, demand, open_claim
from rpr_solver.verify.equations import Mechanism
from rpr_solver.verify.members import POSE_KINDS, Document, Leg
from rpr_solver.verify.numbers import POSITIVE, Printed, exact_within
from rpr_solver.verify.reader import (
    Read,
    Record,
    count,
    drawn,
    either,
    no_claim,
    record,
    rows,
    truth,
    word,
)
from rpr_solver.verify.tables import Cusps, is_sorted
from rpr_solver.verify.work import Work


def singular_schema(leg: Leg) -> Read:
    """The members of the singular curves of a slice."""
    angles = ("alpha_deg", leg.theta)
    point = {"index": no_claim(count()), **leg.degenerate_point}
    cusp = record({**point, **leg.point, "kind": word("cusp"), "cusp": count(1, MOST_CUSPS)})
    other = record({**point, "kind": word("turning", "closed-leg", *POSE_KINDS)})
    strand = record(
        {
            "closed": truth,
            "turns": record({"alpha": count(-9, 9), leg.theta.removesuffix("_deg"): count(-9, 9)}),
            **dict.fromkeys((*angles, *leg.free), no_claim(rows(drawn))),
            "vertices": rows(either(lambda value: value.get("kind") == "cusp", cusp, other), 0, 1000),
        }
    )
    region = record(
        {
            "poses": count(0, MOST_POSES),
            "bounded": truth,
            "point": record(dict.fromkeys(leg.free, POSITIVE)),
            "rings": no_claim(rows(record(dict.fromkeys(leg.free, rows(drawn))))),
        }
    )
    aspect = record(
        {
            "sign": count(-1, 1),
            "share": no_claim(drawn),
            "polygons": no_claim(rows(record(dict.fromkeys(angles, rows(drawn))))),
        }
    )
    return record(
        {
            **leg.on_leg,
            leg.length: POSITIVE,
            "tolerance": no_claim(exact_within(FINEST_TOLERANCE, COARSEST_TOLERANCE, ends=True)),
            "components": rows(record({"strands": rows(strand, 1, 1000)}), 0, 1000),
            "regions": rows(region, 0, 1000),
            "thin_regions": count(),
            "aspects": rows(aspect, 0, 1000),
        }
    )


def singular_claims(document: Document, work: Work, progress: Progress) -> Iterator[Claim]:
    """The claims of the singular curves of a slice."""
    progress(0, 1)
    strands = [strand for part in document.members["components"] for strand in part["strands"]]
    listed = [vertex for strand in strands for vertex in strand["vertices"] if vertex["kind"] == "cusp"]
    listed.sort(key=lambda vertex: vertex["cusp"])
    numbers = [{name: x for name, x in vertex.items() if isinstance(x, Printed)} for vertex in listed]
    length = document.members[f"l{document.fixed}"]
    cusps = Cusps(Mechanism(document.geometry, document.fixed), length, numbers, work)
    claim = "the cusps on them are all of the slice, with these numbers and digits"
    yield claim_by("/components", claim, partial(_has_cusps, cusps, listed))
    signs = Counter(aspect["sign"] for aspect in document.members["aspects"])
    yield claim_by(
        "/aspects", "the number of aspects of each sign", partial(_has_aspects, cusps, signs, work)
    )
    others = {
        "/components": "strands, their turns, the other points on them, and their order",
        "/regions": "the regions of the joint plane, and their numbers of poses",
        "/thin_regions": "the number of regions without a point",
    }
    for at, what in others.items():
        yield open_claim(at, what, "this is not verified")
    progress(1, 1)


def _has_cusps(cusps: Cusps, listed: list[Record]) -> str:
    demand(
        [vertex["cusp"] for vertex in listed] == list(range(1, len(listed) + 1)),
        "the numbers are not 1, 2, …",
    )
    angles = [vertex[f"theta{cusps.mechanism.fixed}_deg"].value for vertex in listed]
    demand(is_sorted(angles), "the numbers are not in the order of angles")
    for n in range(len(listed)):
        cusps.proved(n)
    return cusps.complete()


def _has_aspects(cusps: Cusps, signs: Counter[int], work: Work) -> str:
    found = number_of_aspects([cusps.slice], work)
    wrong = f"there are {found[1]} with J > 0 and {found[-1]} with J < 0"
    return demand(
        all(signs[s] == found[s] for s in SIGNS) and not signs[0], wrong, "by the sign of J on cells"
    )
