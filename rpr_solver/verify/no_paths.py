"""Why there is no path between two poses: different signs of J, or different aspects."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from functools import partial

from flint import ctx

from rpr_solver.verify.aspects import Node, are_joined
from rpr_solver.verify.claims import Claim, Open, Refused, demand, open_claim
from rpr_solver.verify.conditioning import Rates
from rpr_solver.verify.equations import Slice
from rpr_solver.verify.numbers import Printed, ball
from rpr_solver.verify.path_ends import ENDS, PIECE_BITS, PathEnds


def obstacle_claims(ends: PathEnds) -> Iterator[Claim]:
    """The claims of a document that says that there is no path, but those of the ends."""
    members = ends.members
    obstacle, joining, clearance = (members.get(x) for x in ("obstacle", "connecting_range", "clearance"))
    says = members["connected"] is (None if obstacle == "undecided" else False)
    yield ends.claim_by("/connected", "null if undecided, and else false", lambda: demand(says, "it is not"))
    claim, proofs = (
        f"there is no path: {obstacle}",
        {
            "opposite-signs": _has_opposite_signs,
            "other-aspect": _is_in_other_aspect,
            "outside-limits": _is_outside,
            "ill-conditioned": _is_ill_conditioned,
        },
    )
    if obstacle in proofs:
        yield ends.claim_by("/obstacle", claim, partial(proofs[obstacle], ends))
    elif obstacle != "undecided":
        yield open_claim("/obstacle", claim, "what limits or a clearance leave of aspects is not verified")
    if joining is not None:
        span = [joining[end] for end in ENDS]
        yield ends.claim_by("/connecting_range", "there is a path in it", partial(_is_joined_in, ends, span))
    if "condition" in members:
        claim = "the condition numbers of the best path that was found"
        yield open_claim("/condition", claim, "this is not verified")
    if clearance is not None:
        yield open_claim("/clearance", "how clear paths may be", "this is not verified")


def _has_opposite_signs(ends: PathEnds) -> str:
    first, second = _own_signs(ends)
    return demand(first != second, "J has one sign at both poses", "J has different signs at both poses")


def _is_in_other_aspect(ends: PathEnds) -> str:
    between = ends.members["between"]
    span = [ends.length(end) if between is None else between[end] for end in ENDS]
    return demand(not _joined(ends, span), "both are in one aspect", "by the sign of J on cells")


def _is_joined_in(ends: PathEnds, span: list[Fraction]) -> str:
    if ends.members["limits"] or ends.members.get("clearance"):
        raise Open("a path within limits or with a clearance is not sought")
    return demand(_joined(ends, span), "both are in different aspects", "by the sign of J on cells")


def _is_outside(ends: PathEnds) -> str:
    for end in ENDS:
        own = ends.lengths(end)
        for name, limit in (ends.members["limits"] or {}).items():
            x = own[name]
            low, high = (x.lower, x.upper) if isinstance(x, Printed) else (x, x)
            above = limit["max"] is not None and low > limit["max"]
            if above or (limit["min"] is not None and high < limit["min"]):
                return "a length of an end is beyond a limit"
    raise Refused("no length of an end is proved to be beyond a limit")


def _is_ill_conditioned(ends: PathEnds) -> str:
    asked = ends.members.get("condition")
    if asked is None or asked["asked"] is None:
        raise Refused("no condition number was asked for")
    for end in ENDS:
        place = ends.place(end)
        length = place[2] * ball(ends.unit)
        rates = Rates(ends.mechanism.geometry, ends.mechanism.fixed, asked["length_scale"])
        if rates.condition(place, length) > ball(asked["asked"]):
            return "that of an end is greater than was asked for"
    raise Refused("no end is proved to have a greater condition number")


def _sign(ends: PathEnds, end: str, length: Fraction) -> int:
    """The sign of J at the angles of an end, for a length of the fixed leg; 0 if it is not decided."""
    with ctx.workprec(PIECE_BITS):
        j = Slice(ends.mechanism, length).on(ends.place(end)[:2], 0).singular.value
    return 0 if j.contains(0) else 1 if j > 0 else -1


def _own_signs(ends: PathEnds) -> list[int]:
    """Those of J at both poses.

    Raises:
        Open: one is not decided.
    """
    signs = [_sign(ends, end, ends.length(end)) for end in ENDS]
    if not all(signs):
        raise Open("the sign of J at a pose is not decided")
    return signs


def _joined(ends: PathEnds, span: list[Fraction]) -> bool:
    """Whether both poses are in one aspect while the fixed leg varies between two lengths."""
    lengths, (sign, other) = sorted(set(span)), _own_signs(ends)
    own = [ends.length(end) for end in ENDS]
    demand(lengths[0] <= min(own) and max(own) <= lengths[-1], "the fixed leg at an end is beyond the range")
    if other != sign:
        return False
    slices = [Slice(ends.mechanism, x) for x in lengths]
    with ctx.workprec(PIECE_BITS):
        first, second = (_node(ends, end, lengths, sign) for end in ENDS)
        return are_joined(slices, sign, first, second, ends.work)


def _node(ends: PathEnds, end: str, lengths: list[Fraction], sign: int) -> Node:
    """A pose in a slice where J has its sign, too: as J / L is linear in L, at an end of the range.

    Raises:
        Open: it is not decided at which.
    """
    layer = next((n for n, x in enumerate(lengths) if _sign(ends, end, x) == sign), None)
    if layer is None:
        raise Open("a pose is not placed in a slice")
    return layer, ends.place(end)[:2]
