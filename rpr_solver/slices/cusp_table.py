"""The cusp tables of slices: counted exactly, printed to proved digits, with their certificates."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cached_property

from rpr_solver.contract import DEFAULT_DIGITS, check_digits, check_leg, check_type
from rpr_solver.errors import SolverError
from rpr_solver.exact.rationals import Exact
from rpr_solver.exact.real_roots import number_of_real_roots
from rpr_solver.model.lengths import slice_length, slice_lengths
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.slices.eliminant import Eliminant, kept_eliminant
from rpr_solver.slices.reference import ReferenceSlice
from rpr_solver.slices.slice_table import SliceTable

_FEWEST, _FEWEST_TO_IMPORT = 4, 64
"""Fewer slices do not repay what proves many at once, or the import of numpy for it."""


class SliceSolver:
    """Slices of one manipulator and fixed leg, each solved when it is asked for.

    Args:
        eliminant: of the manipulator and its fixed leg.
        lengths: of the fixed leg, in the user's unit, > 0.
        digits: significant digits of every printed number.
    """

    def __init__(self, eliminant: Eliminant, lengths: Sequence[Fraction], digits: int) -> None:
        self._eliminant, self._lengths, self._digits = eliminant.expect(len(lengths)), lengths, digits
        self._fast: Callable[[int], SliceTable | None] = lambda _place: None
        if len(lengths) >= (_FEWEST if "numpy" in sys.modules else _FEWEST_TO_IMPORT):
            from rpr_solver.slices.fast.scan import Scan  # few slices need none of it

            self._fast = Scan(eliminant, lengths, digits).table

    def table(self, place: int) -> SliceTable:
        """The table of one of the slices.

        Raises:
            SolverError: the slice could not be decided.
        """
        table = self._fast(place)
        return table or ReferenceSlice(self._eliminant, self._lengths[place], self._digits).solve()


class CountedSlice:
    """A slice whose cusps are counted at once, and computed when they are asked for.

    Args:
        eliminant: of the manipulator and its fixed leg.
        length: of the fixed leg, in the user's unit, > 0.
        digits: significant digits of every printed number.

    Raises:
        SolverError: the slice could not be decided.
    """

    def __init__(self, eliminant: Eliminant, length: Fraction, digits: int) -> None:
        self.length, self.digits = length, digits
        self._reference = ReferenceSlice(eliminant, length, digits)
        q = eliminant.at(self._reference.scaled)
        self.count = number_of_real_roots(q) if self._reference.is_generic else self.table.count

    @cached_property
    def table(self) -> SliceTable:
        """The cusps."""
        return self._reference.solve()

    @property
    def degenerate_points(self) -> Sequence[Mapping[str, str]]:
        """As in the table."""
        return () if self._reference.is_generic else self.table.degenerate_points


def cusp_table(
    manipulator: Manipulator,
    lengths: Exact | Iterable[Exact],
    *,
    digits: int = DEFAULT_DIGITS,
    fixed_leg: int = 1,
) -> list[SliceTable]:
    """The cusps of the slices of a manipulator, counted by proof.

    In a slice one leg has a fixed length. The cusps of a slice are the joint vectors at which exactly three
    poses coalesce: J = 0 (the article's equation 6) and E = 0 (equivalent there to its equation 10), with
    proof that no further pose coalesces.

    The elimination (10 to 40 ms) of the manipulators asked for last is kept, so that a loop of single lengths
    costs a few milliseconds each; in one call with all lengths each costs a half to a third of that.

    Args:
        manipulator: the geometry.
        lengths: one length of the fixed leg or several, exact (see :data:`Exact`), > 0, in the user's unit.
            A text is one number, never a sequence.
        digits: significant digits of every printed number, 15 to 10000; all are proved.
        fixed_leg: the leg of fixed length, 1, 2 or 3.

    Returns:
        A table for each length, in the order of ``lengths``.

    Raises:
        InputError: naming each length at fault by the leg and its place (``l1[0]``), or ``digits``,
            ``fixed_leg`` or ``manipulator``.
        SolverError: a slice could not be decided.

    >>> from rpr_solver import EXAMPLES
    >>> cusp_table(EXAMPLES["zein-flat"], [10, "34.5"], digits=15)
    [<SliceTable L1=10: 4 cusps, 15 digits>, <SliceTable L1=34.5: 8 cusps, 15 digits>]
    """
    digits, leg = check_digits(digits), check_leg(fixed_leg)
    exact = slice_lengths(lengths, leg)
    eliminant = kept_eliminant(manipulator, leg)
    solver = SliceSolver(eliminant, exact, digits)
    return [solver.table(place) for place in range(len(exact))]


def solve_slice(eliminant: Eliminant, length: Exact, digits: int = DEFAULT_DIGITS) -> SliceTable:
    """All cusps of one slice; several slices of one manipulator share its eliminant.

    Args:
        eliminant: of the manipulator and its fixed leg (see :func:`eliminate`).
        length: of the fixed leg, exact, > 0, in the user's unit.
        digits: significant digits of every printed number, 15 to 10000; all are proved.

    Raises:
        InputError: ``length`` (named by the leg, such as ``l1``), ``digits`` or ``eliminant`` is wrong.
        SolverError: the slice could not be decided.

    >>> from rpr_solver import EXAMPLES, eliminate
    >>> eliminant = eliminate(EXAMPLES["zein-flat"])
    >>> [solve_slice(eliminant, length, 15).count for length in ("10", "34.5", 100)]
    [4, 8, 4]
    """
    check_type(eliminant, Eliminant, "eliminant")
    exact = slice_length(length, eliminant.slice_map.fixed_leg)
    return SliceSolver(eliminant, [exact], check_digits(digits)).table(0)


def solve_slices(
    eliminant: Eliminant, lengths: Exact | Iterable[Exact], digits: int = DEFAULT_DIGITS
) -> Iterator[SliceTable | SolverError]:
    """The cusps of many slices of one manipulator, several times faster than one by one.

    Each table is that of :func:`solve_slice`, byte for byte. They come one by one, in the order of lengths;
    a slice that could not be decided has its error in the place of its table.

    Args:
        eliminant: of the manipulator and its fixed leg (see :func:`eliminate`).
        lengths: of the fixed leg, exact (see :data:`Exact`), > 0, in the user's unit.
        digits: significant digits of every printed number, 15 to 10000; all are proved.

    Raises:
        InputError: naming each length at fault by the leg and its place (``l1[0]``), ``digits`` or
            ``eliminant``.

    >>> from rpr_solver import EXAMPLES, eliminate
    >>> tables = solve_slices(eliminate(EXAMPLES["zein-flat"]), range(5, 45, 5), 15)
    >>> [table.count for table in tables]
    [4, 4, 4, 4, 6, 6, 8, 4]
    """
    check_type(eliminant, Eliminant, "eliminant")
    exact = slice_lengths(lengths, eliminant.slice_map.fixed_leg)
    return _tables(SliceSolver(eliminant, exact, check_digits(digits)), len(exact))


def _tables(solver: SliceSolver, size: int) -> Iterator[SliceTable | SolverError]:
    for place in range(size):
        try:
            yield solver.table(place)
        except SolverError as error:
            yield error
