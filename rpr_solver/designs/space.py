"""The geometries among which a design is sought: what varies and how far, ties between lengths, roundings.

A geometry is a function of *parameters*: its six lengths, or fewer numbers if a tie binds them, as that both
triangles are isosceles. Each parameter is varied within two bounds, or fixed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise, permutations
from math import atan2, ceil, floor, tan
from typing import TypeAlias

from rpr_solver.contract import LENGTHS, check_integer
from rpr_solver.errors import InputError, shown
from rpr_solver.exact.numerals import check_doubles, double
from rpr_solver.exact.rationals import Exact, exact_str, parse_all, parse_exact, parse_not_negative
from rpr_solver.model.lengths import ExactBounds
from rpr_solver.model.manipulator import Length, Manipulator
from rpr_solver.triangles import CCW, CW, Surd

Parameters: TypeAlias = Mapping[str, Fraction]
Sides: TypeAlias = tuple[Fraction, Fraction, Fraction]
Vary: TypeAlias = str | Exact | Mapping[str, ExactBounds]

DEFAULT_VARY, DEFAULT_DECIMALS, MOST_DECIMALS = "10%", 4, 12
_NARROW = Fraction(1, 10**12)
"""The least width of bounds, relative to their values."""
_FLAT, _FLATTEST = 100, 10_000
"""A triangle is nearly flat if its least height is smaller than this part of its longest side: the first, or
the second if the least height is given. Flatter ones take longer and longer."""
_NEAR = Fraction(1, 10**6)
"""Triangles are nearly congruent or similar if the squares of their sides miss it by no more than this share.
The less they miss it by, the longer they take, unless they are exactly so."""


@dataclass(frozen=True)
class Tie:
    """A family of geometries: the six lengths as functions of parameters, and the parameters of the nearest
    geometry of the family, in floats."""

    meaning: str
    lengths: Callable[[Parameters], tuple[Fraction, ...]]
    nearest: Callable[[Manipulator], Mapping[str, float]]
    orientation: Callable[[Manipulator], str] = lambda manipulator: manipulator.orientation


def _corner(base: Fraction, half: Fraction) -> tuple[Fraction, Fraction]:
    """The point at a distance from the origin in a direction, by the tangent of half its angle."""
    size = 1 + half * half
    return base * (1 - half * half) / size, 2 * base * half / size


def _half_tangent(x: float, y: float) -> float:
    return tan(atan2(y, x) / 2)


def _isosceles_1(p: Parameters) -> tuple[Fraction, ...]:
    return (p["a2x"], *_corner(p["a2x"], p["t1"]), p["d1"], p["d2"], p["d1"])


def _isosceles_2(p: Parameters) -> tuple[Fraction, ...]:
    x, y = _corner(p["a2x"], p["t2"])
    return (p["a2x"], p["a2x"] - x, y, p["d1"], p["d1"], p["d3"])


def _isosceles_3(p: Parameters) -> tuple[Fraction, ...]:
    return (p["a2x"], p["a2x"] / 2, p["a3y"], p["d1"], p["d2"], p["d2"])


def _triangle(p: Parameters) -> tuple[Fraction, ...]:
    """a2x, A3 and the sides of the triangle with the half-angle tangents t1 at A1 and t2 at A2: rationals."""
    base, t1, t2 = p["a2x"], p["t1"], p["t2"]
    whole = (t1 + t2) * (1 - t1 * t2)
    if whole == 0:
        raise InputError.of("t1", "gives no triangle together with t2")
    first = base * t2 * (1 + t1 * t1) / whole
    second = base * t1 * (1 + t2 * t2) / whole
    return (base, *_corner(first, t1), abs(base), abs(second), abs(first))


def _similar(p: Parameters) -> tuple[Fraction, ...]:
    base, x, y, *sides = _triangle(p)
    return (base, x, y, *(p["ratio"] * side for side in sides))


def _floats(m: Manipulator) -> dict[str, float]:
    return dict(zip(LENGTHS, m.doubles(), strict=True))


def _near_isosceles_1(m: Manipulator) -> Mapping[str, float]:
    g = _floats(m)
    half = _half_tangent(g["a3x"], g["a3y"])
    return {"a2x": g["a2x"], "t1": half, "d1": (g["d1"] + g["d3"]) / 2, "d2": g["d2"]}


def _near_isosceles_2(m: Manipulator) -> Mapping[str, float]:
    g = _floats(m)
    half = _half_tangent(g["a2x"] - g["a3x"], g["a3y"])
    return {"a2x": g["a2x"], "t2": half, "d1": (g["d1"] + g["d2"]) / 2, "d3": g["d3"]}


def _near_isosceles_3(m: Manipulator) -> Mapping[str, float]:
    g = _floats(m)
    return {"a2x": g["a2x"], "a3y": g["a3y"], "d1": g["d1"], "d2": (g["d2"] + g["d3"]) / 2}


def _near_similar(m: Manipulator) -> Mapping[str, float]:
    g = _floats(m)
    halves = {"t1": _half_tangent(g["a3x"], g["a3y"]), "t2": _half_tangent(g["a2x"] - g["a3x"], g["a3y"])}
    return {"a2x": g["a2x"], **halves, "ratio": g["d1"] / abs(g["a2x"])}


def _near_congruent(m: Manipulator) -> Mapping[str, float]:
    return {name: x for name, x in _near_similar(m).items() if name != "ratio"}


def _of_base(m: Manipulator) -> str:
    return m.geometry.base.sense if m.geometry.base.area16 else CW


def _against_base(m: Manipulator) -> str:
    return CW if _of_base(m) == CCW else CCW


TIES: Mapping[str, Tie] = {
    "isosceles-1": Tie("|A1A2| = |A1A3| and d1 = d3", _isosceles_1, _near_isosceles_1),
    "isosceles-2": Tie("|A2A1| = |A2A3| and d1 = d2", _isosceles_2, _near_isosceles_2),
    "isosceles-3": Tie("|A3A1| = |A3A2| and d2 = d3", _isosceles_3, _near_isosceles_3),
    "similar": Tie("the platform is the base, enlarged", _similar, _near_similar, _of_base),
    "congruent": Tie("the platform is the base", _triangle, _near_congruent, _of_base),
    "mirror": Tie("the platform is the mirror image of the base", _triangle, _near_congruent, _against_base),
}
"""Families of geometries by name. t1 and t2 are the tangents of half the angles of the base at A1 and A2."""

NO_TIE = Tie("the six lengths", lambda p: tuple(p[name] for name in LENGTHS), _floats)


@dataclass(frozen=True)
class Space:
    """What varies in a design.

    Attributes:
        start: the given geometry.
        tie: the family of geometries.
        values: the parameters of the start.
        bounds: the least and the greatest value of each parameter that varies.
        decimals: those to which parameters are rounded.
        min_height: the least height of both triangles; None if only nearly flat ones are left out.
    """

    start: Manipulator
    tie: Tie
    values: Parameters
    bounds: Mapping[str, tuple[Fraction, Fraction]]
    decimals: int
    min_height: Fraction | None

    @classmethod
    def of(
        cls,
        start: Manipulator,
        vary: Vary = DEFAULT_VARY,
        fixed: Sequence[str] = (),
        decimals: int = DEFAULT_DECIMALS,
        min_height: Exact | None = None,
        family: str | None = None,
    ) -> Space:
        """Reads what may vary.

        Args:
            start: the geometry to start from.
            vary: how far parameters may change: a text such as ``"15%"`` of each one's size, that of a3x and
                a3y being |A1A3|; or bounds by name, others then keeping their values.
            fixed: names that keep their values.
            decimals: those to which candidates are rounded, and an irrational length that varies; a value
                that does not vary stays exact.
            min_height: the least height of both triangles.
            family: a name in TIES.

        Raises:
            InputError: naming the argument at fault.
        """
        if family is not None and family not in TIES:
            raise InputError.of("family", f"is {shown(family)}; give one of {', '.join(TIES)}")
        places = check_integer(decimals, "decimals", f"0 to {MOST_DECIMALS}", 0, MOST_DECIMALS)
        tie = NO_TIE if family is None else TIES[family]
        near = tie.nearest(start)
        values = {name: _rounded(Fraction(x), places) for name, x in near.items()}
        if family is None:
            values |= {
                name: x for name, x in zip(LENGTHS, start.lengths, strict=True) if isinstance(x, Fraction)
            }
        bounds = _bounds(start, values, vary)
        for k, end in enumerate(("from", "to")):
            check_doubles({f"vary.{name}.{end}": ends[k] for name, ends in bounds.items()}, "designs")
        _check_fixed(fixed, values, vary)
        bounds = {name: ends for name, ends in bounds.items() if name not in fixed and ends[0] < ends[1]}
        _check_widths(bounds)
        least = None if min_height is None else parse_not_negative(min_height, "min_height")
        space = cls(start, tie, values, bounds, places, least)
        space._check_exact()
        return space

    @cached_property
    def origin(self) -> Mapping[str, float]:
        """The parameters of the start in floats, of irrational lengths, too."""
        exact = self.tie.nearest(self.start) if self.tie is NO_TIE else {}
        return {name: exact.get(name, double(x)) for name, x in self.values.items()}

    @property
    def names(self) -> tuple[str, ...]:
        """The parameters that vary."""
        return tuple(self.bounds)

    def place(self, manipulator: Manipulator) -> list[float]:
        """The parameters that vary, each 0 at its lower bound and 1 at its upper one."""
        nearest = self.tie.nearest(manipulator)
        return [
            (nearest[name] - double(low)) / double(high - low) for name, (low, high) in self.bounds.items()
        ]

    def lengths(self, place: Sequence[float]) -> list[float]:
        """The six lengths at a place, in floats."""
        return [double(x) for x in self.tie.lengths(self._parameters(place))]

    def manipulator(self, place: Sequence[float]) -> Manipulator | None:
        """The rounded geometry at a place; None if it is none, or a triangle is too flat."""
        parameters = self._parameters(place)
        unit = 10**self.decimals
        for name, (low, high) in self.bounds.items():
            rounded = min(max(round(parameters[name] * unit), ceil(low * unit)), floor(high * unit))
            parameters[name] = Fraction(rounded, unit)
        try:
            found = self._exact(parameters)
        except InputError:
            return None
        return found if self.is_high(found) and not is_nearly_special(found) else None

    def _exact(self, parameters: Parameters) -> Manipulator:
        """The geometry; without a tie lengths that do not vary are those of the start, irrational or not."""
        lengths: Sequence[Length] = self.tie.lengths(parameters)
        if self.tie is NO_TIE:
            each = zip(LENGTHS, self.start.lengths, lengths, strict=True)
            lengths = [moved if name in self.bounds else own for name, own, moved in each]
        a2x, a3x, a3y, d1, d2, d3 = lengths
        return Manipulator(a2x, a3x, a3y, d1, d2, d3, self.tie.orientation(self.start))

    def _check_exact(self) -> None:
        """Refuses irrational lengths that are kept beside those that vary, where no triangle has both."""
        roots = [name for name, x in zip(LENGTHS, self.start.lengths, strict=True) if isinstance(x, Surd)]
        if self.tie is NO_TIE and (kept := [name for name in roots if name not in self.bounds]):
            try:
                self._exact(self.values)
            except InputError:
                text = f"keeps {kept[0]} = {getattr(self.start, kept[0])} and varies others of its triangle"
                raise InputError.of("vary", f"{text}; let all of them vary, or none") from None

    def is_high(self, m: Manipulator) -> bool:
        """Whether both triangles are as high as they must be."""
        for triangle in (m.geometry.base, m.geometry.platform):
            area4, longest = (
                triangle.area16,
                max(triangle.squares),
            )  # the height on it is (area4/4/longest)^(1/2)
            least = longest / _FLAT**2
            if self.min_height is not None:
                least = max(self.min_height**2, longest / _FLATTEST**2)
            if area4 < 4 * longest * least:
                return False
        return True

    def reach(self, name: str) -> Fraction:
        """How far a parameter may change from its start."""
        low, high = self.bounds[name]
        return max(high - self.values[name], self.values[name] - low)

    def _parameters(self, place: Sequence[float]) -> dict[str, Fraction]:
        moved = {
            name: low + (high - low) * Fraction(x)
            for (name, (low, high)), x in zip(self.bounds.items(), place, strict=True)
        }
        return {**self.values, **moved}


def is_nearly_special(m: Manipulator) -> bool:
    """Whether the triangles nearly are congruent, whatever the names of the corners, or similar, but not so
    exactly.

    >>> [is_nearly_special(Manipulator(4, 0, 3, *sides)) for sides in ((4, 5, 3), (5, "3.000001", 4))]
    [False, True]
    """
    base, platform = m.geometry.base.squares, m.geometry.platform.squares
    turned = [
        (x * w, y * z)
        for (x, z), (y, w) in pairwise(zip((*base, base[0]), (*platform, platform[0]), strict=True))
    ]
    for pairs in (turned, *(list(zip(base, sides, strict=True)) for sides in permutations(platform))):
        if any(x != y for x, y in pairs) and all(abs(x - y) <= _NEAR * max(x, y) for x, y in pairs):
            return True
    return False


def _rounded(x: Fraction, decimals: int) -> Fraction:
    return Fraction(round(x * 10**decimals), 10**decimals)


def _check_fixed(fixed: Sequence[str], known: Iterable[str], vary: Vary) -> None:
    """Refuses names that keep their values but are unknown, or have bounds."""
    if unknown := [name for name in fixed if name not in known]:
        raise InputError.of("fixed", f"{shown(unknown[0])} is unknown; give some of {', '.join(known)}")
    if both := [name for name in fixed if isinstance(vary, Mapping) and name in vary]:
        raise InputError.of("fixed", f"has {both[0]}, which also has bounds in vary; leave it out of one")


def _check_widths(bounds: Mapping[str, tuple[Fraction, Fraction]]) -> None:
    """Refuses bounds if there are none, or if doubles do not tell two of them apart."""
    if not bounds:
        raise InputError.of("vary", "leaves nothing that varies")
    for name, (low, high) in bounds.items():
        if high - low < _NARROW * max(abs(low), abs(high)):
            raise InputError.of(f"vary.{name}", "is too narrow for a search in doubles; leave it out")


def _bounds(start: Manipulator, values: Parameters, vary: Vary) -> dict[str, tuple[Fraction, Fraction]]:
    if isinstance(vary, Mapping):
        unknown = [name for name in vary if name not in values]
        if unknown or not vary:
            name = f"vary.{unknown[0]}" if unknown else "vary"
            raise InputError.of(name, f"give bounds of some of {', '.join(values)}")
        read = parse_all({f"vary.{name}": ends for name, ends in vary.items()}, _ends)
        return {name: read[f"vary.{name}"] for name in vary}
    share = percent(vary)
    sizes = {name: abs(x) for name, x in values.items()}
    _, a3x, a3y, *_ = start.doubles()
    corner = Fraction((a3x**2 + a3y**2) ** 0.5)
    sizes.update({name: corner for name in ("a3x", "a3y") if name in sizes})
    return {name: (x - share * sizes[name], x + share * sizes[name]) for name, x in values.items()}


def percent(value: object) -> Fraction:
    """Reads ``"15%"`` exactly.

    Raises:
        InputError: naming ``vary``.
    """
    if not isinstance(value, str) or not value.strip().endswith("%"):
        raise InputError.of("vary", f'is {shown(value)}; give a share such as "15%", or bounds by name')
    share = parse_exact(value.strip()[:-1], "vary") / 100
    if not 0 < share < 1:
        raise InputError.of("vary", f"is {shown(value)}; give more than 0% and less than 100%")
    return share


def _ends(ends: ExactBounds, field: str) -> tuple[Fraction, Fraction]:
    if isinstance(ends, str | bytes) or not isinstance(ends, Sequence) or len(ends) != 2 or None in ends:
        raise InputError.of(field, f"is {shown(ends)}; give (from, to)")
    low, high = (parse_exact(end, field) for end in ends if end is not None)
    if high < low:
        raise InputError.of(field, f"ends at {exact_str(high)}, below its start {exact_str(low)}")
    return low, high
