"""Margins: what follows from what, the number of cusps of the given geometry, and the counter-example, anew.

That all geometries within a radius have the property is not verified, but where no slice of any can fail it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial

from rpr_solver.contract import LENGTHS, MOST_CUSPS, Progress
from rpr_solver.verify.checks import admits, limits_of, requirement_schema
from rpr_solver.verify.claims import Claim, Open, claim_by, demand
from rpr_solver.verify.equations import Mechanism, Slice
from rpr_solver.verify.events import Limit, decided
from rpr_solver.verify.finding import cusps_of
from rpr_solver.verify.geometry import Geometry
from rpr_solver.verify.members import Document, Leg
from rpr_solver.verify.numbers import NOT_NEGATIVE, POSITIVE
from rpr_solver.verify.reader import (
    Read,
    Record,
    anything,
    count,
    no_claim,
    nothing_or,
    record,
    refusal,
    word,
)
from rpr_solver.verify.survey import Survey, admitted
from rpr_solver.verify.work import Work

_DIGITS = 6
"""Of the validity."""
_OF_SOLVER = ("method", "boxes", "arithmetic")
"""What a certificate tells of the solver's way to its answer."""


def margin_schema(leg: Leg) -> Read:
    """The members of a margin."""
    changes = record(dict.fromkeys(LENGTHS, NOT_NEGATIVE))
    asked = {
        leg.length: POSITIVE,
        "window": POSITIVE,
        "requirement": requirement_schema(leg),
        "tolerance": changes,
    }
    cusps = nothing_or(count(0, MOST_CUSPS))
    example = {
        "radius": POSITIVE,
        "geometry": Geometry.read,
        leg.length: nothing_or(POSITIVE),
        "count": cusps,
    }
    return record(
        {
            **leg.on_leg,
            "asked": record({}, asked),
            "count": cusps,
            "weights": changes,
            "validity": nothing_or(NOT_NEGATIVE),
            "first_order": no_claim(anything),
            "proved": nothing_or(NOT_NEGATIVE),
            "counterexample": nothing_or(record(example)),
            "verdict": nothing_or(word("proved", "refuted", "open")),
            "reason": no_claim(anything),
            "certificate": no_claim(record({}, dict.fromkeys(_OF_SOLVER, anything))),
        }
    )


def margin_claims(document: Document, work: Work, progress: Progress) -> Iterator[Claim]:
    """The claims of a margin."""
    progress(0, 1)
    yield from _Margin(document, work).claims()
    progress(1, 1)


