"""Members of a document that this verifier does not read, so that nobody believes them verified."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rpr_solver.verify.claims import Claim, ClaimStatus

_HEAD = frozenset({"geometry", "geometry_hash", "solver_version", "digits"})
_LENGTHS = frozenset({"l1", "l2", "l3"})
_POINT = _LENGTHS | {"alpha_deg", "theta1_deg", "theta2_deg", "theta3_deg"}
_EVENT = _POINT | {"kind"}
_END = _LENGTHS | {"kind", "joins", "events"}

_READ: Mapping[str, Mapping[str, frozenset[str]]] = {
    "cusp-table": {
        "": _HEAD | {"fixed_leg", "slices", "method"},
        "slices/*": _LENGTHS | {"count", "cusps", "degenerate_points", "certificate", "method", "error"},
        "slices/*/cusps/*": _POINT,
        "slices/*/degenerate_points/*": _EVENT | {"equation"},
        "slices/*/certificate": frozenset({"eliminant_degree", "real_roots", "factors", "method", "full"}),
    },
    "poses": {
        "": _HEAD
        | _LENGTHS
        | {"count", "count_with_multiplicity", "poses", "curves", "polynomial", "certificate"},
        "poses/*": _POINT | {"b1_x", "b1_y", "multiplicity"},
        "certificate": frozenset({"factors"}),
    },
    "census": {
        "": _HEAD | {"fixed_leg", "range", "transitions", "intervals", "degenerate", "certificate"},
        "transitions/*": _LENGTHS | {"kind", "events", "count_before", "count_after"},
        "transitions/*/events/*": _EVENT,
        "intervals/*": frozenset({"from", "to", "count", "aspects"}),
        "certificate": frozenset({"full"}),
    },
    "cusp-curves": {
        "": _HEAD | {"fixed_leg", "curves", "certificate"},
        "curves/*": frozenset({"name", "from", "to", "points"}),
        "curves/*/from": _END,
        "curves/*/to": _END,
        "curves/*/points/*": _POINT | {"cusp"},
        "certificate": frozenset({"full"}),
    },
    "check": {
        "": _HEAD
        | {"requirement", "passed", "max_cusps_found", "min_cusps_found"}
        | {"intervals", "violations", "degenerate"},
        "requirement": frozenset({"fixed_leg", "range", "max_cusps", "min_cusps", "limits", "degenerate"}),
        "intervals/*": frozenset({"from", "to", "count"}),
        "violations/*": frozenset({"from", "to", "count", "example"}),
        "violations/*/example": _LENGTHS | {"cusps"},
        "violations/*/example/cusps/*": _POINT,
    },
}
"""Kind → an object of the document → its members that are read, or named by a claim of their own.

What is in other objects is read as a whole.
"""


def unread_claims(kind: str, document: Mapping[str, Any]) -> Iterator[Claim]:
    """The claim that names all members about which nothing is said, if there are any."""
    read = dict(_READ[kind])
    if kind == "cusp-curves" and "full" in (document.get("certificate") or {}):
        read[""] |= {"range"}
    names = sorted(set(_unread(read, "", document)))
    if names:
        reason = f"this verifier does not read {', '.join(names)}"
        yield Claim("", "what else the document says", ClaimStatus.NOT_CHECKED, reason)


def _unread(read: Mapping[str, frozenset[str]], at: str, value: Any) -> Iterator[str]:
    if isinstance(value, list):
        for item in value:
            yield from _unread(read, f"{at}/*", item)
    elif isinstance(value, Mapping):
        known = read.get(at)
        for name, member in value.items():
            here = f"{at}/{name}" if at else str(name)
            if known is not None and name not in known:
                yield here
            else:
                yield from _unread(read, here, member)
