"""A document of any kind, and the result of its independent verification."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

from rpr_solver.contract import Progress, check_integer, silent
from rpr_solver.verify.censuses import DEGENERATE, census_claims
from rpr_solver.verify.chains import joining, leading
from rpr_solver.verify.checks import check_claims
from rpr_solver.verify.claims import Claim, ClaimStatus, Verification, judged
from rpr_solver.verify.core.reader import (
    LEAST_CHARACTERS,
    UNITS_OF_A_CHARACTER,
    ExhaustedError,
    Record,
    bounded,
    check_texts,
    names_of_unread,
    parsed,
)
from rpr_solver.verify.core.schema import Document, read_document
from rpr_solver.verify.curves import JOINED, curve_claims
from rpr_solver.verify.margins import margin_claims, promised_of_margin
from rpr_solver.verify.poses import pose_claims
from rpr_solver.verify.tables import isolation, simple, table_claims

CLAIMS: Mapping[str, Callable[[Document, Progress], Iterator[Claim]]] = {
    "cusp-table": table_claims,
    "poses": pose_claims,
    "census": census_claims,
    "cusp-curves": curve_claims,
    "check": check_claims,
    "margin": margin_claims,
}
"""Kind of a document → its claims."""


def verify_document(
    document: Mapping[str, Any] | str | bytes, *, effort: int = 1, progress: Progress = silent
) -> Verification:
    """Checks a document of any solver by independent means: SymPy, exact integers and intervals.

    The document is read once, by a closed schema; the equations are derived from the closure of the legs, α
    is eliminated by Sylvester's determinant, real roots are counted by Descartes' rule of signs, and a pose
    is proved by Krawczyk's test in intervals. Nothing of the solver is used, and none of its libraries.

    Args:
        document: a cusp table, a table of poses, a census, cusp curves, a report of a check or a margin: the
            bytes or the text of its JSON, or what JSON made of them, with its texts. Only of bytes or a text
            is it seen that a key is there twice.
        effort: how many times the work is done that the length of the document allows: for ``1`` about
            ten seconds for each 100 kB. Each claim that is left then is open.
        progress: callback ``progress(done, total)``.

    Raises:
        InputError: this is no such document; the member is named by its JSON pointer.

    >>> from rpr_solver import EXAMPLES, table_document
    >>> document = table_document(EXAMPLES["zein-flat"], 10, digits=15)
    >>> verify_document(document)
    <Verification of cusp-table: established; 10 proved>
    >>> document["slices"][0]["cusps"].pop()["l2"]
    '...'
    >>> verify_document(document).refused[0].at
    '/slices/0/count'
    """
    check_integer(effort, "effort", "1 to 1000", 1, 1000)
    value = parsed(document) if isinstance(document, str | bytes) else document
    size = check_texts(value) if isinstance(value, Mapping) else 0
    read = read_document(value)
    units = UNITS_OF_A_CHARACTER * max(LEAST_CHARACTERS, size) * effort
    claims = (_hash_claim(read), *_within(units, read, CLAIMS[read.kind](read, progress)))
    unread = tuple(sorted(names_of_unread(read.members)))
    return Verification(read.kind, read.geometry.hash, str(value["solver_version"]), claims, unread)


def _within(units: int, document: Document, claims: Iterator[Claim]) -> Iterator[Claim]:
    """The claims for which there is enough work, and all others as open."""
    found: list[Claim] = []
    with bounded(units):
        try:
            found.extend(claims)
        except ExhaustedError:
            reason = "it needs more work than its length allows; verify parts of it, or allow more effort"
            named = {(claim.at, claim.claim) for claim in found}
            for at, text in promised(document):
                if (at, text) not in named:
                    found.append(Claim(at, text, ClaimStatus.NOT_CHECKED, reason))
    return iter(found)


def _hash_claim(document: Document) -> Claim:
    right, own = document.members["geometry_hash"] == document.geometry.hash, document.geometry.hash
    reason = "it is the SHA-256 of the geometry as printed"
    return judged("/geometry_hash", "the hash of the geometry", right, reason, f"it is {own}")


Named = Iterator[tuple[str, str]]
"""The member that makes a claim, and what is claimed."""


def promised(document: Document) -> Named:
    """All claims of a document, as its verification names them; no work is needed to tell."""
    of_kind = _PROMISED.get(document.kind)
    if of_kind is not None:
        yield from of_kind(document)
        return
    for name in document.members:
        if name not in ("geometry", "geometry_hash", "digits", "solver_version", "fixed_leg"):
            yield f"/{name}", "this member"


def _of_table(document: Document) -> Named:
    for n, part in enumerate(document.members["slices"]):
        at = f"/slices/{n}"
        if "error" in part:
            yield at, "the slice has no answer"
            continue
        yield f"{at}/count", f"these {part['count']} cusps are all"
        yield f"{at}/cusps", "the cusps are sorted by angle"
        for k in range(len(part["cusps"])):
            yield f"{at}/cusps/{k}", "a cusp with these digits"
        for k, point in enumerate(part["degenerate_points"]):
            text = f"a degenerate pose: {point['kind']}"
            is_curve = point["kind"] == "curve"
            yield f"{at}/degenerate_points/{k}", "a whole curve of degenerate poses" if is_curve else text
        if "certificate" in part and "audit" not in part:
            yield from _of_slice(f"{at}/certificate", part["certificate"])


def _of_slice(at: str, certificate: Record) -> Named:
    if (full := certificate.get("full")) is not None:
        yield f"{at}/full/polynomial", "Q of this slice"
        yield f"{at}/full/squarefree", simple("Q", full["squarefree"])
        yield f"{at}/full/real_roots", isolation(full["real_roots"])
        yield f"{at}/full/boxes", "boxes of the cusps"
    yield f"{at}/factors", "the factors of the resultant of J and E, with multiplicities"
    yield f"{at}/eliminant_degree", "the degree of the eliminant"
    yield f"{at}/real_roots", "real roots"


def _of_poses(document: Document) -> Named:
    yield "/poses", "these are all poses"
    for n in range(len(document.members["poses"])):
        yield f"/poses/{n}", "a pose with these digits and this multiplicity"
    yield "/poses", "the poses are sorted by alpha"
    yield "/polynomial", "the sixth-degree polynomial of direct kinematics"
    yield "/count", "the number of poses"
    yield "/count_with_multiplicity", "with multiplicity"
    yield "/certificate/factors", "degrees and multiplicities of the factors"
    yield "/curves", "the curves of poses"


def _of_range(at: str, intervals: Sequence[Record]) -> Named:
    yield at, "a range of lengths, and cuts that ascend within it"
    yield "/intervals", "the intervals lie between the cuts, and fill the range"
    for n, row in enumerate(intervals):
        yield f"/intervals/{n}/count", f"{row['count']} cusps in every slice of this interval"


def _of_census(document: Document) -> Named:
    members = document.members
    yield "/transitions", "these are all transitions"
    yield from _of_range("/transitions", members["intervals"])
    yield "/intervals", "counts before and after are those of the intervals"
    for n, row in enumerate(members["transitions"]):
        if not row["events"]:
            yield f"/transitions/{n}", "an event, without its pose"
        for k, event in enumerate(row["events"]):
            yield f"/transitions/{n}/events/{k}", f"a {event['kind']} at this length"
    yield "/degenerate", DEGENERATE
    if (full := members["certificate"].get("full")) is not None:
        at = "/certificate/full"
        for n, box in enumerate(full["events"]):
            yield f"{at}/events/{n}", f"one {box['kind']} in this box"
        yield f"{at}/events", "each event has its box"
        for n, system in enumerate(full["systems"]):
            yield f"{at}/systems/{n}/polynomial", f"the eliminant of {system['name']}"
            yield f"{at}/systems/{n}/squarefree", simple("it", system["squarefree"])
            yield f"{at}/systems/{n}/real_roots", isolation(system["real_roots"])
        for n in range(len(full["samples"])):
            yield f"{at}/samples/{n}", "a length in this interval"


def _of_curves(document: Document) -> Named:
    members, length = document.members, f"l{document.fixed}"
    yield "/curves", "these are all curves of the range"
    yield "/curves", "curves have different names, and those that join name each other"
    yield "/range", "the curves meet the range, and points are in it"
    together: dict[Fraction, list[str]] = {}
    for n, curve in enumerate(members["curves"]):
        for side in ("from", "to"):
            end = curve[side]
            if "certificate" in members:
                yield f"/curves/{n}/{side}", leading(end)
            if len(end["events"]) != 1 or end["kind"] == "undecided":
                yield f"/curves/{n}/{side}", f"an end: {end['kind']}"
            for k, event in enumerate(end["events"]):
                yield f"/curves/{n}/{side}/events/{k}", f"a {event['kind']} at this length"
        yield f"/curves/{n}/points", "the points ascend between the ends"
        if not curve["points"]:
            yield f"/curves/{n}", "a curve without points is there"
        for k, point in enumerate(curve["points"]):
            yield f"/curves/{n}/points/{k}", "a cusp with these digits"
            together.setdefault(point[length], []).append(f"/curves/{n}/points/{k}")
    for x, places in together.items():
        claim = f"the {len(places)} curves of {length} = {x} have all cusps of the slice"
        yield places[0], claim
    if "certificate" not in members:
        yield "/curves", JOINED
    else:
        yield from _of_chains(members["curves"], members["certificate"]["full"]["chains"], length)
    yield "/degenerate", DEGENERATE


def _of_chains(curves: Sequence[Record], chains: Sequence[Record], length: str) -> Named:
    for n in range(len(curves)):
        yield f"/curves/{n}/points", "each two neighbouring points of the curve are joined by tubes"
    for n, chain in enumerate(chains):
        start, stop = ((chain[side]["curve"], chain[side][length]) for side in ("from", "to"))
        yield f"/certificate/full/chains/{n}", joining(len(chain["tubes"]), start, stop)


def _of_check(document: Document) -> Named:
    members = document.members
    yield "/passed", "the requirement is met" if members["passed"] else "the requirement is not met"
    yield "/passed", "the verdict follows from the intervals"
    yield "/requirement", "a bound of the number of cusps"
    for name in ("max_cusps_found", "min_cusps_found"):
        yield f"/{name}", f"{name.replace('_', ' ')} in the intervals"
    yield "/violations", "these intervals violate the requirement"
    yield "/intervals", "neighbouring intervals have different numbers"
    yield from _of_range("/intervals", members["intervals"])
    for n in range(1, len(members["intervals"])):
        yield f"/intervals/{n}/from", "the number of cusps changes here"
    for k in range(len(members["violations"])):
        yield f"/violations/{k}/example", "a slice of this interval, with its cusps within the limits"
    yield "/degenerate", DEGENERATE


_PROMISED: Mapping[str, Callable[[Document], Named]] = {
    "cusp-table": _of_table,
    "poses": _of_poses,
    "census": _of_census,
    "cusp-curves": _of_curves,
    "check": _of_check,
    "margin": promised_of_margin,
}
