"""The ends of a path: poses of joint vectors by their numbers, or poses at exact angles."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import cached_property, partial
from itertools import pairwise

from flint import acb, arb, ctx

from rpr_solver.boxes import Box, Zero
from rpr_solver.contract import LEGS
from rpr_solver.verify.claims import Claim, Open, Refused, claim_by, demand
from rpr_solver.verify.equations import ALPHA, Lengths, Mechanism
from rpr_solver.verify.finding import Found, poses_of
from rpr_solver.verify.members import Document
from rpr_solver.verify.numbers import Printed, ball, bits_of
from rpr_solver.verify.reader import Record
from rpr_solver.verify.work import Work

ENDS = ("from", "to")
PIECE_BITS = 192
"""Enough for signs on pieces of arcs."""
_SPARE_BITS = 64
_ORDER_BITS = 128
"""So many bits tell two angles of poses apart, or it stays open which is the first."""


class PathEnds:
    """What the document of a path says of its ends, and what is found anew of them.

    Attributes:
        members: those of the document.
        mechanism: the manipulator with its fixed leg.
        space: its poses, for all lengths of the fixed leg.
        angles: the names of α and θ.
        unit: of all lengths.
        work: what may be spent.
    """

    def __init__(self, document: Document, work: Work) -> None:
        self.members, self.work = document.members, work
        self.mechanism = Mechanism(document.geometry, document.fixed)
        self.space = Lengths(self.mechanism)
        self.fixed, self.angles = f"l{document.fixed}", ("alpha_deg", f"theta{document.fixed}_deg")
        self.unit = Fraction(2) ** document.geometry.size
        self._found: dict[tuple[Fraction, ...], Found] = {}
        self._corners: dict[int, Sequence[Sequence[acb]]] = {}

    @cached_property
    def bits(self) -> int:
        """The working precision: well below the last printed digit, in degrees and in units."""
        table = (*self.members["samples"], *(self.members[end] for end in ENDS))
        numbers = (x for row in table for x in row.values() if isinstance(x, Printed))
        return max(bits_of(numbers) + abs(self.mechanism.geometry.size) + _SPARE_BITS, PIECE_BITS)

    def lengths(self, end: str) -> Record:
        """What has the leg lengths of an end."""
        own: Record = self.members[end]
        return own if "l1" in own else self.members

    def length(self, end: str) -> Fraction:
        """The length of the fixed leg at an end."""
        result: Fraction = self.lengths(end)[self.fixed]
        return result

    def is_given(self, end: str) -> bool:
        """Whether the pose is given by its angles, which are exact."""
        return self.members[end]["pose"] is None

    def claim_by(self, at: str, claim: str, proof: Callable[[], str]) -> Claim:
        """A claim, with a proof at the working precision."""
        with ctx.workprec(self.bits):
            return claim_by(at, claim, proof)

    def end_claims(self) -> Iterator[Claim]:
        """The claims of both ends."""
        for end in ENDS:
            if self.is_given(end):
                claim, proof = "the pose at these angles has these lengths", self._proved_given
            else:
                claim, proof = f"it is pose {self.members[end]['pose']}", self._proved_number
            yield self.claim_by(f"/{end}", claim, partial(proof, end))

    def place(self, end: str) -> Box:
        """The pose, at the working precision: α and θ in radians, as they are printed; the length in units.

        Raises:
            Open: the poses of its joint vector are not known.
            Refused: there is no pose with its number.
        """
        near = [ball(self.members[end][name].value) * arb.pi() / 180 for name in self.angles]
        length = ball(self.length(end) / self.unit)
        if self.is_given(end):
            return [*near, length]
        turn, pose = 2 * arb.pi(), self._numbered(end).within(ctx.prec - 8)
        turned = [
            x - turn * ((x - y) / turn + arb(0.5)).mid().floor() for x, y in zip(pose, near, strict=True)
        ]
        return [*turned, length]

    def legs(self, at: Box) -> dict[str, arb]:
        """The lengths of the legs at a pose, in the user's unit: |L e^iθ + e^iα m − a|, as the legs close."""
        if ctx.prec not in self._corners:
            self._corners[ctx.prec] = self.mechanism.geometry.base, self.mechanism.geometry.platform
        own, length = self.mechanism.fixed - 1, at[2] * ball(self.unit)
        turn, tip = acb(0, at[0]).exp(), length * acb(0, at[1]).exp()
        base, platform = self._corners[ctx.prec]
        corners = (
            tip + turn * (b - platform[own]) - (a - base[own]) for a, b in zip(base, platform, strict=True)
        )
        found = dict(zip(LEGS, (x.abs_lower().union(x.abs_upper()) for x in corners), strict=True))
        return {**found, self.fixed: length}

    def _numbered(self, end: str) -> Zero:
        """The pose of an end, by its number."""
        lengths = self.lengths(end)
        key = tuple(lengths[name] for name in LEGS)
        if key not in self._found:
            squares = [lengths[f"l{leg}"] ** 2 for leg in self.mechanism.free]
            self._found[key] = poses_of(self.mechanism, lengths[self.fixed], squares, self.work)
        if self._found[key].open:
            raise Open("two poses of its joint vector coalesce, or nearly so")
        poses, number = in_order(self._found[key].zeros, ALPHA), int(self.members[end]["pose"])
        demand(number <= len(poses), f"there are {len(poses)} poses with these lengths")
        return poses[number - 1]

    def _proved_number(self, end: str) -> str:
        for name, x in zip(self.angles, self.place(end), strict=False):
            right = self.members[end][name].rounds(x * 180 / arb.pi())
            if right is False:
                raise Refused(f"this pose has another {name}")
            if right is None:
                raise Open(f"{name} is half way between two decimals, or exactly 0, as far as balls tell")
        return "all poses with these lengths are found anew"

    def _proved_given(self, end: str) -> str:
        own = self.members[end]
        at = self.place(end)
        found = {name: own[name].rounds(x) for name, x in self.legs(at).items() if name != self.fixed}
        if all(found.values()):
            return "the lengths at exactly these angles"
        wide = [arb(x.mid(), x.rad()) for x in at]
        for k, name in enumerate(self.angles):  # the angles may be rounded ones
            wide[k] = ball(own[name].lower).union(ball(own[name].upper)) * arb.pi() / 180
        if any(own[name].rounds(x) is False for name, x in self.legs(wide).items() if name != self.fixed):
            raise Refused("a leg has another length there")
        raise Open("the lengths are not those at exactly these angles, which may have been rounded")


def in_order(zeros: Sequence[Zero], variable: int) -> list[Zero]:
    """Poses in the order of an angle from −180° to 180°, by which they are numbered: joint vectors by α.

    Raises:
        Open: it is not decided.
    """
    with ctx.workprec(2 * _ORDER_BITS):
        half, placed = arb.pi(), []
        for zero in zeros:
            angle = zero.within(_ORDER_BITS)[variable]
            placed.append((angle - 2 * half * (angle / (2 * half) + arb(0.5)).mid().floor(), zero))
        placed.sort(key=lambda pair: pair[0].mid())
        if not all(x < y for x, y in pairwise([-half, *(angle for angle, _ in placed), half])):
            raise Open("two poses are at one angle, or one is at 180 degrees, as far as balls tell")
        return [zero for _, zero in placed]
