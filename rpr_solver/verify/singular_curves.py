"""Singular curves of a slice: components with their special points in order, aspects, and poses at points."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from functools import cached_property, partial
from itertools import pairwise

from rpr_solver.contract import Progress
from rpr_solver.verify.claims import Claim, Finding, finding, judged, worked
from rpr_solver.verify.core.reader import Record, spend
from rpr_solver.verify.core.schema import Document
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.regions import Regions
from rpr_solver.verify.special_points import Name, SpecialPoints
from rpr_solver.verify.tables import sorted_turns
from rpr_solver.verify.topology import Classes

_SAYS = {
    "cusp": "a cusp with these digits",
    "turning": "a turning point with these digits",
    "closed-leg": "a pose with a closed leg, with these digits",
}
Strand = tuple[bool, tuple[int, int], tuple[Name, ...]]
"""Whether it is closed, its turns in α and θ, and its special points; of a closed one from the least on."""


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
        self.regions = Regions(self.points, self.members)

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
            curve = "a closed curve with these turns" if strand["closed"] else "a strand between its ends"
            claim = f"{curve}, through these points in this order"
            yield worked(at, claim, partial(self._strand, at))
        claim = f"these {len(self.members['components'])} components are all, and so are their special points"
        yield worked("/components", claim, self._complete)
        signs = [aspect["sign"] for aspect in self.members["aspects"]]
        claim = f"these {signs.count(1)} aspects with J > 0 and {signs.count(-1)} with J < 0 are all"
        yield worked("/aspects", claim, partial(self._aspects, signs))
        yield from self.regions.claims()  # they may need all the work that is left

    @cached_property
    def _found(self) -> list[list[Strand]]:
        """The strands of each component that is found anew.

        Raises:
            OpenError: they, or their special points, are not.
        """
        chains, _ = list(self.points.topology.chains()), self.regions.cusps
        parts = Classes(range(len(chains)))
        first: dict[int, int] = {}
        for k, chain in enumerate(chains):
            for end in chain.ends or ():
                parts.join(k, first.setdefault(end, k))
        found: dict[int, list[Strand]] = {}
        for k, chain in enumerate(chains):
            names = self.points.of_chain(chain)
            found.setdefault(parts.root(k), []).append(_strand(names, chain.turns, closed=chain.ends is None))
        return list(found.values())

    def _listed(self, at: str) -> Strand | None:
        """A strand in the same form; None if a point is not known."""
        strand = self.strands[at]
        names = [self.points.name(f"{at}/vertices/{n}") for n in range(len(strand["vertices"]))]
        known = [name for name in names if name is not None]
        turns = strand["turns"]["alpha"], strand["turns"][f"theta{self.surface.fixed}"]
        return _strand(known, turns, closed=strand["closed"]) if len(known) == len(names) else None

    def _strand(self, at: str) -> Finding:
        found, listed = self._found, self._listed(at)
        right = any(listed in part for part in found)
        return finding(right, "traced from line to line", "no strand is like this")

    def _complete(self) -> Finding:
        def alike(part: Iterable[Strand | None]) -> frozenset[tuple[Strand | None, int]]:
            return frozenset(Counter(part).items())

        found = Counter(map(alike, self._found))
        listed = Counter(
            alike(self._listed(f"/components/{i}/strands/{k}") for k in range(len(part["strands"])))
            for i, part in enumerate(self.members["components"])
        )
        reason = f"there are {found.total()}, not these"
        return finding(listed == found, "each is another one of those traced", reason)

    def _aspects(self, signs: Sequence[int]) -> Finding:
        topology = self.points.topology
        found = Counter(topology.gap_sign(*cell) for cell in set(topology.aspects().values()))
        reason = f"there are {found[1]} with J > 0 and {found[-1]} with J < 0"
        return finding(Counter(signs) == found, "gaps between arcs, joined through the lines", reason)


def turned(names: Sequence[Name]) -> tuple[Name, ...]:
    """A cyclic order, from where on it is least; points that are printed alike have one name."""
    least = min(names, default=None)
    starts = [k for k, name in enumerate(names) if name == least]
    spend(len(names) * (1 + len(starts)))
    return min(((*names[k:], *names[:k]) for k in starts), default=())


def _strand(names: Sequence[Name], turns: tuple[int, int], *, closed: bool) -> Strand:
    return closed, turns, turned(names) if closed else tuple(names)
