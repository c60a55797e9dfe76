"""Slices, counted exactly: as tables, and as the contract's objects and documents.

A slice without an answer reports the error in its own entry; other slices are unaffected.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

from rpr_solver.contract import (
    DEFAULT_DIGITS,
    Progress,
    check_digits,
    check_leg,
    check_type,
    document_head,
    silent,
)
from rpr_solver.errors import InputError, SolverError
from rpr_solver.exact.rationals import Exact, exact_str, one_or_more, parse_all, parse_exact
from rpr_solver.model.joint_points import coordinate_names, shortened_points
from rpr_solver.model.lengths import slice_length, slice_lengths
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.notebook import csv_text
from rpr_solver.slices.eliminant import Eliminant, kept_eliminant
from rpr_solver.slices.reference import ReferenceSlice
from rpr_solver.slices.shared_joints import shared_slice
from rpr_solver.slices.single import single_slice
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
        self._remark = eliminant.manipulator.remark
        self._fast: Callable[[int], SliceTable | None] = lambda _place: None
        if eliminant.manipulator.geometry.shared_joints:
            self._fast = lambda place: shared_slice(eliminant.slice_map, lengths[place], digits)
        elif len(lengths) >= (_FEWEST if "numpy" in sys.modules else _FEWEST_TO_IMPORT):
            from rpr_solver.slices.fast import Scan  # few slices need none of it

            self._fast = Scan(eliminant, lengths, digits).table

    def table(self, place: int) -> SliceTable:
        """The table of one of the slices.

        Raises:
            SolverError: the slice could not be decided.
        """
        table = self._fast(place)
        if table is None:
            reference = ReferenceSlice(self._eliminant, self._lengths[place], self._digits)
            table = single_slice(reference) or reference.solve()
        return replace(table, remark=self._remark) if self._remark else table


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


Solve = Callable[[Fraction], dict[str, Any]]
"""The contract's slice object for a length of the fixed leg, in the user's unit."""


def table_document(
    manipulator: Manipulator,
    lengths: Exact | Iterable[Exact],
    *,
    fixed_leg: int = 1,
    digits: int = DEFAULT_DIGITS,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Solves slices of one manipulator and returns the contract's cusp table document.

    The entry of a slice without an answer, or of a length that is not positive, is an ``error``.

    Args:
        manipulator: the geometry.
        lengths: one length of the fixed leg or several, exact, in the user's unit.
        fixed_leg: the leg whose length is fixed, 1, 2 or 3.
        digits: significant digits of every printed number, 15 to 10000; all are proved.
        progress: callback ``progress(done, total)``.

    Raises:
        InputError: naming ``manipulator``, ``fixed_leg``, ``digits``, or each length that is not an exact
            number.

    >>> from rpr_solver import EXAMPLES
    >>> document = table_document(EXAMPLES["zein-flat"], [10, "34.5", 0], digits=15)
    >>> [part["count"] if "count" in part else part["error"]["type"] for part in document["slices"]]
    [4, 8, 'input-error']
    """
    digits, leg = check_digits(digits), check_leg(fixed_leg)
    exact = list(parse_all(one_or_more(lengths, f"l{leg}"), parse_exact).values())
    eliminant = kept_eliminant(manipulator, leg)
    slices = slices_json(SliceAnswers(eliminant, exact, digits), exact, leg, progress)
    return table_json(manipulator, leg, digits, slices)


def slice_json(eliminant: Eliminant, length: Exact, digits: int = DEFAULT_DIGITS) -> dict[str, Any]:
    """Solves one slice and returns the contract's slice object, with an ``error`` if there is no answer.

    Args:
        eliminant: of the manipulator and its fixed leg (see :func:`eliminate`).
        length: of the fixed leg, exact, in the user's unit.
        digits: significant digits of every printed number, 15 to 10000; all are proved.

    Raises:
        InputError: naming ``eliminant``, or the leg whose length is not an exact number.

    >>> from rpr_solver import EXAMPLES, eliminate
    >>> slice_json(eliminate(EXAMPLES["zein-flat"]), "10.0", 15)["count"]
    4
    """
    check_type(eliminant, Eliminant, "eliminant")
    exact = parse_exact(length, f"l{eliminant.slice_map.fixed_leg}")
    return SliceAnswers(eliminant, [exact], digits)(exact)


class SliceAnswers:
    """The contract's slice objects of many lengths, each solved when it is asked for.

    Args:
        eliminant: of the manipulator and its fixed leg.
        lengths: that will be asked for, exact, in the user's unit; others can be, too, but take longer.
        digits: significant digits of every printed number, 15 to 10000; all are proved.
    """

    def __init__(self, eliminant: Eliminant, lengths: Iterable[Fraction], digits: int) -> None:
        self._eliminant, self._digits = eliminant, digits
        positive = [x for x in dict.fromkeys(lengths) if x > 0]
        self._places = {x: place for place, x in enumerate(positive)}
        self._solver = SliceSolver(eliminant, positive, digits)

    def __call__(self, length: Fraction) -> dict[str, Any]:
        """The slice object of one length, with an ``error`` if there is no answer."""
        return answer_json(self._solve, length, self._eliminant.slice_map.fixed_leg)

    def _solve(self, length: Fraction) -> dict[str, Any]:
        place = self._places.get(length)
        table = (
            solve_slice(self._eliminant, length, self._digits) if place is None else self._solver.table(place)
        )
        return table.to_json()


