"""A document of any kind, and the result of its independent verification."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any

from rpr_solver.contract import MAX_DIGITS, MIN_DIGITS, Progress, silent
from rpr_solver.verify.censuses import census_claims, census_schema
from rpr_solver.verify.checks import check_claims, check_schema
from rpr_solver.verify.claims import Claim, Open, Verification, claim_by, demand
from rpr_solver.verify.curves import curve_claims, curves_schema
from rpr_solver.verify.geometry import Geometry
from rpr_solver.verify.margins import margin_claims, margin_schema
from rpr_solver.verify.members import Document, Leg
from rpr_solver.verify.path_members import path
from rpr_solver.verify.paths import path_claims
from rpr_solver.verify.poses import pose_claims, poses_schema
from rpr_solver.verify.reader import (
    Read,
    check_bounds,
    count,
    names_without_claim,
    parsed,
    refusal,
)
from rpr_solver.verify.singular_curves import singular_claims, singular_schema
from rpr_solver.verify.special_shapes import NEAR, near_claims
from rpr_solver.verify.tables import table_claims, table_schema
from rpr_solver.verify.work import Work

Claims = Callable[[Document, Work, Progress], Iterator[Claim]]

KINDS: Mapping[str, tuple[str, Callable[[Leg], Read], Claims]] = {
    "poses": ("poses", poses_schema, pose_claims),
    "cusp-table": ("slices", table_schema, table_claims),
    "census": ("transitions", census_schema, census_claims),
    "cusp-curves": ("curves", curves_schema, curve_claims),
    "check": ("violations", check_schema, check_claims),
    "path": ("samples", path, path_claims),
    "margin": ("first_order", margin_schema, margin_claims),
    "singular-curves": ("regions", singular_schema, singular_claims),
}
"""Kind → the member by which it is known, its schema, and its claims."""

_UNVERIFIED: Mapping[str, str] = {
    "moving_leg": "poses along a leg",
    "sensed": "poses with angles of legs",
    "change": "assembly modes",
    "matrix": "connections of poses",
    "conic": "a workspace",
    "orientations": "workspaces of several orientations",
}
"""A member by which a document is known that is not verified, and what to call it."""

_OTHERS: Mapping[str, str] = {
    "aspects": "a document of aspects",
    "checks": "a list of reports of checks",
    "verdict": "a verification",
}
"""A member by which another document is known, and what to call that."""


def kind_of(value: object) -> str:
    """The kind of a document that can be verified.

    Raises:
        InputError: it is none.
    """
    if not isinstance(value, Mapping):
        raise refusal("", "is not an object")
    kind = next((kind for kind, (member, _, _) in KINDS.items() if member in value), None)
    own = next((f", {name}," for member, name in _UNVERIFIED.items() if member in value), "")
    if kind is None or own:
        other = own or next((f", {name}," for member, name in _OTHERS.items() if member in value), "")
        raise refusal("", f"is{other} of no kind that can be verified; known are {', '.join(KINDS)}")
    return kind


def read_document(value: Mapping[str, Any]) -> Document:
    """Reads a document by the schema of its kind.

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
    members = KINDS[kind][1](Leg(fixed, digits))({name: x for name, x in value.items() if name != "near"}, "")
    if "near" in value:
        members = MappingProxyType({**members, "near": NEAR(value["near"], "/near")})
    return Document(kind, geometry, fixed, members)


def verify_document(
    document: Mapping[str, Any] | str | bytes, *, progress: Progress = silent
) -> Verification:
    """Verifies a document of any solver by independent means: everything in it is computed again.

    Args:
        document: a cusp table, a table of poses, a census, cusp curves, a report of a check, a margin,
            singular curves or a path: the bytes or the text of its JSON, or what JSON made of them, with its
            texts. Only of bytes or a text is it seen that a key is there twice.
        progress: callback ``progress(done, total)``.

    Raises:
        InputError: this is no such document; the member is named by its JSON pointer.

    >>> from rpr_solver import EXAMPLES, table_document
    >>> verify_document(table_document(EXAMPLES["innocenti"], "14.98", digits=15)).verdict
    <Verdict.VERIFIED: 'verified'>
    """
    value = parsed(document) if isinstance(document, str | bytes) else document
    kind_of(value)
    work = Work(check_bounds(value))
    read = read_document(value)
    right, own = read.members["geometry_hash"] == read.geometry.hash, f"it is {read.geometry.hash}"
    hashed = claim_by("/geometry_hash", "the hash of the geometry", lambda: demand(right, own))
    near = near_claims(read.geometry, read.members.get("near", ()))
    claims = (hashed, *near, *_claims(read, work, progress))
    no_claims = tuple(sorted(names_without_claim(read.members)))
    return Verification(read.kind, read.geometry.hash, str(value["solver_version"]), claims, no_claims)


def _claims(read: Document, work: Work, progress: Progress) -> Iterator[Claim]:
    """Those of its kind; where legs share joints, of poses alone."""
    if read.geometry.has_shared_joints and read.kind != "poses":
        yield claim_by("", "what it says of a machine whose legs share joints", _not_verified)
        return
    yield from KINDS[read.kind][2](read, work, progress)


def _not_verified() -> str:
    raise Open("of machines whose legs share joints only poses are verified")
