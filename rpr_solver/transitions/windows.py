"""Windows of lengths that are narrow enough to be ignored, decided exactly.

A window of a requirement is a longest stretch of lengths, in the range that is asked for, in which the number
of cusps is not admitted: neighbouring intervals that violate the requirement are one window, and its width is
that of all of them together, within the range. A window is ignored if it is narrower than a given width, not
if it is as wide. So a larger width ignores no fewer windows. In a census, which requires nothing, each
interval between two transitions is a window.

Widths are compared in balls, at rising precision; those between rational lengths exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import groupby
from typing import Any

from flint import arb, ctx

from rpr_solver.exact import decided
from rpr_solver.exact.decimals import round_all
from rpr_solver.exact.precision import EVENT_BITS
from rpr_solver.exact.rationals import exact_str
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.notebook import counted, shortened
from rpr_solver.transitions.event_systems import Event

WIDTH_DIGITS = 6
"""Significant digits of a printed width: one tells a reader how narrow it is, six tell windows apart."""
_BITS = 256

End = Fraction | Sequence[Event] | None
"""An end of an interval: exact, in the user's unit; or simultaneous events; None is an open end."""


@dataclass(frozen=True)
class IgnoredWindow:
    """A window that is narrower than what is ignored.

    Attributes:
        start, stop: its ends, as those of intervals.
        width: its width, correctly rounded to six digits.
        counts: the numbers of cusps of the intervals that make it up, ascending in length.

    >>> IgnoredWindow("31.8632047694475", "31.8635738939382", "0.000369125", counts=(8,))
    <IgnoredWindow 31.863204… to 31.863573…, 0.000369125 wide: 8 cusps>
    """

    start: str
    stop: str
    width: str
    counts: tuple[int, ...]

    def __repr__(self) -> str:
        numbers = [*map(str, self.counts[:-1]), counted(self.counts[-1], "cusp")]
        ends = f"{shortened(self.start)} to {shortened(self.stop)}"
        return f"<IgnoredWindow {ends}, {self.width} wide: {', '.join(numbers)}>"

    def to_json(self) -> dict[str, Any]:
        """The contract's object."""
        return {"from": self.start, "to": self.stop, "width": self.width, "counts": list(self.counts)}


@dataclass(frozen=True)
class Part:
    """An interval of lengths whose slices all have one number of cusps.

    Attributes:
        start, stop: its ends.
        texts: the same as documents have them.
        count: the number of cusps.
    """

    start: End
    stop: End
    texts: tuple[str, str | None]
    count: int


def narrow_windows(
    slice_map: SliceMap, parts: Iterable[Part], admits: Callable[[int], bool], least: Fraction
) -> Iterator[tuple[list[Part], IgnoredWindow | None]]:
    """The windows of a requirement, each with its parts; None beside one that is not ignored.

    Args:
        slice_map: the slices; its scale is that of the events.
        parts: the range in ascending intervals.
        admits: whether the requirement admits a number of cusps.
        least: windows that are narrower are ignored, in the user's unit.

    Raises:
        Unproved: a window is as wide as ``least``, or so nearly that it could not be decided.
    """
    for is_admitted, same in groupby(parts, key=lambda part: admits(part.count)):
        if not is_admitted:
            run = list(same)
            yield run, ignored(slice_map, run, least)


def ignored(slice_map: SliceMap, run: Sequence[Part], least: Fraction) -> IgnoredWindow | None:
    """The window that neighbouring intervals make up, if it is narrower than ``least``; else None.

    Raises:
        Unproved: as :func:`narrow_windows`.
    """
    first, last = run[0], run[-1]
    if last.stop is None or not least:
        return None
    width = _width(slice_map, first.start, last.stop)

    def is_narrower(bits: int) -> bool | None:
        value = width(bits)
        if isinstance(value, Fraction):
            return value < least
        with ctx.workprec(bits):
            excess = value - arb(least.numerator) / least.denominator
        return True if excess < 0 else False if excess > 0 else None

    def text(bits: int) -> str | None:
        with ctx.workprec(bits):
            texts = round_all([width(bits)], WIDTH_DIGITS)
        return None if texts is None else texts[0]

    unproved = (
        f"whether a window is narrower than {exact_str(least)} could not be decided; give another width"
    )
    if not decided(is_narrower, _BITS, EVENT_BITS, unproved):
        return None
    printed = decided(text, _BITS, EVENT_BITS, "the width of a window could not be decided")
    assert last.texts[1] is not None
    return IgnoredWindow(first.texts[0], last.texts[1], printed, tuple(part.count for part in run))


def _width(slice_map: SliceMap, start: End, stop: End) -> Callable[[int], Fraction | arb]:
    """The width between two ends: exact if both are rational, else a ball for any number of bits."""
    low, high = _exact(slice_map, start), _exact(slice_map, stop)
    if low is not None and high is not None:
        return lambda _bits: high - low

    def width(bits: int) -> arb:
        with ctx.workprec(bits):
            return _ball(slice_map, stop, bits) - _ball(slice_map, start, bits)

    return width


def _exact(slice_map: SliceMap, end: End) -> Fraction | None:
    """An end as a rational number, in the user's unit; None if it is not known to be one."""
    if isinstance(end, Fraction):
        return end
    numbers = (event.exact_length for event in end or ())
    rational = next((x.rational for x in numbers if x is not None and x.rational is not None), None)
    return None if rational is None else rational / slice_map.scale


def _ball(slice_map: SliceMap, end: End, bits: int) -> arb:
    assert end is not None
    if isinstance(end, Fraction):
        return arb(end.numerator) / end.denominator
    return end[0].scaled_length(bits) / slice_map.scale_ball()