def slices_json(
    solve: Solve, lengths: Sequence[Fraction], fixed_leg: int, progress: Progress
) -> list[dict[str, Any]]:
    """The slice objects of several lengths, solved in turn."""
    slices = []
    for done, length in enumerate(lengths):
        progress(done, len(lengths))
        slices.append(answer_json(solve, length, fixed_leg))
    progress(len(lengths), len(lengths))
    return slices


def answer_json(solve: Solve, length: Fraction, fixed_leg: int) -> dict[str, Any]:
    """The slice object of one length, with an ``error`` if ``solve`` raises one."""
    try:
        return solve(length)
    except (InputError, SolverError) as error:
        kind = "input-error" if isinstance(error, InputError) else "solver-error"
        return slice_error_json(length, fixed_leg, kind, str(error))


def slice_error_json(length: Exact, fixed_leg: int, kind: str, detail: str) -> dict[str, Any]:
    """The slice object of a slice without an answer.

    Args:
        length: of the fixed leg, exact, in the user's unit.
        fixed_leg: the leg whose length is fixed, 1, 2 or 3.
        kind: the type of error, such as ``"solver-error"``.
        detail: the error message.

    Raises:
        InputError: naming ``fixed_leg``, or the leg whose length is not an exact number.

    >>> slice_error_json("5.0", 1, "solver-error", "not decided")
    {'l1': '5', 'error': {'type': 'solver-error', 'detail': 'not decided'}}
    """
    name = f"l{check_leg(fixed_leg)}"
    return {name: exact_str(parse_exact(length, name)), "error": {"type": kind, "detail": detail}}


def table_json(
    manipulator: Manipulator, fixed_leg: int, digits: int, slices: Sequence[Mapping[str, object]]
) -> dict[str, Any]:
    """The contract's cusp table document.

    Args:
        manipulator: the geometry.
        fixed_leg: the leg whose length is fixed, 1, 2 or 3.
        digits: the significant digits of every printed number.
        slices: slice objects: :meth:`SliceTable.to_json`, :func:`slice_json` or :func:`slice_error_json`.

    Raises:
        InputError: naming ``manipulator``, ``fixed_leg`` or ``digits``.

    >>> from rpr_solver import EXAMPLES, cusp_table
    >>> manipulator = EXAMPLES["zein-flat"]
    >>> tables = cusp_table(manipulator, [10, "34.5"], digits=15)
    >>> list(table_json(manipulator, 1, 15, [table.to_json() for table in tables]))
    ['geometry', 'geometry_hash', 'fixed_leg', 'digits', 'solver_version', 'slices']
    """
    check_type(manipulator, Manipulator, "manipulator")
    head = document_head(manipulator, check_digits(digits), check_leg(fixed_leg))
    return {**head, "slices": [dict(s) for s in slices]}


def shorten_slice(slice_json: Mapping[str, Any], have_digits: int, digits: int) -> dict[str, Any] | None:
    """Rounds a slice object to fewer digits; None if its digits are insufficient to decide the rounding.

    Every number is correctly rounded, as if it had been computed with ``digits``.

    Args:
        slice_json: the contract's slice object (:meth:`SliceTable.to_json`).
        have_digits: the significant digits of its numbers.
        digits: the significant digits of the result, 15 to 10000.

    Raises:
        InputError: ``digits`` is not an integer or out of range.

    >>> from rpr_solver import EXAMPLES, cusp_table
    >>> [more], [less] = (cusp_table(EXAMPLES["zein-flat"], 10, digits=digits) for digits in (30, 15))
    >>> shorten_slice(more.to_json(), 30, 15)["cusps"] == less.to_json()["cusps"]
    True
    """
    digits = check_digits(digits)
    if digits > have_digits:
        return None
    result = dict(slice_json)
    for name in {"cusps", "degenerate_points"} & slice_json.keys():
        if (points := shortened_points(slice_json[name], digits)) is None:
            return None
        result[name] = points
    return result


def table_csv(table: Mapping[str, Any]) -> str:
    """A cusp table document as CSV: a line for each cusp and each degenerate point, with its ``kind``.

    A slice without either, or with an error, has one line.

    >>> from rpr_solver import EXAMPLES, cusp_table, table_json
    >>> [table] = cusp_table(EXAMPLES["zein-flat"], "0.1", digits=15)
    >>> print(table_csv(table_json(EXAMPLES["zein-flat"], 1, 15, [table.to_json()])))
    l1,count,cusp,alpha_deg,theta1_deg,l2,l3,error,kind,equation
    0.1,0,,,,,,,,
    <BLANKLINE>
    """
    return csv_text(*table_rows(table))


def table_rows(table: Mapping[str, Any]) -> tuple[list[str], list[Mapping[str, object]]]:
    """The columns of a cusp table document as CSV, and its rows."""
    leg = table["fixed_leg"]
    length = f"l{leg}"
    records: list[Mapping[str, object]] = []
    for item in table["slices"]:
        if "error" in item:
            records.append({length: item[length], "error": item["error"]["detail"]})
        else:
            head = {length: item[length], "count": item["count"]}
            points = [
                {"cusp": number, "kind": "cusp", **cusp} for number, cusp in enumerate(item["cusps"], 1)
            ]
            points += item.get("degenerate_points", ())
            records += [{**head, **point} for point in points] or [head]
    return [length, "count", "cusp", *coordinate_names(leg), "error", "kind", "equation"], records
