"""The decimal mark of a table whose columns are not separated by commas: a point or a comma, throughout."""

from __future__ import annotations

import re

from service.api.batches.bodies import invalid
from service.api.problems import ProblemError

_DECIMAL = re.compile(r"[+-]?(?:\d+([.,])\d*|([.,])\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}", re.ASCII)
_IN_ROOT = re.compile(r"\d+[.,]\d*|[.,]\d+", re.ASCII)
_NAMES = {".": "point", ",": "comma"}


class Decimals:
    """Reads numbers as they are written in a table.

    ``1.000`` is 1 if the point is the decimal mark, and 1000 if it separates thousands, as in a table with
    decimal commas; ``1,000`` likewise. Such a number is doubtful: it is read only if other numbers of the
    table, before or after it, have the same decimal mark, and none the other.
    """

    def __init__(self) -> None:
        self._sure: dict[str, str] = {}  # decimal mark → place of the first number that shows it
        self._doubtful: dict[str, tuple[str, str]] = {}  # mark → the first doubtful number, and its place

    def read(self, cell: str, place: str) -> str:
        """Returns a number with a decimal point; what is no number is returned as it is.

        Args:
            cell: a number, or several with semicolons between them.
            place: its row and column, for messages.

        Raises:
            ProblemError: a number has two readings.
        """
        return ";".join(self._number(text, place) for text in cell.split(";"))

    def end(self) -> None:
        """Refuse a doubtful number if no other of the table shows the decimal mark.

        Raises:
            ProblemError: there is one.
        """
        for mark in self._doubtful:
            if mark not in self._sure:
                raise self._refusal(mark, "and no other number of the table shows which")

    def _number(self, text: str, place: str) -> str:
        number = text.strip()
        if "sqrt" in number:
            return _IN_ROOT.sub(lambda part: self._number(part[0], place), number)
        match = _DECIMAL.fullmatch(number)
        if match is None:
            return text
        if _THOUSANDS.fullmatch(number):
            self._doubtful.setdefault(match[1], (number, place))
        else:
            self._sure.setdefault(match[1] or match[2], place)
        for mark, other in (".,", ",."):
            if mark in self._doubtful and other in self._sure:
                raise self._refusal(mark, f"and {self._sure[other]} has a decimal {_NAMES[other]}")
        return number.replace(",", ".")

    def _refusal(self, mark: str, why: str) -> ProblemError:
        number, place = self._doubtful[mark]
        decimal = number.replace(mark, ".").rstrip("0").rstrip(".")
        thousands = number.replace(mark, "")
        readings = (
            f"{thousands} if the {_NAMES[mark]} separates thousands, {decimal} if it is the decimal mark"
        )
        return invalid(f"{place}: {number!r} is {readings}, {why}; write {thousands} or {decimal}", "CSV")
