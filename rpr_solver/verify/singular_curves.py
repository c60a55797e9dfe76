"""Singular curves of a slice: components with their special points in order, aspects, and poses at points."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cached_property, partial
from itertools import pairwise

from rpr_solver.contract import Progress
from rpr_solver.verify.claims import Claim, ClaimStatus, Finding, OpenError, finding, judged, worked
from rpr_solver.verify.core.reader import Record
from rpr_solver.verify.core.schema import Document
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.poses import number_of_poses
from rpr_solver.verify.special_points import Name, SpecialPoints, is_beyond_reach
from rpr_solver.verify.tables import sorted_turns

_SAYS = {
    "cusp": "a cusp with these digits",
    "turning": "a turning point with these digits",
    "closed-leg": "a pose with a closed leg, with these digits",
}
Component = tuple[tuple[int, int], tuple[Name, ...]]
"""Full turns in α and θ, and the special points in order, from the least one on."""


def singular_claims(document: Document, progress: Progress) -> Iterator[Claim]:
    """The claims of a document of singular curves."""
    progress(0, 1)
    yield from _Curves(document).claims()
    progress(1, 1)


class _Curves:
    def __init__(self, document: Document) -> None:
        self.members = document.members
        self.surface = Surface(document.geometry, document.fixed)
        self.length: Fraction = self.members[f"l{document.fixed}"]
        self.strands: dict[str, Record] = {
            f"/components/{i}/strands/{k}": strand
            for i, part in enumerate(self.members["components"])
            for k, strand in enumerate(part["strands"])
        }
        vertices = {
            f"{at}/vertices/{n}": vertex
            for at, strand in self.strands.items()
            for n, vertex in enumerate(strand["vertices"])
        }
        self.points = SpecialPoints(self.surface, self.length, vertices)

    def claims(self) -> Iterator[Claim]:
        for at, vertex in self.points.listed.items():
            claim = _SAYS.get(vertex["kind"], f"a degenerate pose: {vertex['kind']}")
            yield worked(at, claim, partial(self.points.judged, at))
        cusps = [vertex for vertex in self.points.listed.values() if vertex["kind"] == "cusp"]
        cusps.sort(key=lambda vertex: vertex["cusp"])
        angles = [vertex[f"theta{self.surface.fixed}_deg"].value for vertex in cusps]
        right = [x["cusp"] for x in cusps] == list(range(1, len(cusps) + 1)) and sorted_turns(angles)
        yield judged("/components", "the numbers of the cusps", right, "by their angle, as printed")
        for at, strand in self.strands.items():
            right = all(x["index"] < y["index"] for x, y in pairwise(strand["vertices"]))
            yield judged(f"{at}/vertices", "the special points are in order", right, "by their index")
            claim = "a closed curve with these turns, through these points in this order"
            yield worked(at, claim, partial(self._strand, at))
        claim = f"these {len(self.members['components'])} components are all, and so are their special points"
        yield worked("/components", claim, self._complete)
        yield from self._regions()
        signs = [aspect["sign"] for aspect in self.members["aspects"]]
        claim = f"these {signs.count(1)} aspects with J > 0 and {signs.count(-1)} with J < 0 are all"
        yield worked("/aspects", claim, partial(self._aspects, signs))

    @cached_property
    def _found(self) -> Counter[Component]:
        """The components that are found anew.

        Raises:
            OpenError: they, or their special points, are not.
        """
        chains = list(self.points.topology.chains())
        if not self.points.cusps[1].complete:
            raise OpenError("it is not proved that these cusps are all")
        return Counter((chain.turns, turned(self.points.of_chain(chain))) for chain in chains)

    def _listed(self, at: str) -> Component | None:
        """A strand in the same form; None if a point is not known, or it is not closed."""
        strand = self.strands[at]
        names = [self.points.name(f"{at}/vertices/{n}") for n in range(len(strand["vertices"]))]
        known = [name for name in names if name is not None]
        turns = strand["turns"]["alpha"], strand["turns"][f"theta{self.surface.fixed}"]
        return (turns, turned(known)) if strand["closed"] and len(known) == len(names) else None

    def _strand(self, at: str) -> Finding:
        found, listed = self._found, self._listed(at)
        right = listed is not None and found[listed] > 0
        return finding(right, "traced from line to line", "no component is like this")

    def _complete(self) -> Finding:
        found = self._found
        if any(len(part["strands"]) != 1 for part in self.members["components"]):
            return ClaimStatus.REFUSED, "each component is one closed curve"
        right = Counter(map(self._listed, self.strands)) == found
        return finding(right, "each is another one of those traced", f"there are {found.total()}, not these")

    def _regions(self) -> Iterator[Claim]:
        regions: Sequence[Record] = self.members["regions"]
        for n, region in enumerate(regions):
            at, claim = f"/regions/{n}", f"{region['poses']} poses at its point"
            yield worked(f"{at}/poses", claim, partial(self._poses_at, region))
            claim = "the region is bounded" if region["bounded"] else "the region is unbounded"
            yield worked(f"{at}/bounded", claim, partial(self._bounded, region))
        right = [region["bounded"] for region in regions].count(False) == 1
        yield judged("/regions", "one region is unbounded", right, "that of all legs that are long enough")
        reason = "where the images of the components cross each other is not found anew"
        yield Claim("/regions", f"these {len(regions)} regions are all", ClaimStatus.NOT_CHECKED, reason)

    def _poses_at(self, region: Record) -> Finding:
        lengths = {**region["point"], f"l{self.surface.fixed}": self.length}
        squares = lengths["l1"] ** 2, lengths["l2"] ** 2, lengths["l3"] ** 2
        number = number_of_poses(self.surface.geometry, squares)
        if number is None:
            raise OpenError("two poses coalesce there, or the linear equations are dependent")
        return finding(number == region["poses"], "by Descartes' rule of signs", f"there are {number}")

    def _bounded(self, region: Record) -> Finding:
        far = any(
            is_beyond_reach(self.surface, self.length, leg, region["point"][f"l{leg}"])
            for leg in self.surface.free
        )
        if not region["bounded"]:
            if far:
                return ClaimStatus.PROVED, "at no pose a leg is as long as at its point, or longer"
            raise OpenError("its point is not beyond the reach of a leg")
        if far:
            return ClaimStatus.REFUSED, "its point is beyond the reach of a leg"
        if not region["poses"]:
            raise OpenError("a region without poses may be joined to the unbounded one")
        found = self._poses_at(region)
        return found if found[0] is not ClaimStatus.PROVED else (found[0], "there are no poses far away")

    def _aspects(self, signs: Sequence[int]) -> Finding:
        topology = self.points.topology
        found = Counter(topology.gap_sign(*cell) for cell in set(topology.aspects().values()))
        reason = f"there are {found[1]} with J > 0 and {found[-1]} with J < 0"
        return finding(Counter(signs) == found, "gaps between arcs, joined through the lines", reason)


def turned(names: Sequence[Name]) -> tuple[Name, ...]:
    """A cyclic order, from its least member on."""
    first = names.index(min(names)) if names else 0
    return (*names[first:], *names[:first])
