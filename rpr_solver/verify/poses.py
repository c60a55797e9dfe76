"""Tables of poses: all poses of a joint vector are found anew, each with its digits."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from itertools import pairwise
from math import isqrt

from flint import acb, arb, ctx

from rpr_solver.boxes import Box, Zero
from rpr_solver.contract import LEGS, MOST_POSES, Progress
from rpr_solver.verify.claims import Claim, Open, Refused, claim_by, compared, demand, settled
from rpr_solver.verify.clearance import bend_bound, is_clear, keeps_clear
from rpr_solver.verify.conditioning import SCALE, Rates, has_condition
from rpr_solver.verify.equations import Lengths, Mechanism
from rpr_solver.verify.finding import Found, poses_of
from rpr_solver.verify.listed import Matching, Row, degrees
from rpr_solver.verify.members import IN_GIVEN_FRAME, Document, Leg
from rpr_solver.verify.numbers import Printed, ball, printed, square_of
from rpr_solver.verify.reader import (
    Read,
    Record,
    anything,
    count,
    either,
    no_claim,
    nothing_or,
    record,
    rows,
    text,
    word,
)
from rpr_solver.verify.work import Work

_THETAS = tuple(f"theta{leg}_deg" for leg in (1, 2, 3))


_CONDITIONS = ("condition", "clearance_deg")
_BOUND_DIGITS, _CLEARANCE_BITS = 6, 192


def poses_schema(leg: Leg) -> Read:
    """The members of a table of poses."""
    pose = {
        "alpha_deg": leg.angle,
        **dict.fromkeys(_THETAS, leg.angle),
        **dict.fromkeys(("b1_x", "b1_y"), leg.number),
        "multiplicity": count(1, MOST_POSES),
    }
    curve = {"kind": word("curve"), "alpha_deg": text(), "description": text()}
    asked = {"condition": nothing_or(leg.positive), "clearance_deg": printed(_BOUND_DIGITS, 0)}
    with_condition, without = (
        rows(record({**pose, **own}, IN_GIVEN_FRAME), 0, MOST_POSES) for own in (asked, {})
    )
    members = {
        **leg.head,
        **dict.fromkeys(LEGS, square_of),
        "count": count(0, MOST_POSES),
        "count_with_multiplicity": count(0, MOST_POSES),
        "curves": rows(record(curve), 0, 2),
        "polynomial": no_claim(anything),
        "certificate": no_claim(anything),
    }
    return either(
        lambda value: "condition" in value,
        record({**members, "condition": record(SCALE), "poses": with_condition}),
        record({**members, "poses": without}),
    )


def pose_claims(document: Document, work: Work, progress: Progress) -> Iterator[Claim]:
    """The claims of a table of poses."""
    progress(0, 1)
    yield from _Poses(document, work).claims()
    progress(1, 1)


def _root(square: Fraction) -> Fraction | None:
    """The rational square root, if there is one."""
    n, d = (isqrt(part) for part in square.as_integer_ratio())
    return Fraction(n, d) if Fraction(n, d) ** 2 == square else None


@dataclass(frozen=True)
class _Poses:
    document: Document
    work: Work

    @property
    def listed(self) -> Sequence[Record]:
        poses: Sequence[Record] = self.document.members["poses"]
        return poses

    @settled
    def slice(self) -> tuple[Mechanism, Fraction]:
        """The first leg with a rational length as the fixed one, and its length."""
        for leg, name in enumerate(LEGS, 1):
            length = _root(self.document.members[name])
            if length is not None:
                return Mechanism(self.document.geometry, leg), length
        raise Open("no leg has a rational length")

    @settled
    def found(self) -> Found:
        """All poses."""
        mechanism, length = self.slice
        squares = [self.document.members[f"l{leg}"] for leg in mechanism.free]
        return poses_of(mechanism, length, squares, self.work)

    @settled
    def matching(self) -> Matching:
        """Which listed pose is which."""
        names = ("alpha_deg", f"theta{self.slice[0].fixed}_deg")
        listed = []
        for pose in self.listed:
            own = {name: x for name, x in pose.items() if name not in _CONDITIONS}
            numbers = {name: x for name, x in own.items() if isinstance(x, Printed)}
            listed.append(Row({**{name: numbers[name] for name in names}, **numbers}))
        return Matching.of(listed, self.found.zeros, self._numbers, self.work)

    def _numbers(self, box: Box) -> Mapping[str, arb]:
        """The numbers of a pose, as documents name them."""
        mechanism, length = self.slice
        base, platform, own = mechanism.geometry.base, mechanism.geometry.platform, mechanism.fixed - 1
        # B_k = A_i + L exp(iθ) + exp(iα) (b_k − b_i)
        tip, turn = base[own] + ball(length) * acb(0, box[1]).exp(), acb(0, box[0]).exp()
        corners = [tip + turn * (b - platform[own]) for b in platform]
        angles = [_direction(b - a) for a, b in zip(base, corners, strict=True)]
        angles[own] = box[1]
        return {
            "alpha_deg": degrees(box[0]),
            **{name: degrees(x) for name, x in zip(_THETAS, angles, strict=True)},
            "b1_x": corners[0].real,
            "b1_y": corners[0].imag,
        }

    def claims(self) -> Iterator[Claim]:
        """All of them."""
        members = self.document.members
        for n in range(len(self.listed)):
            yield claim_by(f"/poses/{n}", "a pose with these digits", partial(self._proved, n))
        if "condition" in members:
            nearer, numbers = "no singular pose with this length of leg 1 is nearer", range(len(self.listed))
            for n in numbers:
                yield claim_by(f"/poses/{n}/condition", "its condition number", partial(self._conditioned, n))
            for n in numbers:
                yield claim_by(f"/poses/{n}/clearance_deg", nearer, partial(self._clear, n))
        ends = [(pose["alpha_deg"].value, pose["theta1_deg"].value) for pose in self.listed]
        yield compared(
            "/poses",
            "the poses are sorted by angle",
            holds=all(x <= y for x, y in pairwise(ends)),
            reason="as printed",
            wrong="an angle is less than the one before",
        )
        number = sum(pose["multiplicity"] for pose in self.listed)
        yield compared(
            "/count_with_multiplicity",
            "the sum of multiplicities",
            holds=members["count_with_multiplicity"] == number,
            reason="as printed",
            wrong=f"it is {number}",
        )
        yield claim_by("/curves", "the curves of poses with these lengths", self._curves)
        yield claim_by("/count", f"these {members['count']} poses are all", self._complete)

    def _proved(self, n: int) -> str:
        if self.matching.places[n] is not None:
            right = self.listed[n]["multiplicity"] == 1
            return demand(right, "it is a regular pose, of multiplicity 1", "there is exactly one in a box")
        if n in self.matching.unsure or self.found.open:
            raise Open("poses coalesce, or nearly so, or a digit is not decided")
        raise Refused("no pose has these digits, or it is listed before")

    def _zero(self, n: int) -> Zero:
        """The pose that is listed, as it is found anew."""
        place = self.matching.places[n]
        if place is None:
            raise Open("the pose is not found anew")
        return self.found.zeros[place]

    def _conditioned(self, n: int) -> str:
        number, zero = self.listed[n]["condition"], self._zero(n)
        if number is None:
            raise Refused("it is a regular pose, whose condition number is finite")
        (mechanism, length), square = self.slice, self.document.members["condition"]["length_scale"]

        def at(bits: int) -> arb:
            box = zero.within(bits)
            return Rates(mechanism.geometry, mechanism.fixed, square).condition(box, ball(length))

        return has_condition(number, at, self.work)

    def _clear(self, n: int) -> str:
        number, zero = self.listed[n]["clearance_deg"], self._zero(n)
        mechanism, length = self.slice
        if number.is_zero:
            return "0 is no bound"
        if mechanism.fixed != 1:
            raise Open("leg 1 has no rational length")
        with ctx.workprec(_CLEARANCE_BITS):
            space = Lengths(mechanism)
            unit = Fraction(2) ** mechanism.geometry.size
            place = [*zero.within(_CLEARANCE_BITS // 2), ball(length / unit)]
            j = space.on(place, 1).singular
            if j.value.contains(0):
                raise Open("the sign of J is not decided")
            if is_clear(j, bend_bound(space, place[2]), ball(number.value) * arb.pi() / 180):
                return "by J and its slope there, and a bound of its second derivatives"
            return keeps_clear(space, [[place, place]], 1 if j.value > 0 else -1, number.value, self.work)

    def _curves(self) -> str:
        if self.found.open:
            raise Open("poses coalesce, or nearly so")
        return demand(not self.document.members["curves"], "all poses are isolated", "all poses are isolated")

    def _complete(self) -> str:
        number, listed = len(self.found.zeros), len(self.listed)
        demand(self.document.members["count"] == listed, f"{listed} are listed")
        demand(number <= listed, f"there are {number} at least")
        if self.found.open:
            raise Open("poses coalesce, or nearly so")
        demand(number == listed, f"there are {number}")
        if None in self.matching.places:
            raise Open("not every listed pose is known to be another one")
        return "they are found anew, in boxes that cover all poses"


def _direction(z: acb) -> arb:
    """The angle of a number that is not 0, up to turns."""
    return (-z).arg() + arb.pi() if z.real < 0 else z.arg()