class _Margin:
    """A margin as it is printed."""

    def __init__(self, document: Document, work: Work) -> None:
        self.members, self.geometry, self.fixed, self.work = (
            document.members,
            document.geometry,
            document.fixed,
            work,
        )
        self.asked: Record = self.members["asked"]
        self.weights: Mapping[str, Fraction] = self.members["weights"]
        self.example: Record | None = self.members["counterexample"]
        self.count: int | None = self.members["count"]
        self.length = f"l{self.fixed}"
        subjects = [name for name in (self.length, "window", "requirement") if name in self.asked]
        if len(subjects) != 1:
            raise refusal("/asked", "has not exactly one of a length, a window and a requirement")
        [self.subject] = subjects
        if self.count is None and self.subject != "requirement":
            raise refusal("/count", "is missing")
        self.requirement: Record | None = self.asked.get("requirement")
        self.limits: Sequence[Limit] = tuple(limits_of(self.requirement)) if self.requirement else ()

    def claims(self) -> Iterator[Claim]:
        """All of them."""
        yield claim_by("/weights", "what radii multiply", self._weighted)
        yield claim_by("/validity", "from this radius on a geometry may be flat", self._valid)
        yield claim_by("/verdict", "it follows from what is proved and refuted", self._decided)
        if self.requirement is not None:
            yield claim_by("/asked", "a range of lengths, and a bound of the number of cusps", self._bounded)
        if self.count is not None:
            yield claim_by(
                "/count", f"{self.count} cusps, as was asked for", partial(self._counted, self.count)
            )
        if self.example is not None:
            at, radius = "/counterexample/radius", "the distance of the counter-example"
            yield claim_by(at, radius, partial(self._far, self.example))
            yield claim_by("/counterexample", "it has not the property", partial(self._refuted, self.example))
        if self.members["proved"] is not None:
            yield claim_by("/proved", "all geometries within this radius have the property", self._proved)

    def _weighted(self) -> str:
        demand(any(self.weights.values()), "nothing varies")
        tolerance = self.asked.get("tolerance")
        return demand(
            tolerance is None or dict(tolerance) == dict(self.weights), "they are not the tolerance"
        )

    def _valid(self) -> str:
        own, printed = _validity(self.geometry, self.weights), self.members["validity"]
        return demand(
            printed == (None if own is None else _rounded_down(own)), f"it is {own}", "by the lengths"
        )

    def _decided(self) -> str:
        proved, example, verdict = self.members["proved"], self.example, None
        if "tolerance" in self.asked:
            verdict = "proved" if proved else "refuted" if example and example["radius"] <= 1 else "open"
        demand(self.members["verdict"] == verdict, f"it is {verdict}")
        if proved:
            demand(
                "tolerance" not in self.asked or proved == 1, "another radius than the tolerance is proved"
            )
            demand(example is None or proved < example["radius"], "it is beyond the counter-example")
            own = _validity(self.geometry, self.weights)
            demand(own is None or proved < own, "a geometry within it may be flat")
        return "as printed"

    def _bounded(self) -> str:
        assert self.requirement is not None
        start, stop = self._span
        demand(stop is None or start < stop, "the range has no length")
        bounds = self.requirement["min_cusps"], self.requirement["max_cusps"]
        return demand(any(x is not None for x in bounds), "nothing is bounded", "as printed")

    @property
    def _span(self) -> tuple[Fraction, Fraction | None]:
        """The range of the requirement."""
        assert self.requirement is not None
        return self.requirement["range"]["from"], self.requirement["range"]["to"]

    def _number(self, geometry: Geometry, length: Fraction) -> int:
        """The number of cusps of a slice within the limits.

        Raises:
            Open: it is not decided.
        """
        mechanism = Mechanism(geometry, self.fixed)
        found, own = cusps_of(mechanism, length, self.work), Slice(mechanism, length)
        if found.open:
            raise Open("a slice has degenerate poses, or nearly so")
        return sum(
            decided(lambda bits, x=zero: admitted(own, x.within(bits), self.limits))  # type: ignore[misc]
            for zero in found.zeros
        )

    def _counted(self, number: int) -> str:
        if self.requirement is not None:
            counts = Survey(Mechanism(self.geometry, self.fixed), *self._span, self.limits, self.work).counts
            return demand(
                set(counts) == {number}, f"slices of the range have {counts}", "by a slice, and all events"
            )
        length = self.asked[self.subject]
        found = self._number(self.geometry, length)
        return demand(found == number, f"there are {found}", "all are found anew")

    def _far(self, example: Record) -> str:
        other: Geometry = example["geometry"]
        own = self.geometry.lengths
        changes = {g: abs(x - own[g]) for g, x in other.lengths.items()}
        demand(not any(x for g, x in changes.items() if not self.weights[g]), "an exact length is changed")
        demand(other.clockwise == self.geometry.clockwise, "it has the other orientation")
        radius = max(x / self.weights[g] for g, x in changes.items() if self.weights[g])
        return demand(radius == example["radius"], f"it is {radius}", "by the lengths")

    def _refuted(self, example: Record) -> str:
        number, length = example["count"], example[self.length]
        if self.subject == "window":
            demand(number is None and length is None, "it is about all slices")
            survey = Survey(Mechanism(example["geometry"], self.fixed), Fraction(0), None, (), self.work)
            return demand(
                self.count not in survey.counts, "slices of it have as many cusps", "by all its events"
            )
        demand(number is not None and length is not None, "it has no slice, or no number")
        if self.requirement is None:
            demand(length == self.asked[self.length], "it is another slice")
            demand(number != self.count, "it has the property")
        else:
            start, stop = self._span
            demand(start <= length and (stop is None or length <= stop), "it is a slice beyond the range")
            demand(not admits(self.requirement, number), "it has the property")
            if "ignore_windows" in self.requirement:
                raise Open("that the window of this slice is too wide to be ignored is not verified")
        found = self._number(example["geometry"], length)
        return demand(found == number, f"there are {found} cusps", "all are found anew")

    def _proved(self) -> str:
        asked = self.requirement
        if not self.members["proved"] and self.count is not None:
            return "no other geometry is within it"
        if (
            asked
            and asked["degenerate"] == "allowed"
            and all(admits(asked, n) for n in range(MOST_CUSPS + 1))
        ):
            return f"no slice of any geometry has more than {MOST_CUSPS} cusps"
        raise Open("what is said of other geometries is not verified")


def _validity(geometry: Geometry, weights: Mapping[str, Fraction]) -> Fraction | None:
    """The radius at which the first platform is flat, or two base points coincide; None if there is none."""
    w, lengths = weights, geometry.lengths
    a2x, a3x, a3y, *sides = (lengths[name] for name in LENGTHS)
    change = w["d1"] + w["d2"] + w["d3"]
    radii = [(sum(sides) - 2 * side) / change for side in sides if change]
    if w["a2x"]:
        radii.append(abs(a2x) / w["a2x"])
    for along, by in ((a3x, w["a3x"]), (a3x - a2x, w["a3x"] + w["a2x"])):
        ways = [(along, by), (a3y, w["a3y"])]
        if all(step or not distance for distance, step in ways):
            radii.append(max((abs(distance) / step for distance, step in ways if step), default=Fraction(0)))
    return min(radii, default=None)


def _rounded_down(x: Fraction) -> Fraction:
    """The greatest number of six digits that is not greater."""
    unit = Fraction(1)
    while x >= unit * 10**_DIGITS:
        unit *= 10
    while x and x < unit * 10 ** (_DIGITS - 1):
        unit /= 10
    return x // unit * unit
