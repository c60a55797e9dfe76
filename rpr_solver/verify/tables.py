"""Cusp tables: of each slice the cusps are found anew, and with them that those listed are all."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial

from rpr_solver.contract import MOST_CUSPS, Progress
from rpr_solver.verify.claims import (
    Claim,
    Open,
    Refused,
    claim_by,
    compared,
    open_claim,
    settled,
)
from rpr_solver.verify.equations import Mechanism, Slice
from rpr_solver.verify.finding import Found, cusps_of
from rpr_solver.verify.listed import Matching, Row, pose_numbers
from rpr_solver.verify.members import Document, Leg
from rpr_solver.verify.numbers import POSITIVE, exact
from rpr_solver.verify.reader import (
    Read,
    Record,
    anything,
    count,
    either,
    no_claim,
    record,
    rows,
    text,
    word,
)
from rpr_solver.verify.work import Work

_OF_SOLVER = ("eliminant_degree", "real_roots", "factors", "method", "nonzero")
"""What a certificate tells of the solver's way to its answer."""


def table_schema(leg: Leg) -> Read:
    """The members of a cusp table."""
    curve = record({"kind": word("curve"), "equation": text()})
    points = rows(either(lambda x: x.get("kind") == "curve", curve, record(leg.degenerate_point)), 0, 200)
    answer: dict[str, Read] = {
        leg.length: POSITIVE,
        "count": count(0, MOST_CUSPS),
        "cusps": rows(record(leg.point), 0, MOST_CUSPS),
        "degenerate_points": points,
    }
    certificate = record({}, dict.fromkeys(_OF_SOLVER, no_claim(anything)))
    article = {"method": no_claim(word("article")), "audit": no_claim(anything)}
    solved = record(answer, {**article, "certificate": certificate})
    failed = record({leg.length: exact, "error": record({"type": text(), "detail": text(most=20_000)})})
    part = either(lambda x: "error" in x, failed, solved)
    return record({**leg.on_leg, "slices": rows(part)}, {"method": no_claim(word("article"))})


def table_claims(document: Document, work: Work, progress: Progress) -> Iterator[Claim]:
    """The claims of all slices of a cusp table."""
    slices: Sequence[Record] = document.members["slices"]
    mechanism = Mechanism(document.geometry, document.fixed)
    for n, part in enumerate(slices):
        progress(n, len(slices))
        at = f"/slices/{n}"
        if "error" in part:
            yield open_claim(at, "the slice has no answer", "an error says nothing about cusps")
        else:
            cusps = Cusps(mechanism, part[f"l{mechanism.fixed}"], part["cusps"], work)
            yield from cusps.claims(at)
            yield from _degenerate(cusps, part["degenerate_points"], at)
            yield _counted(cusps, part["count"], at)
    progress(len(slices), len(slices))


def is_sorted(angles: Sequence[Fraction]) -> bool:
    """Whether angles in degrees ascend, where one just above −180 is printed as 180 and comes first."""
    first = next((n for n, x in enumerate(angles) if x != 180), 0)
    turned = [Fraction(-180)] * first + list(angles[first:])
    return turned == sorted(turned)


@dataclass(frozen=True)
class Cusps:
    """The cusps of a slice as they are listed, and as they are found."""

    mechanism: Mechanism
    length: Fraction
    listed: Sequence[Record]
    work: Work

    @cached_property
    def slice(self) -> Slice:
        """The equations."""
        return Slice(self.mechanism, self.length)

    @cached_property
    def rows(self) -> Sequence[Row]:
        """The listed ones."""
        return [Row(cusp) for cusp in self.listed]

    @settled
    def found(self) -> Found:
        """All that there are."""
        return cusps_of(self.mechanism, self.length, self.work)

    @settled
    def matching(self) -> Matching:
        """Which is which."""
        return Matching.of(self.rows, self.found.zeros, partial(pose_numbers, self.slice), self.work)

    def claims(self, at: str) -> Iterator[Claim]:
        """That each is a cusp with its digits, and that they are sorted."""
        for n in range(len(self.listed)):
            yield claim_by(f"{at}/cusps/{n}", "a cusp with these digits", partial(self.proved, n))
        angles = [cusp[f"theta{self.mechanism.fixed}_deg"].value for cusp in self.listed]
        yield compared(
            f"{at}/cusps",
            "the cusps are sorted by angle",
            holds=is_sorted(angles),
            reason="as printed",
            wrong="an angle is less than the one before",
        )

    def proved(self, n: int) -> str:
        """Why a listed one is a cusp with its digits."""
        if self.matching.places[n] is not None:
            return "there is exactly one in a box, and all of its numbers round to the printed ones"
        if n in self.matching.unsure or self.found.may_hold(self.rows[n].angles):
            raise Open("a degenerate pose is here, or one nearly so, or a digit is not decided")
        raise Refused("no cusp has these digits, or it is listed before")

    def complete(self) -> str:
        """Why those listed are all.

        Raises:
            Refused: they are not.
            Open: it is not decided.
        """
        missing = len(self.found.zeros) - len(self.listed)
        if missing > 0:
            raise Refused(f"there are {len(self.found.zeros)} at least")
        if self.found.open:
            raise Open(
                f"more may be at {len(self.found.open)} places, where poses are degenerate or nearly so"
            )
        if missing < 0:
            raise Refused(f"there are {len(self.found.zeros)}")
        if None in self.matching.places:
            raise Open("not every listed cusp is known to be another one")
        return "they are found anew, in boxes that cover all poses"


def _counted(cusps: Cusps, number: int, at: str) -> Claim:
    if number != len(cusps.listed):
        wrong = f"{len(cusps.listed)} are listed"
        return compared(f"{at}/count", "the number of cusps", holds=False, reason="", wrong=wrong)
    return claim_by(f"{at}/count", f"these {number} cusps are all", cusps.complete)


def _degenerate(cusps: Cusps, points: Sequence[Record], at: str) -> Iterator[Claim]:
    for n, point in enumerate(points):
        yield claim_by(
            f"{at}/degenerate_points/{n}", f"a degenerate pose: {point['kind']}", partial(_kind, cusps)
        )


def _kind(cusps: Cusps) -> str:
    if cusps.mechanism.geometry.is_similar_pair or cusps.found.open:
        raise Open("kinds of degenerate poses are not verified")
    raise Refused("all poses with J = E = 0 are cusps")
